"""Minimising a quadratic or linear objective over P(M), with fixed vertices and bounds of edge factors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array, eye_array, vstack

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, raise_worst
from geometry.mesh import Mesh
from geometry.optimise import (
    ConvergenceError,
    Reason,
    Solution,
    SparseMatrix,
    apply,
    distances_from_zero,
    max_norm,
    minimise_bounded,
    minimise_semidefinite,
)
from geometry.parallel.constraints import FactorBounds, FixedVertices, Objective
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.face_unknowns import FaceUnknowns
from geometry.parallel.optimality import (
    ROUNDING_MULTIPLE,
    Optimality,
    check_optimal,
    edge_rounding,
    position_uncertainty,
)

__all__ = ["ELEMENT_TOLERANCE", "SOLVER_TARGET_RATIO", "check_solved", "minimising_mesh", "restore_parallelity"]

ELEMENT_TOLERANCE = 1e-12
"""Largest component of an edge of S perpendicular to its edge of M, over the size of S, for S in P(M)."""

LEAST_IMAGE_SIZE = 1e-2
"""Size of S over that of M, below which accuracy is relative to M, since all edges of S may vanish."""

FACTOR_BOUND_TOLERANCE = 1e-9
"""Length by which an edge may be outside the bounds of its factor, over the size of S."""

SOLVER_TARGET_RATIO = 0.1
"""Violation required of the solvers over the one allowed afterwards."""

CONTRADICTION_RATIO = 1e-9
"""Violation over the size of M, of the fixed positions and of S, above which fixed vertices contradict each other."""

FREE_MOVE_RATIO = 1e-6
"""Largest coordinate of a random move within what fixed vertices allow, over that of the move, below which nothing is
free: what solvers leave is a thousandth of it."""


def minimising_mesh(
    unknowns: FaceUnknowns, objective: Objective, fixed: FixedVertices, bounds: FactorBounds | None
) -> Mesh:
    """The mesh in P(M) that minimises the objective; unknowns: those of the mesh M."""
    mesh, to_vertices = unknowns.mesh, unknowns.matrix
    A = csr_array(vstack([unknowns.constraints, fixed.rows(mesh.n_vertices) @ to_vertices]))
    b = np.concatenate([np.zeros(unknowns.constraints.shape[0]), fixed.positions.ravel()])
    H, g = unknowns.objective(objective.H, objective.g)
    noise = _noise(mesh)
    if bounds is None:
        solution = least = _determined(H, g, A, b, near=unknowns.of(mesh.vertices.ravel()), noise=noise)
        rows, residual = A, apply(A, least.x) - b
    else:
        factors = csr_array(bounds.rows(mesh) @ to_vertices)
        lower, upper = bounds.lower * mesh.edge_lengths, bounds.upper * mesh.edge_lengths
        least = _bounded(H, g, A, b, factors, lower, upper, size=max_norm(mesh.vertices), noise=noise)
        rows = csr_array(vstack([A, factors]))
        residual = np.concatenate([apply(A, least.x) - b, _from_bounds(least, apply(factors, least.x), lower, upper)])
        solution = replace(restore_parallelity(least.x, A, b, noise=noise), reason=least.reason)
    found = mesh.with_vertices(apply(to_vertices, solution.x).reshape(-1, 3))
    if bounds is not None:
        _check_bounds(mesh, found, bounds, solution)
    if len(fixed.vertices):
        _check_fixed(mesh, found, fixed, solution)
        _check_free(unknowns, A, b, solution.x, fixed, noise)
    size = max(max_norm(found.vertices), max_norm(fixed.positions), LEAST_IMAGE_SIZE * max_norm(mesh.vertices))
    optimality = Optimality.of(unknowns, H, g, rows, residual, least, found)
    check_solved(mesh, found, solution, size)
    check_optimal(unknowns, optimality, least, what="the minimum")
    return found


def _noise(mesh: Mesh) -> float:
    """Largest parallelity that the rounding of M explains, over the size of S."""
    return ROUNDING_MULTIPLE * position_uncertainty(mesh) / max_norm(mesh.vertices - mesh.vertices.mean(axis=0))


def _determined(
    H: SparseMatrix, g: FloatArray, A: SparseMatrix, b: FloatArray, *, near: FloatArray, noise: float
) -> Solution:
    """The minimiser, or the one nearest to M."""
    solution = minimise_semidefinite(H, g, A, b, near, accuracy=_accuracy(noise), noise=noise)
    if solution.reason is Reason.UNBOUNDED:
        raise _unbounded_error()
    return solution


def _bounded(
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    rows: SparseMatrix,
    lower: FloatArray,
    upper: FloatArray,
    *,
    size: float,
    noise: float,
) -> Solution:
    """The minimiser with lower <= rows y <= upper, with multipliers of A, then rows; size: that of M, where no number
    has one."""
    curvature = float(H.diagonal().mean()) or np.inf
    nearest = max_norm(distances_from_zero(lower, upper))
    size = max(max_norm(b), nearest, max_norm(g) / curvature) or size
    if nearest == 0 and H.nnz:  # signs only
        solution = minimise_semidefinite(H, g, A, b, np.zeros(len(g)), accuracy=ELEMENT_TOLERANCE, noise=noise)
        if _is_within(solution, rows, lower, upper):
            return replace(solution, multipliers=np.concatenate([solution.multipliers, np.zeros(len(lower))]))
    solution = minimise_bounded(H, g, A, b, rows, lower, upper, tolerance=_accuracy(noise) * size)
    if solution.reason is Reason.UNBOUNDED:
        raise _unbounded_error()
    if solution.reason is Reason.INFEASIBLE:
        raise GeometryError(
            "no mesh parallel to M has its fixed vertices at their positions and all edge factors within their "
            "bounds: free some vertices, or widen the bounds"
        )
    if solution.reason in (Reason.STALLED, Reason.STEP_LIMIT):
        raise ConvergenceError(
            f"the least value within the bounds was not reached: after {solution.steps} steps the solver stopped "
            f"because {solution.reason.value}; P(M) may be determined by rounding only: look at `spectrum`, or widen "
            "bounds",
            solution=solution,
            value=solution.violation,
            bound=_accuracy(noise) * size,
        )
    return solution


def _from_bounds(solution: Solution, values: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """(k,) distances of values (k,) from their active bounds, which the signs of the multipliers show.

    The largest value where there is no such bound.
    """
    active = solution.multipliers[-len(values) :]
    bounds = np.where(active > 0, upper, np.where(active < 0, lower, values))
    return np.where(np.isfinite(bounds), values - bounds, max_norm(values))


def restore_parallelity(y: FloatArray, A: SparseMatrix, b: FloatArray, *, noise: float = 0.0) -> Solution:
    """The solution of A y = b nearest to the given y. noise: see `minimise_semidefinite`."""
    H = csr_array(eye_array(len(y)))
    return minimise_semidefinite(H, y, A, b, y, accuracy=_accuracy(noise), noise=noise)


def _accuracy(noise: float) -> float:
    """Accuracy required of the solvers, over the size of S."""
    return min(ELEMENT_TOLERANCE, max(SOLVER_TARGET_RATIO * ELEMENT_TOLERANCE, noise))


def _is_within(solution: Solution, rows: SparseMatrix, lower: FloatArray, upper: FloatArray) -> bool:
    """Whether a minimiser without bounds is within them. Where they are signs it often is, and it is found faster."""
    values = apply(rows, solution.x)
    return solution.reason is Reason.CONVERGED and bool(((lower <= values) & (values <= upper)).all())


def _unbounded_error() -> GeometryError:
    return GeometryError(
        "the objective has no least value: it decreases without bound as the mesh moves or grows within P(M); "
        "add a quadratic term, fix vertices, or bound the edge factors from both sides"
    )


def _check_fixed(mesh: Mesh, found: Mesh, fixed: FixedVertices, solution: Solution) -> None:
    """Raise GeometryError where fixed vertices are off their positions, since these contradict each other."""
    distances = fixed.distances(found.vertices)
    bound = CONTRADICTION_RATIO * max(max_norm(mesh.vertices), max_norm(fixed.positions), max_norm(found.vertices))
    if solution.violation > bound:
        worst = fixed.vertices[np.argsort(-distances)]
        raise GeometryError(
            "the fixed vertices contradict each other: no mesh parallel to M has all of them at their positions. "
            f"They or edges are off by at least {solution.violation:.1e}, allowed {bound:.1e}; free or move vertex "
            f"{worst[0]} first",
            elements=worst.tolist(),
            value=solution.violation,
            bound=bound,
        )


def _check_free(
    unknowns: FaceUnknowns, A: SparseMatrix, b: FloatArray, x: FloatArray, fixed: FixedVertices, noise: float
) -> None:
    """Raise GeometryError where x (n,) is the only solution of A x = b, so that the objective has no effect.

    Skipped where there are more unknown edge lengths than equations.
    """
    mesh, c = unknowns.mesh, unknowns.mesh.combinatorics
    n_parts = int(c.face_components.max()) + 1
    least_dimension = mesh.n_edges - 2 * mesh.n_faces + 3 * (c.euler_characteristic - n_parts)
    if 3 * len(fixed.vertices) < least_dimension:
        return
    size = max(max_norm(x), max_norm(mesh.vertices))
    elsewhere = x + size * np.random.default_rng(0).standard_normal(len(x))
    move = max_norm(restore_parallelity(elsewhere, A, b, noise=noise).x - x) / size
    if move < FREE_MOVE_RATIO:
        raise GeometryError(
            f"the {len(fixed.vertices)} fixed vertices leave nothing to be minimised: only one mesh parallel to M has "
            "them at their positions; fix fewer, see `free_dimension`, or ask for `close_to` them instead",
            elements=fixed.vertices.tolist(),
            value=move,
            bound=FREE_MOVE_RATIO,
        )


def _check_bounds(mesh: Mesh, found: Mesh, bounds: FactorBounds, solution: Solution) -> None:
    factors = edge_factors(mesh, found)
    off = np.maximum(factors - bounds.upper, bounds.lower - factors) * mesh.edge_lengths
    bound = FACTOR_BOUND_TOLERANCE * max_norm(found.vertices)
    raise_worst(
        off,
        "<=",
        bound,
        lambda edge, value: (
            f"edge {edge} has the factor {factors[edge]}, its bounds are {bounds.lower[edge]} and {bounds.upper[edge]}"
            f": its length is outside them by {value:.1e}, allowed {bound:.1e}; the solver stopped "
            f"because {solution.reason.value}: P(M) may be determined by rounding only, look at `spectrum`"
        ),
        error=ConvergenceError,
        solution=solution,
    )


def check_solved(mesh: Mesh, found: Mesh, solution: Solution, size: float) -> None:
    """Raise ConvergenceError, naming the worst edge, where `found` is less parallel than ELEMENT_TOLERANCE x size."""
    bound = ELEMENT_TOLERANCE * size

    def message(edge: int, value: float) -> str:
        cure = "add a term for closeness beside fairness"
        if ROUNDING_MULTIPLE * max_norm(edge_rounding(mesh, found)) > bound:
            deviation = position_uncertainty(mesh)
            cure = f"faces of M are off their planes by {deviation:.1e}: planarise the mesh further, at the origin"
        return (
            f"{mesh.combinatorics.edge_name(edge)} is off the direction of its edge of M by {value:.1e}, allowed "
            f"{bound:.1e}: the solver stopped because {solution.reason.value}; {cure}"
        )

    raise_worst(parallelity(mesh, found), "<=", bound, message, error=ConvergenceError, solution=solution)
