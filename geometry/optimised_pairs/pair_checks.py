"""Checks of a pair before and after it is optimised, with errors that name value, bound and cure."""

from __future__ import annotations

import numpy as np

from geometry.errors import FoldedError, GeometryError, raise_worst
from geometry.gauss import Pair, refuse_triangle_mesh
from geometry.mesh import Mesh
from geometry.optimise import ConvergenceError, Reason, Solution
from geometry.optimised_pairs.pair_measures import PairMeasures, faces_off_the_rim, independent_curvatures
from geometry.optimised_pairs.pair_objective import LARGEST_UPRIGHT_LEAN, Objective
from geometry.optimised_pairs.pair_targets import PairTargets
from geometry.surface import Surface

__all__ = ["check_given", "check_outcome", "check_solution"]

LARGEST_SURFACE_DISTANCE = 1.0
"""Distance from Phi in mean edge lengths, which at most 5 % of the vertices may exceed at the start."""

COLLAPSED_EDGE_SHARE = 0.2
"""Length of an edge afterwards over its length before, below which it counts as collapsed."""

LARGEST_CURVED_LEAN = np.radians(5.0)
"""Lean in radians which at most 5 % of the axes may exceed where a curvature is required: with axes that lean, M has
another curvature."""

INDEPENDENT_CURVATURE_TOLERANCE = 0.05
"""Deviation of a curvature with respect to a Gauss image of M alone, over its size, that is allowed, as in the
paper."""

UNCHECKED_RIM_ROWS = 2
"""Rows of faces at the boundary whose curvature is not checked: there a Gauss image of M alone is less reliable."""


def _advice(targets: PairTargets) -> str:
    """The cure where no pair meets the targets."""
    cure = (
        "ask for a larger height_error"
        if targets.heights
        else "ask for edges, vertices or faces, which need not be exact"
    )
    cure = (
        "start nearer to such a mesh, or free the boundary (keep_boundary=False, nothing fixed)"
        if targets.curved
        else cure
    )
    return f"{cure}, or lay the mesh along principal directions"


def check_given(pair: Pair, surface: Surface | None) -> None:
    """Raise GeometryError for what cannot be optimised."""
    mesh, image = pair.mesh, pair.gauss_image
    refuse_triangle_mesh(mesh)
    used = mesh.combinatorics.is_used
    normals = mesh.vertex_normals[used]
    if surface is not None:
        points = mesh.vertices[used]
        feet, normals = surface.closest(points)
        distance = float(np.quantile(np.linalg.norm(points - feet, axis=1), 0.95)) / mesh.mean_edge_length
        if distance > LARGEST_SURFACE_DISTANCE:
            raise GeometryError(
                f"the mesh is not on the surface: 5 % of its vertices are {distance:.2g} mean edge lengths or more "
                f"off the surface, allowed {LARGEST_SURFACE_DISTANCE:g}; give both in the same unit and place, or "
                "leave the surface out",
                value=distance,
                bound=LARGEST_SURFACE_DISTANCE,
            )
        _check_side(normals, mesh.vertex_normals[used], "the surface is oriented opposite to the mesh: reverse it")
    _check_side(
        image.vertices[used],
        normals,
        "the Gauss image is oriented opposite to the mesh: take the pair of M and -S",
    )


def _check_side(vectors: np.ndarray, others: np.ndarray, message: str) -> None:
    share = float((np.einsum("ni,ni->n", vectors, others) > 0).mean())
    if share < 0.5:
        raise GeometryError(message, value=share, bound=0.5)


def check_solution(objective: Objective, solution: Solution, tolerance: float) -> None:
    """Raise FoldedError for an edge that collapsed or a face that turned over, and ConvergenceError where the
    constraints are not met."""
    mesh = objective.mesh
    if np.isfinite(solution.x).all():
        after = objective.mesh_at(solution.x)
        raise_worst(
            after.edge_lengths / mesh.edge_lengths,
            ">=",
            COLLAPSED_EDGE_SHARE,
            lambda edge, share: (
                f"{mesh.combinatorics.edge_name(edge)} collapsed to {share:.2g} of its length while the pair was "
                f"optimised, allowed {COLLAPSED_EDGE_SHARE}"
            ),
            error=FoldedError,
            advice=_advice(objective.targets),
        )
        raise_worst(
            np.einsum("fi,fi->f", mesh.face_normals, after.face_normals),
            ">",
            0.0,
            lambda face, cosine: (
                f"face {face} turned by {np.degrees(np.arccos(max(-1.0, cosine))):.0f} degrees while the pair was "
                "optimised, allowed 90"
            ),
            error=FoldedError,
            advice=_advice(objective.targets),
        )
    if solution.reason is not Reason.CONVERGED:
        raise ConvergenceError(
            "no pair near the given one meets the targets: parallelity, planarity and other constraints are off by "
            f"up to {solution.violation:.1e} after {solution.steps} Newton steps, allowed {tolerance:.0e}; "
            f"{_advice(objective.targets)}",
            solution=solution,
            value=solution.violation,
            bound=tolerance,
        )


def check_outcome(
    after: Mesh, targets: PairTargets, measures_before: PairMeasures, measures_after: PairMeasures
) -> None:
    """Raise GeometryError where axes lean too far, where requested distances spread more than before, or where the
    curvature is not that of M with respect to a Gauss image of M alone."""
    largest_lean = LARGEST_CURVED_LEAN if targets.curved else max(LARGEST_UPRIGHT_LEAN, measures_before.lean[1])
    if not measures_after.lean[1] <= largest_lean:
        raise GeometryError(
            f"the axes lean too far: 5 % of them by {np.degrees(measures_after.lean[1]):.1f} degrees or more, allowed "
            f"{np.degrees(largest_lean):.1f}; {_advice(targets)}",
            value=measures_after.lean[1],
            bound=largest_lean,
        )
    for kind in ("edge", "vertex", "face"):
        spread_before, spread_after = (
            getattr(measures, f"{kind}_spread") for measures in (measures_before, measures_after)
        )
        required = {"edge": targets.edges, "vertex": targets.vertices, "face": targets.faces}[kind]
        if required and not spread_after <= max(spread_before, targets.height_error):
            raise GeometryError(
                f"the {kind} distances spread by {spread_after:.2g} afterwards and by {spread_before:.2g} before, "
                f"which is no improvement; {_advice(targets)}",
                value=spread_after,
                bound=spread_before,
            )
    if targets.curved:
        _check_curvature(after, targets)


def _check_curvature(after: Mesh, targets: PairTargets) -> None:
    faces = faces_off_the_rim(after.combinatorics, UNCHECKED_RIM_ROWS)
    if not len(faces):
        return
    gaussian = targets.mean is None
    required, name = (targets.gaussian, "K") if gaussian else (targets.mean, "H")
    assert required is not None
    found, size = independent_curvatures(after, gaussian=gaussian)
    size = abs(required) or size or 1.0
    raise_worst(
        np.abs(found[faces] - required) / size,
        "<=",
        INDEPENDENT_CURVATURE_TOLERANCE,
        lambda face, off: (
            f"no mesh near the given one has {name} = {required:g}: only a tilted S has it; with respect to a "
            f"Gauss image of M alone face {face} has {found[face]:.3g}, off by {off:.2g} of the curvature, allowed "
            f"{INDEPENDENT_CURVATURE_TOLERANCE}; ask for a curvature nearer to that of the mesh, or free the boundary "
            "(keep_boundary=False, nothing fixed)"
        ),
        elements=faces,
    )
