"""The depth of overlap of two convex pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Pieces", "depths", "distinct", "shafts"]

PARALLEL_AXES_SINE = 1e-10
"""Sine of the angle below which two directions count as one axis. Over 10 m the overlap is too large by 1e-6 mm at
most."""
MAX_PROJECTIONS_IN_MEMORY = 400_000
"""Number of projections held in memory at a time: 3 MB, which the processor's cache holds."""
MAX_SEPARATION_STEPS = 200
"""Number of steps in which a direction is sought that separates round pieces: enough for gaps above 1/1000 of their
size. Smaller gaps are found between faces, and between a face and a round bar."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Convex polyhedra with equally many vertices, or round bars, in world coordinates.

    parts (Q,): position of the part to which each belongs. vertices (Q, V, 3) in mm; normals (Q, N, 3): unit vectors
    along all face normals, parallel ones once; edges (E, 2): vertices at their ends.

    A round bar has its two centres for vertices, and its axis for an edge. half_axes (Q, 2, 2, 3) in mm, None of
    polyhedra: of the circle or ellipse about each centre.
    """

    parts: IntArray
    vertices: FloatArray
    normals: FloatArray
    edges: IntArray
    half_axes: FloatArray | None = None

    @property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest coordinates (Q, 3)."""
        reach = 0.0 if self.half_axes is None else np.sqrt((self.half_axes * self.half_axes).sum(axis=2))
        return (self.vertices - reach).min(axis=1), (self.vertices + reach).max(axis=1)

    def taken(self, rows: IntArray) -> Pieces:
        """The pieces at these rows."""
        half_axes = None if self.half_axes is None else self.half_axes[rows]
        return Pieces(self.parts[rows], self.vertices[rows], self.normals[rows], self.edges, half_axes)

    @property
    def directions(self) -> FloatArray:
        """(Q, D, 3) unit vectors along all edges, parallel ones once."""
        along = self.vertices[:, self.edges[:, 1]] - self.vertices[:, self.edges[:, 0]]
        return distinct(along / np.linalg.norm(along, axis=-1, keepdims=True))

    def extents(self, axes: FloatArray, origin: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(Q, A) least and largest projections onto axes (Q, A, 3), from an origin (Q, 1, 3)."""
        points = np.ascontiguousarray((self.vertices - origin).transpose(1, 2, 0))  # pieces last, which is fastest
        low, high = np.empty((2, *axes.shape[1::-1]))
        for k, (x, y, z) in enumerate(np.ascontiguousarray(axes.transpose(1, 2, 0))):
            levels = x * points[:, 0] + y * points[:, 1] + z * points[:, 2]
            least = largest = levels
            if self.half_axes is not None:
                reach = np.linalg.norm(np.einsum("qk,qvhk->vqh", axes[:, k], self.half_axes), axis=-1)
                least, largest = levels - reach, levels + reach
            low[k], high[k] = least.min(axis=0), largest.max(axis=0)
        return low.T, high.T

    def furthest(self, along: FloatArray) -> FloatArray:
        """(Q, 3) the point of each piece furthest along a direction (Q, 3)."""
        points = self.vertices
        if self.half_axes is not None:
            reach = np.einsum("qk,qvhk->qvh", along, self.half_axes)
            size = np.linalg.norm(reach, axis=-1, keepdims=True)
            reach = np.divide(reach, size, out=np.zeros_like(reach), where=size > 0)
            points = points + np.einsum("qvh,qvhk->qvk", reach, self.half_axes)
        furthest: FloatArray = points[np.arange(len(points)), np.einsum("qk,qvk->qv", along, points).argmax(axis=1)]
        return furthest

    def towards(self, points: FloatArray) -> FloatArray:
        """(Q, m, 3) unit vectors from the axis of each round bar, perpendicular to it, to points (Q, m, 3); none of
        polyhedra."""
        if self.half_axes is None:
            return points[:, :0]
        across = points - self.vertices[:, :1]
        across = across - np.einsum("qmk,qk->qm", across, self.directions[:, 0])[..., None] * self.directions[:, :1]
        return _units(across)


def distinct(directions: FloatArray) -> FloatArray:
    """(P, k, 3) the directions, out of (P, m, 3), without those that are parallel to an earlier one in all rows."""
    kept: list[int] = []
    may_be = _are_parallel(directions[:1, :, None], directions[:1, None])  # since they are in the first row
    for k in range(directions.shape[1]):
        earlier = [j for j in kept if may_be[:, j, k].any()]
        if not any(_are_parallel(directions[:, j], directions[:, k]).all() for j in earlier):
            kept.append(k)
    return directions[:, kept]


def _are_parallel(first: FloatArray, second: FloatArray) -> BoolArray:
    """(...,) whether unit vectors (..., 3) lie along one axis."""
    return np.asarray((np.abs(np.cross(first, second)) <= PARALLEL_AXES_SINE).all(axis=-1))


