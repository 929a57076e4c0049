"""Outlines that are not simple polygons: a corner on an edge to which it does not belong, or two edges that cross.

In small outlines all edges are compared. In large ones only neighbours are: a segment tree over the order of the
corners along x divides the plane into strips, in which edges are ordered from bottom to top unless some cross. So each
corner has one edge above it and one below it in every strip that contains it. This takes n log n numbers for n corners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Meeting", "flattened", "meetings"]

STRIP_SEARCH_CORNERS = 256
"""Corners of an outline above which it is searched by strips; for smaller ones, comparing all edges takes no longer."""


@dataclass(frozen=True)
class Meeting:
    """A place where an outline meets itself: the number of the outline; the corner that is near an edge, or at which
    one of two crossing edges begins; the corner at which the (other) edge begins; and the distance of the corner from
    the edge, zero where edges cross."""

    outline: int
    corner: int
    edge: int
    distance: float = 0.0


def meetings(outlines: FloatArray, clearance: float) -> tuple[list[Meeting], list[Meeting]]:
    """Two lists, with one place for each outline (n, k, 2): outlines with a corner within `clearance` of an edge to
    which it does not belong, and outlines with two edges that cross."""
    if outlines.shape[1] > STRIP_SEARCH_CORNERS:
        return _large_meetings(outlines, clearance)
    return _folds(outlines, clearance), _crossings(outlines)


def flattened(polygons: FloatArray) -> FloatArray:
    """(n, k, 2) the projections of polygons (n, k, 3) along their vector areas, where they are largest; each in units
    of its mean edge length."""
    here = polygons - polygons.mean(axis=1, keepdims=True)
    lengths = np.linalg.norm(np.roll(here, -1, axis=1) - here, axis=2).mean(axis=1)
    here = here / lengths[:, None, None]
    normals = np.cross(here, np.roll(here, -1, axis=1)).sum(axis=1)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    flat = size[:, 0] < np.finfo(np.float32).eps  # no vector area: project to the best plane
    if flat.any():
        scatter = np.einsum("nki,nkj->nij", here[flat], here[flat])
        normals[flat], size[flat] = np.linalg.eigh(scatter)[1][:, :, 0], 1.0
    normals /= size
    x_axis = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    x_axis /= np.linalg.norm(x_axis, axis=1, keepdims=True)
    axes = np.stack([x_axis, np.cross(normals, x_axis)], axis=2)
    outlines: FloatArray = here @ axes
    return outlines


def _folds(outlines: FloatArray, clearance: float) -> list[Meeting]:
    found: dict[int, Meeting] = {}
    for step in range(1, outlines.shape[1] - 1):
        edge = (np.arange(outlines.shape[1]) + step) % outlines.shape[1]
        distance = _distances(outlines, outlines[:, edge], np.roll(outlines, -step - 1, axis=1))
        for outline, corner in np.argwhere(distance <= clearance).tolist():
            place = Meeting(outline, corner, int(edge[corner]), float(distance[outline, corner]))
            found.setdefault(outline, place)
    return list(found.values())


def _crossings(outlines: FloatArray) -> list[Meeting]:
    found: dict[int, Meeting] = {}
    for step in range(2, outlines.shape[1] // 2 + 1):
        a, b, c, d = (np.roll(outlines, -shift, axis=1) for shift in (0, 1, step, step + 1))
        for outline, corner in np.argwhere(_cross(a, b, c, d)).tolist():
            found.setdefault(outline, Meeting(outline, corner, (corner + step) % outlines.shape[1]))
    return list(found.values())


def _distances(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """(...) distance of each point (..., 2) from the edge from start to end."""
    along, offset = end - start, points - start
    squares = (along * along).sum(axis=-1)  # zero where an edge is parallel to the direction of projection
    shares = (offset * along).sum(axis=-1)
    share = np.divide(shares, squares, out=np.zeros_like(squares), where=squares > 0)
    foot = np.clip(share, 0.0, 1.0)[..., None] * along
    distances: FloatArray = np.linalg.norm(offset - foot, axis=-1)
    return distances


def _cross(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> BoolArray:
    """(...) whether the edges from a to b and from c to d (..., 2) cross."""
    crossed: BoolArray = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
    return crossed


def _side(start: FloatArray, end: FloatArray, point: FloatArray) -> IntArray:
    """(...) 1 where the point is to the left of the line, -1 to the right."""
    along, offset = end - start, point - start
    return np.sign(along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0]).astype(np.int64)


# --- large outlines, one by one


def _large_meetings(outlines: FloatArray, clearance: float) -> tuple[list[Meeting], list[Meeting]]:
    folds, crossings = [], []
    for number, points in enumerate(outlines):
        strips = _Strips.of(points)
        beside = strips.beside_corners()
        corner, edge, distance = _nearest(points, beside)
        if distance <= clearance:
            folds.append(Meeting(number, corner, edge, distance))
        k = len(points)
        pairs = np.concatenate([strips.above_each_other(), beside, (beside - [1, 0]) % k])
        ends = (points[pairs[:, 0]], points[(pairs[:, 0] + 1) % k], points[pairs[:, 1]], points[(pairs[:, 1] + 1) % k])
        crossed = np.flatnonzero(_cross(*ends))
        if len(crossed):
            first, second = sorted(pairs[crossed[0]].tolist())
            crossings.append(Meeting(number, first, second))
    return folds, crossings


def _nearest(points: FloatArray, beside: IntArray) -> tuple[int, int, float]:
    """A corner, an edge and their distance: the least among neighbours, between which there is no other part.

    Strips along x find edges above and below, strips along y find steep edges, and a tree finds corners.
    """
    k = len(points)
    near = cKDTree(points).query(points, k=4)[1]  # the corner, its two neighbours and one more
    near = np.stack([np.repeat(np.arange(k), 4), near.ravel()], axis=1)
    pairs = np.concatenate([beside, _Strips.of(points[:, ::-1]).beside_corners(), near, (near - [0, 1]) % k])
    pairs = pairs[(pairs[:, 0] != pairs[:, 1]) & (pairs[:, 0] != (pairs[:, 1] + 1) % k)]
    distance = _distances(points[pairs[:, 0]], points[pairs[:, 1]], points[(pairs[:, 1] + 1) % k])
    least = int(distance.argmin())
    corner, edge = pairs[least].tolist()
    return corner, edge, float(distance[least])


@dataclass(frozen=True, eq=False)
class _Strips:
    """A segment tree over the corners of an outline (k, 2), in their order along x.

    order (k,): the corners along x. nodes, edges (m,): for each node of the tree the edges that cross its strip from
    side to side, but not the strip of its parent; sorted by node, and from bottom to top in the middle of the strip.
    Leaf `size` + r is the strip between the corners r and r + 1 of the order; node i has the children 2 i and 2 i + 1.
    """

    points: FloatArray
    order: IntArray
    size: int
    nodes: IntArray
    edges: IntArray

    @classmethod
    def of(cls, points: FloatArray) -> _Strips:
        k = len(points)
        order = np.lexsort((points[:, 1], points[:, 0]))
        rank = np.empty(k, dtype=np.int64)
        rank[order] = np.arange(k)
        after = np.roll(rank, -1)
        size = 1 << (k - 1).bit_length()
        low, high = np.minimum(rank, after) + size, np.maximum(rank, after) + size
        nodes, edges = [], []
        while (low < high).any():
            for end, at in ((low, low), (high, high - 1)):
                crossing = np.flatnonzero((low < high) & (end & 1 == 1))
                nodes.append(at[crossing])
                edges.append(crossing)
            low, high = (low + 1) >> 1, high >> 1
        flat = cls(points, order, size, np.concatenate(nodes), np.concatenate(edges))
        middle = np.lexsort((flat._heights(flat.edges, flat._middles()), flat.nodes))
        return cls(points, order, size, flat.nodes[middle], flat.edges[middle])

    def above_each_other(self) -> IntArray:
        """(n, 2) pairs of edges next to each other in a strip."""
        same = np.flatnonzero(self.nodes[1:] == self.nodes[:-1])
        return np.stack([self.edges[same], self.edges[same + 1]], axis=1)

    def beside_corners(self) -> IntArray:
        """(n, 2) pairs of a corner and an edge next to it, in each strip that contains the corner."""
        k = len(self.points)
        corners = np.repeat(self.order, self.size.bit_length())
        ranks = np.minimum(np.arange(k), k - 2)
        node = ((ranks + self.size)[:, None] >> np.arange(self.size.bit_length())).ravel()
        low = np.searchsorted(self.nodes, node)
        first, last = low, np.searchsorted(self.nodes, node, side="right")
        full = np.flatnonzero(first < last)
        corners, first, last = corners[full], first[full], last[full]
        low, high = first.copy(), last.copy()
        x, y = self.points[corners].T
        while len(searching := np.flatnonzero(low < high)):
            middle = (low[searching] + high[searching]) // 2
            below = self._heights(self.edges[middle], x[searching]) < y[searching]
            low[searching[below]] = middle[below] + 1
            high[searching[~below]] = middle[~below]
        places = low[:, None] + np.arange(-3, 3)  # two of these may be edges of the corner itself
        within = (places >= first[:, None]) & (places < last[:, None])
        return np.stack([np.repeat(corners, within.sum(axis=1)), self.edges[places[within]]], axis=1)

    def _middles(self) -> FloatArray:
        """(m,) x in the middle of the strip of each node."""
        level = self.size.bit_length() - np.frexp(self.nodes)[1].astype(np.int64)  # 0 for leaves
        left = (self.nodes << level) - self.size
        right = np.minimum(left + (1 << level), len(self.order) - 1)
        return np.asarray(self.points[self.order[[left, right]], 0].mean(axis=0))

    def _heights(self, edges: IntArray, x: FloatArray) -> FloatArray:
        """(n,) y of edges (n,) at x (n,); of a vertical edge, y of its midpoint."""
        tail, head = self.points[edges], self.points[(edges + 1) % len(self.points)]
        along = head - tail
        share = np.divide(x - tail[:, 0], along[:, 0], out=np.full(len(x), 0.5), where=along[:, 0] != 0)
        return np.asarray(tail[:, 1] + np.clip(share, 0.0, 1.0) * along[:, 1])
