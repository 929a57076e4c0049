"""Solids as convex pieces, and the depth of overlap of two convex pieces.

Two pieces are compared by each face of the one with each corner of the other, and a large plate has many neighbours. So
prisms over outlines with many corners are cut into triangular prisms even if they are convex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fabkit.checking.convex_pieces import MAX_CORNERS_UNCUT, triangles
from fabkit.parts import SolidArray, Topology, prism_topology
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Pieces", "convex_pieces", "depths", "is_splittable"]

CONVEXITY_TOLERANCE_MM = 1e-6
"""Largest height of a corner above a face plane of its solid, up to which the solid counts as convex, in mm."""
PARALLEL_AXES_SINE = 1e-10
"""Sine of the angle below which two directions count as one axis. Over 10 m the overlap is too large by 1e-6 mm at
most."""
MAX_PROJECTIONS_IN_MEMORY = 4_000_000
"""Number of projections held in memory at a time: 32 MB."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Convex polyhedra with equally many vertices, in world coordinates.

    parts (Q,): position of the part to which each belongs. vertices (Q, V, 3) in mm; normals (Q, N, 3) and
    directions (Q, D, 3): unit vectors along all face normals and all edges, parallel ones once.
    """

    parts: IntArray
    vertices: FloatArray
    normals: FloatArray
    directions: FloatArray


def convex_pieces(batch: SolidArray) -> list[Pieces]:
    """Convex solids with few corners as they are; the others, which must be splittable, as triangular prisms."""
    uncut = _is_uncut(batch)
    return [_pieces(part) for part in (batch[uncut], _triangular_prisms(batch[~uncut])) if len(part.parts)]


def is_splittable(batch: SolidArray) -> BoolArray:
    """(P,) whether `convex_pieces` can take each solid: it is convex, or a right or oblique prism over a simple
    polygon."""
    result = _is_uncut(batch)
    others = np.flatnonzero(~result)
    n = batch.topology.n_vertices // 2
    if len(others) and _is_prism(batch.topology):
        vertices = batch.vertices[others]
        outlines, axes, _ = _along_axes(vertices)
        generators = vertices[:, n:] - vertices[:, :n]
        deviations = np.linalg.norm(np.cross(generators, axes[:, None, :]), axis=-1).max(axis=1)
        result[others] = (deviations <= CONVEXITY_TOLERANCE_MM) & shapely.is_valid(shapely.polygons(outlines))
    return result


def _is_uncut(batch: SolidArray) -> BoolArray:
    """(P,) whether each solid is convex and not a prism over an outline with many corners."""
    t = batch.topology
    if t.n_vertices > 2 * MAX_CORNERS_UNCUT and _is_prism(t):
        return np.zeros(len(batch.parts), dtype=bool)
    is_convex = np.empty(len(batch.parts), dtype=bool)
    done = 0
    for few in batch.in_batches():
        normals = few.normals
        levels = np.einsum("pfk,pfk->pf", normals, few.vertices[:, t.face_vertex])
        heights = normals @ few.vertices.transpose(0, 2, 1) - levels[..., None]
        is_convex[done : done + len(few.parts)] = heights.max(axis=(1, 2), initial=-np.inf) <= CONVEXITY_TOLERANCE_MM
        done += len(few.parts)
    return is_convex


def _is_prism(topology: Topology) -> bool:
    n, odd = divmod(topology.n_vertices, 2)
    if odd or n < 3:
        return False
    prism = prism_topology(n)
    names = ("corners", "loop_starts", "face_starts")
    return all(np.array_equal(getattr(topology, name), getattr(prism, name)) for name in names)


def _along_axes(vertices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Prisms with vertices (P, 2n, 3) projected along their axes, with their first corners as origins: outlines (P, n,
    2), counter-clockwise; unit axes (P, 3); two unit vectors perpendicular to each, the columns of (P, 3, 2)."""
    n = vertices.shape[1] // 2
    axes = vertices[:, n] - vertices[:, 0]
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    x = np.cross(np.eye(3)[np.abs(axes).argmin(axis=1)], axes)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    plane = np.stack([x, np.cross(axes, x)], axis=-1)
    return (vertices[:, :n] - vertices[:, :1]) @ plane, axes, plane


