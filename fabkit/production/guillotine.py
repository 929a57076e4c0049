"""Nesting for cuts from edge to edge, as glass is cut: each outline stands for its smallest rectangle.

A sheet is filled by splitting it: of all the free sections and all the rectangles left, in both orientations, the pair
comes next that leaves the narrowest strip beside the rectangle; it goes into the section's corner, and one cut across
the section leaves two smaller ones. Sections are never merged, so that the cuts really run from edge to edge.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fabkit.production.nest import Placement, Stock, polygons, turned
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


@dataclass(frozen=True)
class _Free:
    """A rectangle of a sheet, and how well the best rectangle left fits it: the strip it leaves (inf where none fits),
    and which one it is (the number of rectangles is added where it is turned)."""

    x: float
    y: float
    length: float
    width: float
    strip: float
    choice: int


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
        gap, border = self.stock.gap_mm, self.stock.border_mm
        sizes = self.sizes[pool] + gap
        inside = (self.stock.inside[0] + gap, self.stock.inside[1] + gap)
        areas = np.tile(sizes.prod(axis=1), 2)
        fillings = (_fill(sizes, inside, split, ways) for split in SPLITS for ways in WAYS)
        choices, corners = max(fillings, key=lambda filling: float(areas[filling[0]].sum()))
        placements = []
        for choice, corner in zip(choices.tolist(), corners, strict=True):
            panel = int(pool[choice % len(pool)])
            angle = float(self.angles[panel]) + (90.0 if choice >= len(pool) else 0.0)
            offset = corner + border - turned(self.outlines[panel], angle).min(axis=0)
            placements.append(Placement(panel, 0, angle, (float(offset[0]), float(offset[1]))))
        return placements

    def sheets(self, pool: IntArray) -> list[list[Placement]]:
        """The whole pool, a list a sheet; every outline must fit onto an empty sheet."""
        fillings = []
        while len(pool):
            fillings.append(self.fill(pool))
            pool = np.setdiff1d(pool, [placement.panel for placement in fillings[-1]])
        return fillings


def _fill(
    sizes: FloatArray,
    inside: tuple[float, float],
    split: Callable[[float, float, float, float], bool],
    ways: tuple[bool, bool],
) -> tuple[IntArray, FloatArray]:
    """Rectangles sizes (m, 2) chosen for one sheet (c,), m added where they are turned by 90 degrees, and their lower
    left corners (c, 2)."""
    m = len(sizes)
    length, width = np.concatenate([sizes, sizes[:, ::-1]]).T
    free = np.repeat(ways, m)

    def section(x: float, y: float, section_length: float, section_width: float) -> _Free:
        left_x, left_y = section_length - length, section_width - width
        strip = np.minimum(left_x, left_y)
        strip = np.where(free & (strip >= -ROUNDING_MM), strip, np.inf)
        choice = int(strip.argmin())
        return _Free(x, y, section_length, section_width, float(strip[choice]), choice)

    chosen, corners = [], []
    sections = [section(0.0, 0.0, *inside)]
    while (here := min(sections, key=lambda s: s.strip, default=None)) and here.strip < np.inf:
        chosen.append(here.choice)
        corners.append((here.x, here.y))
        free[[here.choice % m, here.choice % m + m]] = False
        x, y = float(length[here.choice]), float(width[here.choice])
        left_x, left_y = here.length - x, here.width - y
        cut_along_x = split(left_x, left_y, x, y)
        parts = [
            (here.x, here.y + y, here.length if cut_along_x else x, left_y),
            (here.x + x, here.y, left_x, y if cut_along_x else here.width),
        ]
        sections = [
            s if free[s.choice] or s.strip == np.inf else section(s.x, s.y, s.length, s.width)
            for s in sections
            if s is not here
        ]
        sections += [section(*part) for part in parts if part[2] > 0 and part[3] > 0]
    return np.array(chosen, dtype=np.int64), np.array(corners).reshape(-1, 2)
