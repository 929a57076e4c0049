"""Make the faces of a mesh planar by small moves of its vertices."""

from __future__ import annotations

from geometry.mesh import MeshLike, as_mesh
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.result_checks import Requirement
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["planarise"]


def planarise(mesh: MeshLike, guides: Guides = Guides(), effort: Effort = Effort()) -> OptimisedMesh:
    """Move vertices so that no corner is off the plane of its face by more than the tolerance, in mean edge lengths.

    Constrained Newton steps minimise |moves|^2 + fairness * strain. Faces have any number of corners. A mesh that
    meets all requirements is returned as the same object. After the anchored steps the distance from the given
    vertices is no longer minimised, see `Effort`. So the result is planar to the tolerance and near to the given mesh,
    but not the nearest of all planar meshes. Where no planar mesh is near, as along asymptotic lines, the result has
    another shape; `moves` of the result show that.

    Raises MeshError for an edge without length; GeometryError for an invalid vertex, face, path or number;
    ConvergenceError where a face does not become planar or convex; and FoldedError where an edge or face folds over.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(6, 6)
    >>> shell = grid.with_vertices([(x, y, -0.05 * (x * x + x * y / 4 + y * y)) for x, y, _ in grid.vertices])
    >>> result = planarise(shell)
    >>> round(result.plane_deviation_before, 4), result.plane_deviation_after < 1e-12, result.largest_move < 0.1
    (0.0029, True, True)
    """
    mesh = as_mesh(mesh)
    requirement = Requirement("planarising", "lay the mesh along conjugate directions", anchored_steps=16)
    return optimised(mesh, requirement, guides, effort)
