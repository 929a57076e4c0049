"""Normals at the vertices, at the boundary too: there the faces lie on one side only, and their mean lags behind.

To second order, the normal of a face is the mean of the normals at its corners. Inside, the mean of the faces about a
vertex is good to second order; at the rim it is the normal of a place half a face or more inside. What the corners of
a face at the rim lack for its normal is therefore laid on those at the rim.
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
"""Of what the corners of a face lack, laid on one of them: half, as at a corner of a grid. A vertex where the rim turns
inwards has faces all around but one, lacks little, and would take over all that is rough in one face."""

LEAST_EXTRAPOLATED_COSINE = 0.5
"""Of the turn from the mean of the faces. Where faces turn by more than 60 degrees there is nothing to go on with."""


def extrapolated_normals(mesh: Mesh) -> FloatArray:
    """(N, 3) unit normals: `Mesh.vertex_normals` inside, extrapolated to the boundary.

    On grids of quads over smooth surfaces the error falls with the square of the edge length, at corners of the rim
    too. The rougher the faces inside are, the less is extrapolated: as a signal is taken from noise, d loses the part
    r^2 / (d^2 + r^2), with r what faces inside would have laid on the vertex. Where no face is inside, as in a single
    row, the corners of each face get its normal in the mean. Zero for a vertex that belongs to no face.
    """
    c, known = mesh.combinatorics, mesh.vertex_normals
    if not c.is_boundary_vertex.any():
        return known
    around: SparseMatrix = csr_array((np.ones(c.n_corners), c.corners, c.face_starts), shape=(c.n_faces, c.n_vertices))
    lacking = c.face_sizes[:, None] * mesh.face_normals - around @ known
    inside, roughness = _means_inside(mesh, around, lacking)
    laid = _laid_on_vertices(mesh)
    further = np.asarray(laid @ (lacking - inside))
    signal, noise = np.square(further).sum(axis=1), np.square(apply(laid, roughness))
    trust = np.divide(signal, signal + noise, out=np.zeros(c.n_vertices), where=signal > 0)
    normals = known + trust[:, None] * further
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    sound = np.einsum("ni,ni->n", normals, known) > LEAST_EXTRAPOLATED_COSINE
    return floats(np.where((c.is_boundary_vertex & sound)[:, None], normals, known))


def _laid_on_vertices(mesh: Mesh) -> SparseMatrix:
    """(N, F) what of that which the corners of a face lack in sum is laid on each of its vertices at the rim.

    On regular meshes a vertex of half as many faces is twice as far from their middle, so it lacks twice as much. Where
    a vertex has several faces to learn from, those with no vertex further out say it best: beside a corner of the
    rim, the face at the corner knows of two directions at once.
    """
    c = mesh.combinatorics
    n_faces = np.bincount(c.corners, minlength=c.n_vertices)
    at_rim, counts = c.is_boundary_vertex[c.corners], n_faces[c.corners]
    least = np.minimum.reduceat(np.where(at_rim, counts, c.n_corners), c.face_starts[:-1])[c.corner_face]
    best = at_rim & (counts == least)
    heard = np.where(np.bincount(c.corners[best], minlength=c.n_vertices)[c.corners] > 0, best, at_rim)
    weights = at_rim / counts
    shares = weights / np.maximum(face_sums(c, weights), 1 / c.n_corners)[c.corner_face]
    heard_by = np.maximum(np.bincount(c.corners[heard], minlength=c.n_vertices), 1)[c.corners]
    values = heard * np.minimum(shares, LARGEST_VERTEX_SHARE) / heard_by
    return csr_array(coo_array((values, (c.corners, c.corner_face)), shape=(c.n_vertices, c.n_faces)))


def _means_inside(mesh: Mesh, around: SparseMatrix, lacking: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(F, 3) mean and (F,) root mean square of what the corners lack in faces inside, up to two vertices away.

    On smooth surfaces both are of second order, and the mean goes on smoothly to the rim. Zero where none is inside.
    """
    c = mesh.combinatorics
    inside = np.zeros((c.n_faces, 1))
    inside[c.inner_faces] = 1.0
    sums = inside * np.concatenate([lacking, np.square(lacking).sum(axis=1)[:, None], inside], axis=1)
    for _ in range(2):
        sums = around @ (around.T @ sums)
    means = np.divide(sums[:, :4], sums[:, 4:], out=np.zeros((c.n_faces, 4)), where=sums[:, 4:] > 0)
    return means[:, :3], np.sqrt(means[:, 3])