def shafts(parts: IntArray, centres: FloatArray, normals: FloatArray, radii: FloatArray) -> Pieces:
    """Round bars of the parts (Q,), between planes through centres (Q, 2, 3) with unit normals (Q, 2, 3); radii (Q,) in
    mm."""
    axes = centres[:, 1:] - centres[:, :1]
    axes = axes / np.linalg.norm(axes, axis=-1, keepdims=True)
    along = np.einsum("qek,qjk->qe", normals, axes)[..., None]
    lean = normals - along * axes
    sizes = np.linalg.norm(lean, axis=-1, keepdims=True)
    other = np.cross(axes[:, 0], np.eye(3)[np.abs(axes[:, 0]).argmin(axis=1)])[:, None]
    lean = np.where(sizes > PARALLEL_AXES_SINE, lean, other)
    lean = lean / np.linalg.norm(lean, axis=-1, keepdims=True)
    major = lean - axes * np.einsum("qek,qek->qe", normals, lean)[..., None] / along
    half_axes = radii[:, None, None, None] * np.stack([major, np.cross(axes, lean)], axis=2)
    return Pieces(parts, centres, normals, np.array([[0, 1]]), half_axes)


def depths(first: Pieces, second: Pieces, pairs: IntArray, *, touching_mm: float) -> FloatArray:
    """(K,) depth in mm by which piece pairs[k, 0] of `first` and piece pairs[k, 1] of `second` overlap.

    The depth is the shortest displacement that separates the two, found by the separating axis test: the smallest
    overlap of their projections onto all face normals and all cross products of two edge directions. It is zero or
    negative if they share no volume. Where the overlap along a face normal is no larger than `touching_mm`, this
    overlap is returned without further tests.

    Of a round bar, edges are its lines along the axis, and further directions lead from the axis to the corners of the
    other piece; where all of these overlap, the nearest points of the two are sought. The depth of
    an overlap of a round bar may be too large.
    """
    result = np.full(len(pairs), np.inf)
    n_vertices = first.vertices.shape[1] + second.vertices.shape[1]
    for n_axes, axes_of in (
        (first.normals.shape[1], lambda one, other: one.normals),
        (second.normals.shape[1], lambda one, other: other.normals),
        (len(first.edges) * len(second.edges) + n_vertices, _axes_between),
    ):
        for rows in _chunks(np.flatnonzero(result > touching_mm), n_axes * n_vertices):
            one, other = first.taken(pairs[rows, 0]), second.taken(pairs[rows, 1])
            result[rows] = np.minimum(result[rows], _overlaps(axes_of(one, other), one, other))
    if first.half_axes is not None or second.half_axes is not None:
        rows = np.flatnonzero(result > touching_mm)
        one, other = first.taken(pairs[rows, 0]), second.taken(pairs[rows, 1])
        result[rows] = _least_overlaps(one, other, result[rows], touching_mm)
    return result


def _least_overlaps(first: Pieces, second: Pieces, known: FloatArray, touching_mm: float) -> FloatArray:
    """(K,) the overlaps, or smaller ones, along directions between the nearest points of two pieces that share no
    volume: the least difference of two points is approached over straight lines [Gilbert1966]."""
    result = known.copy()
    rows = np.arange(len(known))
    between = second.vertices.mean(axis=1) - first.vertices.mean(axis=1)
    for _ in range(MAX_SEPARATION_STEPS):
        one, other = first.taken(rows), second.taken(rows)
        point = other.furthest(-between) - one.furthest(between)
        length = np.linalg.norm(between, axis=1)
        overlap = -np.einsum("kj,kj->k", point, between) / np.where(length > 0, length, np.nan)
        result[rows] = np.fmin(result[rows], overlap)
        step = point - between
        size = np.einsum("kj,kj->k", step, step)
        share = -np.einsum("kj,kj->k", step, between) / np.where(size > 0, size, np.inf)
        between = between + np.clip(share, 0, 1)[:, None] * step
        going = (result[rows] > touching_mm) & (np.linalg.norm(between, axis=1) > touching_mm)
        rows, between = rows[going], between[going]
        if not len(rows):
            break
    return result


def _chunks(rows: IntArray, numbers: int) -> list[IntArray]:
    """The rows in batches of at most MAX_PROJECTIONS_IN_MEMORY projections. numbers: of projections in a row."""
    size = max(1, MAX_PROJECTIONS_IN_MEMORY // numbers)
    return [rows[start : start + size] for start in range(0, len(rows), size)]


def _axes_between(one: Pieces, other: Pieces) -> FloatArray:
    """(K, A, 3) unit vectors perpendicular to an edge of either piece in each row, and from round bars to corners; some
    of them zero."""
    products = _products(one.directions, other.directions)
    return np.concatenate([products, one.towards(other.vertices), other.towards(one.vertices)], axis=1)


def _products(first: FloatArray, second: FloatArray) -> FloatArray:
    """(K, D1 * D2, 3) unit vectors perpendicular to directions (K, D1, 3) and (K, D2, 3); zero where these are
    parallel."""
    return _units(np.cross(first[:, :, None, :], second[:, None, :, :]).reshape(len(first), -1, 3))


def _units(vectors: FloatArray) -> FloatArray:
    """The unit vectors along vectors (..., 3); zero where they are as short as those of parallel axes."""
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    units: FloatArray = np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes > PARALLEL_AXES_SINE)
    return units


def _overlaps(axes: FloatArray, first: Pieces, second: Pieces) -> FloatArray:
    """(K,) smallest overlap of the projections of the pieces in each row onto unit axes (K, A, 3)."""
    middle = first.vertices[:, :1]
    (first_low, first_high), (second_low, second_high) = (each.extents(axes, middle) for each in (first, second))
    overlap = np.minimum(first_high - second_low, second_high - first_low)
    smallest: FloatArray = np.where(axes.any(axis=-1), overlap, np.inf).min(axis=-1)
    return smallest
