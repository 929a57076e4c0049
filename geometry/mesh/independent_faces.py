"""Faces that share no vertex, nearly as many as there can be."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.spanning_forests import spanning_forest

__all__ = ["disjoint_faces"]


def disjoint_faces(combinatorics: Combinatorics) -> IntArray:
    """(m,) faces of which no two share a vertex, and to which none can be added.

    Faces at an even distance from the first face are preferred, where distances count steps across common vertices and
    across common edges. On a grid of quads these are every second face of every second row, which use all vertices.
    Ties are broken by random numbers with a fixed seed.
    """
    c = combinatorics
    by_vertex = _depths(c.n_faces + c.n_vertices, np.stack([c.corner_face, c.n_faces + c.corners], axis=1))
    by_edge = _depths(c.n_faces, c.edge_faces[~c.is_boundary_edge])
    even = (by_vertex[: c.n_faces] // 2 % 2 == 0) & (by_edge % 2 == 0)
    rank = np.random.default_rng(0).permutation(c.n_faces) + np.where(even, 0, c.n_faces)
    return _greedy(c, rank)


def _depths(n_nodes: int, links: IntArray) -> IntArray:
    """(n,) distance of each node from the first one of its component, in links (m, 2)."""
    depths = np.zeros(n_nodes, dtype=np.int64)
    for depth, level in enumerate(spanning_forest(n_nodes, links).levels, start=1):
        depths[level.children] = depth
    return integers(depths)


def _greedy(c: Combinatorics, rank: IntArray) -> IntArray:
    """The faces that are chosen one by one in the order of their ranks (F,), without those that share a vertex with a
    chosen one; found in rounds, each of which chooses all faces that have the least rank at all of their vertices."""
    is_used, chosen = np.zeros(c.n_vertices, dtype=bool), []
    corners, corner_face = c.corners, c.corner_face
    while len(corners):
        first = np.full(c.n_vertices, 2 * c.n_faces)
        np.minimum.at(first, corners, rank[corner_face])
        is_first = np.ones(c.n_faces, dtype=bool)
        is_first[corner_face[rank[corner_face] != first[corners]]] = False
        is_used[corners[is_first[corner_face]]] = True
        chosen.append(np.unique(corner_face[is_first[corner_face]]))
        is_excluded = np.zeros(c.n_faces, dtype=bool)
        is_excluded[corner_face[is_used[corners]]] = True
        keep = ~is_excluded[corner_face]
        corners, corner_face = corners[keep], corner_face[keep]
    return integers(np.sort(np.concatenate(chosen)))
