"""The marks of a finished folder, for a build that keeps them."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from pathlib import Path

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from fabkit.production import MARK_POINTS, KeptMarks, MarkPoints
from fabkit.wording import echo

__all__ = ["kept_marks"]

_MARK = re.compile(r"[\w-]+")
_TABLES = ("mark_points.csv", "placements.csv", "pieces.csv")
_CENTRE = ("Centre x (mm)", "Centre y (mm)", "Centre z (mm)")
_HIDDEN = ("Hidden difference (mm)", "Hidden at far ends (mm)")


def kept_marks(folder: Path) -> dict[str, KeptMarks]:
    """By groups, by what the marks of a folder that `fabkit build` wrote are recognised.

    Raises FolderError where it is no such folder, one of another version or without tables, or where it is damaged.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.formats.finished import kept_marks
    >>> _ = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out="roof"))
    >>> list(kept_marks(Path("roof"))["nodes"].points)
    ['N001', 'N002']
    """
    contents = Contents(folder)
    if "mark_points.csv" not in contents.files:
        raise FolderError(
            f"{folder} has no mark_points.csv, so its marks cannot be kept: it is of another version of fabkit, or was "
            "built without 'tables' among its documents"
        )
    points: dict[tuple[str, str], dict[str, list[list[float]]]] = defaultdict(
        lambda: {what: [] for what in MARK_POINTS}
    )
    materials: dict[tuple[str, str], str] = {}
    pieces: dict[str, list[tuple[list[float], list[float]]]] = defaultdict(list)
    try:
        for row in contents.table("mark_points"):
            mark = row["Group"], _mark(row["Mark"])
            materials[mark] = row["Material"].removeprefix("'")
            points[mark][row["Point"]].append([_number(row[axis]) for axis in "xyz"])
        off = {row["Piece"]: [_number(row[name] or "0") for name in _HIDDEN] for row in contents.table("pieces")}
        for row in contents.table("placements"):
            pieces[row["Mark"]].append(([_number(row[name]) for name in _CENTRE], off[row["Piece"]]))
        contents.check_unchanged(_TABLES)
    except FolderError as error:
        raise FolderError(f"the marks of {folder} cannot be kept: {error}") from None
    except (KeyError, ValueError) as error:
        raise FolderError(
            f"the marks of {folder} cannot be kept: {', '.join(_TABLES[:2])} or {_TABLES[2]} there is damaged, near "
            f"{error}"
        ) from None
    found: dict[str, dict[str, MarkPoints]] = defaultdict(dict)
    latest: dict[str, dict[str, MarkPoints]] = defaultdict(dict)
    for (group, name), each in points.items():
        last, first = (
            MarkPoints(materials[group, name], *(np.array(each[what]).reshape(-1, 3) for what in pair))
            for pair in (MARK_POINTS[:2], MARK_POINTS[2:])
        )
        found[group][name] = last
        if len(first.corners):
            found[group][name], latest[group][name] = first, last
            if first.shape != last.shape:
                raise FolderError(f"the marks of {folder} cannot be kept: mark_points.csv there lacks points of {name}")
    kept: dict[str, KeptMarks] = {}
    for group, marks in found.items():
        own = tuple(mark for mark in marks for _ in pieces[mark])
        centres = np.array([centre for mark in marks for centre, _ in pieces[mark]]).reshape(-1, 3)
        hidden = np.array([each for mark in marks for _, each in pieces[mark]]).reshape(-1, 2)
        kept[group] = KeptMarks(marks, latest[group], own, centres, hidden)
    return kept


def _mark(text: str) -> str:
    """A mark, which is the name of files. Raises ValueError for another text."""
    if not _MARK.fullmatch(text):
        raise ValueError(echo(text))
    return text


def _number(text: str) -> float:
    """Raises ValueError for what is no finite number."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(echo(text))
    return number
