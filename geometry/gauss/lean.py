"""How far node axes lean from the normals of the mesh."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, angles_between
from geometry.errors import MeshError
from geometry.functionals import extrapolated_normals
from geometry.mesh import MeshLike, as_mesh

__all__ = ["axis_lean"]


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
