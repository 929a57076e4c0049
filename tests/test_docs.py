"""What the documents promise: keys that resolve, links that lead somewhere, defaults as the code has them."""

from __future__ import annotations

import re
import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import geometry
from fabkit.commands.command_line import app
from fabkit.project import project_from

ROOT = Path(__file__).parents[1]
CITED = re.compile(r"\[([A-Z][A-Za-z]+(?:19|20)\d\d)[],]")


def test_every_cited_key_is_in_the_bibliography() -> None:
    known = set(re.findall(r"@\w+\{(\w+),", (ROOT / "docs" / "references.bib").read_text(encoding="utf-8")))
    files = [p for folder in ("geometry", "fabkit", "docs", "tests") for p in (ROOT / folder).rglob("*") if p.is_file()]
    cited = {key for p in files if p.suffix in (".py", ".md") for key in CITED.findall(p.read_text(encoding="utf-8"))}
    assert "Pottmann2007" in cited
    assert cited <= known


@pytest.mark.parametrize(
    "path", sorted(ROOT.glob("*.md")) + sorted((ROOT / "docs").rglob("*.md")), ids=lambda p: p.name
)
def test_links_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\((?!https://)([^)#]+)\)", path.read_text(encoding="utf-8")):
        assert (path.parent / target).exists(), target


def test_the_project_file_in_the_how_to_states_the_defaults() -> None:
    text = (ROOT / "docs" / "howto" / "project-file.md").read_text(encoding="utf-8")
    block = re.search(r"```toml\n(.*?)```", text, re.DOTALL)
    assert block
    stated = project_from(tomllib.loads(block[1])).model_dump(exclude={"out", "name"})
    assert stated == project_from({"mesh": "roof.obj", "unit": "m"}).model_dump(exclude={"out", "name"})
    # what has no value of its own is commented out; with the comment signs taken off it must still be known
    project_from(tomllib.loads(re.sub(r"^# (?!mean_edge_mm|file)", "", block[1], flags=re.MULTILINE)))
    project_from(tomllib.loads(re.sub(r"^# (?=file)", "", block[1], flags=re.MULTILINE)))


def test_shipped_text_holds_no_machine_paths() -> None:
    tracked = [p for folder in ("geometry", "fabkit", "docs", "tests", "examples") for p in (ROOT / folder).rglob("*")]
    for path in [*tracked, ROOT / "README.md", ROOT / "pyproject.toml"]:
        if path.suffix in (".py", ".md", ".toml", ".js", ".css", ".html", ".obj", ".bib"):
            assert not re.search(r"/(home|root|Users)/\w", path.read_text(encoding="utf-8")), path


def test_meshes_of_other_libraries_go_in_and_out_as_the_how_to_says() -> None:
    pytest.importorskip("compas")
    text = (ROOT / "docs" / "howto" / "mesh-files.md").read_text(encoding="utf-8")
    block = re.search(r"<!-- other libraries -->\n```python\n(.*?)```", text, re.DOTALL)
    assert block
    names: dict[str, Any] = {}
    exec(block[1], names)
    assert len(names["triangles"].faces) == 2 * names["same"].number_of_faces() == 96
    assert names["ball"].n_faces == 80


def test_the_how_to_on_parallel_meshes_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    text = (ROOT / "docs" / "howto" / "parallel-meshes.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(block, names)
    assert names["structure"].twists.max() < 1e-9
    assert geometry.parallelity(names["mesh"], names["blend"]).max() < 1e-9


def test_the_how_to_on_pictures_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "docs" / "howto" / "pictures.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(block, names)
    names["plt"].close("all")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["both.png", "lean.obj", "mean.ply", "mean.png"]
    assert geometry.read_mesh("mean.ply").mesh.n_faces == names["roof"].n_faces


def test_the_how_to_on_shortcuts_runs() -> None:
    text = (ROOT / "docs" / "howto" / "shortcuts.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(block, names)
    assert names["fine"].n_faces == 16 * names["coarse"].n_faces
    assert abs(names["glass"].face_distances - 0.2).max() < 1e-9
    assert abs(names["near"].vertices[[0, 19]] - names["wanted"]).max() < 0.3


def test_the_how_to_on_designing_edge_offset_meshes_runs() -> None:
    text = (ROOT / "docs" / "howto" / "designing-edge-offset-meshes.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(block, names)
    assert abs(names["leaning"].edge_distances - 1).max() < 1e-12
    assert (geometry.edge_factors(names["square"], names["saddle"]) < 0).any()


def test_the_commands_of_the_how_to_on_edge_offset_meshes_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "howto" / "edge-offset-meshes.md").read_text(encoding="utf-8")
    commands = [line for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    (project,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    Path("project.toml").write_text(project, encoding="utf-8")
    dome = geometry.mesh.shapes.dome(60, 20)  # of which a cap is left
    cap = [face for face in dome.combinatorics.faces if dome.vertices[face, 2].min() > 0.5]
    Path("surface.obj").write_text(_obj(dome.vertices.tolist(), cap), encoding="utf-8")
    for command in [*commands, "fabkit build project.toml --nest off"]:
        program, *arguments = command.split()
        assert program == "fabkit"
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, f"{command}: {done.output}"
    for command in re.findall(r"^\| `(\w+)`", text, re.MULTILINE):
        assert any(line.startswith(f"fabkit design {command} ") for line in commands), command
    assert (tmp_path / "shell-built" / "model.step").is_file()
    assert (tmp_path / "shell-from-file" / "model.step").is_file()


def _obj(vertices: list[list[float]], faces: list[list[int]]) -> str:
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
    return "\n".join(rows + ["f " + " ".join(str(vertex + 1) for vertex in face) for face in faces])


def test_the_python_of_the_readme_on_geometry_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    (block,) = [block for block in blocks if block.startswith("import geometry")]
    exec(block, {})


def test_the_command_line_reference_is_made_from_the_program() -> None:
    script = runpy.run_path(str(ROOT / "docs" / "tools" / "command_line.py"))
    text = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    assert text == script["page"](), "run python docs/tools/command_line.py"
    for command in ("build", "inspect", "planarise", "offset", "curvature", "design koebe", "design hexagons"):
        assert f"## fabkit {command}" in text
    help_text = " ".join(CliRunner().invoke(app, ["build", "--help"], env={"COLUMNS": "200"}).stdout.split())
    for option in re.findall(r"--[a-z][a-z-]+", text.split("## fabkit build")[1].split("## ")[0]):
        assert option in help_text
