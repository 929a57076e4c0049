"""How far node axes lean from the normals of the mesh."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.functionals import extrapolated_normals
from geometry.gauss.edge_cones import angles_between
from geometry.mesh import Mesh

__all__ = ["axis_lean"]


def axis_lean(mesh: Mesh, gauss_image: Mesh) -> FloatArray:
    """(N,) angle in radians between the node axis s_i and the estimated normal of M at m_i, from 0 to pi.

    Zero torsion says nothing of it: on meshes laid askew of the principal directions axes lean far. Large angles make
    long node blocks and slanted cuts. At the boundary there are two estimates, the mean of the faces and
    `extrapolated_normals`; the smaller angle counts, since neither is sure on a rough rim. NaN for vertices that belong
    to no face, and where s_i is zero.

    Raises MeshError where the two meshes do not have the same faces.
    """
    if not mesh.combinatorics.same_as(gauss_image.combinatorics):
        raise MeshError("the Gauss image does not have the faces of the mesh, so its vertices are no axes of it")
    s = gauss_image.vertices
    leans = np.minimum(angles_between(s, mesh.vertex_normals), angles_between(s, extrapolated_normals(mesh)))
    meant = mesh.combinatorics.is_used & s.any(axis=1)
    return np.where(meant, leans, np.nan)
