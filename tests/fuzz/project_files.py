"""Damaged project files: a project, or one sentence that names the key; then inspected or built."""

from __future__ import annotations

from pathlib import Path
from random import Random

import command_lines
from driver import Files, Kind, mutated

from fabkit import load_project
from fabkit.errors import ProjectError

PROJECT = """# A roof
mesh = "mesh.obj"
unit = "m"
out = "out"
name = "Roof (ß)"
flip = false
skip_unbuildable = true
equal_within_mm = 1e-7
accept = ["moves", "lean"]

[planarise]
fairness = 0.1
keep_boundary = true

[gauss_image]
edges = 1.0
fairness = 0.01
rounds = 3

[beams]
width_mm = 40
height_mm = 100.5
reference = "centre"
material = "steel"

[connection]
kind = "contact"

[nodes]
clearance_mm = 5
setbacks = "least"

[[layers]]
thickness_mm = 8
joint_mm = 12
seat_mm = 3

[[zones]]
name = "North"
below_mm = 9e8

[sheets]
length_mm = 3000
width_mm = 2000

[nesting]
mode = "quick"
seconds = 10

[fitness]
moves_refused = 0.4

[densities_kg_m3]
steel = 7850
glass = 2500.0
"""

VALUES = [
    "",
    "0",
    "-1",
    "1e400",
    "-1e300",
    "1e-300",
    "nan",
    "-inf",
    "9" * 5000,
    "0x" + "f" * 400,
    "1_000",
    "true",
    "''",
]
VALUES += [
    "'x'",
    "[]",
    "[1, 'a']",
    "{}",
    "{ a = { b = 1 } }",
    "[" * 3000,
    "[" * 90 + "]" * 90,
    "1979-05-27",
    "07:32:00",
]
VALUES += [
    r'"C:\models\roof.obj"',
    r"'C:\models\roof.obj'",
    r'"C:\new\table.obj"',
    '"a\\u0000b"',
    r'"\ud800"',
    "'''\n'''",
]
VALUES += ["'missing.obj'", "'.'", "'..'", "'earlier'", "'folder'", "'/'", "''", "'second.obj'", "'" + "x" * 3000 + "'"]
VALUES += [
    "'mesh.obj'",
    "'loop.obj'",
    "'project.toml'",
    "1e9",
    "1000",
    "[nan]",
    "['moves', 'moves', 'nothing']",
    "'inf'",
]
VALUES += ["true", "false", "'inner'", "'equal'", "'off'", "'glass'", "['heights']", "'best'", "'ft'"]
NUMBERS = ["0.001", "0.5", "1", "2.5", "3", "10", "30", "200", "1e3", "9e8", "1e-8"]
KEYS = [
    "colour",
    "gauss_image.file",
    "beams",
    "mean_edge_mm",
    "'' ",
    "'屋根'",
    "a.b.c",
    "x" * 3000,
    "layers.z_mm",
    "layers.distance_mm",
    "layers.build_up",
    "layers.rim_step_mm",
    "out",
]
KEYS += ["fitness.nothing", "planarise.rounds", "__class__", "nesting.mode", "model_config", "'a b'", '"\\u001b[31m"']


def inputs(random: Random) -> Files:
    """A project file with faults, and a command that is to make something of it."""
    content = PROJECT if random.random() < 0.6 else "mesh = 'mesh.obj'\nunit = 'm'\nout = 'out'\n"
    for _ in range(random.choice([0, 1, 1, 1, 2])):
        content = _other_value(content, random)
    data = content.encode("utf-8", "surrogatepass")
    files = command_lines.files(random, damage=0.05)
    files["work/project.toml"] = mutated(data, random) if random.random() < 0.25 else data
    command = random.choice(
        [["build", "project.toml"], ["inspect", "project.toml"], ["build", "project.toml", "-o", "o"]]
    )
    return {**files, command_lines.ASKED: command_lines.asked(command, random)}


def attempt(folder: Path) -> str:
    """The file is a project with a name that can be written, or refused; and so says the command."""
    try:
        project = load_project(folder / "work" / "project.toml", {})
    except ProjectError:
        return command_lines.attempt(folder)
    project.title.encode()
    if project.nesting.mode == "best" and project.nesting.seconds > 1:
        return "not built"  # it takes as long as was asked for
    return command_lines.attempt(folder)


def _other_value(content: str, random: Random) -> str:
    """A line with another value, or one more line."""
    lines = content.split("\n")
    place = random.choice([n for n, line in enumerate(lines) if "=" in line])
    if random.random() < 0.8:
        key, _, value = lines[place].partition(" = ")
        values = NUMBERS if value[:1].isdigit() and random.random() < 0.6 else VALUES
        lines[place] = f"{key} = {random.choice(values)}"
    else:
        lines.insert(place, f"{random.choice(KEYS)} = {random.choice(VALUES)}")
    return "\n".join(lines)


PROJECT_FILES = Kind("projects", inputs, attempt, ())