def _triangular_prisms(batch: SolidArray) -> SolidArray:
    if not len(batch.parts):
        return batch
    outlines, axes, plane = _along_axes(batch.vertices)
    corners, owner = triangles(outlines)
    points = np.einsum("tck,tjk->tcj", corners, plane[owner])
    normals = batch.normals
    ends = []
    for face, first in ((0, 0), (1, batch.topology.n_vertices // 2)):  # both ends are planar, but need not be square
        slope = normals[:, face] / np.einsum("pk,pk->p", normals[:, face], axes)[:, None]
        rise = -np.einsum("tcj,tj->tc", points, slope[owner])
        ends.append(batch.vertices[owner, None, first] + points + rise[..., None] * axes[owner, None])
    return SolidArray(prism_topology(3), batch.parts[owner], np.concatenate(ends, axis=1))


def _pieces(batch: SolidArray) -> Pieces:
    tail, head = batch.topology.edges.T
    edges = batch.vertices[:, head] - batch.vertices[:, tail]
    directions = edges / np.linalg.norm(edges, axis=-1, keepdims=True)
    return Pieces(batch.parts, batch.vertices, _distinct(batch.normals), _distinct(directions))


def _distinct(directions: FloatArray) -> FloatArray:
    """(P, k, 3) the directions, out of (P, m, 3), without those that are parallel to an earlier one in all solids."""
    kept: list[int] = []
    for k in range(directions.shape[1]):
        turn = np.cross(directions[:, kept], directions[:, k : k + 1])
        parallel = (np.abs(turn) <= PARALLEL_AXES_SINE).all(axis=(0, 2))
        if not parallel.any():
            kept.append(k)
    return directions[:, kept]


def depths(first: Pieces, second: Pieces, pairs: IntArray, *, touching_mm: float) -> FloatArray:
    """(K,) depth in mm by which piece pairs[k, 0] of `first` and piece pairs[k, 1] of `second` overlap.

    The depth is the shortest displacement that separates the two, found by the separating axis test: the smallest
    overlap of their projections onto all face normals and all cross products of two edge directions. It is zero or
    negative if they share no volume. Where the overlap along a face normal is no larger than `touching_mm`, this
    overlap is returned without further tests.
    """
    result = np.empty(len(pairs))
    numbers = (first.normals.shape[1] + second.normals.shape[1]) * _n_vertices(first, second)
    for rows in _chunks(np.arange(len(pairs)), numbers):
        i, j = pairs[rows].T
        axes = np.concatenate([first.normals[i], second.normals[j]], axis=1)
        result[rows] = _overlaps(axes, first.vertices[i], second.vertices[j])
    numbers = first.directions.shape[1] * second.directions.shape[1] * _n_vertices(first, second)
    for rows in _chunks(np.flatnonzero(result > touching_mm), numbers):
        i, j = pairs[rows].T
        axes = _products(first.directions[i], second.directions[j])
        result[rows] = np.minimum(result[rows], _overlaps(axes, first.vertices[i], second.vertices[j]))
    return result


def _n_vertices(first: Pieces, second: Pieces) -> int:
    return int(first.vertices.shape[1] + second.vertices.shape[1])


def _chunks(rows: IntArray, numbers: int) -> list[IntArray]:
    """The rows in batches of at most MAX_PROJECTIONS_IN_MEMORY projections. numbers: of projections in a row."""
    size = max(1, MAX_PROJECTIONS_IN_MEMORY // numbers)
    return [rows[start : start + size] for start in range(0, len(rows), size)]


def _products(first: FloatArray, second: FloatArray) -> FloatArray:
    """(K, D1 * D2, 3) unit vectors perpendicular to directions (K, D1, 3) and (K, D2, 3); zero where these are
    parallel."""
    perpendicular = np.cross(first[:, :, None, :], second[:, None, :, :]).reshape(len(first), -1, 3)
    sines = np.linalg.norm(perpendicular, axis=-1, keepdims=True)
    units: FloatArray = np.divide(
        perpendicular, sines, out=np.zeros_like(perpendicular), where=sines > PARALLEL_AXES_SINE
    )
    return units


def _overlaps(axes: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """(K,) smallest overlap of the projections of corners (K, V, 3) and (K, W, 3) onto unit axes (K, A, 3)."""
    middle = first[:, :1]
    one = axes @ (first - middle).transpose(0, 2, 1)
    other = axes @ (second - middle).transpose(0, 2, 1)
    overlap_above = one.max(axis=-1) - other.min(axis=-1)
    overlap_below = other.max(axis=-1) - one.min(axis=-1)
    overlap = np.where(axes.any(axis=-1), np.minimum(overlap_above, overlap_below), np.inf)
    smallest: FloatArray = overlap.min(axis=-1)
    return smallest
