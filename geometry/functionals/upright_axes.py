"""Upright node axes, edge lengths and face normals where M and S are unknown: x (6N,), M before S, or M alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.functionals.pair_distances import derivatives_by_corners, face_rows
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics
from geometry.mesh.polygons import vector_areas
from geometry.optimise import SparseMatrix

__all__ = ["CloseToNormals", "EdgeStretch", "FaceNormalCosines", "InsideCones", "UprightVertices"]


NORMAL_TURN_STEP = 0.1
"""Step in the unit of x, mean edge lengths, of the differences that measure how normals turn as a vertex glides: short
against an edge, and long against the rounding of interpolated normals."""


@dataclass(frozen=True, eq=False)
class CloseToNormals:
    """s_i - n_i, three residuals for each vertex, with unit normals n_i (N, 3) = normals(M (N, 3)).

    n_i depends on vertex i only. How it turns is measured by differences over `NORMAL_TURN_STEP`: an edge of a coarse
    mesh spans so much of a surface that vertices which glide turn their normals as much as S turns. The target of a
    vertex without a normal, (0, 0, 0), is the origin.

    >>> from geometry.mesh import shapes
    >>> M = shapes.grid(1, 1)
    >>> r = CloseToNormals(M.combinatorics, lambda vertices: np.tile([0.0, 0.0, 1.0], (4, 1)))
    >>> r.residual(np.concatenate([M.vertices.ravel(), np.tile([0.1, 0.0, 1.0], 4)]))[:3].tolist()
    [0.1, 0.0, 0.0]
    """

    combinatorics: Combinatorics
    normals: Callable[[FloatArray], FloatArray]

    def residual(self, x: FloatArray) -> FloatArray:
        mesh, image = x.reshape(2, -1, 3)
        return np.asarray((image - self.normals(mesh)).ravel())

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        n = 3 * self.combinatorics.n_vertices
        turns = _normal_turns(self.combinatorics, self.normals, x.reshape(2, -1, 3)[0])
        values = np.concatenate([-turns.reshape(n, 3), np.ones((n, 1))], axis=1)
        own = np.repeat(np.arange(n).reshape(-1, 3), 3, axis=0)
        columns = np.concatenate([own, n + np.arange(n)[:, None]], axis=1)
        return csr_array((values.ravel(), columns.ravel(), np.arange(0, 4 * n + 1, 4)), shape=(n, 2 * n))


@dataclass(frozen=True, eq=False)
class InsideCones:
    """Signed distance of s_i from the cone of revolution about n_i with an opening angle, for each vertex.

    |s_i| sin(angle - lean): positive inside. Normals and Jacobian as in `CloseToNormals`.

    >>> from geometry.mesh import shapes
    >>> M = shapes.grid(1, 1)
    >>> r = InsideCones(M.combinatorics, lambda vertices: np.tile([0.0, 0.0, 1.0], (4, 1)), np.radians(30))
    >>> r.residual(np.concatenate([M.vertices.ravel(), np.tile([0.0, 0.0, 1.0], 4)])).round(3).tolist()
    [0.5, 0.5, 0.5, 0.5]
    """

    combinatorics: Combinatorics
    normals: Callable[[FloatArray], FloatArray]
    angle: float

    def residual(self, x: FloatArray) -> FloatArray:
        return self._distances(x)[0]

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        _, by_image, by_normals = self._distances(x)
        n = self.combinatorics.n_vertices
        turns = _normal_turns(self.combinatorics, self.normals, x.reshape(2, -1, 3)[0])
        values = np.concatenate([np.einsum("ni,nij->nj", by_normals, turns), by_image], axis=1)
        columns = np.concatenate([coordinates(np.arange(n)), coordinates(n + np.arange(n))], axis=1)
        return csr_array((values.ravel(), columns.ravel(), np.arange(0, 6 * n + 1, 6)), shape=(n, 6 * n))

    def _distances(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The distances (N,) and their gradients by s_i and by n_i (N, 3), the latter for normals that stay unit."""
        mesh, image = x.reshape(2, -1, 3)
        normals = self.normals(mesh)
        up = np.einsum("ni,ni->n", image, normals)
        across = image - up[:, None] * normals
        lengths, directions = np.linalg.norm(across, axis=1), _unit(across)
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        by_normals = sine * image + cosine * up[:, None] * directions
        return sine * up - cosine * lengths, sine * normals - cosine * directions, by_normals


def _normal_turns(c: Combinatorics, normals: Callable[[FloatArray], FloatArray], positions: FloatArray) -> FloatArray:
    """(N, 3, 3) derivatives of the normals by the positions (N, 3), which the normals themselves do not change.

    Differences along an edge and across it, so that they do not depend on how the mesh lies in space.
    """
    n, neighbours = normals(positions), np.arange(c.n_vertices)
    neighbours[c.edges] = c.edges[:, ::-1]
    along = _unit(np.cross(n, np.cross(positions[neighbours] - positions, n)))
    turns = np.zeros((len(n), 3, 3))
    for direction in (along, np.cross(n, along)):
        step = NORMAL_TURN_STEP * direction
        difference = (normals(positions + step) - normals(positions - step)) / (2 * NORMAL_TURN_STEP)
        turns += difference[:, :, None] * direction[:, None, :]
    return turns


