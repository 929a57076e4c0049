"""Random damage to a finished folder, as copying, editing and failing disks do it."""

from __future__ import annotations

import random
import re
from pathlib import Path

__all__ = ["corrupt"]


def corrupt(folder: Path, source: random.Random) -> str:
    """Damage one file of the folder in one way; what was done."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    before = {path: path.read_bytes() for path in files}
    while True:
        path = source.choice(files)
        way = source.choice((_digit, _digit, _digit, _byte, _line, _cut, _gone, _exchanged))
        said = way(path, files, source)
        if {path: path.read_bytes() for path in files if path.exists()} != before:
            return f"{path.relative_to(folder)}: {said}"


def _digit(path: Path, files: list[Path], source: random.Random) -> str:
    data = bytearray(path.read_bytes())
    places = [found.start() for found in re.finditer(rb"[0-9]", data)]
    if places:
        place = source.choice(places)
        data[place] = ord(source.choice("0123456789"))
        path.write_bytes(data)
        return f"digit {place}: {bytes(data[max(0, place - 30) : place + 10])!r}"
    return ""


def _byte(path: Path, files: list[Path], source: random.Random) -> str:
    data = bytearray(path.read_bytes())
    place = source.randrange(len(data))
    data[place] ^= 1 << source.randrange(8)
    path.write_bytes(data)
    return f"byte {place}"


def _line(path: Path, files: list[Path], source: random.Random) -> str:
    lines = path.read_bytes().split(b"\n")
    del lines[source.randrange(len(lines))]
    path.write_bytes(b"\n".join(lines))
    return "a line is missing"


def _cut(path: Path, files: list[Path], source: random.Random) -> str:
    data = path.read_bytes()
    path.write_bytes(data[: source.randrange(len(data))])
    return "cut off"


def _gone(path: Path, files: list[Path], source: random.Random) -> str:
    path.unlink()
    return "gone"


def _exchanged(path: Path, files: list[Path], source: random.Random) -> str:
    other = source.choice([each for each in files if each.suffix == path.suffix])
    one, two = path.read_bytes(), other.read_bytes()
    path.write_bytes(two)
    other.write_bytes(one)
    return f"exchanged with {other.name}"
