"""Words of other people in our sentences: names of files, and values that were typed."""

from __future__ import annotations

import re
import reprlib
from datetime import date, time
from pathlib import Path

__all__ = ["echo", "readable"]

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60


def readable(name: str) -> str:
    r"""A name as text that can be written everywhere: bytes of a file's name that are not UTF-8 as \xff."""
    bytes_shown = re.sub("[\udc80-\udcff]", lambda found: f"\\x{ord(found[0]) - 0xDC00:02x}", name)
    return bytes_shown.encode("utf-8", "backslashreplace").decode("utf-8")


def echo(value: object) -> str:
    """A value as it is written in Python, without its middle where it is long; dates and times as people write them."""
    if isinstance(value, date | time):
        return str(value)
    try:
        return _SHORT.repr(str(value) if isinstance(value, Path) else value)
    except ValueError:  # of more digits than Python writes
        return "a number of thousands of digits"
