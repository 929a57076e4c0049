"""What goes wrong around the program, in its terminal, file names and while it starts, is one sentence or silence."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.text import Text
from typer.testing import CliRunner, Result

from fabkit.commands.command_line import app
from fabkit.commands.terminal import LONGEST_SENTENCE, printable

ROOT = Path(__file__).parents[2]
FULL = Path("/dev/full")

MESH = "v 0 0 0\nv 2 0 0\nv 4 0 0\nv 0 2 0\nv 2 2 0\nv 4 2 0\nf 1 2 5 4\nf 2 3 6 5\n"


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mesh.obj").write_text(MESH)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def refused(*arguments: str) -> str:
    """The one sentence on standard error, without what shows the stages."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("fabkit:")]
    assert result.stderr.rstrip("\n").endswith(line)
    return line


def program(*arguments: str, **settings: object) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **settings.pop("env", {})}  # type: ignore[dict-item]
    return subprocess.Popen(
        [sys.executable, "-m", "fabkit", *arguments],
        env=environment,
        text=True,
        errors="replace",
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **settings},  # type: ignore[call-overload]
    )


# --- arguments


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["build", "mesh.obj", "--unit", "m", "-o", "out", "--beam", "1..2x3"], "--beam is '1..2x3', but needs two"),
        (["build", "mesh.obj", "--unit", "m", "-o", "out", "--sheet", "1.2.3x4"], "--sheet is '1.2.3x4', but needs"),
        (["build", "mesh.obj", "--unit", "m", "-o", "out", "--beam", "9" * 5000 + "x5"], "beams.width_mm is inf"),
        (["build", "mesh.obj", "--mean-edge", "1e300", "-o", "out"], "mean_edge_mm is 1e+300: input should be less"),
        (["build", "mesh.obj", "--mean-edge", "nan", "-o", "out"], "mean_edge_mm is nan: input should be a finite"),
        (["build", "mesh.obj", "--mean-edge", "wide", "-o", "out"], "build --help lists the options"),
        (["build", "mesh.obj", "--mean-egde", "5", "-o", "out"], "No such option: --mean-egde"),
        (["design", "minimal", "-o", "out", "--shape", "ball"], "Invalid value for '--shape': 'ball' is not one of"),
        (["biuld", "mesh.obj"], "No such command 'biuld'"),
        (["build"], "Missing argument 'MESH'"),
        (["build", "mesh.obj", "--unit", "m", "-o", r"x\[/]"], r"x\[ in which ] should appear does not exist"),
        (["build", r"x\[/].obj", "--unit", "m", "-o", "out"], r"x\[/].obj: there is no such file"),
        (["build", "x" * 300 + ".obj", "--unit", "m", "-o", "out"], "the file cannot be read: File name too long"),
        (["build", "mesh.obj", "--unit", "m", "-o", "x" * 300], "cannot be written: File name too long"),
        (["build", "x" * 300 + ".toml", "-o", "out"], "cannot be read: File name too long"),
        (["build", "mesh.obj/mesh.obj", "--unit", "m", "-o", "out"], "there is no such file"),
        (["build", "mesh.obj", "--unit", "m", "-o", "mesh.obj/out"], "does not exist; make it first"),
        (["design", "minimal", "--count", "1000000000", "-o", "out"], "at most 250000 are made"),
        (["design", "minimal", "--shape", "enneper", "--count", "9" * 4000, "-o", "out"], "at most 250000 are made"),
        (["design", "koebe", "--count", "1000000000", "-o", "out"], "at most 20000 are made"),
        (["design", "cmc", "--rows", "1000000000", "-o", "out"], "at most 250000 are made"),
        (["design", "cmc", "--bulge", "1e300", "-o", "out"], "at most 1e+06 is possible"),
        (["design", "hexagons", "mesh.obj", "--count", "1000000000", "-o", "out"], "at most 20000 are made"),
    ],
)
def test_arguments_that_make_no_sense_get_one_sentence(place: Path, arguments: list[str], sentence: str) -> None:
    said = refused(*arguments)
    assert sentence in said
    assert len(said) < LONGEST_SENTENCE + 20
    assert [path.name for path in place.iterdir()] == ["mesh.obj"]


