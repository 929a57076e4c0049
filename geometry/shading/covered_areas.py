"""How much of polygons in the plane is covered by convex ones, what several cover counted once.

Between two heights with no corner and no crossing of edges, the covered length of a horizontal line is a linear
function of its height: the line in the middle says all. Edges that agree, wholly or but for rounding, need no care,
because nothing is decided by which of them lies in front.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh.ragged_arrays import rows_by_size

__all__ = ["covered_areas"]

MAX_EDGE_PAIRS = 2**20
"""Most pairs of edges treated at once, which bounds the memory."""


def covered_areas(polygons: FloatArray, covers: FloatArray, covered: IntArray) -> FloatArray:
    """(f,) covered area of simple polygons (f, k, 2) by convex polygons (c, q, 2), each of which covers one, (c,).

    Polygons with fewer than k corners repeat a corner. The pairs that may meet are found first.
    """
    areas = np.zeros(len(polygons))
    polygons, covers = polygons - polygons[:, :1], covers - polygons[covered, :1]  # products of large numbers round
    meet = np.flatnonzero(_may_meet(covers, polygons[covered]))
    order = meet[np.argsort(covered[meet], kind="stable")]
    some, counts = np.unique(covered[order], return_counts=True)
    for runs, places in rows_by_size(np.concatenate([[0], np.cumsum(counts)])):
        edges = places.shape[1] * covers.shape[1] + polygons.shape[1]
        for part in np.array_split(np.arange(len(runs)), min(len(runs), 1 + len(runs) * edges**2 // MAX_EDGE_PAIRS)):
            own = some[runs[part]]
            areas[own] = _covered(polygons[own], covers[order[places[part]]])
    return areas


def _may_meet(covers: FloatArray, polygons: FloatArray) -> BoolArray:
    """(c,) false where an edge of the convex polygon (c, q, 2) has all corners of the other one (c, k, 2) behind it."""
    along = np.roll(covers, -1, axis=1) - covers
    own = _sides(along, covers, covers)
    inside = np.where(own.sum(axis=2) > 0, 1.0, -1.0)
    before: BoolArray = np.any(_sides(along, covers, polygons) * inside[..., None] >= 0, axis=2)
    return np.asarray(before.all(axis=1))


def _sides(along: FloatArray, tails: FloatArray, points: FloatArray) -> FloatArray:
    """(c, q, k) twice the area of the triangle of each edge (c, q, 2) and each point (c, k, 2)."""
    lines = np.stack([-along[..., 1], along[..., 0], tails[..., 0] * along[..., 1] - tails[..., 1] * along[..., 0]], 2)
    return np.asarray(lines @ np.insert(points, 2, 1.0, axis=2).swapaxes(1, 2))


def _covered(polygons: FloatArray, covers: FloatArray) -> FloatArray:
    """(g,) the same for polygons (g, k, 2) with n covers each (g, n, q, 2)."""
    group, levels = _levels(polygons, covers)
    rise = np.diff(levels)
    slabs = np.flatnonzero((rise > 0) & (group[1:] == group[:-1]))
    group, level = group[slabs], (levels[slabs] + levels[slabs + 1]) / 2
    begin, end = _pieces(*_spans(covers, group, level))
    corners = np.moveaxis(polygons, 0, 2)[..., group]
    x, crossed = _crossed(corners[:, 0], corners[:, 1], level)
    upwards = np.sign(np.roll(corners[:, 1], -1, axis=0) - corners[:, 1])
    before = (np.clip(x[:, None], begin, end) - begin).sum(axis=1)
    lengths = np.where(crossed, upwards * before, 0.0).sum(axis=0)
    return np.abs(np.bincount(group, lengths * rise[slabs], minlength=len(polygons)))


def _levels(polygons: FloatArray, covers: FloatArray) -> tuple[IntArray, FloatArray]:
    """Heights (h,) of all corners and crossings, sorted group by group and kept to the polygon's, with the groups."""
    g, n, q, _ = covers.shape
    k = polygons.shape[1]
    points = np.concatenate([polygons, covers.reshape(g, n * q, 2)], axis=1)
    following = np.concatenate([np.roll(np.arange(k), -1), k + np.roll(np.arange(n * q).reshape(n, q), -1, 1).ravel()])
    sides = _sides(points[:, following] - points, points, points)
    changes = (sides > 0) != (sides[:, :, following] > 0)
    group, edge, line = np.nonzero(np.triu(changes & changes.swapaxes(1, 2)))
    here, there = sides[group, line, edge], sides[group, line, following[edge]]
    y = points[..., 1]
    crossings = y[group, edge] + here / (here - there) * (y[group, following[edge]] - y[group, edge])
    levels = np.concatenate([y.ravel(), crossings])
    group = np.concatenate([np.repeat(np.arange(g), k + n * q), group])
    levels = np.clip(levels, polygons[group, :, 1].min(axis=1), polygons[group, :, 1].max(axis=1))
    order = np.lexsort((levels, group))
    return group[order], levels[order]


def _crossed(x: FloatArray, y: FloatArray, level: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(k, ...) where lines at heights (...) cross the edges of polygons x, y (k, ...), and whether they do."""
    next_x, next_y = np.roll(x, -1, axis=0), np.roll(y, -1, axis=0)
    crossed = (y < level) != (next_y < level)
    return x + (level - y) / np.where(crossed, next_y - y, 1.0) * (next_x - x), crossed


def _spans(covers: FloatArray, group: IntArray, level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, s) from where to where the covers (g, n, q, 2) of groups (s,) cover lines at heights (s,).

    Nothing is from 0 to 0.
    """
    corners = np.ascontiguousarray(np.moveaxis(covers, 0, 3).swapaxes(0, 1))[..., group]
    x, crossed = _crossed(corners[:, :, 0], corners[:, :, 1], level)
    some = crossed.any(axis=0)
    low, high = np.where(crossed, x, np.inf).min(axis=0), np.where(crossed, x, -np.inf).max(axis=0)
    return np.where(some, low, 0.0), np.where(some, high, 0.0)


def _pieces(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, s) disjoint pieces, some of them empty, that cover what spans (n, s) do."""
    order = np.argsort(low, axis=0)
    low, high = np.take_along_axis(low, order, axis=0), np.take_along_axis(high, order, axis=0)
    reach = np.maximum.accumulate(high, axis=0)
    begin = low.copy()
    begin[1:] = np.maximum(low[1:], reach[:-1])
    return begin, np.maximum(high, begin)
