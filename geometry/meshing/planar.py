"""Make the faces of a mesh planar by small moves of its vertices."""

from __future__ import annotations

from collections.abc import Sequence

from geometry.mesh import Mesh
from geometry.meshing.guides import Faces, Guides, Indices
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.outcome_checks import Aim
from geometry.surface import Surface

__all__ = ["planarise"]


def planarise(
    mesh: Mesh,
    *,
    tolerance: float = 1e-12,
    fairness: float = 0.3,
    surface: Surface | None = None,
    fixed: Indices = (),
    curves: Sequence[Indices] = (),
    keep_boundary: bool = False,
    convex: Faces = (),
    held_steps: int = 16,
    max_steps: int = 50,
) -> OptimisedMesh:
    """Move vertices so that no corner is further than `tolerance` l from its face's plane; l: mean edge length.

    Constrained Newton steps of least |moves|^2 + fairness * strain; see `functionals.fairness.strain`. Faces
    have any number of corners; a mesh that is as asked comes back as the same object. Less fairness (0.01) stays closer
    to the given vertices in the mean, and turns and shortens edges more; with more of it, edges collapse less easily.
    After `held_steps` the pull back to the given vertices is dropped: it is in the way of quadratic convergence. So the
    result is planar to the tolerance and near to the given mesh, but not the nearest of all planar meshes; and where
    none is near, as along asymptotic lines, it is another shape. The `moves` of the result tell.

    surface: vertices glide on it: squared distances from it count 10 times as much as squared moves. How far
      vertices end up from it is part of the result.
    fixed: vertices that stay, to the last bit.
    curves: paths of vertices along edges, closed where the first vertex is the last one too. Their vertices
      slide on the spline through them, see `Curve.through`; ends, corners and crossings stay.
    keep_boundary: the same for all boundary loops.
    convex: faces whose corners are to turn to one side, each by `outcome.LEAST_TURN` l or more; or "all".

    Raises MeshError for an edge without length; GeometryError for a vertex, face, path or number that cannot be
    meant; ConvergenceError where faces do not become planar, or convex; and FoldedError where an edge or face
    folded over on the way.
    """
    aim = Aim("planarising", "lay the mesh along conjugate directions")
    guides = Guides.of(mesh, surface, fixed, curves, keep_boundary, convex)
    return optimised(
        mesh, aim, guides, tolerance=tolerance, fairness=fairness, held_steps=held_steps, max_steps=max_steps
    )
