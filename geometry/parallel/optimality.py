"""Checks that a mesh found in P(M) is the minimum and that M determines it.

At the minimiser of x H x / 2 - g x under A x = 0 there are multipliers y with H x - g + A^T y = 0. Both this equation
and parallelity are checked. The multipliers also show how much the least value changes where A x = r is not exactly
zero: by y . r. So |y| (|r| + rounding), with the effect of the rounding of M on A x, bounds the effect of rounding on
the least value. It is large where equations nearly depend on each other, as at edges between faces that are nearly in
one plane; the corresponding singular values are about |A^T y| / |y|.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import RankError
from geometry.mesh import Mesh
from geometry.optimise import ConstrainedQuadratic, ConvergenceError, Solution, SparseMatrix, apply, max_norm
from geometry.parallel.edge_parallelity import parallelity
from geometry.parallel.face_unknowns import FaceUnknowns

__all__ = [
    "ROUNDING_MULTIPLE",
    "Optimality",
    "check_optimal",
    "edge_rounding",
    "not_parallel",
    "optimal_mesh",
    "position_uncertainty",
]

ROUNDING_MULTIPLE = 4.0
"""Deviation of an edge from its direction over the rounding of M, up to which it is accepted. Equations that depend on
each other in exact arithmetic contradict each other by this rounding, and solving them exactly would distort S."""

CAREFUL_ROUNDING_MULTIPLE = 10.0
"""The same multiple in the second attempt, where equations nearly depend on each other."""

OPTIMUM_ACCURACY = 1e-13
"""Accuracy required of the solver over the size of S; mostly it reaches 1e-15."""

CAREFUL_OPTIMUM_ACCURACY = 1e-14
"""The same accuracy in the second attempt, where nearly dependent equations amplify residuals."""

LARGEST_ROUNDING_EFFECT = 1e-5
"""Largest effect of rounding: change of the least value by one equation, or of one entry of the gradient, over their
sizes. Most meshes reach 1e-12. At this limit S is accurate to about 1e-4, a hundredth of a millimetre in a beam."""

FAR_FROM_ORIGIN_RATIO = 100.0
"""Distance of a mesh from the origin over its extent, above which a message advises to move it to the origin."""

SMALL_SINGULAR_VALUE = 1e-4
"""Singular value below which nearly dependent equations, not the solver, explain a lack of accuracy."""

MAX_NAMED_EDGES = 3
"""Largest number of edges that a message names."""


@dataclass(frozen=True, eq=False)
class Optimality:
    """How accurately a solution meets the conditions of a minimum, as ratios that do not depend on the size of M.

    gradient: largest entry of H x - g + A^T y, over the size of its terms. changes (m,): effect of the residual of each
    equation and of the rounding of M on the least value, over the size of its terms. singular_value: the approximate
    singular value of A that belongs to y.
    """

    gradient: float
    changes: FloatArray
    singular_value: float

    @classmethod
    def of(
        cls,
        unknowns: FaceUnknowns,
        H: SparseMatrix,
        g: FloatArray,
        A: SparseMatrix,
        residual: FloatArray,
        solution: Solution,
        image: Mesh,
    ) -> Optimality:
        """H (n, n), g (n,) in the unknowns of M; A (m, n): equations of open edges, then others; residual (m,) of them.

        image: the mesh S of the solution.
        """
        size = max_norm(image.vertices) or 1.0
        scale = max(max_norm(g), float(H.diagonal().mean()) * size) or 1.0
        y = solution.multipliers
        constraint_gradient = np.asarray(y @ A)
        noise = np.full(len(y), np.spacing(size))
        edge_noise = np.repeat(edge_rounding(unknowns.mesh, image)[unknowns.open_edges], 2)
        noise[: len(edge_noise)] += edge_noise
        return cls(
            max_norm(apply(H, solution.x) - g + constraint_gradient) / scale,
            np.abs(y) * (np.abs(residual) + noise) / (scale * size),
            float(np.linalg.norm(constraint_gradient) / (np.linalg.norm(y) or 1.0)),
        )

    @property
    def rounding_effect(self) -> float:
        """The largest effect of rounding on the least value."""
        return max_norm(self.changes)

    @property
    def is_met(self) -> bool:
        return self.gradient <= LARGEST_ROUNDING_EFFECT and self.rounding_effect <= LARGEST_ROUNDING_EFFECT


def optimal_mesh(
    unknowns: FaceUnknowns,
    quadratic: ConstrainedQuadratic,
    g: FloatArray,
    *,
    origin: FloatArray,
    size: float,
    bounds: tuple[float, float],
    what: str,
) -> Mesh:
    """The mesh S parallel to M with the least x H x / 2 - g x; S is origin (3N,) plus the mesh of the unknowns x.

    quadratic: H and the equations of the open edges, and g (n,), in the unknowns of M. size: a typical size of S.
    bounds: S is parallel to M within the first one, or within the rounding of M if that is larger, but always within
    the second one. what: the name of S in messages.

    Where equations nearly depend on each other there is a second attempt, with `careful`. Raises RankError, naming
    edges and singular values, where rounding decides about S, and ConvergenceError where S is not parallel or not the
    minimum.
    """
    mesh, A = unknowns.mesh, quadratic.A
    target = -apply(unknowns.open_constraints, origin)
    tolerance = max(
        OPTIMUM_ACCURACY * size, ROUNDING_MULTIPLE * position_uncertainty(mesh) / mesh.mean_edge_length * size
    )
    for problem in (quadratic, replace(quadratic, careful=True)):
        solution = problem.minimise(g, target, tolerance=tolerance)
        image = mesh.with_vertices((origin + apply(unknowns.matrix, solution.x)).reshape(-1, 3))
        noise = max_norm(edge_rounding(mesh, image))
        found = Optimality.of(unknowns, problem.H, g, A, apply(A, solution.x) - target, solution, image)
        bound = min(bounds[1], max(bounds[0], ROUNDING_MULTIPLE * noise))
        is_parallel = max_norm(parallelity(mesh, image)) <= bound
        if is_parallel and found.is_met:
            return image
        tolerance = max(CAREFUL_OPTIMUM_ACCURACY * size, CAREFUL_ROUNDING_MULTIPLE * noise)
    if not is_parallel:
        raise not_parallel(unknowns, found, solution, image, bound, what=what)
    check_optimal(unknowns, found, solution, what=what)
    return image


def position_uncertainty(mesh: Mesh) -> float:
    """The uncertainty of the position of a corner: its rounding, or the largest distance of a corner from the plane of
    its face, whichever is larger."""
    return max(max_norm(mesh.plane_deviations), float(np.spacing(max_norm(mesh.vertices))))


def edge_rounding(mesh: Mesh, image: Mesh) -> FloatArray:
    """(E,) deviations of the edges of a mesh S = `image` from their directions that the rounding of M explains."""
    return position_uncertainty(mesh) / mesh.edge_lengths * image.edge_lengths


def check_optimal(unknowns: FaceUnknowns, found: Optimality, solution: Solution, *, what: str) -> None:
    """Raise RankError where rounding decides about `what`, and ConvergenceError where it is not the minimum."""
    if not found.rounding_effect <= LARGEST_ROUNDING_EFFECT:
        edges = _worst_edges(unknowns, found.changes)
        raise RankError(
            f"rounding decides about {what}: equations of P(M) nearly depend on each other, with singular values of "
            f"about {found.singular_value:.0e}{_edge_list(unknowns.mesh, edges)}. Its least value is uncertain by "
            f"{found.rounding_effect:.0e} of its size, allowed {LARGEST_ROUNDING_EFFECT:.0e}; {_cure(unknowns.mesh)}",
            elements=edges.tolist(),
            value=found.rounding_effect,
            bound=LARGEST_ROUNDING_EFFECT,
        )
    if not found.gradient <= LARGEST_ROUNDING_EFFECT:
        raise ConvergenceError(
            f"{what} is not at its least value: {found.gradient:.0e} of the gradient remains, allowed "
            f"{LARGEST_ROUNDING_EFFECT:.0e}; the solver stopped because {solution.reason.value}; "
            f"{_cure(unknowns.mesh)}",
            solution=solution,
            value=found.gradient,
            bound=LARGEST_ROUNDING_EFFECT,
        )


def not_parallel(
    unknowns: FaceUnknowns, found: Optimality, solution: Solution, image: Mesh, bound: float, *, what: str
) -> ConvergenceError:
    """The error for an S = `image` that is less parallel than `bound`."""
    deviations = parallelity(unknowns.mesh, image)
    edge = int(deviations.argmax())
    reason = f"the solver stopped because {solution.reason.value}; planarise the mesh further"
    if found.singular_value < SMALL_SINGULAR_VALUE:
        edges = _worst_edges(unknowns, found.changes)
        reason = (
            f"equations of P(M) nearly depend on each other, with singular values of about "
            f"{found.singular_value:.0e}{_edge_list(unknowns.mesh, edges)}; {_cure(unknowns.mesh)}"
        )
    return ConvergenceError(
        f"{unknowns.mesh.combinatorics.edge_name(edge)} is off the direction of its mesh edge by "
        f"{deviations[edge]:.1e} in {what}, allowed {bound:.0e}: {reason}",
        solution=solution,
        elements=[edge],
        value=float(deviations[edge]),
        bound=bound,
    )


def _worst_edges(unknowns: FaceUnknowns, values: FloatArray) -> IntArray:
    """At most `MAX_NAMED_EDGES` edges: those of the equations (m,) with the largest values."""
    edges = unknowns.open_edges
    edge_values = values[: 2 * len(edges)].reshape(-1, 2).max(axis=1)
    return integers(edges[np.argsort(-edge_values, kind="stable")[:MAX_NAMED_EDGES]])


def _edge_list(mesh: Mesh, edges: IntArray) -> str:
    pairs = [f"{i} to {j}" for i, j in mesh.combinatorics.edges[edges].tolist()]
    return f", mostly at the edges from vertex {', '.join(pairs)}" if pairs else ""


def _cure(mesh: Mesh) -> str:
    """The cure where equations nearly depend on each other."""
    advice = "unite faces there that are nearly in one plane, or move them exactly into one plane"
    extent = max_norm(mesh.vertices - mesh.vertices.mean(axis=0))
    if max_norm(mesh.vertices) > FAR_FROM_ORIGIN_RATIO * extent:
        advice += ", or move the mesh to the origin before it is planarised"
    return advice
