"""Decoding of text files: UTF-8, UTF-16 or UTF-32, with or without a byte order mark."""

from __future__ import annotations

import codecs

__all__ = ["decoded", "spelled_out"]

_MARKS = [
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),  # before UTF-16, whose mark begins in the same way
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
]

_ZEROS = {
    (False, True, True, True): "utf-32-le",
    (True, True, True, False): "utf-32-be",
    (False, True, False, True): "utf-16-le",
    (True, False, True, False): "utf-16-be",
}
"""Encodings by which of the first four bytes are zero, for a text without mark that begins with two ASCII
characters."""


def decoded(data: bytes) -> str:
    """The text of a file, with lines ended by \\n; bytes that are invalid in its encoding, as in Latin-1 names, become
    �. Byte order marks are removed, also in the middle, where files were joined.
    """
    text = data.decode(_encoding(data), errors="replace").replace("\ufeff", "")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def spelled_out(data: bytes) -> bytes:
    """The bytes of a file in UTF-8, for files with a text header and binary data: only UTF-16 and UTF-32 are
    converted."""
    encoding = _encoding(data)
    if encoding == "utf-8":
        return data.removeprefix(codecs.BOM_UTF8)
    return data.decode(encoding, errors="replace").replace("\ufeff", "").encode()


def _encoding(data: bytes) -> str:
    for mark, name in _MARKS:
        if data.startswith(mark):
            return name
    return _ZEROS.get((data[:1] == b"\0", data[1:2] == b"\0", data[2:3] == b"\0", data[3:4] == b"\0"), "utf-8")
