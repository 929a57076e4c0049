"""The order in which marks are numbered: along rings or rows of the mesh."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components

from fabkit.rules import MarkOrder
from geometry.arrays import FloatArray, IntArray, integers
from geometry.mesh import Mesh

__all__ = ["element_ranks"]

ComplexArray = npt.NDArray[np.complex128]

SAME_TURN_DECIMALS = 9
"""Decimals of a turn to which places around a ring are compared, so that rounding does not decide: a ring may have a
million pieces."""
LEAST_MEAN = 1e-9
"""Length of a sum of points of the unit circle from which on it has a direction: what is shorter is the rounding of
points that cancel, as those around the last vertex of a dome do."""


def element_ranks(mesh: Mesh, order: MarkOrder) -> dict[str, IntArray]:
    """For vertices, edges and faces of a mesh, the place of each in the order of marks, counted from 0.

    elements: the order of the mesh. rings: by the fewest edges from the longest boundary, or from the first face where
    there is none, piece by piece of a mesh that is not connected; each ring runs beside the one before it, the first
    one counter-clockwise seen from outside; edges of a ring come before those that lead inwards from it. rows: in
    strips as wide as the mean edge along the longest extent of the mesh.

    >>> from geometry.mesh.shapes import grid
    >>> from fabkit.production.marks import element_ranks
    >>> element_ranks(grid(2, 2), "rings")["vertex"].tolist()[4]
    8
    """
    c = mesh.combinatorics
    corners = mesh.vertices[c.corners]
    ends = mesh.vertices[c.edges]
    middles = {
        "vertex": mesh.vertices,
        "edge": ends.mean(axis=1),
        "face": np.add.reduceat(corners, c.face_starts[:-1]) / np.diff(c.face_starts)[:, None],
    }
    if order == "elements":
        return {element: np.arange(len(points)) for element, points in middles.items()}
    if order == "rows":
        return {element: _ranks(*_along_rows(mesh, points)) for element, points in middles.items()}
    piece, ring, around = _rings(mesh)
    starts = c.face_starts[:-1]
    keys = {
        "vertex": (piece, 2 * ring, around),
        "edge": (piece[c.edges[:, 0]], ring[c.edges].sum(axis=1), around[c.edges].sum(axis=1)),
        "face": (
            piece[c.corners[starts]],
            np.minimum.reduceat(ring[c.corners], starts),
            np.add.reduceat(around[c.corners], starts),
        ),
    }
    return {
        element: _ranks(np.round(np.angle(z) / (2 * np.pi), SAME_TURN_DECIMALS) % 1.0, number, own)
        for element, (own, number, z) in keys.items()
    }


def _ranks(*keys: FloatArray | IntArray) -> IntArray:
    """The place of each element where they are sorted by these keys, the last one first."""
    order = np.lexsort(keys)
    ranks = np.empty(len(order), dtype=np.int64)
    ranks[order] = np.arange(len(order))
    return ranks


def _rings(mesh: Mesh) -> tuple[IntArray, IntArray, ComplexArray]:
    """(N,) the connected piece of each vertex, the number of edges between it and the longest boundary of its piece,
    and a point of the unit circle that turns once around each ring: the mean of those of its neighbours in the ring
    before."""
    c = mesh.combinatorics
    piece = integers(connected_components(c.adjacency, directed=False)[1])
    pieces, first_faces = np.unique(piece[c.corners[c.face_starts[:-1]]], return_index=True)
    faces = (c.corners[c.face_starts[face] : c.face_starts[face + 1]] for face in first_faces.tolist())
    loops = dict(zip(pieces.tolist(), faces, strict=True))
    for loop in sorted(c.boundary_loops, key=lambda loop: float(_steps(mesh, loop).sum())):
        loops[int(piece[loop[0]])] = loop
    ring = np.full(mesh.n_vertices, mesh.n_vertices, dtype=np.int64)
    around = np.zeros(mesh.n_vertices, dtype=np.complex128)
    for loop in loops.values():
        steps = _steps(mesh, loop)
        ring[loop], around[loop] = 0, np.exp(2j * np.pi * (np.cumsum(steps) - steps) / steps.sum())
    at, number = np.flatnonzero(ring == 0), 0
    while len(at):
        number += 1
        near = c.adjacency[at].indices
        at = np.unique(near[ring[near] > number])
        ring[at] = number
        mean = np.asarray(c.adjacency[at] @ around)  # that of vertices of this ring and the next one is still 0
        size = np.abs(mean)
        around[at] = np.where(size > LEAST_MEAN, mean / np.maximum(size, LEAST_MEAN), 1.0)
    return piece, ring, around


def _steps(mesh: Mesh, loop: IntArray) -> FloatArray:
    """Lengths of the edges from each vertex of a loop to the next one."""
    ends = mesh.vertices[np.roll(loop, -1)]
    return np.asarray(np.linalg.norm(ends - mesh.vertices[loop], axis=1))


def _along_rows(mesh: Mesh, points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The place of each point (k,) along its row, and the row."""
    centred = mesh.vertices - mesh.vertices.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2][:2]
    axes *= np.sign(axes[np.arange(2), np.abs(axes).argmax(axis=1)])[:, None]
    along, across = axes @ (points - mesh.vertices.mean(axis=0)).T
    return along, np.floor(across / mesh.mean_edge_length).astype(np.int64)
