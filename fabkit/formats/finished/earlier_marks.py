"""The marks of a finished folder, for a build that keeps them."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from pathlib import Path

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from fabkit.production import KeptMarks, MarkPoints

__all__ = ["kept_marks"]

_TABLES = ("mark_points", "placements", "pieces")
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
    _check_tables(contents)
    points: dict[tuple[str, str], dict[str, list[list[float]]]] = defaultdict(lambda: {"corner": [], "direction": []})
    materials: dict[tuple[str, str], str] = {}
    pieces: dict[str, list[tuple[list[float], list[float]]]] = defaultdict(list)
    try:
        for row in contents.table("mark_points"):
            mark = row["Group"], row["Mark"]
            materials[mark] = row["Material"].removeprefix("'")
            points[mark][row["Point"]].append([float(row[axis]) for axis in "xyz"])
        off = {row["Piece"]: [float(row[name] or 0) for name in _HIDDEN] for row in contents.table("pieces")}
        for row in contents.table("placements"):
            pieces[row["Mark"]].append(([float(row[name]) for name in _CENTRE], off[row["Piece"]]))
    except (KeyError, ValueError) as error:
        raise FolderError(
            f"mark_points.csv, placements.csv or pieces.csv of {folder} is damaged, so its marks cannot be kept: there "
            f"is no {error} where one is needed"
        ) from None
    found: dict[str, dict[str, MarkPoints]] = defaultdict(dict)
    for (group, name), each in points.items():
        corners, directions = (np.array(each[what]).reshape(-1, 3) for what in ("corner", "direction"))
        found[group][name] = MarkPoints(materials[group, name], corners, directions)
    kept: dict[str, KeptMarks] = {}
    for group, marks in found.items():
        own = tuple(mark for mark in marks for _ in pieces[mark])
        centres = np.array([centre for mark in marks for centre, _ in pieces[mark]]).reshape(-1, 3)
        hidden = np.array([each for mark in marks for _, each in pieces[mark]]).reshape(-1, 2)
        kept[group] = KeptMarks(marks, own, centres, hidden)
    return kept


def _check_tables(contents: Contents) -> None:
    """Raise FolderError unless the tables that are read are those that were written."""
    for name in (f"{table}.csv" for table in _TABLES):
        if name not in contents.files:
            raise FolderError(
                f"{contents.folder} has no {name}, so its marks cannot be kept: it is of another version of fabkit, or "
                "was built without 'tables' among its documents"
            )
        path = contents.folder / name
        if not path.is_file() or hashlib.sha256(path.read_bytes()).hexdigest() != contents.files[name]:
            raise FolderError(
                f"{name} of {contents.folder} is damaged or missing, so its marks cannot be kept: it is not as fabkit "
                "build wrote it; take an untouched copy of the folder"
            )
