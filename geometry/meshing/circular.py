"""Circular meshes: planar faces with circumcircles, hence vertex offsets [Pottmann2007, Prop. 2]."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.functionals import CircularFaces
from geometry.mesh import Combinatorics, MeshLike, as_mesh
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.result_checks import Aim
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["make_circular"]


def make_circular(mesh: MeshLike, guides: Guides = Guides(), effort: Effort = Effort()) -> OptimisedMesh:
    """Move vertices so that each face is planar and its corners are on a circle, to the tolerance in mean edge lengths.

    Both are asked at once, in the way of `planarise`. That takes small moves where edges follow the principal
    curvature lines of the shape, as those of circular meshes do; elsewhere edges would have to turn far, or collapse,
    which is refused.

    Raises as `planarise` does, and ConvergenceError where corners are not on circles.
    """
    mesh = as_mesh(mesh)
    c = mesh.combinatorics
    aim = Aim(
        "making the mesh circular",
        "lay the mesh along principal curvature lines",
        anchored_steps=8,
        functional=CircularFaces(c),
        elements=_faces_of_residuals(c),
        noun="face",
        lacks="is off a circle",
        unit="of the mean edge length",
    )
    return optimised(mesh, aim, guides, effort)


def _faces_of_residuals(combinatorics: Combinatorics) -> IntArray:
    """(m,) the face of each residual of `CircularFaces`."""
    parts = [np.repeat(faces, corners.shape[1] - 3) for faces, corners in combinatorics.faces_by_size()]
    return integers(np.concatenate(parts))
