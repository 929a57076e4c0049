"""The order of the coordinates of a mesh in one vector of unknowns: x (3N,), vertex after vertex."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from geometry.arrays import IntArray
from geometry.optimise import SparseMatrix

__all__ = ["coordinates", "for_each_coordinate"]


def coordinates(vertices: IntArray) -> IntArray:
    """(..., 3) indices of the coordinates of vertices (...).

    >>> coordinates(np.array([0, 5])).tolist()
    [[0, 1, 2], [15, 16, 17]]
    """
    return 3 * vertices[..., None] + np.arange(3)


def for_each_coordinate(matrix: SparseMatrix) -> SparseMatrix:
    """The matrix (3m, 3N) that applies a matrix (m, N) to each coordinate of the vertices."""
    return csr_array(kron(matrix, eye_array(3), format="csr"))
