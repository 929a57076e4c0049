"""Planar faces with any number of corners.

For a face with k corners let h (k,) be the distances of its corners from its best plane. As that plane is best, h is
perpendicular to 1 and to the in-plane coordinates of the corners, so the residuals Q^T h, with Q as in `face_frames`,
have the norm of h: no false zeros, whatever corners are collinear. Turning the plane changes h by in-plane
coordinates, which Q^T removes, so the Jacobian is Q^T times the normal, up to terms of the order of h.

Q is full of numbers, k^2 of them; faces with many corners are measured from three of these instead, see
`reference_planes`: k - 3 distances that vanish together with h, and whose squares add up to at least |h|^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, vstack

from geometry.arrays import FloatArray, IntArray
from geometry.functionals.face_frames import NonTriangularFaces
from geometry.functionals.reference_planes import ReferencePlanes, far_apart
from geometry.mesh import Combinatorics, Mesh
from geometry.optimise import SparseMatrix

__all__ = ["PlanarFaces", "relative_plane_deviations"]

MAX_FRAMED_CORNERS = 12
"""Number of corners of a face up to which Q is used; above it, three reference corners need fewer numbers."""


def relative_plane_deviations(mesh: Mesh) -> FloatArray:
    """(F,) largest distance of a corner from the best plane of its face, over the mean edge length of the mesh.

    Zero for a mesh that is a point.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(1, 1)
    >>> bent = grid.with_vertices(grid.vertices + [(0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0.4)])
    >>> relative_plane_deviations(bent).round(1).tolist()
    [0.1]
    """
    return mesh.plane_deviations / (mesh.mean_edge_length or 1.0)


@dataclass(frozen=True, eq=False)
class PlanarFaces:
    """k - 3 residuals for each face with k corners, in the unit of the coordinates; the unknown is all of them (3N,).

    jacobian^T residual is the gradient of |residual|^2 / 2 everywhere. shape (3N,): positions by which the three
    reference corners of large faces are chosen once, so that the sparsity pattern of the Jacobian is constant; without
    it, they are chosen at each x.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(2, 2)
    >>> r = PlanarFaces(grid.combinatorics)
    >>> raised = grid.vertices + [(0, 0, 0.1) if k == 0 else (0, 0, 0) for k in range(9)]
    >>> r.residual(grid.vertices.ravel()).tolist(), (abs(r.residual(raised.ravel())) > 0.01).sum().item()
    ([0.0, 0.0, 0.0, 0.0], 1)
    """

    combinatorics: Combinatorics
    shape: FloatArray | None = None

    def residual(self, x: FloatArray) -> FloatArray:
        small = self._faces.stacked([frames.project_out(frames.heights) for frames in self._faces.frames(x)])
        return np.concatenate([small, *(planes.heights.ravel() for planes in self._planes(x))])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        small = self._faces.matrix(
            [np.einsum("fkq,fi->fqki", frames.basis, frames.normals) for frames in self._faces.frames(x)]
        )
        if not self._large:
            return small
        large = [planes.rows(at, len(x)) for planes, at in zip(self._planes(x), self._large, strict=True)]
        return csr_array(vstack([small, *large], format="csr"))

    @cached_property
    def _faces(self) -> NonTriangularFaces:
        return NonTriangularFaces(self.combinatorics, MAX_FRAMED_CORNERS)

    @cached_property
    def _large(self) -> list[IntArray]:
        """For each k above the bound: the vertices (n, k) of its faces."""
        c = self.combinatorics
        return [c.corners[corners] for _, corners in c.faces_by_size() if corners.shape[1] > MAX_FRAMED_CORNERS]

    def _planes(self, x: FloatArray) -> list[ReferencePlanes]:
        corners = [x.reshape(-1, 3)[vertices] for vertices in self._large]
        three = self._three or [far_apart(each) for each in corners]
        return [ReferencePlanes.of(*each) for each in zip(corners, three, strict=True)]

    @cached_property
    def _three(self) -> list[IntArray] | None:
        """As `large`: the corners (n, 3) of the planes, where they are chosen beforehand."""
        if self.shape is None:
            return None
        return [far_apart(self.shape.reshape(-1, 3)[vertices]) for vertices in self._large]
