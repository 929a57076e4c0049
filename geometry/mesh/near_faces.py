"""Which faces of a mesh are near each other, so that they may meet: by boxes, and about a vertex by directions.

Boxes along the coordinates say little of slender faces that run askew, and nothing of very many faces at one vertex,
whose boxes all meet there. So boxes are taken along the directions in which the edges run, and of two faces at such a
vertex it is asked whether they are in directions from it that meet: a face lies in the cone over its other corners.
"""

from __future__ import annotations

import numpy as np
import shapely

from geometry.arrays import FloatArray, IntArray
from geometry.mesh.mesh import Mesh

__all__ = ["meeting_boxes", "near_faces"]

MANY = 32
"""Faces at a vertex, above which they are not all compared with each other by boxes."""

WIDEST = 1.0
"""Angle in radians between a direction to a corner and the mean of a face's, from which on its cone may be any."""

ROOM = 1e-3
"""Added to boxes of directions, for rounding and for corners off their planes."""

BATCH = 4096
"""Boxes that are sought at a time: what meets in the plane of the tree only is forgotten in between."""


def near_faces(mesh: Mesh, clearance: float) -> tuple[IntArray, IntArray]:
    """Every two faces (n,), (n,) that may come nearer than the clearance, the lower first, each pair once."""
    lower, upper = _face_boxes(mesh)
    lower, upper = lower - clearance, upper + clearance
    hub = _hubs(mesh)
    rest, starred = np.flatnonzero(hub < 0), np.flatnonzero(hub >= 0)
    found = [_among(rest, np.arange(mesh.n_faces), lower, upper)]
    for vertex in np.unique(hub[starred]):
        star, others = starred[hub[starred] == vertex], starred[hub[starred] > vertex]
        found += [_among(star, others, lower, upper), star[_in_meeting_directions(mesh, int(vertex), star)]]
    pairs = np.sort(np.concatenate(found), axis=1)
    pairs = np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)
    return pairs[:, 0], pairs[:, 1]


def _among(some: IntArray, others: IntArray, lower: FloatArray, upper: FloatArray) -> IntArray:
    """(n, 2) faces of the two kinds whose boxes meet."""
    first, second = meeting_boxes(lower[some], upper[some], lower[others], upper[others])
    return np.stack([some[first], others[second]], axis=1)


def _hubs(mesh: Mesh) -> IntArray:
    """(F,) the vertex of each face at which most faces meet, if they are `MANY`; else -1."""
    c = mesh.combinatorics
    degrees = np.bincount(c.corners, minlength=c.n_vertices)[c.corners]
    last = c.face_starts[1:] - 1
    fullest = c.corners[np.lexsort((c.corners, degrees, c.corner_face))[last]]
    return np.where(np.maximum.reduceat(degrees, c.face_starts[:-1]) > MANY, fullest, -1)


def _in_meeting_directions(mesh: Mesh, vertex: int, faces: IntArray) -> IntArray:
    """(n, 2) which of faces (k,) at a vertex lie in directions from it that meet."""
    c = mesh.combinatorics
    corners, owner = c.corners_of(faces)
    kept = c.corners[corners] != vertex
    steps, owner = mesh.vertices[c.corners[corners[kept]]] - mesh.vertices[vertex], owner[kept]
    lengths = np.linalg.norm(steps, axis=1)
    directions = steps / np.maximum(lengths, np.finfo(float).tiny)[:, None]
    starts = np.flatnonzero(np.diff(owner, prepend=-1))
    means = np.add.reduceat(directions, starts, axis=0)
    means /= np.maximum(np.linalg.norm(means, axis=1), np.finfo(float).tiny)[:, None]
    cosines = np.minimum.reduceat(np.einsum("ck,ck->c", directions, means[owner]), starts)
    off = mesh.plane_deviations[faces] / np.maximum(np.minimum.reduceat(lengths, starts), np.finfo(float).tiny)
    room = (1 - cosines + ROOM + off)[:, None]  # between two directions the arc bulges by 1 - cos
    lower = np.minimum.reduceat(directions, starts, axis=0) - room
    upper = np.maximum.reduceat(directions, starts, axis=0) + room
    is_wide = ~((cosines > np.cos(WIDEST)) & (off < ROOM))
    lower[is_wide], upper[is_wide] = -2.0, 2.0
    return np.stack(meeting_boxes(lower, upper, lower, upper), axis=1)


def _face_boxes(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """(F, 3) least and largest coordinates of each face, along the directions in which edges run most and least."""
    axes = np.linalg.eigh(mesh.edge_vectors.T @ mesh.edge_vectors)[1]
    corners = (mesh.vertices @ axes)[mesh.combinatorics.corners]
    starts = mesh.combinatorics.face_starts[:-1]
    return np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)


def meeting_boxes(
    lower: FloatArray, upper: FloatArray, lower_2: FloatArray, upper_2: FloatArray
) -> tuple[IntArray, IntArray]:
    """Which boxes (n, 3) meet which others (m, 3)."""
    if not len(lower_2):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    # the tree is flat: its plane is that of the two axes along which boxes are shortest beside the whole
    extents = np.maximum(upper_2.max(axis=0) - lower_2.min(axis=0), np.finfo(float).tiny)
    x, y, z = np.argsort((upper_2 - lower_2).mean(axis=0) / extents, kind="stable")
    tree = shapely.STRtree(shapely.box(lower_2[:, x], lower_2[:, y], upper_2[:, x], upper_2[:, y]))
    found = []
    for start in range(0, len(lower), BATCH):
        some = slice(start, start + BATCH)
        boxes = shapely.box(lower[some, x], lower[some, y], upper[some, x], upper[some, y])
        first, second = tree.query(boxes)
        first += start
        meet = (lower[first, z] <= upper_2[second, z]) & (lower_2[second, z] <= upper[first, z])
        found.append(np.stack([first[meet], second[meet]]))
    first, second = np.concatenate(found, axis=1) if found else np.zeros((2, 0), dtype=np.int64)
    return first, second
