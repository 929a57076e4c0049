"""The marks of a finished folder, for a build that keeps them."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from pathlib import Path

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from fabkit.production import KeptMarks, MarkPoints
from fabkit.production.marks import only_ones
from fabkit.wording import echo

__all__ = ["kept_marks"]

_MARK = re.compile(r"[\w-]+")


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
    points: dict[tuple[str, str], dict[str, list[list[float]]]] = defaultdict(lambda: {"corner": [], "direction": []})
    materials: dict[tuple[str, str], str] = {}
    try:
        for row in contents.table("mark_points"):
            mark = row["Group"], _mark(row["Mark"])
            materials[mark] = row["Material"].removeprefix("'")
            points[mark][row["Point"]].append([_number(row[axis]) for axis in "xyz"])
        pieces = [(row["Mark"], int(row["Element"])) for row in contents.table("pieces")]
    except FolderError as error:
        raise FolderError(f"the marks of {folder} cannot be kept: {error}") from None
    except (KeyError, ValueError) as error:
        raise FolderError(
            f"the marks of {folder} cannot be kept: mark_points.csv or pieces.csv there is damaged, near {error}"
        ) from None
    found: dict[str, dict[str, MarkPoints]] = defaultdict(dict)
    for (group, name), each in points.items():
        corners, directions = (np.array(each[what]).reshape(-1, 3) for what in ("corner", "direction"))
        found[group][name] = MarkPoints(materials[group, name], corners, directions)
    kept: dict[str, KeptMarks] = {}
    for group, marks in found.items():
        kept[group] = KeptMarks(marks, only_ones((element, mark) for mark, element in pieces if mark in marks))
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
