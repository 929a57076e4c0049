"""How two finished folders differ: which pieces are new, gone or changed, from their tables alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents, in_words
from fabkit.formats.finished.step_checks import COORDINATE_TOLERANCE_MM
from fabkit.formats.report import ShownModel, differences_html
from fabkit.parts import Cell, Column
from fabkit.production import Table
from geometry.arrays import FloatArray

__all__ = ["differences_page", "folder_differences"]

SAME_SIZE = 0.011
"""Largest difference in mm or degrees of sizes that are put down to their two decimals."""
OWN_PLACE = 0.5
"""Largest movement of a piece that is found again by its place alone, over the distance to its nearest neighbour of the
same kind."""

COLUMNS = (
    "Change",
    "Kind",
    "Piece before",
    "Piece now",
    "Moved (mm)",
    "Size (mm)",
    "Angle (deg)",
    "Mass (kg)",
    "Mark",
    "Zone",
)
DECIMALS = (None, None, None, None, 3, 2, 2, 3, None, None)
_NOTHING = (None, None, None, None, "", "")


@dataclass(frozen=True)
class _Piece:
    name: str
    mark: str
    kind: str
    zone: str
    element: int
    ends: tuple[str, str]
    centre: FloatArray
    mass_kg: float
    sizes_mm: FloatArray
    angles_deg: FloatArray


def folder_differences(old: Path, new: Path) -> Table:
    """One row for each piece that is new, gone or changed, none where the folders describe the same structure.

    Moved: of the centre of mass; size, angle, mass: the largest differences of its sizes, angles and mass; mark, zone:
    where it has another one. Pieces are the same where they are on the same element of the mesh, if the beams of both
    folders have the same nodes at their ends; else where they are nearest to each other. Raises FolderError where one
    of the folders lacks the tables.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.formats.finished import folder_differences
    >>> for name, thickness in (("a", 10), ("b", 12)):
    ...     _ = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=name, layers=[{"thickness_mm": thickness}]))
    >>> len(folder_differences(Path("a"), Path("a")).rows)
    0
    >>> {row[:2] for row in folder_differences(Path("a"), Path("b")).rows}
    {('changed', 'panel')}
    """
    before, after = _pieces(Contents(old)), _pieces(Contents(new))
    rows: list[tuple[Cell, ...]] = []
    by_element = _same_elements(before, after)
    for kind in dict.fromkeys([*(each.kind for each in before), *(each.kind for each in after)]):
        one, other = ([each for each in pieces if each.kind == kind] for pieces in (before, after))
        pairs = _by_element(one, other) if by_element else _by_place(one, other)
        known = set(pairs.values())
        rows += [("gone", kind, each.name, "", *_NOTHING) for k, each in enumerate(one) if k not in pairs]
        rows += [("new", kind, "", each.name, *_NOTHING) for k, each in enumerate(other) if k not in known]
        changes = (_changed(one[k], other[n]) for k, n in pairs.items())
        rows += [row for row in changes if row]
    cells: Sequence[Sequence[Cell]] = list(zip(*rows, strict=True)) or [()] * len(COLUMNS)
    return Table("differences", tuple(map(Column, COLUMNS, DECIMALS, cells)))


def differences_page(old: Path, new: Path, table: Table) -> str:
    """The text of a page that shows the table of differences in colours, with the models of both reports.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.formats.finished import differences_page, folder_differences
    >>> for name, thickness in (("a", 10), ("b", 12)):
    ...     _ = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=name, layers=[{"thickness_mm": thickness}]))
    >>> page = differences_page(Path("a"), Path("b"), folder_differences(Path("a"), Path("b")))
    >>> "<dt>Changed</dt><dd>4</dd>" in page
    True
    """
    earlier, later = (_shown(Contents(folder)) for folder in (old, new))
    names = (folder.resolve().name or str(folder) for folder in (old, new))
    return differences_html(f"Changes from {' to '.join(names)}", table, earlier, later)


def _shown(contents: Contents) -> ShownModel:
    if "report.html" not in contents.files:
        raise FolderError(f"{contents.folder} lacks report.html: build it with 'report' among its documents")
    try:
        page, arrays = contents.report
        middle = np.array(contents.manifest["origin"]["mm"]) + page["model"]["middle_mm"]
        return ShownModel(page["pieces"]["cells"][0], page["model"], arrays, middle.tolist())
    except (FolderError, KeyError, IndexError, TypeError, ValueError):
        raise FolderError(
            f"report.html in {contents.folder} has no model that can be read: it is damaged, or of another version of "
            "fabkit; build the folder again"
        ) from None


def _pieces(contents: Contents) -> list[_Piece]:
    """The pieces with all lengths and angles that the tables have of them, each in order of size: a piece that is
    turned end for end is the same."""
    needed = {"pieces.csv", "placements.csv"}
    if not needed <= contents.files.keys():
        lacking = ", ".join(sorted(needed - contents.files.keys()))
        raise FolderError(f"{contents.folder} lacks {lacking}: build it with 'tables' among its documents")
    values: dict[str, dict[str, list[float]]] = defaultdict(lambda: {"(mm)": [], "(deg)": []})
    try:
        contents.check_unchanged([name for name in contents.files if name.endswith(".csv")])
        for name in contents.files:
            if not name.endswith(".csv") or name in ("pieces.csv", "placements.csv", "survey.csv", "legend.csv"):
                continue
            table = contents.table(name.removesuffix(".csv"))
            for row in table:
                for column, text in row.items():
                    unit = column.rpartition(" ")[2]
                    if unit in ("(mm)", "(deg)") and text and not column.startswith(("Least", "Largest", "Dihedral")):
                        values[row[table.columns[0]]][unit].append(float(text))
        centres = {
            row["Piece"]: np.array([float(row[f"Centre {axis} (mm)"]) for axis in "xyz"])
            for row in contents.table("placements")
        }
        found = []
        for row in contents.table("pieces"):
            of_mark, own = values[row["Mark"]], values[row["Piece"]]
            sizes, angles = (np.sort([*of_mark[unit], *own[unit]]) for unit in ("(mm)", "(deg)"))
            ends = (row["Node A"].rpartition(" ")[2], row["Node B"].rpartition(" ")[2])
            number, mass = int(row["Element"]), float(row["Mass (kg)"])
            piece = _Piece(
                row["Piece"],
                row["Mark"],
                row["Kind"],
                row["Zone"],
                number,
                ends,
                centres[row["Piece"]],
                mass,
                sizes,
                angles,
            )
            found.append(piece)
    except FolderError as error:
        raise FolderError(f"the tables of {contents.folder} cannot be compared: {error}") from None
    except (KeyError, ValueError) as error:
        raise FolderError(f"the tables of {contents.folder} are damaged: {in_words(error)}") from None
    return found


def _same_elements(before: list[_Piece], after: list[_Piece]) -> bool:
    """Whether both meshes have the same combinatorics, as far as beams show it."""
    one, other = (
        {each.element: tuple(sorted(each.ends)) for each in pieces if each.kind == "beam"} for pieces in (before, after)
    )
    common = one.keys() & other.keys()
    return bool(common) and all(one[element] == other[element] for element in common)


def _by_element(one: list[_Piece], other: list[_Piece]) -> dict[int, int]:
    """Positions in `other` by those in `one`. Several pieces on an element are taken in their order."""
    waiting: dict[int, list[int]] = defaultdict(list)
    for n, piece in enumerate(other):
        waiting[piece.element].append(n)
    return {k: waiting[piece.element].pop(0) for k, piece in enumerate(one) if waiting[piece.element]}


def _by_place(one: list[_Piece], other: list[_Piece]) -> dict[int, int]:
    if not one or not other:
        return {}
    first, second = (np.array([each.centre for each in pieces]) for pieces in (one, other))
    near, known = cKDTree(first), cKDTree(second)
    apart, there = map(np.asarray, known.query(first))
    back = np.asarray(near.query(second)[1])
    spacing = np.asarray(near.query(first, k=2)[0])[:, 1]  # infinite for a single piece
    own = (back[there] == np.arange(len(one))) & (apart <= OWN_PLACE * spacing)
    return {int(k): int(there[k]) for k in np.flatnonzero(own)}


def _changed(one: _Piece, other: _Piece) -> tuple[Cell, ...] | None:
    """The row of a piece that changed; None where it did not."""
    moved = float(np.linalg.norm(other.centre - one.centre))
    size, angle = _largest(one.sizes_mm, other.sizes_mm), _largest(one.angles_deg, other.angles_deg)
    mass = other.mass_kg - one.mass_kg
    mark, zone = (
        "" if before == now else f"{before or 'none'} now {now or 'none'}"
        for before, now in ((one.mark, other.mark), (one.zone, other.zone))
    )
    is_same = moved <= 2 * COORDINATE_TOLERANCE_MM and max(size, angle) <= SAME_SIZE and abs(mass) < SAME_SIZE
    if is_same and not mark and not zone:
        return None
    return ("changed", one.kind, one.name, other.name, moved, size, angle, mass, mark, zone)


def _largest(one: FloatArray, other: FloatArray) -> float:
    """The largest difference; of as many as both have where one has more, but then never zero."""
    if len(one) != len(other):
        return max(float(np.abs(one).max(initial=0.0)), float(np.abs(other).max(initial=0.0)))
    return float(np.abs(one - other).max(initial=0.0))
