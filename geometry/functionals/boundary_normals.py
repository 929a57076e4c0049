"""Normals at the vertices, extrapolated to the boundary, where faces lie on one side only.

To second order, the normal of a face is the mean of the normals at its corners. At inner vertices the mean normal of
the faces is accurate to second order; at the boundary it is the normal of a point half a face or more inside. So the
difference between the normal of a face and the mean of its corners is distributed to its corners at the boundary.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array

from geometry.arrays import FloatArray, floats
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_sums
from geometry.optimise import SparseMatrix, apply

__all__ = ["extrapolated_normals"]

LARGEST_VERTEX_SHARE = 0.5
"""Largest part of the difference of a face that one corner takes: half, as at a corner of a grid. A vertex where the
boundary turns inwards needs little, and with more it would take over all the roughness of one face."""

LEAST_EXTRAPOLATED_COSINE = 0.5
"""Least cosine between an extrapolated normal and the mean of the faces; beyond 60 degrees the mean is used."""


def extrapolated_normals(mesh: Mesh) -> FloatArray:
    """(N, 3) unit normals: `Mesh.vertex_normals` inside, extrapolated to the boundary.

    On grids of quads over smooth surfaces the error decreases with the square of the edge length, at corners of the
    boundary too. On rough meshes less is extrapolated: as in separating a signal from noise, a correction d is reduced
    by the factor d^2 / (d^2 + r^2), where r is the correction that inner faces would give. In a single row of faces,
    without inner faces, the mean normal of the corners of each face is the normal of the face. Zero for a vertex that
    belongs to no face.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(6, 6)
    >>> roof = grid.with_vertices([(x, y, -0.05 * (x * x + y * y)) for x, y, _ in grid.vertices])
    >>> exact = np.array([0.6, 0.6, 1]) / np.linalg.norm([0.6, 0.6, 1])  # at the last vertex, (6, 6)
    >>> better, usual = (n[-1] @ exact for n in (extrapolated_normals(roof), roof.vertex_normals))
    >>> bool(better > usual)
    True
    """
    c, known = mesh.combinatorics, mesh.vertex_normals
    if not c.is_boundary_vertex.any():
        return known
    around: SparseMatrix = csr_array((np.ones(c.n_corners), c.corners, c.face_starts), shape=(c.n_faces, c.n_vertices))
    missing = c.face_sizes[:, None] * mesh.face_normals - around @ known
    inside, roughness = _means_inside(mesh, around, missing)
    shares = _vertex_shares(mesh)
    correction = np.asarray(shares @ (missing - inside))
    signal, noise = np.square(correction).sum(axis=1), np.square(apply(shares, roughness))
    trust = np.divide(signal, signal + noise, out=np.zeros(c.n_vertices), where=signal > 0)
    normals = known + trust[:, None] * correction
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    is_plausible = np.einsum("ni,ni->n", normals, known) > LEAST_EXTRAPOLATED_COSINE
    return floats(np.where((c.is_boundary_vertex & is_plausible)[:, None], normals, known))


def _vertex_shares(mesh: Mesh) -> SparseMatrix:
    """(N, F) shares of the vertices at the boundary in the difference of each face.

    On regular meshes a vertex with half as many faces is twice as far from their middle, so it takes twice as much. Of
    several faces of a vertex, those without a vertex with fewer faces are the most accurate: beside a corner of the
    boundary, the difference of the face at the corner belongs to two directions at once.
    """
    c = mesh.combinatorics
    n_faces = np.bincount(c.corners, minlength=c.n_vertices)
    at_boundary, counts = c.is_boundary_vertex[c.corners], n_faces[c.corners]
    least = np.minimum.reduceat(np.where(at_boundary, counts, c.n_corners), c.face_starts[:-1])[c.corner_face]
    best = at_boundary & (counts == least)
    used = np.where(np.bincount(c.corners[best], minlength=c.n_vertices)[c.corners] > 0, best, at_boundary)
    weights = at_boundary / counts
    shares = weights / np.maximum(face_sums(c, weights), 1 / c.n_corners)[c.corner_face]
    n_used = np.maximum(np.bincount(c.corners[used], minlength=c.n_vertices), 1)[c.corners]
    values = used * np.minimum(shares, LARGEST_VERTEX_SHARE) / n_used
    return csr_array(coo_array((values, (c.corners, c.corner_face)), shape=(c.n_vertices, c.n_faces)))


def _means_inside(mesh: Mesh, around: SparseMatrix, missing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(F, 3) mean and (F,) root mean square of the differences of inner faces, up to two vertices away.

    On smooth surfaces both are of second order, and the mean continues smoothly to the boundary. Zero without inner
    faces.
    """
    c = mesh.combinatorics
    inside = np.zeros((c.n_faces, 1))
    inside[c.inner_faces] = 1.0
    sums = inside * np.concatenate([missing, np.square(missing).sum(axis=1)[:, None], inside], axis=1)
    for _ in range(2):
        sums = around @ (around.T @ sums)
    means = np.divide(sums[:, :4], sums[:, 4:], out=np.zeros((c.n_faces, 4)), where=sums[:, 4:] > 0)
    return means[:, :3], np.sqrt(means[:, 3])