def _unit(vectors: FloatArray) -> FloatArray:
    """(N, 3) made unit; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0))


@dataclass(frozen=True, eq=False)
class EdgeStretch:
    """log(|m_j - m_i| / length) for each edge, with given lengths (E,); x (3N,) is M alone.

    >>> from geometry.mesh import shapes
    >>> M = shapes.grid(1, 1)
    >>> set(EdgeStretch(M.combinatorics, M.edge_lengths).residual(2 * M.vertices.ravel()).round(3).tolist())
    {0.693}
    """

    combinatorics: Combinatorics
    lengths: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "lengths", floats(self.lengths))

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(np.log(np.linalg.norm(self._vectors(x), axis=1) / self.lengths))

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        vectors = self._vectors(x)
        slopes = vectors / np.einsum("ei,ei->e", vectors, vectors)[:, None]
        values = np.stack([-slopes, slopes], axis=1)
        c = self.combinatorics
        starts = np.arange(0, values.size + 1, 6)
        return csr_array((values.ravel(), coordinates(c.edges).ravel(), starts), shape=(c.n_edges, 3 * c.n_vertices))

    def _vectors(self, x: FloatArray) -> FloatArray:
        i, j = self.combinatorics.edges.T
        return np.asarray(x.reshape(-1, 3)[j] - x.reshape(-1, 3)[i])


@dataclass(frozen=True, eq=False)
class FaceNormalCosines:
    """The cosine of the angle between each face normal of M and a given unit vector, normals (F, 3); x (6N,).

    >>> from geometry.mesh import shapes
    >>> M = shapes.grid(1, 1)
    >>> r = FaceNormalCosines(M.combinatorics, np.array([[0.0, 0.6, 0.8]]))
    >>> r.residual(np.concatenate([M.vertices.ravel(), M.vertices.ravel()])).round(12).tolist()
    [0.8]
    """

    combinatorics: Combinatorics
    normals: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "normals", floats(self.normals))

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("fi,fi->f", self._normals_and_areas(x)[0], self.normals))

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        face_normals, areas = self._normals_and_areas(x)
        cosines = np.einsum("fi,fi->f", face_normals, self.normals)
        by_area = (self.normals - cosines[:, None] * face_normals) / areas[:, None]
        by_mesh = derivatives_by_corners(self.combinatorics, x, by_area[:, None])
        return face_rows(self.combinatorics, by_mesh, np.zeros_like(by_mesh))

    def _normals_and_areas(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        areas = vector_areas(x.reshape(2, -1, 3)[0], self.combinatorics)
        sizes = np.linalg.norm(areas, axis=1)
        return areas / sizes[:, None], sizes


@dataclass(frozen=True, eq=False)
class UprightVertices:
    """s_i - radius n_i for vertices (k,), three residuals each; n_i is the mean of the normals of the faces of M around
    the vertex, made a unit vector. The Jacobian is exact. On a surface of revolution with a profile of short edges, n_i
    is the normal of the surface, however few faces go around it; the normal of a face and the middle of its image
    differ there by the square of the size of the face.

    >>> from geometry.mesh import shapes
    >>> M, cube = shapes.box(1, 2, 3), shapes.box(2, 2, 2)
    >>> x = np.concatenate([M.vertices.ravel(), (cube.vertices - cube.vertices.mean(axis=0)).ravel()])
    >>> abs(UprightVertices(M.combinatorics, np.arange(8), 3**0.5).residual(x)).max().round(12).item()
    0.0
    """

    combinatorics: Combinatorics
    vertices: IntArray
    radius: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", integers(self.vertices))

    def residual(self, x: FloatArray) -> FloatArray:
        normals, _, _ = self._normals(x)
        image = x.reshape(2, -1, 3)[1, self.vertices]
        return np.asarray((image - self.radius * normals).ravel())

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        c, n = self.combinatorics, self.combinatorics.n_vertices
        normals, sums, areas = self._normals(x)
        across = (normals[:, :, None] * normals[:, None, :] - np.eye(3)) * (self.radius / sums)[:, None, None]
        around, by_face = self._around, np.repeat(np.arange(len(self.vertices)), np.diff(self._around.indptr))
        by_normals = bsr_array((across[by_face], around.indices, around.indptr), shape=(3 * len(sums), 3 * c.n_faces))
        sizes = np.linalg.norm(areas, axis=1)
        face_normals = areas / sizes[:, None]
        turns = (np.eye(3) - face_normals[:, :, None] * face_normals[:, None, :]) / sizes[:, None, None]
        by_mesh = face_rows(c, derivatives_by_corners(c, x, turns), np.zeros((c.n_corners, 3, 3)))
        by_mesh.eliminate_zeros()
        columns = coordinates(n + self.vertices).ravel()
        by_image = coo_array((np.ones(len(columns)), (np.arange(len(columns)), columns)), shape=(len(columns), 6 * n))
        return csr_array(csr_array(by_normals) @ by_mesh + csr_array(by_image))

    @cached_property
    def _around(self) -> SparseMatrix:
        """(k, F) the faces around each vertex."""
        c = self.combinatorics
        ones = np.ones(c.n_corners)
        return csr_array(
            coo_array((ones, (c.corners, c.corner_face)), shape=(c.n_vertices, c.n_faces)).tocsr()[self.vertices]
        )

    def _normals(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """n_i (k, 3), lengths of the sums of face normals (k,), vector areas of faces (F, 3)."""
        areas = vector_areas(x.reshape(2, -1, 3)[0], self.combinatorics)
        sums = self._around @ (areas / np.linalg.norm(areas, axis=1, keepdims=True))
        lengths = np.linalg.norm(sums, axis=1)
        return sums / lengths[:, None], lengths, areas
