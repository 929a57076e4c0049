"""Nests: where each panel lies on which sheet. A nest stores placements, not copies of outlines.

The panels of a sheet have one thickness and one material.

A sheet's own frame has x along its length and y along its width, origin in a corner; panels lie on it with their
outer side up, turned and moved, never mirrored.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
import shapely

from fabkit.errors import NestingError
from fabkit.kinds import PanelDetails, panel_outlines
from fabkit.parts import Parts, Ragged
from geometry.arrays import FloatArray, IntArray, integers, short_repr

__all__ = [
    "NEST_TOLERANCE_MM",
    "Nest",
    "Placement",
    "Rotation",
    "Sheet",
    "Stock",
    "check_nest",
    "outline_areas",
    "placed",
    "polygons",
    "stock_numbers",
    "turned",
]

Rotation = Literal["free", "half", "fixed"]

NEST_TOLERANCE_MM = 1e-6
"""Rounding allowance for gaps and borders of a nest, in mm. Lengths of 10 m, rotated and moved, are accurate to 1e-8
mm."""


@dataclass(frozen=True)
class Sheet:
    """A stock sheet: length_mm along x, width_mm along y. count: how many there are of each thickness and material;
    None for any number.

    >>> from fabkit.production import Sheet
    >>> Sheet(length_mm=6000, width_mm=3210).area_mm2
    19260000
    """

    length_mm: float
    width_mm: float
    count: int | None = None

    @property
    def area_mm2(self) -> float:
        return self.length_mm * self.width_mm


@dataclass(frozen=True)
class Stock:
    """Equal sheets. gap_mm: minimum distance between two panels; border_mm: minimum distance of a panel from the
    sheet's edges. rotation: how panels may be turned: freely, by half a turn, or not at all; then the x axis of a
    panel's own frame lies along the sheet, where the grain or the pattern runs."""

    sheet: Sheet
    gap_mm: float
    border_mm: float
    rotation: Rotation = "free"

    @property
    def inside(self) -> tuple[float, float]:
        """Length and width less the borders, in mm."""
        return self.sheet.length_mm - 2 * self.border_mm, self.sheet.width_mm - 2 * self.border_mm


@dataclass(frozen=True)
class Placement:
    """A panel on a sheet. panel: its index; sheet: number of the sheet, counted from 0. A point in the panel's own
    frame is turned counter-clockwise by angle_deg about the origin, then moved by offset_mm."""

    panel: int
    sheet: int
    angle_deg: float
    offset_mm: tuple[float, float]


@dataclass(frozen=True)
class Nest:
    """Panels on sheets.

    sheets: their sizes, sheet after sheet. gap_mm: minimum distance between two panels; border_mm: minimum distance of
    a panel from the sheet's edges.
    placements: placements[i] is that of panel i. engine: name of the program that found the nest. panel_area_mm2: total
    area of the panels.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> nest = built.nest
    >>> nest.n_sheets, round(nest.utilisation, 2), nest.placements[0].sheet
    (3, 0.45, 0)
    """

    __repr__ = short_repr

    sheets: tuple[Sheet, ...]
    gap_mm: float
    border_mm: float
    placements: tuple[Placement, ...]
    engine: str
    panel_area_mm2: float
    rotation: Rotation = "free"

    @property
    def n_sheets(self) -> int:
        return len(self.sheets)

    @property
    def utilisation(self) -> float:
        """Area of the panels over the area of the sheets, between 0 and 1; 0 without panels."""
        return self.panel_area_mm2 / sum(sheet.area_mm2 for sheet in self.sheets) if self.placements else 0.0


def turned(points: FloatArray, angle_deg: float) -> FloatArray:
    """Points (..., 2) turned counter-clockwise about the origin."""
    angle = np.deg2rad(angle_deg)
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    result: FloatArray = points @ rotation
    return result


def placed(points: FloatArray, panel: IntArray, placements: Sequence[Placement]) -> FloatArray:
    """Points (K, 2) of the own frames of panels (K,), in the frames of their sheets."""
    angles = np.deg2rad([place.angle_deg for place in placements])
    rotations = np.array([[np.cos(angles), np.sin(angles)], [-np.sin(angles), np.cos(angles)]])[..., panel]
    offsets = np.array([place.offset_mm for place in placements]).reshape(-1, 2)
    result: FloatArray = (points[:, None] @ np.moveaxis(rotations, 2, 0))[:, 0] + offsets[panel]
    return result


def polygons(outlines: Ragged) -> npt.NDArray[np.object_]:
    """(m,) array of shapely polygons with these outlines, rows of (k, 2)."""
    shapes: npt.NDArray[np.object_] = shapely.polygons(shapely.linearrings(outlines.values, indices=outlines.row))
    return shapes


def outline_areas(outlines: Ragged) -> FloatArray:
    """(m,) areas of outlines, rows of (k, 2)."""
    areas: FloatArray = shapely.area(polygons(outlines))
    return areas


def stock_numbers(panels: Parts[PanelDetails]) -> IntArray:
    """(n,) the stock from which each panel is cut, by its thickness and material, numbered from 0 in the order of the
    panels."""
    keys = np.stack([panels.details.thickness_mm, panels.material], axis=1)
    _, first, kind = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return integers(np.argsort(np.argsort(first))[kind])


