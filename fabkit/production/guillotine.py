"""Nesting for cuts from edge to edge, as glass is cut: each outline stands for its smallest rectangle.

A sheet is filled by splitting it: of all the free sections and all the rectangles left, in both orientations, the pair
comes next that leaves the narrowest strip beside the rectangle; it goes into the section's corner, and one cut across
the section leaves two smaller ones. Sections are never merged, so that the cuts really run from edge to edge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from heapq import heappop, heappush
from math import fsum

import numpy as np
import shapely

from fabkit.parts import Ragged
from fabkit.production.nests import Placement, Stock, polygons, turned
from fabkit.production.remaining_rectangles import RemainingRectangles
from geometry.arrays import FloatArray, IntArray

__all__ = ["Guillotine", "smallest_rectangles"]

RECTANGLE_ROUNDING_MM = 1e-9
"""Rounding allowance in mm for a rectangle that fits exactly, far below the tolerance of a nest."""

SPLITS: tuple[Callable[[float, float, float, float], bool], ...] = (
    lambda left_x, left_y, length, width: length * left_y <= width * left_x,
    lambda left_x, left_y, length, width: length * left_y > width * left_x,
    lambda left_x, left_y, length, width: True,
    lambda left_x, left_y, length, width: False,
)
"""Rules that say whether the first cut of a section runs along x, above the rectangle, given the remainders of the
section in x and y and the size of the rectangle. None is always best; the fullest sheet is kept."""

ORIENTATIONS = ((True, True), (True, False), (False, True))
"""Whether rectangles may lie along the sheet, and across it. One orientation for all often fills a sheet better than
the best one for each."""


def smallest_rectangles(outlines: Ragged, inside: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Angles (m,) in degrees that turn outlines, rows of (k, 2), so that their smallest enclosing rectangle is along
    the axes, and its sizes (m, 2), the longer side first. Rectangles that fit into the sheet's `inside` come before
    smaller ones that do not. One side of the smallest rectangle lies along an edge of the convex hull (Freeman and
    Shapira 1975), so those are tried."""
    hulls = shapely.orient_polygons(shapely.convex_hull(polygons(outlines)), exterior_cw=True)
    corners, owner = shapely.get_coordinates(hulls, return_index=True)
    is_first = np.diff(owner, prepend=-1) > 0
    following, edges = corners[~is_first], np.diff(corners, axis=0)[~is_first[1:]]
    owner, starts = owner[~is_first], np.flatnonzero(np.diff(owner[~is_first], prepend=-1))
    along = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    extents = np.stack([_extents(following, along, owner, starts, axes) for axes in (along, across)], axis=1)
    sizes = -np.sort(-extents, axis=1)
    unfit = (sizes > np.sort(inside)[::-1] + RECTANGLE_ROUNDING_MM).any(axis=1)
    best = np.lexsort((sizes.prod(axis=1), unfit, owner))[starts]  # of the first of equal ones
    quarter = np.where(extents[best, 0] >= extents[best, 1], 0.0, 90.0)
    return quarter - np.rad2deg(np.arctan2(along[best, 1], along[best, 0])), sizes[best]


def _extents(ends: FloatArray, along: FloatArray, owner: IntArray, starts: IntArray, axes: FloatArray) -> FloatArray:
    """(m,) of convex polygons along unit axes (m, 2), one for each of their edges, which have ends (m, 2), run along
    (m, 2) clockwise, and belong to the polygons (m,) that begin at `starts`.

    The corner that lies farthest along an axis is where edges stop to run along it: edges turn one way, so it is found
    by the angle they have turned since the first.
    """
    first, counts = starts[owner], np.bincount(owner)[owner]

    def turned(directions: FloatArray) -> FloatArray:
        """Angles since the first edge, polygon after polygon."""
        x, y = along[first].T
        angles = np.arctan2(y * directions[:, 0] - x * directions[:, 1], x * directions[:, 0] + y * directions[:, 1])
        since: FloatArray = np.mod(angles, 2 * np.pi) + 10.0 * owner
        return since

    angles = np.maximum.accumulate(turned(along))
    reaches = []
    for sign in (1.0, -1.0):
        aside = sign * np.stack([axes[:, 1], -axes[:, 0]], axis=1)
        place = np.searchsorted(angles, turned(aside)) - first
        near = first + (place + np.arange(-2, 1)[:, None]) % counts  # rounding may find a neighbour
        reaches.append(sign * (sign * np.einsum("cmd,md->cm", ends[near], axes)).max(axis=0))
    extents: FloatArray = reaches[0] - reaches[1]
    return extents


