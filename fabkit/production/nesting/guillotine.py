"""Guillotine nesting, with cuts from edge to edge as glass is cut: each outline is replaced by its smallest rectangle.

A sheet is filled by splitting it into sections. Each step compares all free sections with all remaining rectangles in
both orientations, and takes the combination that leaves the narrowest strip beside the rectangle. The rectangle goes
into a corner of the section, and one cut across the section leaves two smaller sections. Sections are never merged, so
every cut runs from edge to edge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from heapq import heappop, heappush
from math import fsum

import numpy as np
import shapely

from fabkit.parts import Ragged
from fabkit.production.nesting.nests import Placement, Stock, polygons, turned
from fabkit.production.nesting.remaining_rectangles import RemainingRectangles
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Guillotine", "rectangles", "smallest_rectangles"]

RECTANGLE_ROUNDING_MM = 1e-9
"""Rounding allowance in mm for a rectangle that fits exactly, far below the tolerance of a nest."""

SPLITS: tuple[Callable[[float, float, float, float], bool], ...] = (
    lambda rest_x, rest_y, length, width: length * rest_y <= width * rest_x,
    lambda rest_x, rest_y, length, width: length * rest_y > width * rest_x,
    lambda rest_x, rest_y, length, width: True,
    lambda rest_x, rest_y, length, width: False,
)
"""Rules that decide whether the first cut of a section runs along x, above the rectangle. They take the remainders of
the section in x and y, and length and width of the rectangle. No rule is always the best, so all are tried and the
fullest sheet is kept."""

ORIENTATIONS = ((True, True), (True, False), (False, True))
"""Whether rectangles may lie along the sheet, and across it. A sheet is often fuller with one orientation for all
rectangles than with the best orientation for each."""

ALONG_ONLY = ((True, False),)


def rectangles(outlines: Ragged, stock: Stock) -> tuple[FloatArray, FloatArray]:
    """Angles and sizes of rectangles as of `smallest_rectangles`; where panels may not be turned freely, of those along
    the axes of their own frames, with extents along x and y."""
    if stock.rotation == "free":
        return smallest_rectangles(outlines, stock.inside)
    return np.zeros(len(outlines)), outlines.reduced(np.maximum) - outlines.reduced(np.minimum)


def smallest_rectangles(outlines: Ragged, inside: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Angles (m,) in degrees by which outlines, rows of (k, 2) in mm, are turned so that their smallest enclosing
    rectangle is parallel to the axes; and sizes (m, 2) of the rectangles in mm, the longer side first.

    A rectangle that fits into `inside`, the usable area of the sheet, is preferred to a smaller one that does not. One
    side of the smallest rectangle lies along an edge of the convex hull (Freeman and Shapira 1975), so only the
    directions of these edges are tried.
    """
    hulls = shapely.orient_polygons(shapely.convex_hull(polygons(outlines)), exterior_cw=True)
    corners, owner = shapely.get_coordinates(hulls, return_index=True)
    is_first = np.diff(owner, prepend=-1) > 0
    following, edges = corners[~is_first], np.diff(corners, axis=0)[~is_first[1:]]
    owner, starts = owner[~is_first], np.flatnonzero(np.diff(owner[~is_first], prepend=-1))
    along = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    extents = np.stack([_extents(following, along, owner, starts, axes) for axes in (along, across)], axis=1)
    sizes = -np.sort(-extents, axis=1)
    too_large = (sizes > np.sort(inside)[::-1] + RECTANGLE_ROUNDING_MM).any(axis=1)
    best = np.lexsort((sizes.prod(axis=1), too_large, owner))[starts]  # the first of equal ones
    quarter = np.where(extents[best, 0] >= extents[best, 1], 0.0, 90.0)
    return quarter - np.rad2deg(np.arctan2(along[best, 1], along[best, 0])), sizes[best]


def _extents(ends: FloatArray, along: FloatArray, owner: IntArray, starts: IntArray, axes: FloatArray) -> FloatArray:
    """(m,) extents of convex polygons in mm along unit axes (m, 2), one axis for each edge of the polygons.

    ends (m, 2): end points of the edges; along (m, 2): their unit directions, clockwise; owner (m,): the polygon of
    each edge; starts: the first edge of each polygon.

    The corner that lies farthest along an axis is the one where the direction of the edges passes the perpendicular of
    the axis. Edges of a convex polygon always turn to the same side, so a binary search over their angles finds it.
    """
    first, counts = starts[owner], np.bincount(owner)[owner]

    def angles_from_first(directions: FloatArray) -> FloatArray:
        """Angles from the first edge of each polygon; those of later polygons are larger."""
        x, y = along[first].T
        angles = np.arctan2(y * directions[:, 0] - x * directions[:, 1], x * directions[:, 0] + y * directions[:, 1])
        increasing: FloatArray = np.mod(angles, 2 * np.pi) + 10.0 * owner
        return increasing

    angles = np.maximum.accumulate(angles_from_first(along))
    supports = []
    for sign in (1.0, -1.0):
        perpendicular = sign * np.stack([axes[:, 1], -axes[:, 0]], axis=1)
        place = np.searchsorted(angles, angles_from_first(perpendicular)) - first
        nearest = first + (place + np.arange(-2, 1)[:, None]) % counts  # rounding may find a neighbour
        supports.append(sign * (sign * np.einsum("cmd,md->cm", ends[nearest], axes)).max(axis=0))
    extents: FloatArray = supports[0] - supports[1]
    return extents


