"""How much of polygons in the plane is covered by convex ones, what several cover counted once.

Between two heights with no corner and no crossing of edges, the covered length of a horizontal line is a linear function
of its height: there the line in the middle says all. Edges that agree, wholly or but for rounding, need no care, because
nothing is decided by which of them lies in front.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh.ragged_arrays import runs_by_size

__all__ = ["covered_areas"]

AT_ONCE = 2**20
"""Pairs of edges looked at together: memory is bounded by them."""


def covered_areas(polygons: FloatArray, covers: FloatArray, covered: IntArray) -> FloatArray:
    """(f,) covered area of simple polygons (f, k, 2) by convex polygons (c, q, 2), each of which covers one, (c,).

    Corners may be repeated: so do polygons with fewer corners fill their place. Where both meet is looked up for all
    pairs of a polygon with the covers of its own.
    """
    areas = np.zeros(len(polygons))
    meet = np.flatnonzero(_may_meet(covers, polygons[covered]))
    order = meet[np.argsort(covered[meet], kind="stable")]
    some, counts = np.unique(covered[order], return_counts=True)
    for runs, places in runs_by_size(np.concatenate([[0], np.cumsum(counts)])):
        edges = places.shape[1] * covers.shape[1] + polygons.shape[1]
        for part in np.array_split(np.arange(len(runs)), 1 + len(runs) * edges**2 // AT_ONCE):
            own = some[runs[part]]
            areas[own] = _covered(polygons[own], covers[order[places[part]]])
    return areas


def _may_meet(covers: FloatArray, polygons: FloatArray) -> BoolArray:
    """(c,) false where an edge of the convex polygon (c, q, 2) has all corners of the other one (c, k, 2) behind it."""
    along = np.roll(covers, -1, axis=1) - covers
    own = _sides(along, covers, covers)
    inside = np.where(own.max(axis=2) > -own.min(axis=2), 1.0, -1.0)
    return np.asarray(((_sides(along, covers, polygons) * inside[..., None]).max(axis=2) >= 0).all(axis=1))


def _sides(along: FloatArray, tails: FloatArray, points: FloatArray) -> FloatArray:
    """(c, q, k) twice the area of the triangle of each edge (c, q, 2) and each point (c, k, 2)."""
    away = points[:, None] - tails[:, :, None]
    return np.asarray(along[:, :, None, 0] * away[..., 1] - along[:, :, None, 1] * away[..., 0])


def _covered(polygons: FloatArray, covers: FloatArray) -> FloatArray:
    """(g,) the same for polygons (g, k, 2) with n covers each (g, n, q, 2)."""
    group, levels = _levels(polygons, covers)
    rise = np.diff(levels)
    slabs = np.flatnonzero((rise > 0) & (group[1:] == group[:-1]))
    group, level = group[slabs], (levels[slabs] + levels[slabs + 1]) / 2
    begin, end = _pieces(*_spans(covers[group], level))
    x, crossed = _crossed(polygons[group], level[:, None])
    upwards = np.sign(np.roll(polygons[group, :, 1], -1, axis=1) - polygons[group, :, 1])
    before = (np.clip(x[:, :, None], begin[:, None], end[:, None]) - begin[:, None]).sum(axis=2)
    lengths = np.where(crossed, upwards * before, 0.0).sum(axis=1)
    return np.abs(np.bincount(group, lengths * rise[slabs], minlength=len(polygons)))


def _levels(polygons: FloatArray, covers: FloatArray) -> tuple[IntArray, FloatArray]:
    """Heights (h,) of all corners and crossings, sorted group by group and kept to the polygon's, with the groups."""
    tails = np.concatenate([polygons, covers.reshape(len(covers), -1, 2)], axis=1)
    along = np.concatenate(
        [np.roll(polygons, -1, axis=1) - polygons, (np.roll(covers, -1, axis=2) - covers).reshape(len(covers), -1, 2)],
        axis=1,
    )
    one, other = np.triu_indices(tails.shape[1], 1)
    x, y = np.moveaxis(tails[:, other] - tails[:, one], 2, 0)
    (u, v), (s, t) = np.moveaxis(along[:, one], 2, 0), np.moveaxis(along[:, other], 2, 0)
    turn = u * t - v * s
    first, second = x * t - y * s, x * v - y * u  # where they cross along both, times the turn
    size = np.abs(turn)
    crossing = (np.abs(2 * first - turn) <= size) & (np.abs(2 * second - turn) <= size) & (size > 0)
    group, pair = np.nonzero(crossing)
    crossings = tails[group, one[pair], 1] + v[crossing] * (first[crossing] / turn[crossing])
    levels = np.concatenate([tails[..., 1].ravel(), crossings])
    group = np.concatenate([np.repeat(np.arange(len(tails)), tails.shape[1]), group])
    levels = np.clip(levels, polygons[group, :, 1].min(axis=1), polygons[group, :, 1].max(axis=1))
    order = np.lexsort((levels, group))
    return group[order], levels[order]


def _crossed(polygons: FloatArray, level: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(..., k) where lines at heights (..., 1) cross the edges of polygons (..., k, 2), and whether they do."""
    x, y = polygons[..., 0], polygons[..., 1]
    next_x, next_y = np.roll(x, -1, axis=-1), np.roll(y, -1, axis=-1)
    crossed = (y < level) != (next_y < level)
    return x + (level - y) / np.where(crossed, next_y - y, 1.0) * (next_x - x), crossed


def _spans(covers: FloatArray, level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(s, n) from where to where convex polygons (s, n, q, 2) cover lines at heights (s,); nothing is from 0 to 0."""
    x, crossed = _crossed(covers, level[:, None, None])
    some = crossed.any(axis=2)
    low = np.where(crossed, x, np.inf).min(axis=2, initial=np.inf)
    high = np.where(crossed, x, -np.inf).max(axis=2, initial=-np.inf)
    return np.where(some, low, 0.0), np.where(some, high, 0.0)


def _pieces(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(s, n) disjoint pieces, some of them empty, that cover what spans (s, n) do."""
    order = np.argsort(low, axis=1)
    low, high = np.take_along_axis(low, order, axis=1), np.take_along_axis(high, order, axis=1)
    reach = np.maximum.accumulate(high, axis=1)
    begin = low.copy()
    begin[:, 1:] = np.maximum(low[:, 1:], reach[:, :-1])
    return begin, np.maximum(high, begin)
