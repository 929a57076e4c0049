"""What the documents promise: keys that resolve, links that lead somewhere, defaults as the code has them."""

from __future__ import annotations

import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest
from typer.testing import CliRunner

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
    alone = ("z_mm", "distance_mm", "parallel")
    others = rf"^# (?!mean_edge_mm|file|section|clearance_mm|thickness_mm|axes|{'|'.join(alone)})"
    project_from(tomllib.loads(re.sub(others, "", block[1], flags=re.MULTILINE)))
    for key in alone:
        project_from(tomllib.loads(re.sub(rf"^# (?={key} )", "", block[1], flags=re.MULTILINE)))
    in_contact = block[1].replace('kind = "welded"', 'kind = "contact"')
    project_from(tomllib.loads(re.sub(r"^# (?=clearance_mm)", "", in_contact, flags=re.MULTILINE)))
    of_one_plate = block[1].replace("build_up =", "# build_up =")
    project_from(tomllib.loads(re.sub(r"^# (?=thickness_mm)", "", of_one_plate, flags=re.MULTILINE)))
    project_from(tomllib.loads(re.sub(r"^# (?=file|section)", "", block[1], flags=re.MULTILINE)))


def test_shipped_text_holds_no_machine_paths() -> None:
    tracked = [p for folder in ("geometry", "fabkit", "docs", "tests", "examples") for p in (ROOT / folder).rglob("*")]
    for path in [*tracked, ROOT / "README.md", ROOT / "pyproject.toml"]:
        if path.suffix in (".py", ".md", ".toml", ".js", ".css", ".html", ".obj", ".bib"):
            assert not re.search(r"/(home|root|Users)/\w", path.read_text(encoding="utf-8")), path


def test_the_command_line_reference_is_made_from_the_program() -> None:
    script = runpy.run_path(str(ROOT / "docs" / "tools" / "command_line.py"))
    text = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    assert text == script["page"](), "run python docs/tools/command_line.py"
    for command in ("build", "inspect", "planarise", "offset", "curvature", "design koebe", "design hexagons"):
        assert f"## fabkit {command}" in text
    help_text = " ".join(CliRunner().invoke(app, ["build", "--help"], env={"COLUMNS": "200"}).stdout.split())
    for option in re.findall(r"--[a-z][a-z-]+", text.split("## fabkit build")[1].split("## ")[0]):
        assert option in help_text


# --- code of the pages


PAGES = {path.name: path for path in (ROOT / "README.md", *sorted((ROOT / "docs" / "howto").glob("*.md")))}
CODE = re.compile(r"^```(python|sh|toml)\n(.*?)^```", re.DOTALL | re.MULTILINE)
KERNELS = {"to_build123d": "build123d", "to_cadquery": "cadquery"}
"""Blocks that call these need a kernel; they run with `-m kernel`."""

LIBRARIES = {"to_compas": "compas", "suns_at": "sunposition"}
"""Pages that call these need a library, which the extra `[test]` installs."""

MOST_LINES = 15
"""Of the code of a task in ten-tasks.md."""

CHECKS = {
    "parallel-meshes.md": """
assert structure.twists.max() < 1e-9
assert geometry.parallelity(mesh, blend).max() < 1e-9
""",
    "designing-edge-offset-meshes.md": """
assert abs(leaning.edge_distances - 1).max() < 1e-12
assert (geometry.edge_factors(square, saddle) < 0).any()
""",
    "edge-offset-meshes.md": """
for folder in ("shell-built", "shell-from-file"):
    assert (Path(folder) / "model.step").is_file()
""",
    "from-a-surface.md": """
assert planar.mesh.planarity.max() < 1e-12
assert (geometry.read_mesh("planar.obj").mesh.planarity < 1e-9).all()
assert Path("shell-built", "model.step").is_file() and Path("lines.dxf").is_file()
""",
    "mesh-files.md": """
assert len(triangles.faces) == 2 * same.number_of_faces() == 96
assert ball.n_faces == 80
""",
    "pictures.md": """
assert sorted(path.name for path in Path().iterdir()) == ["both.png", "lean.obj", "mean.ply", "mean.png"]
assert geometry.read_mesh("mean.ply").mesh.n_faces == roof.n_faces
""",
    "shortcuts.md": """
assert fine.n_faces == 16 * coarse.n_faces
assert abs(glass.face_distances - 0.2).max() < 1e-9
assert abs(near.vertices[[0, 19]] - wanted).max() < 0.3
""",
    "constant-heights.md": """
assert curve[-1].after.edge_spread < 0.05 < curve[0].after.edge_spread
assert (Path("shell-built") / "model.step").is_file()
""",
    "shading.md": """
assert found.after.share > found.before.share
assert Path("shade.png").stat().st_size > 20_000
rows = np.genfromtxt("shade.csv", delimiter=",", names=True)
assert len(rows) == before.facing.sum()
""",
}
"""What holds when the code of a page has run."""


