"""Nesting for cuts from edge to edge, as glass is cut: each outline stands for its smallest rectangle.

A sheet is filled by splitting it: of all the free sections and all the rectangles left, in both orientations, the pair
comes next that leaves the narrowest strip beside the rectangle; it goes into the section's corner, and one cut across
the section leaves two smaller ones. Sections are never merged, so that the cuts really run from edge to edge.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from math import fsum

import numpy as np
import shapely

from fabkit.production.nest import Placement, Stock, polygons, turned
from fabkit.production.rectangles_left import RectanglesLeft
from geometry.arrays import FloatArray, IntArray

__all__ = ["Guillotine", "smallest_rectangles"]

#: What rounding may add to a rectangle that fits exactly; far below the tolerance of a nest.
ROUNDING_MM = 1e-9

#: Whether the first cut across a section runs along x, above the rectangle, given what is left of the section and the
#: rectangle's size. No rule is always best; the fullest sheet wins.
SPLITS: tuple[Callable[[float, float, float, float], bool], ...] = (
    lambda left_x, left_y, length, width: length * left_y <= width * left_x,
    lambda left_x, left_y, length, width: length * left_y > width * left_x,
    lambda left_x, left_y, length, width: True,
    lambda left_x, left_y, length, width: False,
)

#: Whether rectangles may lie along the sheet and stand across it. All in one way often fills it better than each in the
#: way that fits best at the moment.
WAYS = ((True, True), (True, False), (False, True))


def smallest_rectangles(outlines: Sequence[FloatArray], inside: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Angles (m,) in degrees that turn outlines (k, 2) so that their smallest enclosing rectangle is along the axes,
    and its sizes (m, 2), the longer side first. Rectangles that fit into the sheet's `inside` come before smaller
    ones that do not. One side of the smallest rectangle lies along an edge of the convex hull (Freeman and
    Shapira 1975), so those are tried."""
    hulls = shapely.convex_hull(polygons(outlines))
    corners, owner = shapely.get_coordinates(hulls, return_index=True)
    counts = np.bincount(owner)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    angles, sizes = np.empty(len(outlines)), np.empty((len(outlines), 2))
    for count in np.unique(counts):
        these = np.flatnonzero(counts == count)
        hull = corners[starts[these, None] + np.arange(count - 1)]
        angles[these], sizes[these] = _smallest_of_hulls(hull, inside)
    return angles, sizes


def _smallest_of_hulls(hull: FloatArray, inside: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """As above, for convex polygons (m, k, 2)."""
    edges = np.roll(hull, -1, axis=1) - hull
    along = edges / np.linalg.norm(edges, axis=-1, keepdims=True)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    extents = np.stack([np.ptp(np.einsum("med,mcd->mec", axis, hull), axis=-1) for axis in (along, across)], axis=-1)
    sizes = -np.sort(-extents, axis=-1)
    fits = (sizes <= np.sort(inside)[::-1] + ROUNDING_MM).all(axis=-1)
    best = np.where(fits, sizes.prod(axis=-1), sizes.prod(axis=-1) + 2 * sizes.prod(axis=-1).max()).argmin(axis=1)
    row = np.arange(len(hull))
    quarter = np.where(extents[row, best, 0] >= extents[row, best, 1], 0.0, 90.0)
    direction = along[row, best]
    return quarter - np.rad2deg(np.arctan2(direction[:, 1], direction[:, 0])), sizes[row, best]


@dataclass(frozen=True, eq=False)
class Guillotine:
    """The packer for outlines (k, 2) on some stock: angles (m,) and sizes (m, 2) of their smallest rectangles."""

    outlines: Sequence[FloatArray]
    stock: Stock
    angles: FloatArray
    sizes: FloatArray

    @classmethod
    def of(cls, outlines: Sequence[FloatArray], stock: Stock) -> Guillotine:
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

    def _rectangles(self, pool: IntArray) -> RectanglesLeft:
        return RectanglesLeft(self.sizes[pool] + self.stock.gap_mm, ROUNDING_MM)

    def _fill(self, pool: IntArray, rectangles: RectanglesLeft) -> list[Placement]:
        """As `fill`, from the rectangles of the pool that are left; those laid are taken."""
        gap, border = self.stock.gap_mm, self.stock.border_mm
        inside = (self.stock.inside[0] + gap, self.stock.inside[1] + gap)
        fillings = (_fill(rectangles, inside, split, ways) for split in SPLITS for ways in WAYS)
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
    rectangles: RectanglesLeft,
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
