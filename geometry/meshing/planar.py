"""Make the faces of a mesh planar by small moves of its vertices."""

from __future__ import annotations

from geometry.mesh import MeshLike, as_mesh
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.result_checks import Aim
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["planarise"]


def planarise(mesh: MeshLike, guides: Guides = Guides(), effort: Effort = Effort()) -> OptimisedMesh:
    """Move vertices so that no corner is further than the tolerance from its face's plane, in mean edge lengths.

    Constrained Newton steps of least |moves|^2 + fairness * strain. Faces have any number of corners; a mesh that is as
    asked comes back as the same object. After some steps the pull back to the given vertices is dropped, see `Effort`.
    So the result is planar to the tolerance and near to the given mesh, but not the nearest of all planar meshes; and
    where none is near, as along asymptotic lines, it is another shape. The `moves` of the result tell.

    Raises MeshError for an edge without length; GeometryError for a vertex, face, path or number that cannot be
    meant; ConvergenceError where faces do not become planar, or convex; and FoldedError where an edge or face
    folded over on the way.
    """
    mesh = as_mesh(mesh)
    aim = Aim("planarising", "lay the mesh along conjugate directions", anchored_steps=16)
    return optimised(mesh, aim, guides, effort)
