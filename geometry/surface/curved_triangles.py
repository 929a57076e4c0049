"""Points of a smooth surface through the vertices of triangles: curved point-normal triangles."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh

__all__ = ["on_curved_triangles"]


def on_curved_triangles(mesh: Mesh, normals: FloatArray, triangles: IntArray, weights: FloatArray) -> FloatArray:
    """(n, 3) points at barycentric coordinates (n, 3) in triangles (n,) of a mesh with unit normals (N, 3).

    The cubic triangles of [Vlachos2001]: continuous across edges, and within k h^4 of a smooth surface where a flat
    triangle is k h^2 / 8 off.
    """
    corners = mesh.combinatorics.corners.reshape(-1, 3)[triangles]
    p, n = mesh.vertices[corners], normals[corners]
    w = weights[:, :, None]
    following = np.roll(p, -1, axis=1)
    across = following - p  # from corner k to k + 1
    ahead = np.einsum("nki,nki->nk", across, n)[:, :, None] * n
    back = np.einsum("nki,nki->nk", across, np.roll(n, -1, axis=1))[:, :, None] * np.roll(n, -1, axis=1)
    near = (2 * p + following - ahead) / 3
    far = (2 * following + p + back) / 3
    middle = (near.sum(axis=1) + far.sum(axis=1)) / 4 - p.sum(axis=1) / 6
    w_next = np.roll(w, -1, axis=1)
    edges = 3 * (w**2 * w_next * near + w * w_next**2 * far)
    return np.asarray((w**3 * p + edges).sum(axis=1) + 6 * w.prod(axis=1) * middle)