@dataclass(frozen=True, eq=False)
class Guillotine:
    """Nests outlines on stock sheets. outlines: rows of (k, 2) in mm; angles (m,) in degrees and sizes (m, 2) in mm of
    their smallest rectangles."""

    outlines: Ragged
    stock: Stock
    angles: FloatArray
    sizes: FloatArray

    @classmethod
    def of(cls, outlines: Ragged, stock: Stock) -> Guillotine:
        return cls(outlines, stock, *rectangles(outlines, stock))

    @property
    def fits(self) -> BoolArray:
        """(m,) whether the rectangle of each outline fits onto an empty sheet."""
        inside: FloatArray = np.array(self.stock.inside)
        if self.stock.rotation == "free":
            inside = np.sort(inside)[::-1]
        fits: BoolArray = np.all(self.sizes <= inside + RECTANGLE_ROUNDING_MM, axis=1)
        return fits

    def fill(self, pool: IntArray) -> list[Placement]:
        """One sheet, number 0, filled with some of the outlines in the pool: the fullest that the rules for splitting
        and the orientations give. Deterministic: the first of equally full sheets is taken. Empty if no outline fits.

        pool: indices of the outlines to choose from.
        """
        return self.fill_from(pool, self.remaining(pool))

    def remaining(self, pool: IntArray) -> RemainingRectangles:
        """The rectangles of the pool, all of them free."""
        return RemainingRectangles(self.sizes[pool] + self.stock.gap_mm, RECTANGLE_ROUNDING_MM)

    def fill_from(self, pool: IntArray, rectangles: RemainingRectangles) -> list[Placement]:
        """As `fill`, but only with the free rectangles of the pool, which stay free."""
        gap, border = self.stock.gap_mm, self.stock.border_mm
        inside = (self.stock.inside[0] + gap, self.stock.inside[1] + gap)
        allowed = ORIENTATIONS if self.stock.rotation == "free" else ALONG_ONLY
        fillings = (_fill(rectangles, inside, split, orientations) for split in SPLITS for orientations in allowed)
        placed = max(fillings, key=lambda filling: fsum(each.length * each.width for each in filling))
        placements = []
        for each in placed:
            rectangle = each.choice % len(pool)
            panel = int(pool[rectangle])
            angle = float(self.angles[panel]) + (90.0 if each.choice >= len(pool) else 0.0)
            offset = np.array([each.x, each.y]) + border - turned(self.outlines[panel], angle).min(axis=0)
            placements.append(Placement(panel, 0, angle, (float(offset[0]), float(offset[1]))))
        return placements


@dataclass(frozen=True)
class _PlacedRectangle:
    """A rectangle on a sheet: its lower left corner, and its extents along x and y, in mm.

    choice: number of the rectangle, plus the number of all rectangles if its long side runs along y.
    """

    choice: int
    x: float
    y: float
    length: float
    width: float


def _fill(
    rectangles: RemainingRectangles,
    inside: tuple[float, float],
    split: Callable[[float, float, float, float], bool],
    orientations: tuple[bool, bool],
) -> list[_PlacedRectangle]:
    """Rectangles for one sheet; all are free again afterwards.

    Sections are kept in a heap, sorted by the width of the strip that the best rectangle leaves, then in the order in
    which they were cut. The strip only becomes wider as other rectangles are taken, so it is computed again when the
    section comes first and its rectangle is no longer free.
    """
    placed: list[_PlacedRectangle] = []
    sections: list[tuple[float, int, int, tuple[float, float, float, float]]] = []
    n_sections = 0

    def add(number: int, section: tuple[float, float, float, float]) -> None:
        strip, choice = rectangles.best(section[2], section[3], orientations)
        if choice >= 0:
            heappush(sections, (strip, number, choice, section))

    add(0, (0.0, 0.0, *inside))
    while sections:
        _, number, choice, section = heappop(sections)
        rectangle = choice % len(rectangles.is_free)
        if not rectangles.is_free[rectangle]:
            add(number, section)
            continue
        left, bottom, section_length, section_width = section
        length, width = rectangles.extents(choice)
        placed.append(_PlacedRectangle(choice, left, bottom, length, width))
        rectangles.take(rectangle)
        rest_x, rest_y = section_length - length, section_width - width
        cut_along_x = split(rest_x, rest_y, length, width)
        n_sections += 2
        add(n_sections - 1, (left, bottom + width, section_length if cut_along_x else length, rest_y))
        add(n_sections, (left + length, bottom, rest_x, width if cut_along_x else section_width))
    for each in placed:
        rectangles.put_back(each.choice % len(rectangles.is_free))
    return placed
