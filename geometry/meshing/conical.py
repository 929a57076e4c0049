"""Conical meshes: planar faces tangent to a cone about each vertex, hence face offsets [Pottmann2007, Prop. 2]."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.functionals import ConicalVertices, closed_fans
from geometry.mesh import Combinatorics, MeshLike, as_mesh
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.result_checks import Aim
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["make_conical"]


def make_conical(mesh: MeshLike, guides: Guides = Guides(), effort: Effort = Effort()) -> OptimisedMesh:
    """Move vertices so that each face is planar and the faces at each interior vertex are tangent to a cone.

    Planar to the tolerance in mean edge lengths, conical to the tolerance in radians. Both are asked at once, in the
    way of `planarise`. That takes small moves where edges follow the principal curvature lines of the shape, as those
    of conical meshes do [LiuPottmann2006]; elsewhere edges would have to turn far, or collapse, which is refused.

    Raises as `planarise` does, and ConvergenceError where faces are not tangent to cones.
    """
    mesh = as_mesh(mesh)
    c = mesh.combinatorics
    aim = Aim(
        "making the mesh conical",
        "lay the mesh along principal curvature lines",
        anchored_steps=8,
        functional=ConicalVertices(c),
        elements=_vertices_of_residuals(c),
        noun="vertex",
        lacks="is not conical",
        unit="radians",
    )
    return optimised(mesh, aim, guides, effort)


def _vertices_of_residuals(combinatorics: Combinatorics) -> IntArray:
    """(m,) the vertex of each residual of `ConicalVertices`."""
    fans = [fan for fan in closed_fans(combinatorics) if fan.shape[1] > 3]
    parts = [np.repeat(combinatorics.corners[fan[:, 0]], fan.shape[1] - 3) for fan in fans]
    return integers(np.concatenate([np.zeros(0), *parts]))
