"""Constant mean or Gaussian curvature of a pair M, S, where both are unknown [Pottmann2007, 5]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.functionals.pair_distances import derivatives_by_corners, face_rows
from geometry.mesh import Combinatorics
from geometry.mesh.polygons import face_sums, vector_areas
from geometry.optimise import SparseMatrix

__all__ = ["ConstantCurvature"]


@dataclass(frozen=True, eq=False)
class ConstantCurvature:
    """One residual for each face: mixed area(F, sigma F) or area(sigma F), plus `value` area(F), over sizes (F,).

    x (6N,): the vertices of M, then those of S. mixed, and value H: zero where the mean curvature is H; not mixed, and
    value -K: zero where the Gaussian curvature is K. Areas are along the normals of M.

    >>> from geometry.mesh import shapes
    >>> M = shapes.box(2, 2, 2)
    >>> x = np.concatenate([M.vertices.ravel(), M.vertices.ravel() / 2])  # as for a sphere of radius 2
    >>> ConstantCurvature(M.combinatorics, -0.5, np.ones(6)).residual(x).round(12).tolist()
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """

    combinatorics: Combinatorics
    value: float
    sizes: FloatArray
    mixed: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "sizes", floats(self.sizes))

    def residual(self, x: FloatArray) -> FloatArray:
        vectors, normals, areas = self._areas(x)
        return np.asarray((np.einsum("fi,fi->f", vectors, normals) + self.value * areas) / self.sizes)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        c, (mesh, image) = self.combinatorics, x.reshape(2, -1, 3)
        vectors, normals, areas = self._areas(x)
        along = np.einsum("fi,fi->f", vectors, normals)[:, None] * normals
        by_area = self.value * normals + (vectors - along) / areas[:, None]
        corner_normals = normals[c.corner_face]
        diagonals = [each[c.corners[c.next_corner]] - each[c.corners[c.previous_corner]] for each in (mesh, image)]
        by_other, by_self = (np.cross(each, corner_normals) / (4 if self.mixed else 2) for each in diagonals)
        by_mesh = derivatives_by_corners(c, x, by_area[:, None])
        if self.mixed:
            by_mesh = by_mesh + by_self[:, None]
        sizes = self.sizes[c.corner_face, None, None]
        return face_rows(c, by_mesh / sizes, (by_other if self.mixed else by_self)[:, None] / sizes)

    def _areas(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(F, 3) the mixed vector area of M and S, or the vector area of S; normals (F, 3) and areas (F,) of M."""
        c, (mesh, image) = self.combinatorics, x.reshape(2, -1, 3)
        normals = vector_areas(mesh, c)
        areas = np.linalg.norm(normals, axis=1)
        if self.mixed:
            p, q = mesh[c.corners], image[c.corners]
            crossed = np.cross(p, q[c.next_corner]) + np.cross(q, p[c.next_corner])
            vectors = face_sums(c, crossed) / 4
        else:
            vectors = vector_areas(image, c)
        return vectors, normals / areas[:, None], areas
