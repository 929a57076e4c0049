"""Levels: meshes of hexagons around the z axis that lie on horizontal edges."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from geometry.arrays import IntArray, integers
from geometry.errors import MeshError
from geometry.mesh import Mesh

__all__ = ["levels_of_flat_top_hexagons"]

LARGEST_HORIZONTAL_RISE = 1e-9
"""Rise of an edge over the mean edge length, up to which it counts as horizontal."""


def levels_of_flat_top_hexagons(mesh: Mesh) -> IntArray:
    """(N,) the level of each vertex: how many edges that are not horizontal lead to it from the first boundary.

    Each hexagon has a horizontal edge in level j and one in level j + 2, and two corners in level j + 1 between.
    Counted along the mesh, not by height, so that a band may fold over itself. Raises MeshError for other meshes.
    """
    c = mesh.combinatorics
    horizontal = np.abs(mesh.edge_vectors[:, 2]) <= LARGEST_HORIZONTAL_RISE * mesh.mean_edge_length
    ends = np.flatnonzero(c.vertex_degrees == 2)
    if not (c.face_sizes == 6).all() or not len(ends) or not c.boundary_loops:
        raise MeshError("the mesh consists neither of rings about the z axis nor of an open band of hexagons about it")
    loop = next(loop for loop in c.boundary_loops if ends[0] in loop)
    i, j = c.edges[horizontal].T
    n, pairs = connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(c.n_vertices,) * 2), directed=False)
    i, j = pairs[c.edges[~horizontal]].T
    graph = coo_array((np.ones(len(i)), (i, j)), shape=(n, n)).tocsr()
    first = np.unique(pairs[ends[np.isin(ends, loop)]])
    levels = dijkstra(graph, directed=False, indices=first, unweighted=True, min_only=True)[pairs]
    per_face = np.sort(levels[c.corners].reshape(-1, 6), axis=1)
    wrong = np.flatnonzero((per_face - per_face[:, :1] != [0, 0, 1, 1, 2, 2]).any(axis=1))
    if len(wrong):
        raise MeshError(
            f"face {wrong[0]} is no hexagon between two horizontal edges, in a band of such about the z axis: it has "
            f"corners in the levels {per_face[wrong[0]].tolist()}; the mesh does not consist of rings either",
            elements=wrong.tolist(),
        )
    return integers(levels)
