"""The order in which marks are numbered: along rings or rows of the mesh."""

from __future__ import annotations

import numpy as np

from fabkit.rules import MarkOrder
from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh

__all__ = ["element_ranks"]


def element_ranks(mesh: Mesh, order: MarkOrder) -> dict[str, IntArray]:
    """For vertices, edges and faces of a mesh, the place of each in the order of marks, counted from 0.

    elements: the order of the mesh. rings: by the fewest edges from the boundary, or from vertex 0 where there is none,
    each ring counter-clockwise about the middle in plan. rows: in strips as wide as the mean edge along the longest
    extent of the mesh.

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
    ring = _rings(mesh)
    rings = {
        "vertex": ring,
        "edge": ring[c.edges].min(axis=1),
        "face": np.minimum.reduceat(ring[c.corners], c.face_starts[:-1]),
    }
    centre = mesh.vertices.mean(axis=0)
    return {
        element: _ranks(rings[element], np.arctan2(*(points - centre)[:, 1::-1].T))
        for element, points in middles.items()
    }


def _ranks(strip: IntArray, along: FloatArray) -> IntArray:
    order = np.lexsort((along, strip))
    ranks = np.empty(len(order), dtype=np.int64)
    ranks[order] = np.arange(len(order))
    return ranks


def _rings(mesh: Mesh) -> IntArray:
    """(N,) number of edges between each vertex and the boundary."""
    c = mesh.combinatorics
    start = np.flatnonzero(c.is_boundary_vertex) if c.is_boundary_vertex.any() else np.array([0])
    ring = np.full(mesh.n_vertices, mesh.n_vertices)
    ring[start] = 0
    at, number = start, 0
    while len(at):
        number += 1
        near = c.adjacency[at].indices
        at = np.unique(near[ring[near] > number])
        ring[at] = number
    return ring


def _along_rows(mesh: Mesh, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """The row of each point (k,), and its place along the row."""
    centred = mesh.vertices - mesh.vertices.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2][:2]
    axes *= np.sign(axes[np.arange(2), np.abs(axes).argmax(axis=1)])[:, None]
    along, across = axes @ (points - mesh.vertices.mean(axis=0)).T
    return np.floor(across / mesh.mean_edge_length).astype(np.int64), along
