"""How the positions of a mesh stand in one vector of unknowns: x (3N,), vertex after vertex."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from geometry.arrays import IntArray
from geometry.optimise import SparseMatrix

__all__ = ["coordinates", "for_each_coordinate"]


def coordinates(vertices: IntArray) -> IntArray:
    """(..., 3) indices of the coordinates of vertices (...)."""
    return 3 * vertices[..., None] + np.arange(3)


def for_each_coordinate(matrix: SparseMatrix) -> SparseMatrix:
    """The matrix (3m, 3N) that does to each coordinate what a matrix (m, N) does to values at the vertices."""
    return csr_array(kron(matrix, eye_array(3), format="csr"))
