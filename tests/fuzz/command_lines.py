"""Damaged command lines, most of them in this process, some in one of their own, with faults of the file system."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from driver import Files, Kind, mutated
from faults import FileSystem
from mesh_files import MESHES, written
from run_checks import check_folder, check_messages, snapshot
from typer.testing import CliRunner

from fabkit.commands.command_line import app
from geometry.files.obj import obj_text

ROOT = Path(__file__).parents[2]
ASKED = "asked.json"
"""The file that says what is run: the arguments, and what happens meanwhile."""

NUMBERS = ["0", "-1", "1", "5", "0.5", "45", "200", "1e-9", "1e9", "1e300", "1e400", "nan", "inf", "-inf", "9" * 5000]
NUMBERS += ["0x10", "1_0", "١٢", "wide", "", "1,5", "--", "\0", "1" + "0" * 300]
COUNTS = ["-1", "0", "1", "2", "3", "4", "5", "6", "7", "1000000000", "9" * 30, "9" * 5000, "1.5", "many", ""]
SIZES = [
    "50x120",
    "10x10",
    "1..2x3",
    "x",
    "1e5x3",
    "0x0",
    "9999999999x1",
    "5\u00d75",
    "9" * 5000 + "x5",
    "",
    "5*6",
    "1x2x3",
]
WORDS = ["mm", "m", "quads", "hexagons", "centre", "off", "best", "moves", "lean", "saddle", "enneper", "feet", "", "M"]
WORDS += [
    "=HYPERLINK(1)",
    "\0",
    "\x1b[31m",
    "caf\udce9",
    "x" * 3000,
    "屋根",
    "--force",
    "[/]",
    r"\[/]",
    "\n",
    "a\u202eb",
]
PATHS = ["mesh.obj", "mesh.off", "second.obj", "project.toml", "earlier/M.obj", "earlier", "folder", "loop.obj", "out"]
PATHS += ["missing.obj", "missing/x", ".", "..", "../..", "/", "", "-", "x" * 300 + ".obj", "x/" * 3000, "a\0b.obj"]
PATHS += [
    "caf\udce9.obj",
    "屋根.toml",
    "/dev/null",
    "/proc/x",
    "mesh.obj/x",
    "folder/new",
    "./out/",
    "C:\\m.obj",
    "x.stl",
]
VECTORS = ["0.3,0,-0.1", "0,0,0", "1,0,0", "nan,0,0", "1e400,0,0", "0.1", "0,0", "a,b,c", "9" * 5000 + ",0,0"]

MEASURES = ["--mean-edge", "--clearance", "--thickness", "--joint", "--lift", "--equal-within"]
SHAPES = {"--beam": SIZES, "--sheet": SIZES, "--reference": WORDS, "--nest": ["quick", "off", "most", "QUICK"]}
SHARED = {**dict.fromkeys(MEASURES, NUMBERS), **SHAPES, "--unit": WORDS, "--accept": WORDS, "--gauss-image": PATHS}
SHARED |= {"--flip": [], "--skip-unbuildable": []}
DESIGNS: dict[str, dict[str, list[str]]] = {
    "koebe": {"--tiles": WORDS, "--count": COUNTS, "--combinatorics": PATHS, "--dual": [], "--coverage": NUMBERS}
    | {"--bend": WORDS, "--direction": NUMBERS},
    "minimal": {"--shape": WORDS, "--faces": WORDS, "--count": COUNTS, "--turn": NUMBERS, "--gauss-image": PATHS},
    "cmc": {"--faces": WORDS, "--count": COUNTS, "--rows": COUNTS, "--folds": COUNTS, "--bulge": NUMBERS}
    | {"--start": PATHS, "--gauss-image": PATHS, "--mean": NUMBERS},
    "hexagons": {"--count": COUNTS, "--curvature": COUNTS, "--turn": NUMBERS, "--flip": []},
}
ERRORS = [errno.ENOSPC, errno.EACCES, errno.EIO, errno.EROFS, errno.EMFILE, errno.ENOENT, errno.ESTALE, errno.EDQUOT]


def inputs(random: Random) -> Files:
    """A folder with meshes, a project and an earlier result, and what is run there."""
    arguments = _arguments(random)
    return {**files(random), ASKED: asked(arguments, random)}


def attempt(folder: Path) -> str:
    """The command ends with a known code and a sentence, and leaves one whole folder or nothing."""
    work = folder / "work"
    (work / "folder").mkdir()
    (work / "loop.obj").symlink_to("loop.obj")
    wanted = json.loads((folder / ASKED).read_text())
    before = snapshot(folder)
    run = _run_as_program if wanted["as"] else _run_inside
    code = run(work, wanted)
    after = snapshot(folder)
    check_folder(before, after, may_write=code == 0 or wanted["as"] in ("full device", "ended"))
    return "built" if after != before else f"exit {code}"


def files(random: Random, damage: float = 0.3) -> Files:
    """What lies in the folder where a command is run."""
    mesh = random.choice(MESHES)
    name, content = written("mesh", mesh, random)
    content = mutated(content, random) if random.random() < damage else content
    found = {"mesh.obj": obj_text(mesh).encode(), name: content, **_earlier()}
    found["second.obj"] = obj_text(mesh.with_vertices(mesh.vertices - mesh.vertices.mean(axis=0))).encode()
    found["project.toml"] = b"mesh = 'mesh.obj'\nunit = 'm'\nout = 'out'\n"
    return {f"work/{name}": content for name, content in found.items()}


def asked(arguments: list[str], random: Random) -> bytes:
    """How these arguments are run: in this process, now and then with faults of the file system, or as a program."""
    ways: list[dict[str, Any]] = [{"device": random.randrange(50_000)}]
    ways += [{"failing": [random.randrange(1, 60), random.choice(ERRORS)]}] * 2
    way = random.choice(ways) if random.random() < 0.3 else {}
    program = random.choice(["full device", "ascii", "ended"]) if random.random() < 0.03 else None
    return json.dumps({"arguments": arguments, "as": program, "after": random.random() * 2, **way}).encode()


def _arguments(random: Random) -> list[str]:
    command = random.choice(["build"] * 6 + ["inspect"] * 4 + ["design"] * 5)
    if command == "design":
        kind = random.choice(list(DESIGNS))
        options = {**DESIGNS[kind], "--boost": VECTORS, "--force": []}
        line = [command, kind, *([random.choice(PATHS)] if kind == "hexagons" else [])]
        line += ["-o", "out"] if random.random() < 0.8 else ["-o", random.choice(PATHS)]
    else:
        options = {**SHARED, "--force": [], "--name": WORDS} if command == "build" else SHARED
        line = [command, random.choice(["mesh.obj", "mesh.obj", "mesh.off", "project.toml", random.choice(PATHS)])]
        line += ["--unit", "m"] if random.random() < 0.8 else []
        if command == "build" and random.random() < 0.9:
            line += ["-o", random.choice(["out", "out", "out", "earlier", random.choice(PATHS)])]
    for option in random.sample(list(options), random.choice([0, 0, 1, 1, 2, 3])):
        line += [option, *([random.choice(options[option])] if options[option] else [])]
    return _damaged(line, random) if random.random() < 0.2 else line


def _damaged(line: list[str], random: Random) -> list[str]:
    """With an argument changed, lost, doubled or moved. Counts stay: a little larger they take long, rightly."""
    places = [n for n, word in enumerate(line) if not {*line[max(n - 1, 0) : n + 1]} & {"--count", "--rows", "--folds"}]
    place = random.choice(places)
    match random.randrange(4):
        case 0:
            word = mutated(os.fsencode(line[place]), random).decode("utf-8", "surrogateescape")
            return [*line[:place], word, *line[place + 1 :]]
        case 1:
            return [*line[:place], *line[place + 1 :]]
        case 2:
            return [*line[:place], line[place], *line[place:]]
        case _:
            return [*line[:place], random.choice([*PATHS, *WORDS, "--help", "-o"]), *line[place + 1 :]]


def _run_inside(work: Path, wanted: dict[str, Any]) -> int:
    """Run the command in this process, where a warning is an error and nothing outside the folder can be made."""
    arguments, here = wanted["arguments"], Path.cwd()
    os.chdir(work)
    try:
        with FileSystem(work.parent, failing=wanted.get("failing"), device=wanted.get("device")) as system:
            result = CliRunner().invoke(app, arguments, catch_exceptions=False)
        project = (work / "project.toml").read_bytes().decode("latin-1")
        words = [*arguments, *(word.partition("=")[2] for word in arguments), *re.findall(r"[\"'](.*?)[\"']", project)]
        named = [word.replace("\0", "").rstrip("/") for word in words]
        places = {os.path.realpath(os.path.dirname(word) or ".") for word in named}
        places |= {os.path.dirname(os.path.realpath(word)) for word in named}
        strange = [place for place in system.outside if os.path.realpath(os.path.dirname(place)) not in places]
        assert not strange, f"outside the folder: {strange}"
    finally:
        os.chdir(here)
    check_messages(result.exit_code, result.stdout, result.stderr, f"{' '.join(arguments)} {project}")
    return result.exit_code


def _run_as_program(work: Path, wanted: dict[str, Any]) -> int:
    """Run the command in a process of its own: with a full device or plain letters to print on, or ended half way."""
    way, arguments = wanted["as"], [word for word in wanted["arguments"] if "\0" not in word]
    if any(Path(word).is_absolute() or ".." in word for word in arguments):
        return -1  # there nothing would keep it from writing elsewhere
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"} if way == "ascii" else {}
    number = Random(wanted["after"]).choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP]) if way == "ended" else 0
    with tempfile.TemporaryFile() as printed, open("/dev/full", "wb") as full, tempfile.TemporaryFile() as error_stream:
        process = subprocess.Popen(
            [sys.executable, "-m", "fabkit", *arguments],
            cwd=work,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1", **plain},
            stdin=subprocess.DEVNULL,
            stdout=full if way == "full device" else printed,
            stderr=error_stream,
        )
        try:
            if number:
                try:
                    process.wait(wanted["after"])
                except subprocess.TimeoutExpired:
                    process.send_signal(number)
            code = process.wait()
        finally:
            process.kill()
        printed.seek(0)
        error_stream.seek(0)
        output, errors = printed.read().decode(), error_stream.read().decode()
    check_messages(code, output, errors, " ".join(arguments), signalled=number)
    return code


@cache
def _earlier() -> Files:
    """A small design, as `fabkit` wrote it into the folder earlier."""
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "earlier"
        CliRunner().invoke(app, ["design", "koebe", "--count", "2", "-o", str(out)], catch_exceptions=False)
        return {f"earlier/{path.name}": path.read_bytes() for path in out.iterdir()}


COMMAND_LINES = Kind("commands", inputs, attempt, ())