@dataclass(frozen=True, eq=False)
class Guillotine:
    """The packer for outlines, rows of (k, 2), on some stock: angles (m,) and sizes (m, 2) of their smallest
    rectangles."""

    outlines: Ragged
    stock: Stock
    angles: FloatArray
    sizes: FloatArray

    @classmethod
    def of(cls, outlines: Ragged, stock: Stock) -> Guillotine:
        return cls(outlines, stock, *smallest_rectangles(outlines, stock.inside))

    def fill(self, pool: IntArray) -> list[Placement]:
        """One sheet, number zero, filled with some of the outlines of the pool, as full as some ways of splitting
        and turning make it. Deterministic: a tie goes to the first. Empty if none fits."""
        return self._fill(pool, self._rectangles(pool))

    def sheets(self, pool: IntArray) -> list[list[Placement]]:
        """The whole pool, a list a sheet; every outline must fit onto an empty sheet."""
        rectangles, fillings, n_laid = self._rectangles(pool), [], 0
        while n_laid < len(pool):
            fillings.append(self._fill(pool, rectangles))
            n_laid += len(fillings[-1])
        return fillings

    def _rectangles(self, pool: IntArray) -> RemainingRectangles:
        return RemainingRectangles(self.sizes[pool] + self.stock.gap_mm, RECTANGLE_ROUNDING_MM)

    def _fill(self, pool: IntArray, rectangles: RemainingRectangles) -> list[Placement]:
        """As `fill`, from the rectangles of the pool that are left; those laid are taken."""
        gap, border = self.stock.gap_mm, self.stock.border_mm
        inside = (self.stock.inside[0] + gap, self.stock.inside[1] + gap)
        fillings = (_fill(rectangles, inside, split, ways) for split in SPLITS for ways in ORIENTATIONS)
        laid = max(fillings, key=lambda filling: fsum(each.length * each.width for each in filling))
        placements = []
        for each in laid:
            rectangle = each.choice % len(pool)
            rectangles.take(rectangle)
            panel = int(pool[rectangle])
            angle = float(self.angles[panel]) + (90.0 if each.choice >= len(pool) else 0.0)
            offset = np.array([each.x, each.y]) + border - turned(self.outlines[panel], angle).min(axis=0)
            placements.append(Placement(panel, 0, angle, (float(offset[0]), float(offset[1]))))
        return placements


@dataclass(frozen=True)
class _Laid:
    """A rectangle laid: its number, that of all added where it is turned; its lower left corner; its extents."""

    choice: int
    x: float
    y: float
    length: float
    width: float


def _fill(
    rectangles: RemainingRectangles,
    inside: tuple[float, float],
    split: Callable[[float, float, float, float], bool],
    ways: tuple[bool, bool],
) -> list[_Laid]:
    """Rectangles for one sheet, which are put back afterwards.

    Sections wait in a heap by the strip that the best rectangle leaves, then in the order in which they were made.
    That strip only grows while others are taken, so it is found anew when the section's turn has come.
    """
    laid: list[_Laid] = []
    waiting: list[tuple[float, int, int, tuple[float, float, float, float]]] = []
    n_made = 0

    def wait(number: int, section: tuple[float, float, float, float]) -> None:
        strip, choice = rectangles.best(section[2], section[3], ways)
        if choice >= 0:
            heappush(waiting, (strip, number, choice, section))

    wait(0, (0.0, 0.0, *inside))
    while waiting:
        _, number, choice, section = heappop(waiting)
        rectangle = choice % len(rectangles.left)
        if not rectangles.left[rectangle]:
            wait(number, section)
            continue
        left, bottom, section_length, section_width = section
        length, width = rectangles.extents(choice)
        laid.append(_Laid(choice, left, bottom, length, width))
        rectangles.take(rectangle)
        left_x, left_y = section_length - length, section_width - width
        cut_along_x = split(left_x, left_y, length, width)
        n_made += 2
        wait(n_made - 1, (left, bottom + width, section_length if cut_along_x else length, left_y))
        wait(n_made, (left + length, bottom, left_x, width if cut_along_x else section_width))
    for each in laid:
        rectangles.put_back(each.choice % len(rectangles.left))
    return laid
