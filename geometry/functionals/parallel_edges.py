"""Parallel edges of two meshes: linear in S where M is given, or of M and S together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.polygons import perpendicular_pair
from geometry.optimise import LinearFunctional, SparseMatrix

__all__ = ["ParallelEdges", "parallel_to"]


def parallel_to(mesh: Mesh) -> LinearFunctional:
    """Two residuals an edge: the part of s_j - s_i across the direction of m_j - m_i [Pottmann2007, (2)].

    The paper takes the cross product with m_j - m_i: three equations of rank two, weighted by the length of the
    edge. Here the two rows are orthonormal, so that residuals are lengths in S.

    >>> from geometry.mesh import shapes
    >>> box = shapes.box(1, 2, 3)
    >>> r = parallel_to(box)
    >>> abs(r.residual(shapes.box(5, 2, 4).vertices.ravel())).max().round(12).item()
    0.0
    """
    across = perpendicular_pair(mesh.edge_directions)
    values = np.stack([-across, across], axis=2)  # edge, row, end, coordinate
    columns = np.broadcast_to(coordinates(mesh.combinatorics.edges)[:, None], values.shape)
    starts = np.arange(0, values.size + 1, 6, dtype=np.int64)
    shape = (2 * mesh.n_edges, 3 * mesh.n_vertices)
    matrix: SparseMatrix = csr_array((values.ravel(), columns.ravel(), starts), shape=shape)
    return LinearFunctional(matrix, np.zeros(shape[0]))


@dataclass(frozen=True, eq=False)
class ParallelEdges:
    """f_par of a mesh M and a mesh S, both unknown: x (6N,) is the coordinates of M, then those of S.

    Three residuals an edge, e x (s_j - s_i) with e the unit vector along m_j - m_i [Pottmann2007, 4.4]: lengths in S,
    of rank two. Edges of M must have a length; those of S need not. The Jacobian is exact everywhere.

    >>> from geometry.mesh import shapes
    >>> M, S = shapes.box(1, 2, 3), shapes.box(5, 2, 4)
    >>> x = np.concatenate([M.vertices.ravel(), S.vertices.ravel()])
    >>> abs(ParallelEdges(M.combinatorics).residual(x)).max().round(12).item()
    0.0
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        directions, _, other = self._edges(x)
        return np.cross(directions, other).ravel()

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        directions, lengths, other = self._edges(x)
        # de is the part of d(m_j - m_i) across e, over the length; e x (s_j - s_i) is linear in either
        along = directions[:, :, None] * directions[:, None, :]
        by_mesh = -_cross_matrices(other) @ (np.eye(3) - along) / lengths[:, None, None]
        by_other = _cross_matrices(directions)
        values = np.stack([-by_mesh, by_mesh, -by_other, by_other], axis=2)  # edge, row, end, coordinate
        c = self.combinatorics
        ends = np.concatenate([c.edges, c.edges + c.n_vertices], axis=1)
        columns = np.broadcast_to(coordinates(ends)[:, None], values.shape)
        starts = np.arange(0, values.size + 1, 12)
        return csr_array((values.ravel(), columns.ravel(), starts), shape=(3 * c.n_edges, 6 * c.n_vertices))

    def _edges(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Directions (E, 3) and lengths (E,) in M, and vectors (E, 3) in S."""
        positions = x.reshape(2, -1, 3)
        i, j = self.combinatorics.edges.T
        edges, other = positions[:, j] - positions[:, i]
        lengths = np.linalg.norm(edges, axis=1)
        return edges / lengths[:, None], lengths, other


def _cross_matrices(vectors: FloatArray) -> FloatArray:
    """(E, 3, 3) the matrices of w -> v x w."""
    return np.cross(vectors[:, None, :], np.eye(3)).swapaxes(1, 2)
