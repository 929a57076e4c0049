"""Whether a mesh came out as it was asked for; if not, what is said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.errors import FoldedError
from geometry.functionals import Convexity, OnCurve, face_deviations
from geometry.mesh import Mesh
from geometry.mesh.place import cure_of_place
from geometry.meshing.guides import Guides, in_edge_lengths
from geometry.optimise import ConvergenceError, Functional, Reason, Solution

__all__ = ["LEAST_TURN", "Aim", "check_fixed_faces", "check_outcome"]

LEAST_LENGTH = 0.05
"""Length of an edge afterwards over its length before, below which it counts as collapsed."""

LEAST_TURN = 0.01
"""What is asked of a corner that is to be convex, in mean edge lengths, see `Convexity`: it turns by about 0.6 degrees
between edges of mean length. A corner that is straight could be either."""


ROUNDINGS = 100.0
"""What is left, over the rounding of coordinates, up to which that is what is in the way."""


@dataclass(frozen=True, eq=False)
class Aim:
    """What is asked of a mesh beside planar faces, if anything, and how that is said.

    task: what is being done. functional: its residuals belong to the elements (m,), faces or vertices as `noun` says;
    `lacks` and `unit` say by what words and in what they are off. advice: what to do where that is not reached.
    """

    task: str
    advice: str
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


def check_fixed_faces(mesh: Mesh, guides: Guides, tolerance: float) -> None:
    """Raise ConvergenceError, before anything is done, for a face that is not planar and cannot move."""
    c = mesh.combinatorics
    is_fixed = np.logical_and.reduceat(guides.is_fixed[c.corners], c.face_starts[:-1])
    deviations = np.where(is_fixed, face_deviations(mesh), 0.0)
    face = int(deviations.argmax())
    value = float(deviations[face])
    if value > tolerance:
        raise ConvergenceError(
            f"face {face} leaves its plane by {value:.1e} of the mean edge length, allowed {tolerance:.0e}, and all "
            "its vertices are fixed, or ends, corners or crossings of curves: free one of them",
            solution=Solution(in_edge_lengths(mesh).ravel(), np.zeros(0), value, 0, Reason.INFEASIBLE),
            elements=[face],
            value=value,
            bound=tolerance,
        )


def check_outcome(before: Mesh, after: Mesh, aim: Aim, guides: Guides, solution: Solution, tolerance: float) -> None:
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
    if solution.reason is Reason.CONVERGED or solution.violation <= ROUNDINGS * rounding:
        cure = cure_of_place(after, value)
        coarse = f"because coordinates are rounded to {rounding:.0e} mean edge lengths; allow more"
        return f"because {cure}, or allow more" if cure else coarse
    return f"after {solution.steps} steps: {solution.reason.value}; {aim.advice}"


def _check_planar(after: Mesh, aim: Aim, solution: Solution, tolerance: float) -> None:
    deviations = face_deviations(after)
    face = int(deviations.argmax())
    value = float(deviations[face])
    if value > tolerance:
        raise ConvergenceError(
            f"face {face} still leaves its plane by {value:.1e} of the mean edge length, allowed {tolerance:.0e}, "
            f"{_ending(after, aim, solution, value)}",
            solution=solution,
            elements=[face],
            value=value,
            bound=tolerance,
        )


def _check_aim(after: Mesh, aim: Aim, solution: Solution, tolerance: float) -> None:
    deviations = aim.deviations(after)
    value = float(deviations.max(initial=0.0))
    if value > tolerance:
        element = int(deviations.argmax())
        raise ConvergenceError(
            f"{aim.noun} {element} still {aim.lacks} by {value:.1e} {aim.unit}, allowed {tolerance:.0e}, "
            f"{_ending(after, aim, solution, value)}",
            solution=solution,
            elements=[element],
            value=value,
            bound=tolerance,
        )


def _check_on_curves(after: Mesh, aim: Aim, guides: Guides, solution: Solution, tolerance: float) -> None:
    for curve, vertices in guides.curves:
        residual = OnCurve(curve, vertices, after.n_vertices).residual(solution.x).reshape(-1, 2)
        distances = np.linalg.norm(residual, axis=1)
        value = float(distances.max(initial=0.0))
        if value > tolerance:
            vertex = int(vertices[distances.argmax()])
            raise ConvergenceError(
                f"vertex {vertex} still is off its curve by {value:.1e} of the mean edge length, allowed "
                f"{tolerance:.0e}, {_ending(after, aim, solution, value)}",
                solution=solution,
                elements=[vertex],
                value=value,
                bound=tolerance,
            )


def _check_convex(after: Mesh, aim: Aim, guides: Guides, solution: Solution, tolerance: float) -> None:
    if not len(guides.convex):
        return
    turns = Convexity(after.combinatorics, guides.convex).residual(solution.x)
    if turns.min() >= LEAST_TURN - tolerance:
        return
    worst = int(turns.argmin())
    face = int(np.repeat(guides.convex, after.combinatorics.face_sizes[guides.convex])[worst])
    value = float(turns[worst])
    raise ConvergenceError(
        f"face {face} is not convex: a corner turns by {value:.2g} (of the mean edge length), at least {LEAST_TURN} is "
        f"asked, {_ending(after, aim, solution, LEAST_TURN - value)}, or ask for fewer convex faces",
        solution=solution,
        elements=[face],
        value=value,
        bound=LEAST_TURN,
    )


def _check_not_folded(before: Mesh, after: Mesh, aim: Aim) -> None:
    turned = np.einsum("fi,fi->f", before.face_normals, after.face_normals)
    face = int(turned.argmin())
    if turned[face] <= 0:
        degrees = float(np.degrees(np.arccos(max(-1.0, turned[face]))))
        raise FoldedError(
            f"face {face} folded over while {aim.task}: its normal turned by {degrees:.0f} degrees, allowed 90",
            aim.advice,
            elements=[face],
            value=float(turned[face]),
            bound=0.0,
        )
    along = np.einsum("ei,ei->e", before.edge_vectors, after.edge_vectors) / before.edge_lengths**2
    edge = int(along.argmin())
    if along[edge] < LEAST_LENGTH:
        raise FoldedError(
            f"{before.combinatorics.edge_name(edge)} folded over while {aim.task}: along its old direction it has "
            f"{along[edge]:.2g} times its old length, at least {LEAST_LENGTH} is allowed",
            aim.advice,
            elements=[edge],
            value=float(along[edge]),
            bound=LEAST_LENGTH,
        )
