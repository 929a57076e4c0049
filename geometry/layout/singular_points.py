"""Singular vertices near each other, which must not get the same integer (u, v)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from geometry.arrays import IntArray, integers
from geometry.layout.quarter_turns import quarter_turned
from geometry.layout.seams import SeamlessMaps
from geometry.networks.combed_fields import CombedField
from geometry.networks.tangent_frames import TangentFrames
from geometry.optimise import SparseMatrix

__all__ = ["carried_rows", "integer_rows", "singular_differences", "triangle_graph"]

SINGULAR_PAIR_DISTANCE = 3.0
"""Distance below which two singular vertices must have different (u, v), in edge lengths."""


def singular_differences(frames: TangentFrames, field: CombedField, maps: SeamlessMaps, edge_length: float) -> IntArray:
    """(k, 2, m) for pairs of singular vertices near each other: the matrices from the integers t of the maps to the
    difference of their (u, v), both in the (u, v) of one triangle.
    """
    m = maps.integers.shape[1]
    singular = np.flatnonzero(field.indices)
    places = frames.mesh.vertices[singular]
    near = (
        KDTree(places).query_pairs(SINGULAR_PAIR_DISTANCE * edge_length, output_type="ndarray")
        if len(singular)
        else np.zeros((0, 2))
    )
    pairs = singular[near.astype(np.int64)]
    if not len(pairs):
        return np.zeros((0, 2, m), dtype=np.int64)
    c = frames.combinatorics
    graph = triangle_graph(frames)
    corner = np.zeros(c.n_vertices, dtype=np.int64)
    corner[c.corners] = np.arange(c.n_corners)
    rows = maps.integers.tocsr()
    found = []
    for i in np.unique(pairs[:, 0]).tolist():
        before = integers(dijkstra(graph, directed=False, indices=corner[i] // 3, return_predecessors=True)[1])
        first_rows = integer_rows(rows, np.array([corner[i]]))[0]
        others = corner[pairs[pairs[:, 0] == i, 1]].tolist()
        found += [carried_rows(frames, field, rows, before, other) - first_rows for other in others]
    return integers(np.array(found).swapaxes(1, 2))


def triangle_graph(frames: TangentFrames) -> csr_array[np.float64, tuple[int, int]]:
    """(F, F) distances between the centres of neighbouring triangles."""
    _, left, right = frames.inner_edges
    lengths = np.linalg.norm(frames.centres[left] - frames.centres[right], axis=1)
    return coo_array((lengths, (left, right)), shape=(frames.n_triangles, frames.n_triangles)).tocsr()


def integer_rows(rows: SparseMatrix, corners: IntArray) -> IntArray:
    """(n, m, 2) the rows of u and v at corners (n,), for the integers of the maps."""
    dense = rows[integers(2 * corners[:, None] + [0, 1]).ravel()].toarray()
    return np.rint(dense).astype(np.int64).reshape(len(corners), 2, -1).swapaxes(1, 2)


def carried_rows(
    frames: TangentFrames, field: CombedField, rows: SparseMatrix, before: IntArray, corner: int
) -> IntArray:
    """(m, 2) the rows of u and v at a corner, carried along a path of triangles to its first triangle.

    before (F,): the triangle before each one on the path, negative at its beginning.
    """
    c = frames.combinatorics
    value, triangle = integer_rows(rows, np.array([corner]))[0], corner // 3
    while before[triangle] >= 0:
        halves = 3 * triangle + np.arange(3)
        half = int(halves[c.twin[halves] // 3 == before[triangle]][0])
        edge = c.corner_edge[half]
        if field.is_cut[edge]:
            turn = -field.turns[edge] if c.runs_along_edge[half] else field.turns[edge]
            here, there = integer_rows(rows, np.array([half, c.next_corner[c.twin[half]]]))
            value = there + quarter_turned(value - here, turn)
        triangle = int(before[triangle])
    return np.asarray(value)
