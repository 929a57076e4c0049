"""DXF files of a finished folder against the solids of its panels and the places in its tables."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from geometry.arrays import FloatArray

__all__ = ["check_heads", "check_panel", "check_sheet", "dxf_curves"]

OUTLINE_TOLERANCE_MM = 0.0025
"""Largest distance in mm of a corner of a contour from where solid and tables have it: places of panels have 3
decimals, their turns 6, on sheets of 10 m."""

_DECIMALS, _NEXT_HANDLE = re.compile(r"^.*\..*\d$", re.MULTILINE), re.compile(r"\$HANDSEED\n.*\n.*")
"""A line with a number that has decimals; the variable with the next free handle."""

Curve = tuple[bool, FloatArray]
"""Whether it is closed, and its points (k, 2)."""


def dxf_curves(contents: Contents, name: str) -> tuple[dict[str, list[Curve]], str]:
    """The polylines of each layer, and the text of the file before and after its entities. Raises FolderError."""
    text = contents.text(name)
    head, _, rest = text.partition("  2\nENTITIES\n")
    body, _, tail = rest.partition("  0\nENDSEC\n")
    if not tail.endswith("  0\nEOF\n"):
        raise FolderError(f"{name} is no complete DXF file")
    curves: dict[str, list[Curve]] = defaultdict(list)
    try:
        for entity in body.split("  0\nLWPOLYLINE\n")[1:]:
            lines = entity.split("  0\n")[0].splitlines()
            pairs = list(zip(lines[::2], lines[1::2], strict=True))
            codes = [code.strip() for code, _ in pairs]
            x = [float(value) for code, value in zip(codes, lines[1::2], strict=True) if code == "10"]
            y = [float(value) for code, value in zip(codes, lines[1::2], strict=True) if code == "20"]
            known = dict(zip(codes, lines[1::2], strict=True))
            if (
                codes[-2 * len(x) :] != ["10", "20"] * len(x)
                or int(known["90"]) != len(x)
                or known["100"] != "AcDbPolyline"
            ):
                raise ValueError
            curves[known["8"]].append((bool(int(known["70"])), np.array([x, y]).T))
    except (ValueError, KeyError):
        raise FolderError(f"{name} has a polyline that cannot be read") from None
    return curves, head + tail


def check_heads(heads: dict[str, str]) -> Iterator[str]:
    """What is around the entities is the same in all files, but for numbers with decimals and the next free handle."""
    texts: dict[str, list[str]] = defaultdict(list)
    for name, text in heads.items():
        texts[_DECIMALS.sub("", _NEXT_HANDLE.sub("", text))].append(name)
    usual = max(texts.values(), key=len, default=[])
    for names in texts.values():
        if names is not usual:
            yield f"the head of {', '.join(names[:5])} is not that of the other DXF files"


def check_panel(name: str, curves: dict[str, list[Curve]], outline: FloatArray) -> Iterator[str]:
    """The contour of a panel's drawing against its solid."""
    cut = curves.get("CUT", [])
    if len(cut) != 1 or not cut[0][0] or not _same(cut[0][1], outline):
        yield f"the contour of {name} is not that of the solid of its panel"
    low, high = outline.min(axis=0), outline.max(axis=0)
    if not all((low <= points).all() and (points <= high).all() for _, points in curves.get("MARK", [])):
        yield f"{name} has a mark beside its contour"
    if curves.keys() - {"CUT", "MARK"}:
        yield f"{name} has layers {', '.join(sorted(curves.keys() - {'CUT', 'MARK'}))}"


def check_sheet(
    name: str, curves: dict[str, list[Curve]], rows: list[dict[str, str]], outlines: dict[str, FloatArray]
) -> Iterator[str]:
    """The contours of a sheet against the places that the table of pieces has for it."""
    cut = [points for is_closed, points in curves.get("CUT", []) if is_closed]
    if len(cut) != len(curves.get("CUT", [])) or len(cut) != len(rows):
        yield f"{name} has {len(curves.get('CUT', []))} contours, pieces.csv has {len(rows)} pieces there"
    if len(curves.get("SHEET", [])) != 1:
        yield f"{name} has {len(curves.get('SHEET', []))} outlines of its sheet, one is needed"
    for row in rows:
        turn = np.radians(float(row["Sheet turn (deg)"]))
        x, y = float(row["Sheet x (mm)"]), float(row["Sheet y (mm)"])
        turning = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        placed = outlines[row["Mark"]] @ turning + [x, y]
        if not any(_same(points, placed) for points in cut):
            yield f"{row['Piece']} is not on {name} where pieces.csv has it"


def _same(points: FloatArray, outline: FloatArray) -> bool:
    return points.shape == outline.shape and bool(np.abs(points - outline).max() <= OUTLINE_TOLERANCE_MM)
