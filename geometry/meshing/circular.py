"""Circular meshes: planar faces with circumcircles, hence vertex offsets [Pottmann2007, Prop. 2]."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.functionals import CircularFaces
from geometry.mesh import Combinatorics, MeshLike, as_mesh
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.result_checks import Requirement
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["make_circular"]


def make_circular(mesh: MeshLike, guides: Guides = Guides(), effort: Effort = Effort()) -> OptimisedMesh:
    """Move vertices so that each face is planar and has a circumcircle, to the tolerance in mean edge lengths.

    Both constraints are solved together, as `planarise` solves the first one. Moves are small where edges follow the
    principal curvature lines of the shape, as the edges of circular meshes do. Elsewhere edges would have to turn far
    or collapse, which is refused.

    Raises as `planarise` does, and ConvergenceError where the corners of a face are not on a circle.

    >>> from geometry.mesh import shapes
    >>> tube = shapes.rotational_mesh([(4, 0), (5, 1), (5, 2)], 12)
    >>> bent = tube.with_vertices(tube.vertices + 0.01 * tube.vertices[:, [1, 2, 0]] ** 2)
    >>> result = make_circular(bent)
    >>> result.residual_before > 1e-3, result.residual_after < 1e-12, result.plane_deviation_after < 1e-12
    (True, True, True)
    """
    mesh = as_mesh(mesh)
    c = mesh.combinatorics
    requirement = Requirement(
        "making the mesh circular",
        "lay the mesh along principal curvature lines",
        anchored_steps=8,
        functional=CircularFaces(c),
        elements=_faces_of_residuals(c),
        noun="face",
        violation="is still off a circle",
        unit="of the mean edge length",
    )
    return optimised(mesh, requirement, guides, effort)


def _faces_of_residuals(combinatorics: Combinatorics) -> IntArray:
    """(m,) the face that each residual of `CircularFaces` belongs to."""
    parts = [np.repeat(faces, corners.shape[1] - 3) for faces, corners in combinatorics.faces_by_size()]
    return integers(np.concatenate(parts))
