"""Faces that share no vertex, nearly as many as there can be."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.spanning_forests import spanning_forest

__all__ = ["disjoint_faces"]


def disjoint_faces(combinatorics: Combinatorics) -> IntArray:
    """(m,) faces of which no two share a vertex, and to which none can be added.

    Preferred are faces at an even distance from the first face, both along common vertices and along common edges: on a
    grid of quads that is every second face of every second row, and all vertices are taken. Ties are broken by chance,
    always in the same way.
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
    """What taking faces in the order of their ranks leads to: at once all that are first at each of their vertices."""
    taken, chosen = np.zeros(c.n_vertices, dtype=bool), []
    corners, of_corner = c.corners, c.corner_face
    while len(corners):
        first = np.full(c.n_vertices, 2 * c.n_faces)
        np.minimum.at(first, corners, rank[of_corner])
        is_first = np.ones(c.n_faces, dtype=bool)
        is_first[of_corner[rank[of_corner] != first[corners]]] = False
        taken[corners[is_first[of_corner]]] = True
        chosen.append(np.unique(of_corner[is_first[of_corner]]))
        lost = np.zeros(c.n_faces, dtype=bool)
        lost[of_corner[taken[corners]]] = True
        keep = ~lost[of_corner]
        corners, of_corner = corners[keep], of_corner[keep]
    return integers(np.sort(np.concatenate(chosen)))
