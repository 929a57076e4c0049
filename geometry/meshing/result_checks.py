"""Checks of an optimised mesh: planar, circular or conical, on its curves, convex, not folded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.errors import FoldedError, raise_worst
from geometry.functionals import ConvexFaces, OnCurve, relative_plane_deviations
from geometry.mesh import Mesh
from geometry.mesh.coordinate_rounding import far_from_zero_cure
from geometry.meshing.vertex_guides import MeshGuides, in_edge_lengths
from geometry.optimise import ConvergenceError, Functional, Reason, Solution, max_norm

__all__ = ["LEAST_CONVEX_TURN", "Requirement", "check_fixed_faces", "check_free_vertices", "check_result"]

COLLAPSED_LENGTH_RATIO = 0.05
"""Length of an edge afterwards over its length before, below which it counts as collapsed."""

LEAST_CONVEX_TURN = 0.01
"""Least turn of a corner that has to be convex, in mean edge lengths, see `ConvexFaces`: about 0.6 degrees between two
edges of mean length. A straight corner would be neither convex nor concave."""

ROUNDING_LIMITED_RATIO = 100.0
"""Largest violation, over the rounding of coordinates, that a message explains by this rounding."""


@dataclass(frozen=True, eq=False)
class Requirement:
    """The constraint on a mesh beside planar faces, if there is one, and the words of its messages.

    activity: the words after "while" in messages, such as "planarising". advice: the cure where the constraint is not
    met. anchored_steps: their number where `Effort` does not set it. functional: its residuals (m,) belong to
    `elements` (m,), which are faces or vertices, as `noun` says. violation, unit: how messages describe a residual.
    """

    activity: str
    advice: str
    anchored_steps: int
    functional: Functional | None = None
    elements: IntArray | None = None
    noun: str = ""
    violation: str = ""
    unit: str = ""

    def deviations(self, mesh: Mesh) -> FloatArray:
        """(F,) or (N,) norm of the residuals of each element; empty where there is no functional."""
        if self.functional is None or self.elements is None:
            return np.zeros(0)
        residual = self.functional.residual(in_edge_lengths(mesh).ravel())
        return np.sqrt(np.bincount(self.elements, residual**2))


def check_fixed_faces(mesh: Mesh, guides: MeshGuides, tolerance: float) -> None:
    """Raise ConvergenceError, before any step, for a face that is not planar and all of whose vertices are fixed."""
    c = mesh.combinatorics
    is_fixed = np.logical_and.reduceat(guides.is_fixed[c.corners], c.face_starts[:-1])
    deviations = np.where(is_fixed, relative_plane_deviations(mesh), 0.0)
    raise_worst(
        deviations,
        "<=",
        tolerance,
        lambda face, value: (
            f"face {face} is off its plane by {value:.1e} of the mean edge length, allowed {tolerance:.0e}, and all "
            "its vertices are fixed, or ends, corners or crossings of curves: free one of them"
        ),
        error=ConvergenceError,
        solution=Solution(in_edge_lengths(mesh).ravel(), np.zeros(0), max_norm(deviations), 0, Reason.INFEASIBLE),
    )


def check_free_vertices(mesh: Mesh, requirement: Requirement, guides: MeshGuides) -> None:
    """Raise ConvergenceError, before any step, where all vertices are fixed."""
    if not guides.is_free(mesh).any():
        raise ConvergenceError(
            "the mesh does not meet the requirements and cannot change, since all its vertices are fixed, or ends, "
            f"corners or crossings of curves: free some of them before {requirement.activity}",
            solution=Solution(in_edge_lengths(mesh).ravel(), np.zeros(0), np.inf, 0, Reason.INFEASIBLE),
            value=0.0,
            bound=1.0,
        )


def check_result(
    before: Mesh, after: Mesh, requirement: Requirement, guides: MeshGuides, solution: Solution, tolerance: float
) -> None:
    """Raise ConvergenceError where a face is not planar or not convex, the requirement is not met or a vertex is off
    its curve, and FoldedError where an edge or face folded over.
    """
    if solution.reason is Reason.CONVERGED:  # first, since other measures of collapsed faces are meaningless
        _check_not_folded(before, after, requirement)
    if solution.reason is Reason.INFEASIBLE:  # equations and inequalities contradict each other
        _check_convex(after, requirement, guides, solution, tolerance)
    _check_planar(after, requirement, solution, tolerance)
    _check_requirement(after, requirement, solution, tolerance)
    _check_on_curves(after, requirement, guides, solution, tolerance)
    _check_convex(after, requirement, guides, solution, tolerance)
    _check_not_folded(before, after, requirement)


def _ending(after: Mesh, requirement: Requirement, solution: Solution, value: float) -> str:
    """The end of a message: why a residual of this value remains, and the cure."""
    rounding = float(np.spacing(np.abs(after.vertices).max())) / after.mean_edge_length
    if solution.reason is Reason.CONVERGED or solution.violation <= ROUNDING_LIMITED_RATIO * rounding:
        cure = far_from_zero_cure(after, value)
        coarse = f"because coordinates are rounded to {rounding:.0e} mean edge lengths; allow more"
        return f"because {cure}, or allow more" if cure else coarse
    return f"after {solution.steps} steps: {solution.reason.value}; {requirement.advice}"


def _check_planar(after: Mesh, requirement: Requirement, solution: Solution, tolerance: float) -> None:
    raise_worst(
        relative_plane_deviations(after),
        "<=",
        tolerance,
        lambda face, value: (
            f"face {face} is still off its plane by {value:.1e} of the mean edge length, allowed {tolerance:.0e}, "
            f"{_ending(after, requirement, solution, value)}"
        ),
        error=ConvergenceError,
        solution=solution,
    )


def _check_requirement(after: Mesh, requirement: Requirement, solution: Solution, tolerance: float) -> None:
    raise_worst(
        requirement.deviations(after),
        "<=",
        tolerance,
        lambda element, value: (
            f"{requirement.noun} {element} {requirement.violation} by {value:.1e} {requirement.unit}, allowed "
            f"{tolerance:.0e}, {_ending(after, requirement, solution, value)}"
        ),
        error=ConvergenceError,
        solution=solution,
    )


def _check_on_curves(
    after: Mesh, requirement: Requirement, guides: MeshGuides, solution: Solution, tolerance: float
) -> None:
    for curve, vertices in guides.curves:
        residual = OnCurve(curve, vertices, after.n_vertices).residual(solution.x).reshape(-1, 2)
        raise_worst(
            np.linalg.norm(residual, axis=1),
            "<=",
            tolerance,
            lambda vertex, value: (
                f"vertex {vertex} is still off its curve by {value:.1e} of the mean edge length, allowed "
                f"{tolerance:.0e}, {_ending(after, requirement, solution, value)}"
            ),
            elements=vertices,
            error=ConvergenceError,
            solution=solution,
        )


def _check_convex(
    after: Mesh, requirement: Requirement, guides: MeshGuides, solution: Solution, tolerance: float
) -> None:
    turns = ConvexFaces(after.combinatorics, guides.convex).residual(solution.x)
    if turns.min(initial=np.inf) >= LEAST_CONVEX_TURN - tolerance:
        return
    raise_worst(
        turns,
        ">=",
        LEAST_CONVEX_TURN,
        lambda face, value: (
            f"face {face} is not convex: a corner turns by {value:.2g} (of the mean edge length), at least "
            f"{LEAST_CONVEX_TURN} is required, {_ending(after, requirement, solution, LEAST_CONVEX_TURN - value)}, or "
            "ask for fewer convex faces"
        ),
        elements=np.repeat(guides.convex, after.combinatorics.face_sizes[guides.convex]),
        error=ConvergenceError,
        solution=solution,
    )


def _check_not_folded(before: Mesh, after: Mesh, requirement: Requirement) -> None:
    raise_worst(
        np.einsum("fi,fi->f", before.face_normals, after.face_normals),
        ">",
        0.0,
        lambda face, cosine: (
            f"face {face} folded over while {requirement.activity}: its normal turned by "
            f"{np.degrees(np.arccos(max(-1.0, cosine))):.0f} degrees, allowed 90"
        ),
        error=FoldedError,
        advice=requirement.advice,
    )
    raise_worst(
        np.einsum("ei,ei->e", before.edge_vectors, after.edge_vectors) / before.edge_lengths**2,
        ">=",
        COLLAPSED_LENGTH_RATIO,
        lambda edge, share: (
            f"{before.combinatorics.edge_name(edge)} folded over while {requirement.activity}: along its old "
            f"direction it has {share:.2g} times its old length, at least {COLLAPSED_LENGTH_RATIO} is allowed"
        ),
        error=FoldedError,
        advice=requirement.advice,
    )
