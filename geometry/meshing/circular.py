"""Circular meshes: planar faces with circumcircles, hence vertex offsets [Pottmann2007, Prop. 2]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.functionals import Circularity
from geometry.mesh import Combinatorics, Mesh
from geometry.meshing.guides import Faces, Guides, Indices
from geometry.meshing.optimised import OptimisedMesh, optimised
from geometry.meshing.outcome_checks import Aim
from geometry.surface import Surface

__all__ = ["make_circular"]


def make_circular(
    mesh: Mesh,
    *,
    tolerance: float = 1e-12,
    fairness: float = 0.3,
    surface: Surface | None = None,
    fixed: Indices = (),
    curves: Sequence[Indices] = (),
    keep_boundary: bool = False,
    convex: Faces = (),
    held_steps: int = 8,
    max_steps: int = 50,
) -> OptimisedMesh:
    """Move vertices so that each face is planar and its corners are on a circle, to `tolerance` l.

    Both are asked at once, in the way of `planarise`, where all arguments are explained. That takes small moves where
    edges follow the principal curvature lines of the shape, as those of circular meshes do; elsewhere edges would
    have to turn far, or collapse, which is refused.

    Raises as `planarise` does, and ConvergenceError where corners are not on circles.
    """
    c = mesh.combinatorics
    aim = Aim(
        "making the mesh circular",
        "lay the mesh along principal curvature lines",
        Circularity(c),
        _faces_of_residuals(c),
        "face",
        "is off a circle",
        "of the mean edge length",
    )
    guides = Guides.of(mesh, surface, fixed, curves, keep_boundary, convex)
    return optimised(
        mesh, aim, guides, tolerance=tolerance, fairness=fairness, held_steps=held_steps, max_steps=max_steps
    )


def _faces_of_residuals(combinatorics: Combinatorics) -> IntArray:
    """(m,) the face of each residual of `Circularity`."""
    parts = [np.repeat(faces, corners.shape[1] - 3) for faces, corners in combinatorics.faces_by_size()]
    return integers(np.concatenate(parts))