def test_names_with_what_a_terminal_would_obey_are_built_and_printed(place: Path) -> None:
    for name in (r"x\[b]", "[red]", ":warning:", "a\x1b[31mb", "tab\tand\nline"):
        result = run("build", "mesh.obj", "--unit", "m", "--nest", "off", "-o", name)
        assert result.exit_code == 0, result.output
        assert f"written to {printable(name)} in" in result.stdout
        assert (place / name / "manifest.json").is_file()


@given(st.text())
def test_messages_are_one_line_and_unchanged(text: str) -> None:
    said = printable(text)
    assert len(said.splitlines()) <= 1
    assert said.isprintable()
    said.encode("utf-8")
    assert len(said) <= LONGEST_SENTENCE
    assert len(f"fabkit: {printable(text * 1000)}") <= 3 * 200
    if text.isprintable() and len(text) <= LONGEST_SENTENCE:
        assert said == text
    assert Text(said).plain == said


# --- files


def test_an_unreadable_file_or_folder_gets_a_sentence(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(path: Path, *arguments: object, **settings: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    (place / "p.toml").write_text("mesh = 'mesh.obj'\nunit = 'm'\n")
    monkeypatch.setattr(Path, "read_bytes", denied)
    assert "mesh.obj: the file cannot be read: Permission denied" in refused(
        "build", "mesh.obj", "--unit", "m", "-o", "out"
    )
    assert "p.toml cannot be read: Permission denied" in refused("build", "p.toml", "-o", "out")
    assert "the file cannot be read: Permission denied" in refused("inspect", "mesh.obj")


@pytest.mark.skipif(sys.platform != "linux", reason="file names are bytes")
def test_names_that_are_not_utf_8_are_built(place: Path) -> None:
    name = os.fsdecode(b"\xfe\xff")
    (place / "mesh.obj").rename(f"{name}.obj")
    result = run("build", f"{name}.obj", "--unit", "m", "--nest", "off", "-o", name)
    assert result.exit_code == 0, result.output
    assert r"written to \xfe\xff in" in result.stdout
    assert r"\xfe\xff.obj: there is no" in refused("inspect", f"x/{name}.obj")


def test_the_input_is_read_once(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is edited during a build neither fails it nor changes what the manifest says was built."""
    read, before = Path.read_bytes, (place / "mesh.obj").read_bytes()
    seen: list[Path] = []

    def read_and_edited(path: Path) -> bytes:
        data = read(path)
        if path.suffix == ".obj":
            seen.append(path)
            path.write_bytes(b"edited meanwhile")
        return data

    monkeypatch.setattr(Path, "read_bytes", read_and_edited)
    assert run("build", "mesh.obj", "--unit", "m", "--nest", "off", "-o", "out").exit_code == 0
    assert len(seen) == 1
    manifest = json.loads((place / "out" / "manifest.json").read_text())
    assert manifest["input"]["sha256"] == hashlib.sha256(before).hexdigest()


def test_a_design_is_not_written_over_the_files_it_is_made_from(place: Path) -> None:
    assert run("design", "koebe", "--count", "4", "-o", "dome").exit_code == 0
    near = ["design", "cmc", "--start", "dome/M.obj", "--gauss-image", "dome/S.obj", "--force", "-o"]
    assert "dome contains dome/M.obj, which is an input of this run" in refused(*near, "dome")
    assert "contains" in refused(
        "build", "dome/M.obj", "--gauss-image", "dome/S.obj", "--unit", "m", "--force", "-o", "dome"
    )
    (place / "p.toml").write_text("mesh = 'mesh.obj'\nunit = 'm'\nout = '.'\n")
    assert "contains mesh.obj, which is an input of this run" in refused("build", "p.toml", "--force")
    (place / "dome" / "p.toml").write_text("mesh = '../mesh.obj'\nunit = 'm'\nout = '.'\n")
    assert "edited since, and is not replaced: p.toml" in refused("build", "dome/p.toml", "--force")
    assert (place / "dome" / "M.obj").is_file()


# --- terminals


@pytest.mark.skipif(not FULL.exists(), reason="no device is always full")
@pytest.mark.parametrize("arguments", [["inspect", "mesh.obj"], ["build", "--help"], ["build"]])
def test_a_full_device_is_a_sentence(place: Path, arguments: Sequence[str]) -> None:
    if arguments == ["build"]:
        arguments = ["build", "mesh.obj", "--unit", "m", "-o", "out"]
    with FULL.open("w") as full, program(*arguments, stdout=full) as process:
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 2
    assert errors.splitlines()[-1].startswith("fabkit: No space left on device")
    assert "Traceback" not in errors
    assert "Exception ignored" not in errors
    assert (place / "out" / "manifest.json").is_file() == (arguments[0] == "build" and len(arguments) > 2)


@pytest.mark.skipif(not FULL.exists(), reason="no device is always full")
def test_that_progress_cannot_be_shown_stops_no_build(place: Path) -> None:
    with FULL.open("w") as full, program("build", "mesh.obj", "--unit", "m", "-o", "out", stderr=full) as process:
        printed, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "written to out" in printed


def test_nobody_who_reads_is_no_error(place: Path) -> None:
    with program("build", "mesh.obj", "--unit", "m", "-o", "out") as process:
        assert process.stdout
        assert process.stderr
        process.stdout.close()
        errors = process.stderr.read()
    assert process.returncode == 1
    assert "Traceback" not in errors
    assert "fabkit:" not in errors
    assert (place / "out" / "manifest.json").is_file()


def test_characters_that_the_terminal_lacks_are_shown_by_their_codes(place: Path) -> None:
    with program("build", "mesh.obj", "--unit", "m", "-o", "日", env={"PYTHONIOENCODING": "ascii"}) as process:
        printed, errors = process.communicate(timeout=60)
    assert process.returncode == 0, errors
    assert r"written to \u65e5" in printed


STARTING = """
import signal, sys

class Interrupt:
    module, number = sys.argv[1:]

    def find_spec(self, name, *_):
        if name == self.module:
            signal.raise_signal(int(self.number))

sys.meta_path.insert(0, Interrupt())
sys.argv[:] = ["fabkit", "inspect", "mesh.obj"]
from fabkit.__main__ import main
main()
"""


@pytest.mark.parametrize("module", ["numpy", "scipy", "fabkit.project", "typer", "fabkit.commands.design"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_modules_are_imported_is_silent(place: Path, number: signal.Signals, module: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", STARTING, module, str(int(number))],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 128 + number
    assert done.stderr == ""


def test_programs_that_import_the_package_keep_their_answers_to_signals() -> None:
    script = STARTING.replace("from fabkit.__main__ import main\nmain()", "import fabkit\nfabkit.build")
    done = subprocess.run(
        [sys.executable, "-c", script, "scipy", str(int(signal.SIGINT))],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert "KeyboardInterrupt" in done.stderr


HEAVY = {"numpy", "scipy", "igl", "clarabel", "pyamg", "shapely", "ezdxf", "xlsxwriter", "fabkit.project"}
"""What numerics, formats and project files need, and help does not. Typer itself imports pydantic for some commands."""


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["build", "--help"],
        ["inspect", "--help"],
        ["offset", "--help"],
        ["design", "--help"],
        ["design", "koebe", "--help"],
        [],
    ],
)
def test_help_imports_nothing_heavy(arguments: list[str]) -> None:
    script = (
        "import sys, atexit\n"
        "atexit.register(lambda: print('imported:', *sys.modules))\n"
        f"sys.argv[:] = ['fabkit', *{arguments}]\n"
        "from fabkit.__main__ import main\n"
        "main()\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert "Usage: fabkit" in done.stdout + done.stderr
    imported = done.stdout.split("imported:")[1].split()
    assert "typer" in imported
    assert HEAVY.isdisjoint(imported)


@pytest.mark.parametrize("package", ["geometry", "fabkit"])
def test_packages_offer_their_names_without_importing_them(package: str) -> None:
    script = (
        "import sys\n"
        f"import {package}\n"
        "assert 'numpy' not in sys.modules\n"
        f"assert set({package}.__all__) <= set(dir({package}))\n"
        f"assert all(hasattr({package}, name) for name in {package}.__all__)\n"
        "assert 'numpy' in sys.modules\n"
        f"assert not hasattr({package}, 'nonsense')\n"
    )
    subprocess.run([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": str(ROOT)}, timeout=60, check=True)
