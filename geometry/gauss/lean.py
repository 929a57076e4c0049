"""How far node axes lean from the normals of the mesh."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, angles_between
from geometry.errors import MeshError
from geometry.functionals import extrapolated_normals
from geometry.mesh import Mesh, MeshLike, as_mesh

__all__ = ["axis_lean", "closed_mesh_advice"]

SCALED_AND_MOVED = 4
"""Dimension of P(M) where it contains nothing but scaled and moved copies of M."""


def axis_lean(mesh: MeshLike, axes: FloatArray) -> FloatArray:
    """(N,) angle in radians between node axes (N, 3), such as the s_i, and the estimated normals of M, from 0 to pi.

    Axes may lean far although beams are free of torsion, as on meshes that do not follow the principal directions.
    Large angles cause long node blocks and slanted cuts. At the boundary there are two estimates, the mean of the faces
    and `extrapolated_normals`; the smaller angle counts, since neither is reliable at an irregular boundary. NaN for
    vertices that belong to no face, and where the axis is zero. The lengths of axes do not matter; those of a pair are
    `Pair.leans`.

    Raises MeshError where there is not one axis for each vertex.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import grid
    >>> flat = grid(2, 2)
    >>> np.degrees(axis_lean(flat, np.full((9, 3), [1.0, 0.0, 1.0]))).round(6).max().item()
    45.0
    """
    mesh = as_mesh(mesh)
    if axes.shape != mesh.vertices.shape:
        raise MeshError(f"axes have shape {axes.shape}, one vector a vertex is needed: {mesh.vertices.shape}")
    leans = np.minimum(angles_between(axes, mesh.vertex_normals), angles_between(axes, extrapolated_normals(mesh)))
    is_defined = mesh.combinatorics.is_used & axes.any(axis=1)
    return np.where(is_defined, leans, np.nan)


def closed_mesh_advice(mesh: Mesh) -> str:
    """What to do about axes that lean far because the mesh is closed; empty for a mesh with a boundary.

    A closed mesh of planar quads has few parallel meshes: E - 2F + 3 chi is 6 for a sphere and 0 for a torus, whatever
    the number of faces, so that none of them is near the unit sphere. Every boundary edge adds one.

    >>> from geometry.gauss import closed_mesh_advice
    >>> from geometry.mesh import shapes
    >>> closed_mesh_advice(shapes.grid(2, 2)), closed_mesh_advice(shapes.box(1, 2, 3))[:18]
    ('', 'the mesh is closed')
    """
    c = mesh.combinatorics
    if c.is_boundary_edge.any():
        return ""
    dimension = max(SCALED_AND_MOVED, c.n_edges - 2 * c.n_faces + 3 * c.euler_characteristic)
    return (
        f"the mesh is closed and has hardly any parallel meshes (about {dimension} dimensions, {SCALED_AND_MOVED} of "
        "which scale and move it): leave a strip of the surface out, or optimise the mesh together with its Gauss "
        "image (--optimise heights,axes)"
    )
