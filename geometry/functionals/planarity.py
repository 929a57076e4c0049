"""Planarity of faces with any number of corners.

For a face with k corners let h (k,) be the distances of its corners from its best plane. As that plane is best, h is
perpendicular to 1 and to the in-plane coordinates of the corners, so the residuals Q^T h, with Q as in `frames`, have
the norm of h: no false zeros, whatever corners are collinear. Turning the plane changes h by in-plane
coordinates, which Q^T removes, so the Jacobian is Q^T times the normal, up to terms of the order of h.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray
from geometry.functionals.frames import LargerFaces
from geometry.mesh import Combinatorics, Mesh
from geometry.optimise.functional import SparseMatrix

__all__ = ["Planarity", "face_deviations"]


def face_deviations(mesh: Mesh) -> FloatArray:
    """(F,) largest distance of a corner from the best plane of its face, over the mean edge length of the mesh.

    Zero for a mesh that is a point.
    """
    return mesh.plane_deviations / (mesh.mean_edge_length or 1.0)


@dataclass(frozen=True, eq=False)
class Planarity:
    """k - 3 residuals for each face with k corners, in the unit of the coordinates; the unknown is all of them.

    jacobian^T residual is the gradient of |residual|^2 / 2 everywhere.
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        return self._faces.stacked([frames.beyond(frames.heights) for frames in self._faces.frames(x)])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return self._faces.matrix(
            [np.einsum("fkq,fi->fqki", frames.basis, frames.normals) for frames in self._faces.frames(x)]
        )

    @cached_property
    def _faces(self) -> LargerFaces:
        return LargerFaces(self.combinatorics)
