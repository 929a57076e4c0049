"""Fewer unknowns for the meshes parallel to M: the shapes of faces that share no vertex.

In a mesh parallel to M, a face with k corners has k + 1 degrees of freedom, not 3 k: three of its position, and the
lengths of k - 2 edges, since the other two close the face. For any values of these, its edges are parallel to those of
M. So disjoint faces and the remaining vertices have fewer unknowns and equations than all vertices have: on a mesh of
quads half as many, and a factor takes a third of the time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.functionals import coordinates, parallel_to
from geometry.mesh import Mesh
from geometry.mesh.independent_faces import disjoint_faces
from geometry.optimise import SparseMatrix, apply

__all__ = ["FaceUnknowns"]

LEAST_CORNER_SINE = 1e-3
"""Largest sine between two edges of a face, below which its vertices are separate unknowns: lengths lose digits."""

MAX_UNKNOWN_CORNERS = 12
"""Number of corners of a face above which its vertices are separate unknowns: k^2 numbers cost more than they save."""


@dataclass(frozen=True, eq=False)
class FaceUnknowns:
    """The unknowns y (n,) of meshes s = matrix y (3N,): edges around the disjoint faces are parallel to those of M.

    Columns of the matrix are orthonormal, so |y| = |s|, and y = matrix^T s of a mesh s in P(M). Raises MeshError for
    an edge of M without length.
    """

    mesh: Mesh

    @cached_property
    def matrix(self) -> SparseMatrix:
        """(3N, n): its span contains P(M). Columns of a face are its translations, then its shapes about their mean."""
        n_vertices = self.mesh.n_vertices
        rows, columns, values, n = [], [], [], 0
        alone = np.ones(n_vertices, dtype=bool)
        for corners, shapes in self._shapes:
            vertices = self.mesh.combinatorics.corners[corners]
            alone[vertices] = False
            n_faces, k, _, n_shapes = shapes.shape
            first = n + (3 + n_shapes) * np.arange(n_faces)[:, None, None, None]
            move = np.broadcast_to(first + np.arange(3)[:, None], (n_faces, k, 3, 1))
            shape = np.broadcast_to(first + 3 + np.arange(n_shapes), shapes.shape)
            columns.append(np.concatenate([move, shape], axis=3).ravel())
            values.append(np.concatenate([np.full(move.shape, k**-0.5), shapes], axis=3).ravel())
            rows.append(np.repeat(coordinates(vertices).ravel(), 1 + n_shapes))
            n += (3 + n_shapes) * n_faces
        single = coordinates(np.flatnonzero(alone)).ravel()
        rows.append(single)
        columns.append(n + np.arange(len(single)))
        values.append(np.ones(len(single)))
        places = (np.concatenate(rows), np.concatenate(columns))
        return csr_array(coo_array((np.concatenate(values), places), shape=(3 * n_vertices, n + len(single))))

    @cached_property
    def open_constraints(self) -> SparseMatrix:
        """(m, 3N) A: the equations of parallelity, two for each edge, that matrix y does not satisfy for every y."""
        rows = 2 * self.open_edges[:, None] + np.arange(2)
        return csr_array(parallel_to(self.mesh).matrix[rows.ravel()])

    @cached_property
    def open_edges(self) -> IntArray:
        """(m / 2,) the edges of these equations: those around none of the disjoint faces."""
        c = self.mesh.combinatorics
        closed = np.zeros(c.n_edges, dtype=bool)
        for corners, _ in self._shapes:
            closed[c.corner_edge[corners]] = True
        return integers(np.flatnonzero(~closed))

    @cached_property
    def constraints(self) -> SparseMatrix:
        """(m, n): the same equations for y."""
        return csr_array(self.open_constraints @ self.matrix)

    def objective(self, H: SparseMatrix, g: FloatArray) -> tuple[SparseMatrix, FloatArray]:
        """H (n, n) and g (n,) of the objective x H x / 2 - g x in these unknowns, from H (3N, 3N) and g (3N,)."""
        return csr_array(self._transposed @ (H @ self.matrix)), self.of(g)

    def of(self, x: FloatArray) -> FloatArray:
        """matrix^T x (n,): the unknowns of the mesh x (3N,), or of a gradient."""
        return apply(self._transposed, x)

    @cached_property
    def _transposed(self) -> SparseMatrix:
        return csr_array(self.matrix.T)

    @cached_property
    def _shapes(self) -> list[tuple[IntArray, FloatArray]]:
        """For each number of corners k: the corners (n, k) of the disjoint faces, and their shapes (n, k, 3, k - 2)."""
        c, mesh = self.mesh.combinatorics, self.mesh
        chosen = disjoint_faces(c)
        found = []
        for faces, corners in c.faces_by_size():
            if corners.shape[1] > MAX_UNKNOWN_CORNERS:
                continue
            kept = np.isin(faces, chosen)
            faces, corners = faces[kept], corners[kept]
            directions = mesh.corner_directions[corners]
            crossing = _crossing(directions, mesh.face_normals[faces])
            wide = np.abs(crossing).max(axis=(1, 2), initial=0.0) > LEAST_CORNER_SINE
            found.append((corners[wide], _shapes(directions[wide], crossing[wide])))
        return found


def _crossing(directions: FloatArray, normals: FloatArray) -> FloatArray:
    """(n, k, k) sines of the angles from edge to edge, of edges (n, k, 3) in planes with normals (n, 3)."""
    across = np.cross(normals[:, None], directions)
    return np.asarray(np.einsum("nik,njk->nij", across, directions))


def _shapes(directions: FloatArray, crossing: FloatArray) -> FloatArray:
    """(n, k, 3, k - 2) orthonormal positions of the corners about their mean, for edges in these directions (n, k, 3).

    In each shape one edge has the length 1, and the two edges at the angle nearest to 90 degrees close the polygon, so
    that their lengths are at most 1.
    """
    n, k, _ = directions.shape
    faces, shapes = np.arange(n)[:, None], np.arange(k - 2)
    first, second = np.divmod(np.abs(crossing).reshape(n, k * k).argmax(axis=1)[:, None], k)
    closing = (np.arange(k) == first) | (np.arange(k) == second)
    free = np.argsort(closing, axis=1, kind="stable")[:, : k - 2]
    lengths = np.zeros((n, k, k - 2))
    lengths[faces, free, shapes] = 1.0
    wide = crossing[faces, first, second]
    lengths[faces, first, shapes] = -crossing[faces, free, second] / wide
    lengths[faces, second, shapes] = -crossing[faces, first, free] / wide
    steps = directions[:, :, :, None] * lengths[:, :, None, :]
    tails = np.cumsum(steps, axis=1) - steps
    tails -= tails.mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.qr(tails.reshape(n, 3 * k, k - 2))[0].reshape(tails.shape))
