"""Planarity of faces with any number of corners.

For a face with k corners let h (k,) be the distances of its corners from its best plane. As that plane is best, h is
perpendicular to 1 and to the in-plane coordinates of the corners, so with an orthonormal basis Q (k, k-3) of
what is perpendicular to these three, the residuals Q^T h have the norm of h: no false zeros, whatever
corners are collinear. Turning the plane changes h by in-plane coordinates, which Q^T removes, so the Jacobian is
Q^T times the normal, up to terms of the order of h.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.polygons import face_mean_edge_lengths, planarity
from geometry.optimise.functional import SparseMatrix

__all__ = ["Planarity", "face_deviations"]


def face_deviations(mesh: Mesh) -> FloatArray:
    """(F,) largest distance of a corner from the best plane of its face, over the mean edge length of the mesh."""
    local = mesh.vertices - mesh.vertices.mean(axis=0)  # far from the origin, sums of coordinates would round
    lengths = face_mean_edge_lengths(local, mesh.combinatorics)
    return planarity(local, mesh.combinatorics) * lengths / mesh.mean_edge_length


@dataclass(frozen=True, eq=False)
class Planarity:
    """k - 3 residuals for each face with k corners, in the unit of the coordinates; the unknown is all of them."""

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        parts = [
            np.einsum("fkq,fk->fq", basis, distances).ravel()
            for basis, distances, _ in map(_face_frames, self._corner_positions(x))
        ]
        return np.concatenate([np.zeros(0), *parts])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        parts = [
            np.einsum("fkq,fi->fqki", basis, normals).ravel()
            for basis, _, normals in map(_face_frames, self._corner_positions(x))
        ]
        columns, starts = self._pattern
        shape = (len(starts) - 1, 3 * self.combinatorics.n_vertices)
        return csr_array((np.concatenate([np.zeros(0), *parts]), columns, starts), shape=shape)

    @cached_property
    def _groups(self) -> list[IntArray]:
        """(n, k) vertices of the faces with k corners, for each k > 3."""
        c = self.combinatorics
        return [c.corners[corners] for _, corners in c.faces_by_size() if corners.shape[1] > 3]

    @cached_property
    def _pattern(self) -> tuple[IntArray, IntArray]:
        """Columns and row starts of the Jacobian."""
        columns, lengths = [np.zeros(0, dtype=np.int64)], [np.zeros(1, dtype=np.int64)]
        for vertices in self._groups:
            n, k = vertices.shape
            row = coordinates(vertices).reshape(n, 1, 3 * k)
            columns.append(np.broadcast_to(row, (n, k - 3, 3 * k)).ravel())
            lengths.append(np.full(n * (k - 3), 3 * k))
        return integers(np.concatenate(columns)), integers(np.cumsum(np.concatenate(lengths)))

    def _corner_positions(self, x: FloatArray) -> list[FloatArray]:
        positions = x.reshape(-1, 3)
        return [positions[vertices] for vertices in self._groups]


def _face_frames(corners: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Q (n, k, k-3), distances h (n, k) and unit normals (n, 3) for faces with the corners (n, k, 3)."""
    here = corners - corners.mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(np.einsum("fki,fkj->fij", here, here))[1]
    along = here @ axes
    along[:, :, 0], distances = 1.0, along[:, :, 0].copy()
    return np.linalg.qr(along, mode="complete")[0][:, :, 3:], distances, axes[:, :, 0]
