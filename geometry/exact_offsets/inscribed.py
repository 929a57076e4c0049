"""Candidates for a Gauss image with its vertices on the unit sphere: M circular [Pottmann2007, Prop. 2].

An edge of S is a chord of the sphere, so s_j is s_i reflected in the plane through the origin perpendicular to the
edge. Along a tree of edges, s_i = R_i s_0 with known R_i; the other edges are linear conditions on s_0. Discs
of circular quads leave s_0 free on the sphere, other meshes may leave a circle or two opposite points.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import Mesh
from geometry.mesh.spanning_forests import SpanningForest, spanning_forest

__all__ = ["inscribed_candidate"]

LEAST_CONDITION_RESIDUAL = 1e-6
"""Residual of a condition on s_0, below which it counts as met, whatever the tolerance: the squares of smaller ones
are rounding beside others of order 1."""


def inscribed_candidate(mesh: Mesh, tolerance: float) -> FloatArray:
    """(N, 3) unit vectors, the best start for an inscribed S; exact if there is one.

    Among the s_0 that meet the conditions to about `tolerance`, the one with s_i nearest to the vertex normals;
    each component has its own. An edge of S may have no length only where s_i is perpendicular to it.
    """
    c = mesh.combinatorics
    forest = spanning_forest(c.n_vertices, c.edges)
    reflections = _reflections(mesh, forest)
    n = len(forest.roots)

    targets = np.zeros((n, 3))  # sum of R_i^T n_i
    np.add.at(targets, forest.components, np.einsum("nij,ni->nj", reflections, mesh.vertex_normals))
    there, back = _reflected(reflections[c.edges[:, 0]], mesh.edge_directions), reflections[c.edges[:, 1]]
    gaps = there - back
    scatter, counts = np.zeros((n, 3, 3)), np.zeros(n)
    np.add.at(scatter, forest.components[c.edges[:, 0]], np.einsum("eki,ekj->eij", gaps, gaps))
    np.add.at(counts, forest.components[c.edges[:, 0]], 1.0)
    scatter /= np.maximum(counts, 1)[:, None, None] * max(tolerance, LEAST_CONDITION_RESIDUAL) ** 2

    # minimise |s - target|^2 + gaps^2 / tolerance^2, in coordinates in which the gaps are independent
    squares, axes = np.linalg.eigh(scatter)
    along = np.einsum("nij,ni->nj", axes, targets) / (1 + np.maximum(squares - squares[:, :1], 0))
    s = np.einsum("nij,nj->ni", axes, along)
    lengths = np.linalg.norm(s, axis=1, keepdims=True)
    s = np.where(lengths > 0, s / np.where(lengths > 0, lengths, 1), axes[:, :, 0])
    return np.asarray(np.einsum("nij,nj->ni", reflections, s[forest.components])) * c.is_used[:, None]


def _reflections(mesh: Mesh, forest: SpanningForest) -> FloatArray:
    """(N, 3, 3) R_i: the product of the reflections on the path from the root of the component."""
    products = np.tile(np.eye(3), (mesh.n_vertices, 1, 1))
    for level in forest.levels:
        products[level.children] = _reflected(products[level.parents], mesh.edge_directions[level.edges])
    return products


def _reflected(matrices: FloatArray, normals: FloatArray) -> FloatArray:
    """(n, 3, 3) the matrices, followed by the reflections in the planes with these unit normals (n, 3)."""
    heights = np.einsum("ni,nij->nj", normals, matrices)
    return np.asarray(matrices - 2 * normals[:, :, None] * heights[:, None, :])
