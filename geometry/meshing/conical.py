"""Conical meshes: planar faces tangent to a cone about each vertex, hence face offsets [Pottmann2007, Prop. 2]."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.functionals import ConicalVertices, closed_fans
from geometry.mesh import Combinatorics, MeshLike, as_mesh
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.result_checks import Requirement
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["make_conical"]


def make_conical(mesh: MeshLike, guides: Guides = Guides(), effort: Effort = Effort()) -> OptimisedMesh:
    """Move vertices so that each face is planar and the faces at each interior vertex are tangent to a cone.

    Planar to the tolerance in mean edge lengths, conical to the tolerance in radians. Both constraints are solved
    together, as `planarise` solves the first one. Moves are small where edges follow the principal curvature lines of
    the shape, as the edges of conical meshes do [LiuPottmann2006]. Elsewhere edges would have to turn far or collapse,
    which is refused.

    Raises as `planarise` does, and ConvergenceError where the faces at a vertex are not tangent to a cone.

    >>> from geometry.mesh import shapes
    >>> tube = shapes.rotational_mesh([(4, 0), (5, 1), (5, 2)], 12)
    >>> bent = tube.with_vertices(tube.vertices + 0.01 * tube.vertices[:, [1, 2, 0]] ** 2)
    >>> result = make_conical(bent)
    >>> result.residual_before > 1e-3, result.residual_after < 1e-12, result.plane_deviation_after < 1e-12
    (True, True, True)
    """
    mesh = as_mesh(mesh)
    c = mesh.combinatorics
    requirement = Requirement(
        "making the mesh conical",
        "lay the mesh along principal curvature lines",
        anchored_steps=8,
        functional=ConicalVertices(c),
        elements=_vertices_of_residuals(c),
        noun="vertex",
        violation="is still not conical",
        unit="radians",
    )
    return optimised(mesh, requirement, guides, effort)


def _vertices_of_residuals(combinatorics: Combinatorics) -> IntArray:
    """(m,) the vertex that each residual of `ConicalVertices` belongs to."""
    fans = [fan for fan in closed_fans(combinatorics) if fan.shape[1] > 3]
    parts = [np.repeat(combinatorics.corners[fan[:, 0]], fan.shape[1] - 3) for fan in fans]
    return integers(np.concatenate([np.zeros(0), *parts]))
