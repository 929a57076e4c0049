"""Vertices, edges and faces of S at unit distance from the origin, where M and S are unknown [Pottmann2007, 4.4].

x (6N,): the vertices of M, then those of S. Where S is not exactly parallel to M, an edge line has the direction of the
edge in M and contains the midpoint of the edge in S; a face plane has the normal of the face in M and contains the mean
of the corners in S.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics
from geometry.mesh.polygons import face_centroids, vector_areas
from geometry.optimise import SparseMatrix

__all__ = [
    "EdgesAtUnitDistance",
    "FacesAtUnitDistance",
    "UprightFaces",
    "VerticesAtUnitDistance",
    "derivatives_by_corners",
    "face_rows",
]


@dataclass(frozen=True, eq=False)
class EdgesAtUnitDistance:
    """Distance - 1 for each edge line of S, the error of beam heights over d. Edges of M must have a length.

    >>> from geometry.mesh import shapes
    >>> M, cube = shapes.box(1, 2, 3), shapes.box(2, 2, 2)
    >>> x = np.concatenate([M.vertices.ravel(), (cube.vertices - cube.vertices.mean(axis=0)).ravel()])
    >>> set(EdgesAtUnitDistance(M.combinatorics).residual(x).round(3).tolist())
    {0.414}
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(self._feet(x)[0], axis=1) - 1.0)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        feet, along, lengths = self._feet(x)
        directions = feet / np.linalg.norm(feet, axis=1, keepdims=True)
        turning = (along / lengths)[:, None] * directions  # by the rotation of the edge of M
        values = np.stack([turning, -turning, directions / 2, directions / 2], axis=1)
        c = self.combinatorics
        columns = coordinates(np.concatenate([c.edges, c.edges + c.n_vertices], axis=1))
        starts = np.arange(0, values.size + 1, 12)
        return csr_array((values.ravel(), columns.ravel(), starts), shape=(c.n_edges, 6 * c.n_vertices))

    def _feet(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Feet of the origin on edge lines (E, 3); positions of midpoints along them (E,); edge lengths of M (E,)."""
        mesh, image = x.reshape(2, -1, 3)
        i, j = self.combinatorics.edges.T
        vectors, middles = mesh[j] - mesh[i], (image[i] + image[j]) / 2
        lengths = np.linalg.norm(vectors, axis=1)
        along = np.einsum("ei,ei->e", middles, vectors) / lengths
        return middles - (along / lengths)[:, None] * vectors, along, lengths


@dataclass(frozen=True, eq=False)
class VerticesAtUnitDistance:
    """|s_i| - 1 for each vertex that belongs to a face; x (3N,) is S alone.

    >>> from geometry.mesh import shapes
    >>> cube = shapes.box(2, 2, 2)
    >>> x = (cube.vertices - cube.vertices.mean(axis=0)).ravel()
    >>> set(VerticesAtUnitDistance(cube.combinatorics).residual(x).round(3).tolist())
    {0.732}
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(x.reshape(-1, 3)[self._used], axis=1) - 1.0)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        at = x.reshape(-1, 3)[self._used]
        values = at / np.linalg.norm(at, axis=1, keepdims=True)
        starts = np.arange(0, values.size + 1, 3)
        shape = (len(at), 3 * self.combinatorics.n_vertices)
        return csr_array((values.ravel(), coordinates(self._used).ravel(), starts), shape=shape)

    @property
    def _used(self) -> IntArray:
        return integers(np.flatnonzero(self.combinatorics.is_used))


