"""Cut faces out of a mesh."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray
from geometry.mesh import Combinatorics, Mesh

__all__ = ["inner_faces", "part"]


def part(mesh: Mesh, faces: IntArray) -> Mesh:
    """A mesh of some of the faces (n,), given in their order, with their vertices only."""
    c = mesh.combinatorics
    used, corners = np.unique(c.corners[np.isin(c.corner_face, faces)], return_inverse=True)
    starts = np.concatenate([[0], np.cumsum(c.face_sizes[faces])])
    return Mesh(mesh.vertices[used], Combinatorics(len(used), corners, starts))


def inner_faces(mesh: Mesh) -> IntArray:
    """The faces that have no vertex on the boundary."""
    c = mesh.combinatorics
    return np.setdiff1d(np.arange(c.n_faces), c.corner_face[c.is_boundary_vertex[c.corners]])
