"""What a command may leave behind: sentences at the terminal, and one whole folder or nothing."""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

import typer

from fabkit.commands.command_line import app
from fabkit.formats.manifest import MANIFEST, foreign_files

__all__ = ["check_folder", "check_said", "snapshot"]

STAGE = re.compile(r"(\S|\\u[0-9a-f]{4}) .* (\d+:\d\d:\d\d|-:--:--)")
"""What shows the stages of a build where standard error is no terminal."""

SENTENCE = re.compile(r"fabkit: .{1,600}")
"""Three lines of 200 characters at most."""

ELEMENT = re.compile(r"(?<![\w-])(vertex|edge|face) \d+\b")
OPTION = re.compile(r"(?<![\w/-])--[a-z][a-z-]*")


def check_said(code: int, output: str, errors: str, given: str, *, signalled: int = 0) -> None:
    """Assert that a run ended as it may, and spoke as it should. given: all that the user had written."""
    lines = [line for line in errors.split("\n") if line.strip() and not STAGE.fullmatch(line.rstrip())]
    assert code in ({0, 1, 2} | ({128 + signalled, -signalled} if signalled else set())), f"exit code {code}: {errors}"
    if code == 2 and "Usage" not in output:
        assert len(lines) == 1, f"{len(lines)} lines on standard error: {errors}"
        assert SENTENCE.fullmatch(lines[0]), f"no sentence: {errors}"
    elif not signalled:  # which may come when all is said
        assert lines == [], f"exit code {code}, but said: {errors}"
    for line in [*lines, *re.sub(r"\s*\n {3,}", " ", output).split("\n")]:  # a fact continues where a line is full
        assert line.isprintable(), f"not printable: {line!r}"
        assert "Traceback" not in line, line
        unknown = set(OPTION.findall(line)) - _options() - set(OPTION.findall(given))
        assert not unknown, f"no such option {unknown}: {line}"
        if ELEMENT.search(line):
            assert re.search("count(s|ed) (vertices )?(from|back)", line), f"from where is it counted? {line}"


def snapshot(folder: Path) -> dict[Path, str]:
    """All that is in a folder."""
    return {path: _content(path) for path in sorted(folder.rglob("*"))}


def check_folder(before: dict[Path, str], after: dict[Path, str], *, may_write: bool) -> None:
    """Assert that all is as before, but for one folder that appeared or was replaced, whole."""
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
