"""Parallelity to a given mesh: linear in the other mesh."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Mesh
from geometry.optimise.functional import LinearFunctional, SparseMatrix

__all__ = ["parallel_to"]


def parallel_to(mesh: Mesh) -> LinearFunctional:
    """Two residuals an edge: the part of s_j - s_i across the direction of m_j - m_i [Pottmann2007, (2)].

    The paper takes the cross product with m_j - m_i: three equations of rank two, weighted by the length of the
    edge. Here the two rows are orthonormal, so that residuals are lengths in S.
    """
    across = _across(mesh.edge_directions)
    values = np.stack([-across, across], axis=2)  # edge, row, end, coordinate
    columns = np.broadcast_to(coordinates(mesh.combinatorics.edges)[:, None], values.shape)
    starts = np.arange(0, values.size + 1, 6, dtype=np.int64)
    shape = (2 * mesh.n_edges, 3 * mesh.n_vertices)
    matrix: SparseMatrix = csr_array((values.ravel(), columns.ravel(), starts), shape=shape)
    return LinearFunctional(matrix, np.zeros(shape[0]))


def _across(directions: FloatArray) -> FloatArray:
    """(E, 2, 3) two unit vectors perpendicular to each direction and to each other."""
    smallest = np.eye(3)[np.abs(directions).argmin(axis=1)]
    first = np.cross(directions, smallest)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=1)
