"""Candidates for a Gauss image with its faces tangent to the unit sphere: M conical [Pottmann2007, Prop. 2].

Where M is conical, the planes n_F . x = 1 of the faces at m_i meet in s_i. At the boundary one or two planes do not
determine s_i, and edges there still have to be made parallel.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray
from geometry.exact_offsets.offset_conditions import least_norm, vertex_sums
from geometry.mesh import Mesh

__all__ = ["circumscribed_candidate"]

LEAST_PLANE_SINE = 1e-4
"""Sine of the angles between the planes at a vertex, from which on they determine its position: planes known to 1e-12
then determine it to 1e-8 along them, and far better across."""


def circumscribed_candidate(mesh: Mesh) -> tuple[FloatArray, BoolArray]:
    """Positions (N, 3) where the planes at distance 1 meet in the least squares sense, the one nearest to the vertex
    normal where several do; and whether (N,) the planes determine the position."""
    c = mesh.combinatorics
    normals, start = mesh.face_normals[c.corner_face], mesh.vertex_normals
    residuals = 1 - np.einsum("ck,ck->c", normals, start[c.corners])
    scatter = vertex_sums(mesh, normals[:, :, None] * normals[:, None, :])
    squares = np.linalg.eigvalsh(scatter)
    places = start + least_norm(scatter, vertex_sums(mesh, normals * residuals[:, None]))
    return places, squares[:, 0] > LEAST_PLANE_SINE**2 * squares[:, 2]