@dataclass(frozen=True, eq=False)
class FacesAtUnitDistance:
    """Distance - 1 for each face plane of S, along the normals of M.

    >>> from geometry.mesh import shapes
    >>> M, cube = shapes.box(1, 2, 3), shapes.box(3, 3, 3)
    >>> x = np.concatenate([M.vertices.ravel(), (cube.vertices - cube.vertices.mean(axis=0)).ravel()])
    >>> set(FacesAtUnitDistance(M.combinatorics).residual(x).round(3).tolist())
    {0.5}
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        normals, _, centres = _faces(self.combinatorics, x)
        return np.asarray(np.einsum("fi,fi->f", normals, centres) - 1.0)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        normals, areas, centres = _faces(self.combinatorics, x)
        heights = np.einsum("fi,fi->f", normals, centres)
        by_area = (centres - heights[:, None] * normals) / areas[:, None]
        by_corner = (normals / self.combinatorics.face_sizes[:, None])[self.combinatorics.corner_face]
        return face_rows(
            self.combinatorics, derivatives_by_corners(self.combinatorics, x, by_area[:, None]), by_corner[:, None]
        )


@dataclass(frozen=True, eq=False)
class UprightFaces:
    """The mean of the corners in S minus distance times the normal in M, three residuals for each face: its axis is
    upright.

    >>> from geometry.mesh import shapes
    >>> M, cube = shapes.box(1, 2, 3), shapes.box(2, 2, 2)
    >>> x = np.concatenate([M.vertices.ravel(), (cube.vertices - cube.vertices.mean(axis=0)).ravel()])
    >>> abs(UprightFaces(M.combinatorics).residual(x)).max().round(12).item()
    0.0
    """

    combinatorics: Combinatorics
    distance: float = 1.0

    def residual(self, x: FloatArray) -> FloatArray:
        normals, _, centres = _faces(self.combinatorics, x)
        return np.asarray((centres - self.distance * normals).ravel())

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        normals, areas, _ = _faces(self.combinatorics, x)
        across = normals[:, :, None] * normals[:, None, :] - np.eye(3)
        by_mesh = derivatives_by_corners(self.combinatorics, x, self.distance * across / areas[:, None, None])
        sizes = self.combinatorics.face_sizes[self.combinatorics.corner_face]
        return face_rows(self.combinatorics, by_mesh, np.eye(3) / sizes[:, None, None])


def derivatives_by_corners(combinatorics: Combinatorics, x: FloatArray, derivatives: FloatArray) -> FloatArray:
    """(C, r, 3) derivatives with respect to the corners in M, from those (F, r, 3) with respect to the vector areas of
    M.

    With A the vector area of a face, dA is half the sum of dp_i x (p_i+1 - p_i-1).
    """
    c, mesh = combinatorics, x[: 3 * combinatorics.n_vertices].reshape(-1, 3)
    diagonals = mesh[c.corners[c.next_corner]] - mesh[c.corners[c.previous_corner]]
    return np.asarray(np.cross(diagonals[:, None, :], derivatives[c.corner_face]) / 2)


def face_rows(combinatorics: Combinatorics, by_mesh: FloatArray, by_image: FloatArray) -> SparseMatrix:
    """The Jacobian (F r, 6N) of r residuals a face, from the derivatives (C, r, 3) by its corners in M and in S."""
    c = combinatorics
    rows = c.corner_face[:, None] * by_mesh.shape[1] + np.arange(by_mesh.shape[1])
    values = np.stack([by_mesh, by_image])
    columns = coordinates(np.stack([c.corners, c.corners + c.n_vertices]))[:, :, None, :]
    places = tuple(np.broadcast_to(part, values.shape).ravel() for part in (rows[None, :, :, None], columns))
    shape = (c.n_faces * by_mesh.shape[1], 6 * c.n_vertices)
    return csr_array(coo_array((values.ravel(), places), shape=shape))


def _faces(combinatorics: Combinatorics, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit normals (F, 3) and areas (F,) in M, means of the corners in S (F, 3)."""
    mesh, image = x.reshape(2, -1, 3)
    normals = vector_areas(mesh, combinatorics)
    areas = np.linalg.norm(normals, axis=1)
    return normals / areas[:, None], areas, face_centroids(image, combinatorics)
