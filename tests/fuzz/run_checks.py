"""Checks of a run of the command line: its exit code, its messages, and the files that it leaves."""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

import typer

from fabkit.commands.command_line import app
from fabkit.formats.manifest import MANIFEST, foreign_files

__all__ = ["check_folder", "check_messages", "snapshot"]

STAGE = re.compile(r"(\S|\\u[0-9a-f]{4}) .* (\d+:\d\d:\d\d|-:--:--)")
"""A line that shows a stage of a build, where standard error is no terminal."""

SENTENCE = re.compile(r"fabkit: .{1,600}")
"""An error message: at most three lines of 200 characters."""

ELEMENT = re.compile(r"(?<![\w-])(vertex|edge|face) \d+\b")
OPTION = re.compile(r"(?<![\w/-])--[a-z][a-z-]*")


def check_messages(code: int, output: str, errors: str, given: str, *, signalled: int = 0) -> None:
    """Assert that exit code, standard output and standard error of a run are as they should be.

    given: everything that the user typed or wrote into files. signalled: number of the signal sent to the run, or 0.
    """
    lines = [line for line in errors.split("\n") if line.strip() and not STAGE.fullmatch(line.rstrip())]
    assert code in ({0, 1, 2} | ({128 + signalled, -signalled} if signalled else set())), f"exit code {code}: {errors}"
    if code == 2 and "Usage" not in output:
        assert len(lines) == 1, f"{len(lines)} lines on standard error: {errors}"
        assert SENTENCE.fullmatch(lines[0]), f"no sentence: {errors}"
    elif not signalled:  # a signal may arrive after the last message
        assert lines == [], f"exit code {code}, but on standard error: {errors}"
    for line in [*lines, *re.sub(r"\s*\n {3,}", " ", output).split("\n")]:  # long facts continue on the next line
        assert line.isprintable(), f"not printable: {line!r}"
        assert "Traceback" not in line, line
        unknown = set(OPTION.findall(line)) - _options() - set(OPTION.findall(given))
        assert not unknown, f"no such option {unknown}: {line}"
        if ELEMENT.search(line):
            assert re.search("count(s|ed) (vertices )?(from|back)", line), "elements without the number "
            f"from which they are counted: {line}"


def snapshot(folder: Path) -> dict[Path, str]:
    """The contents of a folder: a hash for each file, by its path."""
    return {path: _content(path) for path in sorted(folder.rglob("*"))}


def check_folder(before: dict[Path, str], after: dict[Path, str], *, may_write: bool) -> None:
    """Assert that nothing has changed except for one complete folder, which is new or was replaced."""
    changed = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
    if not changed:
        return
    manifests = [path for path in changed if path.name == MANIFEST and path in after]
    assert len(manifests) == 1, f"no whole folder, but changed: {changed[:5]}"
    out = manifests[0].parent
    assert all(path == out or out in path.parents for path in changed), f"changed outside {out}: {changed[:5]}"
    assert list(foreign_files(out)) == [], f"half-written: {list(foreign_files(out))}"
    assert may_write, f"written by a run that failed: {out}"


def _content(path: Path) -> str:
    if path.is_symlink():
        return f"link to {path.readlink()}"
    return "folder" if path.is_dir() else hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def _options() -> set[str]:
    """All options of all commands."""
    found, commands = {"--help"}, [typer.main.get_command(app)]
    while commands:
        command = commands.pop()
        found |= {option for parameter in command.params for option in parameter.opts}
        commands += getattr(command, "commands", {}).values()
    return found
