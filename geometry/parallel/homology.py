"""Closed paths of edges that do not bound faces: around holes, around and through handles."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import IntArray
from geometry.mesh import Combinatorics
from geometry.mesh.spanning_forests import spanning_forest
from geometry.optimise import SparseMatrix

__all__ = ["independent_loops"]


def independent_loops(combinatorics: Combinatorics) -> SparseMatrix:
    """(L, E): 1 where a loop runs along an edge, -1 where against it.

    Edge values that sum to zero around each face and along these loops do so along every closed path, and the loops
    are independent: a connected mesh with a boundary has 1 - chi of them, one without has 2 - chi.

    By tree and cotree [EricksonWhittlesey2005]: a tree of edges reaches all vertices; a second tree, across edges that
    are not in the first, reaches all faces and the outside of the boundaries. Each remaining edge closes one loop of
    the first tree.
    """
    c = combinatorics
    if _n_loops(c) == 0:  # a disc needs no trees
        return csr_array((0, c.n_edges))
    parents, through = _parents(c.n_vertices, c.edges)
    remaining = np.ones(c.n_edges, dtype=bool)
    remaining[through[through >= 0]] = False

    others = np.flatnonzero(remaining)
    faces = np.where(c.edge_faces[others] < 0, c.n_faces, c.edge_faces[others])
    _, across = _parents(c.n_faces + 1, faces)
    remaining[others[across[across >= 0]]] = False
    return _closed_in_tree(c, np.flatnonzero(remaining), parents, through)


def _n_loops(c: Combinatorics) -> int:
    """The first Betti number: pieces plus closed surfaces minus chi."""
    pieces = connected_components(c.adjacency, directed=False)[0] - int((~c.is_used).sum())
    is_open = np.zeros(c.face_components.max() + 1, dtype=bool)
    is_open[c.face_components[c.edge_faces[c.is_boundary_edge, 0]]] = True
    return int(pieces) + int((~is_open).sum()) - c.euler_characteristic


def _parents(n: int, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """For each of n nodes its parent in a spanning forest and the index of the pair that links them, -1 at roots."""
    parents, through = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    for level in spanning_forest(n, pairs).levels:
        parents[level.children] = level.parents
        through[level.children] = level.edges
    return parents, through


def _closed_in_tree(c: Combinatorics, closing: IntArray, parents: IntArray, through: IntArray) -> SparseMatrix:
    """The loop of each closing edge: the path in the tree from the root to its tail, and from its head back."""
    n = len(closing)
    loops, edges, signs = [np.arange(n)], [closing], [np.ones(n)]
    for end, sign in ((0, 1.0), (1, -1.0)):
        loop, vertices = np.arange(n), c.edges[closing, end]
        while (inner := through[vertices] >= 0).any():
            loop, vertices = loop[inner], vertices[inner]
            edge = through[vertices]
            loops.append(loop)
            edges.append(edge)
            signs.append(np.where(c.edges[edge, 1] == vertices, sign, -sign))
            vertices = parents[vertices]
    places = (np.concatenate(loops), np.concatenate(edges))
    matrix = csr_array(coo_array((np.concatenate(signs), places), shape=(n, c.n_edges)))
    matrix.eliminate_zeros()  # edges that both paths share
    return matrix
