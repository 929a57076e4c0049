"""Whether a mesh came out as it was asked for; if not, what is said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.errors import FoldedError, raise_worst
from geometry.functionals import ConvexFaces, OnCurve, relative_plane_deviations
from geometry.mesh import Mesh
from geometry.mesh.place import cure_of_place
from geometry.meshing.vertex_guides import MeshGuides, in_edge_lengths
from geometry.optimise import ConvergenceError, Functional, Reason, Solution, max_norm

__all__ = ["LEAST_CONVEX_TURN", "Aim", "check_fixed_faces", "check_outcome"]

COLLAPSED_LENGTH_RATIO = 0.05
"""Length of an edge afterwards over its length before, below which it counts as collapsed."""

LEAST_CONVEX_TURN = 0.01
"""Least turn of a corner that has to be convex, in mean edge lengths, see `ConvexFaces`: about 0.6 degrees between two
edges of mean length. A straight corner would be neither convex nor concave."""

ROUNDING_LIMITED_RATIO = 100.0
"""What is left, over the rounding of coordinates, up to which that is what is in the way."""


@dataclass(frozen=True, eq=False)
class Aim:
    """What is asked of a mesh beside planar faces, if anything, and how that is said.

    task: what is being done. functional: its residuals belong to the elements (m,), faces or vertices as `noun` says;
    `lacks` and `unit` say by what words and in what they are off. advice: what to do where that is not reached.
    anchored_steps: those of an `Effort` that leaves them open.
    """

    task: str
    advice: str
    anchored_steps: int
    functional: Functional | None = None
    elements: IntArray | None = None
    noun: str = ""
    lacks: str = ""
    unit: str = ""

    def deviations(self, mesh: Mesh) -> FloatArray:
        """(F,) or (N,) norms of the residuals of each element; none where nothing is asked."""
        if self.functional is None or self.elements is None:
            return np.zeros(0)
        residual = self.functional.residual(in_edge_lengths(mesh).ravel())
        return np.sqrt(np.bincount(self.elements, residual**2))


def check_fixed_faces(mesh: Mesh, guides: MeshGuides, tolerance: float) -> None:
    """Raise ConvergenceError, before anything is done, for a face that is not planar and cannot move."""
    c = mesh.combinatorics
    is_fixed = np.logical_and.reduceat(guides.is_fixed[c.corners], c.face_starts[:-1])
    deviations = np.where(is_fixed, relative_plane_deviations(mesh), 0.0)
    raise_worst(
        deviations,
        "<=",
        tolerance,
        lambda face, value: (
            f"face {face} leaves its plane by {value:.1e} of the mean edge length, allowed {tolerance:.0e}, and all "
            "its vertices are fixed, or ends, corners or crossings of curves: free one of them"
        ),
        error=ConvergenceError,
        solution=Solution(in_edge_lengths(mesh).ravel(), np.zeros(0), max_norm(deviations), 0, Reason.INFEASIBLE),
    )


def check_outcome(
    before: Mesh, after: Mesh, aim: Aim, guides: MeshGuides, solution: Solution, tolerance: float
) -> None:
    """Raise ConvergenceError where faces are not planar or convex, the aim is missed or a vertex is off its curve, and
    FoldedError where something folded over.
    """
    if solution.reason is Reason.CONVERGED:  # before anything is measured of faces without a shape
        _check_not_folded(before, after, aim)
    if solution.reason is Reason.INFEASIBLE:  # that is said of equations and inequalities together
        _check_convex(after, aim, guides, solution, tolerance)
    _check_planar(after, aim, solution, tolerance)
    _check_aim(after, aim, solution, tolerance)
    _check_on_curves(after, aim, guides, solution, tolerance)
    _check_convex(after, aim, guides, solution, tolerance)
    _check_not_folded(before, after, aim)


def _ending(after: Mesh, aim: Aim, solution: Solution, value: float) -> str:
    """Why something is off by a value, and what to do."""
    rounding = float(np.spacing(np.abs(after.vertices).max())) / after.mean_edge_length
    if solution.reason is Reason.CONVERGED or solution.violation <= ROUNDING_LIMITED_RATIO * rounding:
        cure = cure_of_place(after, value)
        coarse = f"because coordinates are rounded to {rounding:.0e} mean edge lengths; allow more"
        return f"because {cure}, or allow more" if cure else coarse
    return f"after {solution.steps} steps: {solution.reason.value}; {aim.advice}"


def _check_planar(after: Mesh, aim: Aim, solution: Solution, tolerance: float) -> None:
    raise_worst(
        relative_plane_deviations(after),
        "<=",
        tolerance,
        lambda face, value: (
            f"face {face} still leaves its plane by {value:.1e} of the mean edge length, allowed {tolerance:.0e}, "
            f"{_ending(after, aim, solution, value)}"
        ),
        error=ConvergenceError,
        solution=solution,
    )


def _check_aim(after: Mesh, aim: Aim, solution: Solution, tolerance: float) -> None:
    raise_worst(
        aim.deviations(after),
        "<=",
        tolerance,
        lambda element, value: (
            f"{aim.noun} {element} still {aim.lacks} by {value:.1e} {aim.unit}, allowed {tolerance:.0e}, "
            f"{_ending(after, aim, solution, value)}"
        ),
        error=ConvergenceError,
        solution=solution,
    )


def _check_on_curves(after: Mesh, aim: Aim, guides: MeshGuides, solution: Solution, tolerance: float) -> None:
    for curve, vertices in guides.curves:
        residual = OnCurve(curve, vertices, after.n_vertices).residual(solution.x).reshape(-1, 2)
        raise_worst(
            np.linalg.norm(residual, axis=1),
            "<=",
            tolerance,
            lambda vertex, value: (
                f"vertex {vertex} still is off its curve by {value:.1e} of the mean edge length, allowed "
                f"{tolerance:.0e}, {_ending(after, aim, solution, value)}"
            ),
            elements=vertices,
            error=ConvergenceError,
            solution=solution,
        )


def _check_convex(after: Mesh, aim: Aim, guides: MeshGuides, solution: Solution, tolerance: float) -> None:
    turns = ConvexFaces(after.combinatorics, guides.convex).residual(solution.x)
    if turns.min(initial=np.inf) >= LEAST_CONVEX_TURN - tolerance:
        return
    raise_worst(
        turns,
        ">=",
        LEAST_CONVEX_TURN,
        lambda face, value: (
            f"face {face} is not convex: a corner turns by {value:.2g} (of the mean edge length), at least "
            f"{LEAST_CONVEX_TURN} is asked, {_ending(after, aim, solution, LEAST_CONVEX_TURN - value)}, or ask for "
            "fewer convex faces"
        ),
        elements=np.repeat(guides.convex, after.combinatorics.face_sizes[guides.convex]),
        error=ConvergenceError,
        solution=solution,
    )


def _check_not_folded(before: Mesh, after: Mesh, aim: Aim) -> None:
    raise_worst(
        np.einsum("fi,fi->f", before.face_normals, after.face_normals),
        ">",
        0.0,
        lambda face, cosine: (
            f"face {face} folded over while {aim.task}: its normal turned by "
            f"{np.degrees(np.arccos(max(-1.0, cosine))):.0f} degrees, allowed 90"
        ),
        error=FoldedError,
        advice=aim.advice,
    )
    raise_worst(
        np.einsum("ei,ei->e", before.edge_vectors, after.edge_vectors) / before.edge_lengths**2,
        ">=",
        COLLAPSED_LENGTH_RATIO,
        lambda edge, share: (
            f"{before.combinatorics.edge_name(edge)} folded over while {aim.task}: along its old direction it has "
            f"{share:.2g} times its old length, at least {COLLAPSED_LENGTH_RATIO} is allowed"
        ),
        error=FoldedError,
        advice=aim.advice,
    )
