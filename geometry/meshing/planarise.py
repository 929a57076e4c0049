"""Make the faces of a mesh planar by small moves of its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.errors import GeometryError, MeshError
from geometry.functionals.fairness import strain
from geometry.functionals.planarity import Planarity, face_deviations
from geometry.mesh import Mesh
from geometry.optimise.newton import nearest_feasible
from geometry.optimise.solution import ConvergenceError, Reason, Solution

__all__ = ["Planarised", "planarise"]

LONGEST_STEP = 0.5
"""Longest move in a coordinate in one step, over the mean edge length."""

LEAST_LENGTH = 0.05
"""Length of an edge afterwards over its length before, below which it counts as collapsed."""


@dataclass(frozen=True, eq=False)
class Planarised:
    """A mesh with planar faces, and what it took.

    Planarity is the largest distance of a corner from its face's best plane; this and the moves of the vertices
    are parts of the mean edge length l of the mesh as given. `reason` says why the method stopped.
    """

    mesh: Mesh
    iterations: int
    planarity_before: float
    planarity_after: float
    largest_move: float
    mean_move: float
    reason: str


def planarise(
    mesh: Mesh,
    *,
    tolerance: float = 1e-12,
    fairness: float = 0.3,
    held_steps: int = 16,
    max_steps: int = 50,
) -> Planarised:
    """Move vertices so that no corner is further than `tolerance` l from its face's plane.

    Constrained Newton steps of least |moves|^2 + fairness * strain; see `functionals.fairness.strain`. Faces
    have any number of corners; a mesh that is planar comes back as the same object. Less fairness (0.01) stays closer
    to the given surface in the mean, and turns and shortens edges more. After `held_steps` the pull back to the given
    surface is dropped: it is in the way of quadratic convergence.

    Raises MeshError for an edge without length, ConvergenceError where the tolerance is not reached, and
    GeometryError where an edge or face folded over on the way.
    """
    if mesh.edge_lengths.min() == 0:
        edge = int(mesh.edge_lengths.argmin())
        raise MeshError(f"{_edge(mesh, edge)} has no length: make its two vertices one", elements=[edge], value=0.0)
    before = float(face_deviations(mesh).max())
    if before <= tolerance:
        return Planarised(mesh, 0, before, before, 0.0, 0.0, "the faces are planar as given")
    length, centre = mesh.mean_edge_length, mesh.vertices.mean(axis=0)
    start = ((mesh.vertices - centre) / length).ravel()
    metric = csr_array(eye_array(len(start)) + fairness * strain(mesh))
    solution = nearest_feasible(
        Planarity(mesh.combinatorics),
        start,
        metric,
        tolerance=tolerance / 4,  # a corner's distance is at most its face's residuals' norm
        longest_step=LONGEST_STEP,
        held_steps=held_steps,
        max_steps=max_steps,
    )
    result = mesh.with_vertices(solution.x.reshape(-1, 3) * length + centre)
    _check_planar(result, solution, tolerance)
    _check_not_folded(mesh, result)
    moves = np.linalg.norm(result.vertices - mesh.vertices, axis=1) / length
    return Planarised(
        mesh=result,
        iterations=solution.steps,
        planarity_before=before,
        planarity_after=float(face_deviations(result).max()),
        largest_move=float(moves.max()),
        mean_move=float(moves.mean()),
        reason=solution.reason.value,
    )


def _check_planar(result: Mesh, solution: Solution, tolerance: float) -> None:
    deviations = face_deviations(result)
    face = int(deviations.argmax())
    value = float(deviations[face])
    if value <= tolerance:
        return
    allowed = f"{value:.1e} of the mean edge length, allowed {tolerance:.0e}"
    if solution.reason is Reason.CONVERGED:
        distance = float(np.abs(result.vertices).max()) / result.mean_edge_length
        message = (
            f"the mesh lies {distance:.0e} mean edge lengths from the origin, where coordinates are so coarse that "
            f"face {face} leaves its plane by {allowed}; move the mesh nearer to the origin, or allow more"
        )
    else:
        message = (
            f"face {face} still leaves its plane by {allowed}, after {solution.steps} steps: "
            f"{solution.reason.value}; lay the mesh along conjugate directions, or split that face"
        )
    raise ConvergenceError(message, solution=solution, elements=[face], value=value, bound=tolerance)


def _check_not_folded(before: Mesh, after: Mesh) -> None:
    advice = "planarise with more fairness, or lay the mesh along conjugate directions"
    turned = np.einsum("fi,fi->f", before.face_normals, after.face_normals)
    face = int(turned.argmin())
    if turned[face] <= 0:
        degrees = float(np.degrees(np.arccos(max(-1.0, turned[face]))))
        raise GeometryError(
            f"face {face} folded over while planarising: its normal turned by {degrees:.0f} degrees, "
            f"allowed 90; {advice}",
            elements=[face],
            value=float(turned[face]),
            bound=0.0,
        )
    along = np.einsum("ei,ei->e", before.edge_vectors, after.edge_vectors) / before.edge_lengths**2
    edge = int(along.argmin())
    if along[edge] < LEAST_LENGTH:
        raise GeometryError(
            f"{_edge(before, edge)} folded over while planarising: along its old direction it has {along[edge]:.2g} "
            f"times its old length, at least {LEAST_LENGTH} is allowed; {advice}",
            elements=[edge],
            value=float(along[edge]),
            bound=LEAST_LENGTH,
        )


def _edge(mesh: Mesh, edge: int) -> str:
    i, j = mesh.combinatorics.edges[edge].tolist()
    return f"edge {edge} from vertex {i} to vertex {j}"
