"""Whether a mesh found in P(M) is the best one there, and whether M determines it.

At the minimiser of x H x / 2 - g x under A x = 0 there are multipliers y with H x - g + A^T y = 0: that is checked, as
parallelity is. The multipliers also tell how much the least value changes where A x is not quite zero: by y times that.
So with r, what is left of A x, and what the rounding of M makes of it, |y| (|r| + rounding) is by how much
rounding decides. It is large where conditions nearly depend on each other, as at edges between faces that are
nearly in one plane: with y come singular values of about |A^T y| / |y|.
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

__all__ = ["ROUNDING_MULTIPLE", "Optimality", "check_optimal", "coarseness", "not_parallel", "optimum", "rounding"]

ROUNDING_MULTIPLE = 4.0
"""How many times the rounding of M an edge may be off its direction: less asks for more than there is. Conditions that
depend on each other in M itself contradict each other by its rounding, and S would give up freedom for them."""

CAREFUL_ROUNDING_MULTIPLE = 10.0
"""The same where conditions nearly depend on each other, of an S that has been found once."""

OPTIMUM_ACCURACY = 1e-13
"""What is asked of the solver over the size of S; mostly it reaches 1e-15."""

CAREFUL_OPTIMUM_ACCURACY = 1e-14
"""The same where conditions nearly depend on each other, which amplifies what is left of them."""

LARGEST_ROUNDING_EFFECT = 1e-5
"""By how much rounding may decide: largest change of the least value by one equation, or of the gradient in one entry,
over their sizes. Most meshes reach 1e-12. With it S is certain to some 1e-4, a hundredth of a millimetre in a beam."""

FAR_FROM_ORIGIN_RATIO = 100.0
"""Distance of a mesh from the origin over its extent, from which on its coordinates are coarser than they need be."""

SMALL_SINGULAR_VALUE = 1e-4
"""Singular values below this take a solver its accuracy; others are no excuse."""

MAX_NAMED_EDGES = 3
"""Edges that a message names."""


@dataclass(frozen=True, eq=False)
class Optimality:
    """How well a solution meets the conditions of a minimum, in pure numbers: the size of M does not matter.

    gradient: largest entry of H x - g + A^T y, over the size of its terms. changes (m,): of the least value, by what is
    left of each equation and by the rounding of M, over the size of its terms. singular_value: of A, about.
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
        left: FloatArray,
        solution: Solution,
        image: Mesh,
    ) -> Optimality:
        """H (n, n), g (n,) in the unknowns of M; A (m, n): the open edges, then other equations; left (m,) of them.

        image: the mesh S of the solution.
        """
        size = max_norm(image.vertices) or 1.0
        scale = max(max_norm(g), float(H.diagonal().mean()) * size) or 1.0
        y = solution.multipliers
        pull = np.asarray(y @ A)
        noise = np.full(len(y), np.spacing(size))
        of_edges = np.repeat(rounding(unknowns.mesh, image)[unknowns.open_edges], 2)
        noise[: len(of_edges)] += of_edges
        return cls(
            max_norm(apply(H, solution.x) - g + pull) / scale,
            np.abs(y) * (np.abs(left) + noise) / (scale * size),
            float(np.linalg.norm(pull) / (np.linalg.norm(y) or 1.0)),
        )

    @property
    def decided(self) -> float:
        """By how much rounding decides about the result."""
        return max_norm(self.changes)

    @property
    def is_met(self) -> bool:
        return self.gradient <= LARGEST_ROUNDING_EFFECT and self.decided <= LARGEST_ROUNDING_EFFECT


def optimum(
    unknowns: FaceUnknowns,
    quadratic: ConstrainedQuadratic,
    g: FloatArray,
    *,
    origin: FloatArray,
    size: float,
    bounds: tuple[float, float],
    what: str,
) -> Mesh:
    """The mesh S parallel to M at which x H x / 2 - g x is least; S is origin (3N,) plus what x stands for.

    quadratic: H and the open edges, g (n,), in the unknowns of M. size: about that of S. bounds: S is parallel to M
    within the first one, or what the rounding of M explains, and in any case within the second one.

    Where conditions nearly depend on each other it is tried twice, the second time with care. Raises RankError, naming
    edges and singular values, where rounding decides about S, and ConvergenceError where S is not parallel or no
    minimum.
    """
    mesh, A = unknowns.mesh, quadratic.A
    target = -apply(unknowns.open_constraints, origin)
    tolerance = max(OPTIMUM_ACCURACY * size, ROUNDING_MULTIPLE * coarseness(mesh) / mesh.mean_edge_length * size)
    for problem in (quadratic, replace(quadratic, careful=True)):
        solution = problem.minimise(g, target, tolerance=tolerance)
        image = mesh.with_vertices((origin + apply(unknowns.matrix, solution.x)).reshape(-1, 3))
        noise = max_norm(rounding(mesh, image))
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


