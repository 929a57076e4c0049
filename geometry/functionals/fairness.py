"""Fairness of positions, and of how positions change."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array

from geometry.functionals.unknowns import for_each_coordinate
from geometry.mesh import Combinatorics, Mesh
from geometry.optimise import LinearFunctional, SparseMatrix

__all__ = ["laplacian", "strain"]


def laplacian(combinatorics: Combinatorics) -> LinearFunctional:
    """m_i minus the mean of its neighbours, for each vertex that belongs to a face [Pottmann2007, (3)].

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(2, 2)
    >>> laplacian(grid.combinatorics).residual(grid.vertices.ravel()).reshape(-1, 3)[4].tolist()  # the middle vertex
    [0.0, 0.0, 0.0]
    """
    degrees = combinatorics.vertex_degrees
    mean = diags_array(1 / np.maximum(degrees, 1)) @ combinatorics.adjacency
    matrix = for_each_coordinate(csr_array(diags_array((degrees > 0).astype(float)) - mean))
    return LinearFunctional(matrix, np.zeros(matrix.shape[0]))


def strain(mesh: Mesh) -> SparseMatrix:
    """S (3N, 3N) such that d S d is the sum of |d_i - d_j|^2 l^2 / |m_i - m_j|^2 over the edges.

    d: moves of the vertices; l: mean edge length. Short edges have the largest weights, so that moves with a small
    value neither collapse nor rotate edges. Translations have the value zero.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(2, 2)
    >>> shift, stretch = np.ones(27), (grid.vertices * 0.5).ravel()
    >>> (shift @ (strain(grid) @ shift)).item(), (stretch @ (strain(grid) @ stretch)).item()
    (0.0, 3.0)
    """
    i, j = mesh.combinatorics.edges.T
    edges = np.arange(mesh.n_edges)
    relative = mesh.mean_edge_length / mesh.edge_lengths
    values = np.concatenate([relative, -relative])
    places = (np.concatenate([edges, edges]), np.concatenate([j, i]))
    difference = csr_array((values, places), shape=(mesh.n_edges, mesh.n_vertices))
    return for_each_coordinate(csr_array(difference.T @ difference))
