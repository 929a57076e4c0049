"""Names of files and typed values, as they are quoted in messages."""

from __future__ import annotations

import re
import reprlib
from datetime import date, time
from pathlib import Path

__all__ = ["echo", "one_line", "readable"]

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60


def readable(name: str) -> str:
    r"""A file name as printable UTF-8 text; bytes that are not UTF-8 are written as \xff."""
    bytes_shown = re.sub("[\udc80-\udcff]", lambda found: f"\\x{ord(found[0]) - 0xDC00:02x}", name)
    return bytes_shown.encode("utf-8", "backslashreplace").decode("utf-8")


def echo(value: object) -> str:
    """A value as it is written in Python, shortened in the middle if it is long; dates and times as in ISO 8601."""
    if isinstance(value, date | time):
        return str(value)
    try:
        return _SHORT.repr(str(value) if isinstance(value, Path) else value)
    except ValueError:  # of more digits than Python writes
        return "a number of thousands of digits"


def one_line(text: str) -> str:
    """The text of a name or a title as it is. Raises ValueError where it has line breaks or control characters."""
    if not text.isprintable():
        raise ValueError("line breaks and control characters cannot stand in a name or title; take them out")
    return text
