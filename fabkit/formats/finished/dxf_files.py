"""DXF files as fabkit writes them, read strictly: a line that is not one of such a file is damage."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.drawings.dxf import LETTER_WIDTH, LINE_SPACING, TITLE_SHARE, VIEW_SHARE
from fabkit.formats.finished.contents import Contents
from geometry.arrays import FloatArray

__all__ = ["OUTLINE_TOLERANCE_MM", "Curve", "DxfFile", "dxf_file", "stem_of"]

OUTLINE_TOLERANCE_MM = 0.0025
"""Largest distance in mm of a corner of a contour from where solid and tables have it: places of panels have 3
decimals, their turns 6, on sheets of 10 m."""
EXTENT_TOLERANCE_MM = 1e-6
"""Largest difference in mm of the extents, of the view and of the places of the title from those of the curves, whose
coordinates have 9 decimals."""

_N = r"-?[0-9.]+(?:e[-+]?[0-9]+)?"
_PLACE = rf" 10\n({_N})\n 20\n({_N})\n 30\n0\.0\n 40\n({_N})\n"
_R12 = re.compile(
    r"(  0\nPOLYLINE\n  5\n\w+\n  8\n(\w+)\n 66\n1\n 10\n0\.0\n 20\n0\.0\n 30\n0\.0\n 70\n([01])\n()"
    rf"((?:  0\nVERTEX\n  5\n\w+\n  8\n\2\n 10\n{_N}\n 20\n{_N}\n 30\n0\.0\n)+)  0\nSEQEND\n  5\n\w+\n  8\n\2\n)"
    rf"|(  0\nCIRCLE\n  5\n\w+\n  8\n(\w+)\n{_PLACE})"
    rf"|(  0\nTEXT\n  5\n\w+\n  8\nTITLE\n{_PLACE}  1\n([^\n]*)\n)"
)
_OWNED = r"  5\n\w+\n330\n\w+\n100\nAcDbEntity\n  8\n"
_LATER = re.compile(
    rf"(  0\nLWPOLYLINE\n{_OWNED}(\w+)\n100\nAcDbPolyline\n 90\n(\d+)\n 70\n([01])\n((?: 10\n{_N}\n 20\n{_N}\n)+))"
    rf"|(  0\nCIRCLE\n{_OWNED}(\w+)\n100\nAcDbCircle\n{_PLACE})"
    rf"|(  0\nTEXT\n{_OWNED}TITLE\n100\nAcDbText\n{_PLACE}  1\n([^\n]*)\n100\nAcDbText\n)"
)
"""The entities of files: polylines, circles and texts."""
_CODED = re.compile(r"\\U\+[0-9A-F]{4}|% %|\^ ")
_HANDLE = re.compile(r"^  5\n([0-9A-F]+)$", re.MULTILINE)
_OWNER = re.compile(r"^  5\n\w+\n330\n(\w+)$", re.MULTILINE)
_VERTEX = re.compile(rf"^ 10\n({_N})\n 20\n({_N})$", re.MULTILINE)
_SLOT = rf"({_N})"
_AROUND = re.compile(
    rf"(.*?\$EXTMIN\n 10\n){_SLOT}(\n 20\n){_SLOT}(\n 30\n0\.0\n  9\n\$EXTMAX\n 10\n){_SLOT}(\n 20\n){_SLOT}"
    rf"(.*?\$HANDSEED\n  5\n)([0-9A-F]+)(.*?\*Active\n.*?\n 12\n){_SLOT}(\n 22\n){_SLOT}(.*?\n 40\n){_SLOT}"
    rf"(?:(.*?AcDbLayout\n  1\nModel\n.*?\n 14\n){_SLOT}(\n 24\n){_SLOT}(\n 34\n0\.0\n 15\n){_SLOT}(\n 25\n){_SLOT})?"
    r"(.*)",
    re.DOTALL,
)
"""What is around the entities, in pieces, between which are the extents, the next free handle, the view, and, but for
R12, the extents again."""

Curve = tuple[bool, FloatArray]
"""Whether it is closed, and its points (k, 2)."""


@dataclass(frozen=True)
class DxfFile:
    """Curves (k, 2) and circles (k, 3) by layer; title: the lines of text below; around: the text before and after the
    entities, without what depends on them."""

    curves: dict[str, list[Curve]]
    circles: dict[str, list[FloatArray]]
    title: tuple[str, ...]
    around: tuple[str, ...]


def stem_of(name: str) -> str:
    """The mark or sheet of which a file, by its path, is the drawing."""
    return name.rpartition("/")[2].removesuffix(".dxf").removesuffix("-mm")


def dxf_file(contents: Contents, name: str, known: list[tuple[str, ...]]) -> DxfFile:
    """Read a file, and compare its counts, handles, extents, view and places of text with its curves. known: texts
    around the entities of files that were read before, to which its own is added if it is another one. Raises
    FolderError with what is wrong."""
    text = contents.text(name)
    head, _, rest = text.partition("  2\nENTITIES\n")
    body, _, tail = rest.partition("  0\nENDSEC\n")
    if not tail.endswith("  0\nEOF\n"):
        raise FolderError(f"{name} is no complete DXF file")
    is_r12 = contents.manifest["settings"]["drawings"]["version"] == "R12"
    found = (_R12 if is_r12 else _LATER).findall(body)
    if sum(len(each[0]) + len(each[5]) + len(each[10]) for each in found) != len(body):
        raise FolderError(f"{name} has an entity that cannot be read")
    try:
        curves, circles = _curves(found, is_r12)
        places = np.array([each[11:14] for each in found if each[10]], dtype=float).reshape(-1, 3)
        around, slots = _around(head + tail, known)
        low, high = (np.array(slots[k : k + 2], dtype=float) for k in (0, 2))
        seed, view = int(slots[4], 16), np.array(slots[5:8], dtype=float)
    except ValueError:
        raise FolderError(f"{name} has a number that cannot be read, or a head that is not of such a file") from None
    owners = set(_OWNER.findall(body))
    if len(owners) > 1:
        raise FolderError(f"{name} has entities of different owners: {', '.join(sorted(owners))}")
    handles = [int(each, 16) for each in _HANDLE.findall(body)]
    if handles != list(range(seed - len(handles), seed)):
        raise FolderError(f"{name} has handles that do not follow on each other up to {seed:X}")
    title = tuple(each[14] for each in found if each[10])
    _check_extents(name, curves, circles, places, title, np.stack([low, high]))
    if np.abs(view - [*(low + high) / 2, VIEW_SHARE * (high - low).max()]).max() > EXTENT_TOLERANCE_MM:
        raise FolderError(f"{name} opens with a view that is not that of its curves")
    if slots[8:] not in ([], slots[:4]):
        raise FolderError(f"{name} has two extents that differ")
    return DxfFile(curves, circles, title, (*around, *owners))


def _curves(found: list[tuple[str, ...]], is_r12: bool) -> tuple[dict[str, list[Curve]], dict[str, list[FloatArray]]]:
    curves: dict[str, list[Curve]] = defaultdict(list)
    circles: dict[str, list[FloatArray]] = defaultdict(list)
    for each in found:
        if each[0]:
            layer, count, closed = (each[1], each[3], each[2]) if is_r12 else each[1:4]
            words = [word for pair in _VERTEX.findall(each[4]) for word in pair] if is_r12 else each[4].split()[1::2]
            points = np.array(words, dtype=float).reshape(-1, 2)
            if not is_r12 and int(count) != len(points):
                raise ValueError
            curves[layer].append((closed == "1", points))
        elif each[5]:
            circles[each[6]].append(np.array(each[7:10], dtype=float))
    return curves, circles


def _around(text: str, known: list[tuple[str, ...]]) -> tuple[tuple[str, ...], list[str]]:
    for pieces in known:
        slots = _between(text, pieces)
        if slots is not None:
            return pieces, slots
    found = _AROUND.fullmatch(text)
    if found is None:
        raise ValueError
    pieces = tuple(piece for piece in found.groups()[::2] if piece is not None)
    known.append(pieces)
    return pieces, [slot for slot in found.groups()[1::2] if slot is not None]


def _between(text: str, pieces: tuple[str, ...]) -> list[str] | None:
    """What is between the pieces in the text; None where it does not consist of them."""
    at, slots = 0, []
    for piece in pieces[:-1]:
        if not text.startswith(piece, at):
            return None
        end = text.find("\n", at + len(piece))
        slots.append(text[at + len(piece) : end])
        at = end
    return slots if text[at:] == pieces[-1] else None


def _check_extents(
    name: str,
    curves: dict[str, list[Curve]],
    circles: dict[str, list[FloatArray]],
    places: FloatArray,
    title: tuple[str, ...],
    extents: FloatArray,
) -> None:
    """The extents (2, 2) against the curves, circles and lines of text, and the places of these below the others."""
    rings = [ring for own in circles.values() for ring in own]
    points = [points for own in curves.values() for _, points in own]
    points += [ring[None, :2] + side * ring[2] for ring in rings for side in (-1, 1)]
    if not points:
        raise FolderError(f"{name} has no curves")
    every = np.concatenate(points)
    least, largest = every.min(axis=0), every.max(axis=0)
    letters = TITLE_SHARE * float((largest - least).max())
    lines = 1.0 + np.arange(len(places))[:, None]
    wanted = np.hstack([least - lines * [0.0, LINE_SPACING * letters], np.full((len(places), 1), letters)])
    if np.abs(places - wanted).max(initial=0.0) > EXTENT_TOLERANCE_MM:
        raise FolderError(f"{name} has a line of text that is not below its curves")
    least = least - [0.0, LINE_SPACING * letters * len(places)]
    written = max(map(len, title), default=0)
    drawn = max((len(_CODED.sub("*", line)) for line in title), default=0)  # letters that are written as several
    widths = letters * LETTER_WIDTH * np.array([drawn, written])
    right = np.maximum(largest[0], least[0] + widths)
    off = np.abs([*(extents[0] - least), extents[1, 1] - largest[1]]).max()
    if (
        off > EXTENT_TOLERANCE_MM
        or not -EXTENT_TOLERANCE_MM <= extents[1, 0] - right[0] <= np.ptp(right) + EXTENT_TOLERANCE_MM
    ):
        raise FolderError(f"{name} has extents that are not those of its curves")