def check_nest(nest: Nest, panels: Parts[PanelDetails]) -> None:
    """Raise a NestingError, with marks and values, unless each panel lies once, on a sheet of its stock, of which there
    are as many, inside it less the border, and apart from its neighbours by the gap; all to NEST_TOLERANCE_MM."""
    if [placement.panel for placement in nest.placements] != list(range(len(panels))):
        raise NestingError(f"the nest places {len(nest.placements)} panels in a wrong order or number, "
                           f"there are {len(panels)}; each panel must be placed once")  # fmt: skip
    if not len(panels):
        return
    sheets, stocks = np.array([placement.sheet for placement in nest.placements]), stock_numbers(panels)
    if len(unknown := np.flatnonzero((sheets < 0) | (sheets >= nest.n_sheets))):
        raise NestingError(f"panel {panels.marks[unknown[0]]} is on sheet {sheets[unknown[0]] + 1}, but there are "
                           f"{nest.n_sheets}")  # fmt: skip
    _check_turns(nest, panels.marks)
    of_sheets_and_stocks = np.unique(np.stack([sheets, stocks], axis=1), axis=0)
    of_sheets = of_sheets_and_stocks[:, 0]
    if len(mixed := of_sheets[1:][np.diff(of_sheets) == 0]):
        marks = ", ".join(dict.fromkeys(panels.marks[k] for k in np.flatnonzero(sheets == mixed[0])[:10].tolist()))
        raise NestingError(f"sheet {mixed[0] + 1} has panels that differ in thickness or material: {marks}")
    _check_counts(nest, dict(of_sheets_and_stocks.tolist()))
    outlines = panel_outlines(panels)
    on_sheets = outlines.with_values(placed(outlines.values, outlines.row, nest.placements))
    _check_inside(nest, panels.marks, on_sheets)
    _check_gaps(nest, panels.marks, on_sheets)


def _check_counts(nest: Nest, stocks: Mapping[int, int]) -> None:
    """stocks: by the number of a sheet."""
    used = Counter((stocks[number], sheet) for number, sheet in enumerate(nest.sheets))
    for (_, sheet), count in used.items():
        if sheet.count is not None and count > sheet.count:
            raise NestingError(
                f"the nest has {count} sheets of {sheet.length_mm:g} x {sheet.width_mm:g} mm of one thickness and "
                f"material, and there are {sheet.count}"
            )


def _check_turns(nest: Nest, marks: Sequence[str]) -> None:
    step = {"free": 0.0, "half": 180.0, "fixed": 360.0}[nest.rotation]
    for mark, place in zip(marks, nest.placements, strict=True):
        if step and place.angle_deg % step:
            raise NestingError(
                f"panel {mark} is turned by {place.angle_deg:g} degrees, which rotation = {nest.rotation!r} forbids"
            )


def _check_inside(nest: Nest, marks: Sequence[str], outlines: Ragged) -> None:
    low = outlines.reduced(np.minimum).min(axis=1)
    sizes = np.array([(sheet.length_mm, sheet.width_mm) for sheet in nest.sheets])
    size = sizes[[place.sheet for place in nest.placements]]
    high = (size - outlines.reduced(np.maximum)).min(axis=1)
    clearance = np.minimum(low, high)
    wrong = np.flatnonzero(~(clearance >= nest.border_mm - NEST_TOLERANCE_MM))
    if len(wrong):
        first = int(clearance.argmin())
        named = ", ".join(marks[panel] for panel in wrong[:10])
        raise NestingError(
            f"{len(wrong)} panels are nearer to an edge of their sheet than the border of {nest.border_mm:g} mm: "
            f"{named}; panel {marks[first]} is {clearance[first]:.6f} mm from an edge of sheet "
            f"{nest.placements[first].sheet + 1}"
        )


def _check_gaps(nest: Nest, marks: Sequence[str], outlines: Ragged) -> None:
    """Sheets are set side by side, further apart than the gap, so that one search finds the close pairs of all."""
    pitch = max(sheet.length_mm for sheet in nest.sheets) + nest.gap_mm + 1000.0
    shapes = polygons(outlines)
    sheets = np.array([placement.sheet for placement in nest.placements])
    shift = np.stack([pitch * sheets, np.zeros(len(sheets))], axis=1)
    in_a_row = polygons(outlines.with_values(outlines.values + shift[outlines.row]))
    first, second = shapely.STRtree(in_a_row).query(in_a_row, predicate="dwithin", distance=nest.gap_mm)
    first, second = np.unique(np.stack([first, second], axis=1)[first < second], axis=0).T
    distances = shapely.distance(shapes[first], shapes[second])
    overlaps = shapely.area(shapely.intersection(shapes[first], shapes[second]))
    distances -= overlaps / np.minimum(shapely.length(shapes[first]), shapely.length(shapes[second]))
    wrong = np.flatnonzero(~(distances >= nest.gap_mm - NEST_TOLERANCE_MM))
    if len(wrong):
        worst = wrong[distances[wrong].argmin()]
        pairs = [f"{marks[first[pair]]} and {marks[second[pair]]}" for pair in wrong[:10]]
        raise NestingError(
            f"{len(wrong)} pairs of panels are nearer than the gap of {nest.gap_mm:g} mm: {'; '.join(pairs)}; "
            f"{marks[first[worst]]} and {marks[second[worst]]} are {distances[worst]:.6f} mm apart "
            f"(negative: mean depth of overlap) on sheet {sheets[first[worst]] + 1}"
        )
