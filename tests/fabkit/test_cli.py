"""The command line: bad input gets one clear sentence and exit code 2, and leaves nothing behind."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from fabkit.commands.command_line import app
from geometry.files import write_mesh
from geometry.mesh import shapes

QUAD_STRIP = """
v 0 0 0
v 1.5 0 0
v 3 0 0
v 0 1.5 0
v 1.5 1.5 0
v 3 1.5 0
"""


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def refused(tmp_path: Path, mesh: str, *options: str, suffix: str = ".obj") -> str:
    """Build from a mesh file with this content; the sentence with which it is refused."""
    file = tmp_path / f"mesh{suffix}"
    file.write_text(mesh)
    out = tmp_path / "out"
    result = run("build", file, "--unit", "m", "-o", out, *options)
    assert result.exit_code == 2, result.output
    assert sorted(path.name for path in tmp_path.iterdir()) == [file.name], "something was left behind"
    assert result.stdout == ""
    lines = [line for line in result.stderr.splitlines() if line.startswith("fabkit:")]
    assert len(lines) == 1
    assert "Traceback" not in result.output
    return lines[0]


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        pytest.param("", ["empty"], id="empty file"),
        pytest.param(QUAD_STRIP, ["no faces"], id="no faces"),
        pytest.param(QUAD_STRIP.replace("v 3 0 0", "v nan 0 0") + "f 1 2 5 4\nf 2 3 6 5", ["nan"], id="NaN"),
        pytest.param(
            QUAD_STRIP + "f 1 2 5\nf 1 5 4\nf 2 3 6\nf 2 6 5", ["triangle mesh", "scaled copies"], id="triangles"
        ),
        pytest.param(
            QUAD_STRIP + "v 0 0 2\nv 1.5 0 2\nv 0 0 -2\nv 1.5 0 -2\nf 1 2 5 4\nf 1 2 8 7\nf 1 2 10 9",
            ["edge from vertex 1 to vertex 2", "faces 1, 2 and 3", "two at most"],
            id="non-manifold edge",
        ),
        pytest.param(QUAD_STRIP + "f 1 2 5 4\nf 2 4 5 1\nf 2 3 6 5", ["same", "faces"], id="faces over each other"),
        pytest.param(
            QUAD_STRIP + "f 1 2 5 2 4\nf 2 3 6 5", ["face 1 touches itself", "vertex 2"], id="self-touching face"
        ),
        pytest.param(QUAD_STRIP + "f 1 5 2 4\nf 2 3 6 5", ["face"], id="folded face"),
        pytest.param(QUAD_STRIP + "f 1 2 5 44\n", ["44"], id="index out of range"),
    ],
)
def test_bad_meshes(tmp_path: Path, mesh: str, words: list[str]) -> None:
    sentence = refused(tmp_path, mesh)
    assert all(word.lower() in sentence.lower() for word in words), sentence


@pytest.mark.parametrize(
    ("mesh", "mended"),
    [
        pytest.param("v 1.5 0 0\nf 1 2 7 5 4\nf 2 3 6 5", "1 of 2 faces had corners at one place", id="zero length"),
        pytest.param("f 1 2 5 4\nf 2 5 4 1\nf 2 3 6 5", "1 of 3 faces were written before", id="duplicate faces"),
        pytest.param("f 1 2 5 4 4\nf 2 3 6 5\nf 1 2", "1 of 3 faces named a vertex twice", id="doubled corners"),
    ],
)
def test_what_is_mended_is_reported(tmp_path: Path, mesh: str, mended: str) -> None:
    file = tmp_path / "mesh.obj"
    file.write_text(QUAD_STRIP + mesh)
    result = run("inspect", file)
    assert result.exit_code == 0, result.output
    assert mended in " ".join(result.output.split())


def test_a_beam_shorter_than_its_setbacks(tmp_path: Path) -> None:
    acute = QUAD_STRIP.replace("v 0 1.5 0", "v 1.4 0.04 0")
    sentence = refused(tmp_path, acute + "f 1 2 5 4\nf 2 3 6 5", "--connection", "contact")
    assert "beam" in sentence
    assert "is too short" in sentence
    assert "--skip-unbuildable" in sentence


def test_a_panel_cut_away_by_its_joint(tmp_path: Path) -> None:
    sentence = refused(tmp_path, QUAD_STRIP + "f 1 2 5 4\nf 2 3 6 5", "--joint", "1500")
    assert "the panel on face 0 vanishes when cut back by half the joint" in sentence


def test_a_panel_larger_than_every_sheet(tmp_path: Path) -> None:
    sentence = refused(tmp_path, QUAD_STRIP + "f 1 2 5 4\nf 2 3 6 5", "--sheet", "1000x800")
    assert "P001" in sentence
    assert "950 x 750 mm" in sentence


def test_the_unit_is_never_guessed(tmp_path: Path) -> None:
    file = tmp_path / "mesh.obj"
    file.write_text(QUAD_STRIP + "f 1 2 5 4\nf 2 3 6 5")
    result = run("build", file, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "--unit" in result.stderr
    assert "--mean-edge" in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_missing_file_and_an_unknown_key(tmp_path: Path) -> None:
    result = run("build", tmp_path / "none.obj", "--unit", "m", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "none.obj" in result.stderr
    project = tmp_path / "p.toml"
    project.write_text('mesh = "a.obj"\nunit = "m"\nout = "out"\n[beams]\nwdth_mm = 50\n')
    result = run("build", project)
    assert result.exit_code == 2
    assert "unknown key 'wdth_mm' in [beams]; did you mean width_mm?" in result.stderr
    assert list(tmp_path.iterdir()) == [project]


def test_an_existing_folder_is_replaced_only_with_force(tmp_path: Path) -> None:
    file = tmp_path / "mesh.obj"
    file.write_text(QUAD_STRIP + "f 1 2 5 4\nf 2 3 6 5")
    arguments = ["build", file, "--unit", "m", "-o", tmp_path / "out"]
    assert run(*arguments).exit_code == 0
    before = (tmp_path / "out" / "model.step").read_bytes()
    again = run(*arguments)
    assert again.exit_code == 2
    assert "--force" in again.stderr
    forced = run(*arguments, "--force", "--beam", "60x140", "--nest", "off")
    assert forced.exit_code == 0, forced.output
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["settings"]["beams"]["height_mm"] == 140
    assert manifest["settings"]["nesting"]["mode"] == "off"
    assert (tmp_path / "out" / "model.step").read_bytes() != before


@pytest.mark.parametrize(
    ("signal_sent", "code"),
    [(signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129), (signal.SIGQUIT, 131)],
)
def test_a_run_that_is_ended_leaves_nothing(tmp_path: Path, signal_sent: signal.Signals, code: int) -> None:
    write_mesh(tmp_path / "mesh.obj", shapes.dome(40, 12))
    command = [
        sys.executable,
        "-c",
        "from fabkit.commands.command_line import app; app()",
        "build",
        "mesh.obj",
        "--mean-edge",
        "1500",
    ]
    with subprocess.Popen([*command, "-o", "out"], cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not list(tmp_path.glob(".out.*")):
            time.sleep(0.01)
        process.send_signal(signal_sent)
        _, errors = process.communicate(timeout=30)
    assert process.returncode == code
    assert "Traceback" not in errors
    assert [path.name for path in tmp_path.iterdir()] == ["mesh.obj"]


def test_help_reads_well() -> None:
    overview = run("--help")
    assert overview.exit_code == 0
    assert "build" in overview.stdout
    assert "inspect" in overview.stdout
    details = run("build", "--help")
    for option in ("--unit", "--mean-edge", "--flip", "--beam", "--nest", "--skip-unbuildable", "--force"):
        assert option in details.stdout


def test_inspect_says_what_a_mesh_is_fit_for(tmp_path: Path) -> None:
    file = tmp_path / "mesh.obj"
    file.write_text(QUAD_STRIP + "f 1 2 5 4\nf 2 3 6 5")
    result = run("inspect", file)
    assert result.exit_code == 0, result.output
    for word in ("vertices", "faces", "planarity", "circular", "conical", "heights"):
        assert word in result.stdout
    result = run("inspect", tmp_path / "none.off")
    assert result.exit_code == 2
