"""The tables of a TOML file, or one sentence that says what is wrong with it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from fabkit.errors import ProjectError

__all__ = ["BACKSLASHES", "read_tables"]

BACKSLASHES = r"write backslashes in single quotes, as in 'C:\models\roof.obj', or forward slashes"


def read_tables(path: Path) -> dict[str, Any]:
    """What stands in a TOML file. Raises ProjectError where it cannot be read or is not TOML.

    >>> _ = Path("roof.toml").write_text('mesh = "roof.obj"\\nunit = m')
    >>> try:
    ...     read_tables(Path("roof.toml"))
    ... except ProjectError as error:
    ...     print(str(error).split("; ")[1])
    texts stand in quotes, as in unit = 'm'
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise ProjectError(f"there is no project file {path}") from None
    except OSError as error:
        raise ProjectError(f"the project file {path} cannot be read: {error.strerror or error}") from None
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise ProjectError(
            f"{path.name} is not UTF-8 text (byte {error.start + 1} is {data[error.start]:#04x}): save it as UTF-8"
        ) from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ProjectError(f"{path.name} is nested too deeply: a project has tables in two levels") from None
    except tomllib.TOMLDecodeError as error:
        raise ProjectError(f"{path.name} is not TOML: {error}{_cure(text, str(error))}") from None
    except ValueError:
        raise ProjectError(f"{path.name} has a number of thousands of digits: write fewer") from None


def _cure(text: str, message: str) -> str:
    r"""What to do where a line has "C:\models\roof.obj", in which TOML reads \m and \r as signs of its own."""
    number = re.search(r"at line (\d+)", message)
    line = text.split("\n")[int(number[1]) - 1 if number else -1]
    if re.search("overwrite|twice|Duplicate", message):
        return "; the key or table is there twice: take one of the two out"
    if "Invalid value" in message:
        return "; texts stand in quotes, as in unit = 'm'"
    return f"; {BACKSLASHES}" if re.search(r'"[^"]*\\', line) else ""