def skip_without_libraries(text: str) -> None:
    for call, library in LIBRARIES.items():
        if call in text:
            pytest.importorskip(library)


def needs_kernel(block: str) -> bool:
    return any(call in block for call in KERNELS)


def script_of(language: str, block: str) -> str:
    """Python that does what a block says: `fabkit` in lines of the shell is run, a file of TOML is written."""
    if language == "python":
        return block
    if language == "toml":
        name = re.match(r"# (\S+\.toml)\n", block)  # how to call it, where there is something to run it with
        return f"Path({name[1]!r}).write_text({block!r}, encoding='utf-8')\n" if name else ""
    commands = [line.removeprefix(".venv/bin/") for line in block.splitlines()]
    words = [shlex.split(line)[1:] for line in commands if line.startswith("fabkit ")]
    return "".join(f"subprocess.run([sys.executable, '-m', 'fabkit', *{each!r}], check=True)\n" for each in words)


def run(script: str, folder: Path) -> None:
    """In a folder without the project, as whoever has installed it would."""
    head = "import subprocess, sys\nfrom pathlib import Path\n"
    done = subprocess.run(
        [sys.executable, "-c", head + script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{script}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"


@pytest.mark.parametrize("name", sorted(set(PAGES) - {"ten-tasks.md"}))
def test_the_code_of_a_page_runs_from_top_to_bottom(name: str, tmp_path: Path) -> None:
    text = PAGES[name].read_text(encoding="utf-8")
    skip_without_libraries(text)
    if name == "README.md":  # which stands beside the examples
        shutil.copytree(ROOT / "examples", tmp_path / "examples")
    script = "".join(script_of(*block) for block in CODE.findall(text) if not needs_kernel(block[1]))
    run(script + CHECKS.get(name, ""), tmp_path)


@pytest.mark.kernel
@pytest.mark.parametrize("kernel", ["build123d", "cadquery"])
def test_the_code_of_the_readme_for_kernels_runs(kernel: str, tmp_path: Path) -> None:
    if find_spec(kernel) is None:
        pytest.skip(f"{kernel} is not installed")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    (block,) = [text for _, text in CODE.findall(PAGES["README.md"].read_text(encoding="utf-8")) if needs_kernel(text)]
    run(block.replace("build123d", kernel), tmp_path)


TASKS = [text for _, text in CODE.findall(PAGES["ten-tasks.md"].read_text(encoding="utf-8"))]


@pytest.mark.parametrize("number", range(len(TASKS)))
def test_each_of_ten_tasks_is_done_in_few_lines(number: int, tmp_path: Path) -> None:
    assert len(TASKS) == 10
    assert sum(bool(line.strip()) for line in TASKS[number].splitlines()) <= MOST_LINES
    skip_without_libraries(TASKS[number])
    run(TASKS[number], tmp_path)


def test_each_design_has_a_command_that_is_run() -> None:
    text = PAGES["edge-offset-meshes.md"].read_text(encoding="utf-8")
    commands = [line for language, block in CODE.findall(text) if language == "sh" for line in block.splitlines()]
    for command in re.findall(r"^\| `(\w+)`", text, re.MULTILINE):
        assert any(line.startswith(f"fabkit design {command} ") for line in commands), command
