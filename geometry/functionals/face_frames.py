"""Best planes of the faces with a given number of corners, and functionals with k - 3 residuals for each face.

Four or more corners over-determine a plane, or a circle in it: of values at the k corners of a face, the part that is
not a + b u + c v (u, v: in-plane coordinates) has k - 3 components. The columns of Q (k, k-3) are an orthonormal basis
of the vectors perpendicular to 1, u and v, for any position of the corners. The basis is not unique and may change
discontinuously with x, which does not affect norms of residuals.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics
from geometry.optimise import SparseMatrix

__all__ = ["FaceFrames", "NonTriangularFaces"]


@dataclass(frozen=True, eq=False)
class FaceFrames:
    """n faces with k corners each, relative to their centroids.

    here (n, k, 3): the corners; axes (n, 3, 3): orthonormal columns, the normal of the best plane and then the
    in-plane axes in the order of the spread of the corners; basis (n, k, k-3): Q.
    """

    here: FloatArray
    axes: FloatArray
    basis: FloatArray

    @classmethod
    def of(cls, corners: FloatArray) -> FaceFrames:
        """corners (n, k, 3), k > 3."""
        here = corners - corners.mean(axis=1, keepdims=True)
        axes = np.linalg.eigh(np.einsum("fki,fkj->fij", here, here))[1]
        along = here @ axes
        along[:, :, 0] = 1.0
        return cls(here, axes, np.linalg.qr(along, mode="complete")[0][:, :, 3:])

    @property
    def normals(self) -> FloatArray:
        """(n, 3) normals of the best planes, with an arbitrary sign."""
        return self.axes[:, :, 0]

    @property
    def heights(self) -> FloatArray:
        """(n, k) distances of the corners from the best plane, along the normal."""
        return np.asarray(np.einsum("fki,fi->fk", self.here, self.normals))

    def project_out(self, values: FloatArray) -> FloatArray:
        """(n, k-3, ...) components of values (n, k, ...) at the corners without their part a + b u + c v."""
        return np.asarray(np.einsum("fkq,fk...->fq...", self.basis, values))


@dataclass(frozen=True, eq=False)
class NonTriangularFaces:
    """The faces with more than three corners, by their number of corners k, with k - 3 residuals each.

    Residuals are in the order of k, then in the order of faces. Faces with more corners than `bound` are left out.
    """

    combinatorics: Combinatorics
    bound: float = np.inf

    @cached_property
    def vertices(self) -> list[IntArray]:
        """For each k: the vertices (n, k) of its faces."""
        c = self.combinatorics
        return [c.corners[corners] for _, corners in c.faces_by_size() if 3 < corners.shape[1] <= self.bound]

    def frames(self, x: FloatArray) -> list[FaceFrames]:
        """For each k, where the vertices are at x (3N,)."""
        positions = x.reshape(-1, 3)
        return [FaceFrames.of(positions[vertices]) for vertices in self.vertices]

    def stacked(self, parts: list[FloatArray]) -> FloatArray:
        """The vector of all residuals, from (n, k-3) for each k."""
        return np.concatenate([np.zeros(0), *(part.ravel() for part in parts)])

    def matrix(self, parts: list[FloatArray]) -> SparseMatrix:
        """The Jacobian (m, 3N) of all residuals, from (n, k-3, k, 3) for each k: derivatives by each corner."""
        columns, starts = self._pattern
        return csr_array((self.stacked(parts), columns, starts), shape=(len(starts) - 1, self._n_unknowns))

    @property
    def _n_unknowns(self) -> int:
        return 3 * self.combinatorics.n_vertices

    @cached_property
    def _pattern(self) -> tuple[IntArray, IntArray]:
        """Columns and row starts of the Jacobian."""
        columns, lengths = [np.zeros(0, dtype=np.int64)], [np.zeros(1, dtype=np.int64)]
        for vertices in self.vertices:
            n, k = vertices.shape
            row = coordinates(vertices).reshape(n, 1, 3 * k)
            columns.append(np.broadcast_to(row, (n, k - 3, 3 * k)).ravel())
            lengths.append(np.full(n * (k - 3), 3 * k))
        return integers(np.concatenate(columns)), integers(np.cumsum(np.concatenate(lengths)))