def coarseness(mesh: Mesh) -> float:
    """How far off its place a corner may be, as far as the mesh itself tells.

    Faces are off their planes by as much, or coordinates are rounded by it.
    """
    return max(max_norm(mesh.plane_deviations), float(np.spacing(max_norm(mesh.vertices))))


def rounding(mesh: Mesh, image: Mesh) -> FloatArray:
    """(E,) how far the rounding of M may put edges of a mesh S = `image` off their directions."""
    return coarseness(mesh) / mesh.edge_lengths * image.edge_lengths


def check_optimal(unknowns: FaceUnknowns, found: Optimality, solution: Solution, *, what: str) -> None:
    """Raise RankError where rounding decides about `what`, and ConvergenceError where that is no minimum."""
    if not found.decided <= LARGEST_ROUNDING_EFFECT:
        edges = _worst_edges(unknowns, found.changes)
        raise RankError(
            f"rounding decides about {what}: conditions of P(M) nearly depend on each other, with singular values of "
            f"about {found.singular_value:.0e}{_at(unknowns.mesh, edges)}. Its least value is uncertain by "
            f"{found.decided:.0e} of its size, allowed {LARGEST_ROUNDING_EFFECT:.0e}; {_cure(unknowns.mesh)}",
            elements=edges.tolist(),
            value=found.decided,
            bound=LARGEST_ROUNDING_EFFECT,
        )
    if not found.gradient <= LARGEST_ROUNDING_EFFECT:
        raise ConvergenceError(
            f"{what} is not at its least value: {found.gradient:.0e} of the gradient is left, allowed "
            f"{LARGEST_ROUNDING_EFFECT:.0e}; the solver stopped since {solution.reason.value}; {_cure(unknowns.mesh)}",
            solution=solution,
            value=found.gradient,
            bound=LARGEST_ROUNDING_EFFECT,
        )


def not_parallel(
    unknowns: FaceUnknowns, found: Optimality, solution: Solution, image: Mesh, bound: float, *, what: str
) -> ConvergenceError:
    """What is said where S = `image` is less parallel than `bound`."""
    sideways = parallelity(unknowns.mesh, image)
    edge = int(sideways.argmax())
    reason = f"the solver stopped since {solution.reason.value}; planarise the mesh further"
    if found.singular_value < SMALL_SINGULAR_VALUE:
        edges = _worst_edges(unknowns, found.changes)
        reason = (
            f"conditions of P(M) nearly depend on each other, with singular values of about "
            f"{found.singular_value:.0e}{_at(unknowns.mesh, edges)}; {_cure(unknowns.mesh)}"
        )
    return ConvergenceError(
        f"{unknowns.mesh.combinatorics.edge_name(edge)} is off the direction of its mesh edge by {sideways[edge]:.1e} "
        f"in {what}, allowed {bound:.0e}: {reason}",
        solution=solution,
        elements=[edge],
        value=float(sideways[edge]),
        bound=bound,
    )


def _worst_edges(unknowns: FaceUnknowns, values: FloatArray) -> IntArray:
    """At most `MAX_NAMED_EDGES` edges: those of the equations (m,) with the largest values."""
    edges = unknowns.open_edges
    of_edges = values[: 2 * len(edges)].reshape(-1, 2).max(axis=1)
    return integers(edges[np.argsort(-of_edges, kind="stable")[:MAX_NAMED_EDGES]])


def _at(mesh: Mesh, edges: IntArray) -> str:
    pairs = [f"{i} to {j}" for i, j in mesh.combinatorics.edges[edges].tolist()]
    return f", above all at the edges from vertex {', '.join(pairs)}" if pairs else ""


def _cure(mesh: Mesh) -> str:
    """What helps where conditions nearly depend on each other."""
    advice = "unite faces there that are nearly in one plane, or put them in one plane exactly"
    extent = max_norm(mesh.vertices - mesh.vertices.mean(axis=0))
    if max_norm(mesh.vertices) > FAR_FROM_ORIGIN_RATIO * extent:
        advice += ", or move the mesh to the origin before it is planarised"
    return advice
