"""Minimising a convex quadratic under equations and bounds: an interior-point method [GoulartChen2024], then a polish.

The interior-point method leaves equations and active bounds violated by about 1e-8. The polish takes the active bounds
as equations and solves once more, so that equations and active bounds hold to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import clarabel
import numpy as np
from scipy.sparse import csc_array, csr_array, triu, vstack

from geometry.arrays import BoolArray, FloatArray
from geometry.optimise.functional import SparseMatrix, apply, max_norm
from geometry.optimise.semidefinite_quadratic import CERTIFICATE_TOLERANCE, DIVERGENCE_RATIO, minimise_semidefinite
from geometry.optimise.solution import Reason, Solution

__all__ = ["distances_from_zero", "minimise_bounded"]

INTERIOR_POINT_ACCURACY = 1e-12
"""Accuracy required of the interior-point method, for numbers of about 1: it must show which bounds are active."""

ACCEPTED_ACCURACY = 1e-8
"""Accuracy that is accepted of the interior-point method where rounding prevents more."""

LARGEST_SCALED_BOUND = 1e3
"""Bounds over the size of x, above which they are left out unless the result violates them: the accuracy of the
interior-point method is relative to the largest bound."""

POLISH_TOLERANCE = 1e-11
"""How much the polish may increase the objective, over the size of its terms."""

REASONS = {
    clarabel.SolverStatus.Solved: Reason.CONVERGED,
    clarabel.SolverStatus.AlmostSolved: Reason.CONVERGED,
    clarabel.SolverStatus.PrimalInfeasible: Reason.INFEASIBLE,
    clarabel.SolverStatus.AlmostPrimalInfeasible: Reason.INFEASIBLE,
    clarabel.SolverStatus.DualInfeasible: Reason.UNBOUNDED,
    clarabel.SolverStatus.AlmostDualInfeasible: Reason.UNBOUNDED,
    clarabel.SolverStatus.MaxIterations: Reason.STEP_LIMIT,
}


def minimise_bounded(
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    G: SparseMatrix,
    lower: FloatArray,
    upper: FloatArray,
    *,
    tolerance: float,
    max_steps: int = 200,
) -> Solution:
    """Minimise x H x / 2 - g x under A x = b and lower <= G x <= upper.

    H (n, n) symmetric, positive semi-definite; A (m, n) and G (k, n) with rows of about unit length, dependent or
    not; lower and upper (k,) may be infinite, and are an equation where they are equal. Where there are several
    minimisers, one of them is returned.

    Solution: violation is the largest of |A x - b| and of the distances of G x from its bounds where it is outside.
    multipliers (m + k,), of A, then of G, satisfy H x - g + (A, G)^T multipliers = 0; they are positive at active upper
    bounds, negative at active lower ones. The reason is CONVERGED at a minimiser where the violation is at most
    `tolerance`, INACCURATE where it is more, INFEASIBLE where no x satisfies the constraints and UNBOUNDED where there
    is no minimum; in these last two cases x has no meaning.

    >>> identity, none = csr_array(np.eye(2)), csr_array((0, 2))
    >>> lower, upper = np.array([0.0, 0.0]), np.array([1.0, np.inf])
    >>> found = minimise_bounded(
    ...     identity, np.array([5.0, 2.0]), none, np.zeros(0), identity, lower, upper, tolerance=1e-9
    ... )
    >>> found.x.round(6).tolist(), found.multipliers.round(6).tolist()
    ([1.0, 2.0], [4.0, 0.0])
    """
    x_size, size = _sizes(H, g, b, lower, upper)
    problem = _Problem(
        csr_array((1 / size) * H),
        g / (size * x_size),
        A,
        b / x_size,
        G,
        lower / x_size,
        upper / x_size,
        tolerance / x_size,
    )
    found = problem.without_far_bounds().solution(max_steps)
    far_bounds_matter = found.reason is Reason.UNBOUNDED or problem.violation(found.x) > max(
        found.violation, problem.tolerance
    )
    if far_bounds_matter and found.reason is not Reason.INFEASIBLE:
        found = problem.solution(max_steps)
    return Solution(
        found.x * x_size, found.multipliers * (size * x_size), found.violation * x_size, found.steps, found.reason
    )


def _sizes(H: SparseMatrix, g: FloatArray, b: FloatArray, lower: FloatArray, upper: FloatArray) -> tuple[float, float]:
    """A typical size of x, and of the objective over its square."""
    bounds = np.concatenate([b, lower, upper])
    widest = max_norm(bounds[np.isfinite(bounds)])
    curvature, gradient = float(H.diagonal().mean()), max_norm(g)
    unconstrained = gradient / curvature if curvature * gradient > 0 else 0.0
    nearest = max(max_norm(b), max_norm(distances_from_zero(lower, upper)))
    x = max(nearest, min(unconstrained, widest)) or unconstrained or widest or 1.0
    return x, max(curvature, gradient / x) or 1.0


def distances_from_zero(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """(k,) distances of the intervals between bounds from zero: the size that they require of x.

    >>> distances_from_zero(np.array([-1.0, 2.0, -np.inf]), np.array([5.0, np.inf, -3.0])).tolist()
    [0.0, 2.0, 3.0]
    """
    return np.asarray(np.maximum(np.maximum(lower, -upper), 0.0))


@dataclass(frozen=True, eq=False)
class _Problem:
    """The problem scaled so that its numbers are about 1."""

    H: SparseMatrix
    g: FloatArray
    A: SparseMatrix
    b: FloatArray
    G: SparseMatrix
    lower: FloatArray
    upper: FloatArray
    tolerance: float

    @property
    def is_equation(self) -> BoolArray:
        """(k,) where the lower and the upper bound are the same."""
        found: BoolArray = self.lower == self.upper
        return found

    def without_far_bounds(self) -> _Problem:
        """The problem without the bounds above `LARGEST_SCALED_BOUND`."""
        lower = np.where(self.lower < -LARGEST_SCALED_BOUND, -np.inf, self.lower)
        upper = np.where(self.upper > LARGEST_SCALED_BOUND, np.inf, self.upper)
        return replace(self, lower=lower, upper=upper)

    def solution(self, max_steps: int) -> Solution:
        found = self.interior_point(max_steps)
        return found if found.reason in (Reason.INFEASIBLE, Reason.UNBOUNDED) else self.polished(found)

    def interior_point(self, max_steps: int) -> Solution:
        is_equation, above, below = self.is_equation, np.isfinite(self.upper), np.isfinite(self.lower)
        above, below = above & ~is_equation, below & ~is_equation
        rows = csc_array(vstack([self.A, self.G[is_equation], self.G[above], -self.G[below]]))
        bounds = np.concatenate([self.b, self.upper[is_equation], self.upper[above], -self.lower[below]])
        n_equations = len(self.b) + int(is_equation.sum())
        cones = [clarabel.ZeroConeT(n_equations), clarabel.NonnegativeConeT(len(bounds) - n_equations)]
        P = csc_array(triu(self.H))
        found = clarabel.DefaultSolver(P, -self.g, rows, bounds, cones, _settings(max_steps)).solve()
        x, duals = np.asarray(found.x), np.split(found.z, np.cumsum([len(self.b), is_equation.sum(), above.sum()]))
        bound_multipliers = np.zeros(len(self.lower))
        bound_multipliers[is_equation] = duals[1]
        bound_multipliers[above] = duals[2]
        bound_multipliers[below] -= duals[3]
        reason = Reason.UNBOUNDED if self.is_unbounded_along(x) else REASONS.get(found.status, Reason.STALLED)
        return Solution(x, np.concatenate([duals[0], bound_multipliers]), self.violation(x), found.iterations, reason)

    def is_unbounded_along(self, x: FloatArray) -> bool:
        """Whether x is very large and its direction proves that there is no minimum.

        The objective has a slope but no curvature in this direction, which also meets no bound. The interior-point
        method may stop far out in this direction and report a minimum.
        """
        size = max_norm(x)
        if not size > DIVERGENCE_RATIO:
            return False
        direction = x / size
        along = apply(self.G, direction)
        curvature = max(max_norm(apply(self.H, direction)), max_norm(apply(self.A, direction)))
        approach = max(
            along[np.isfinite(self.upper)].max(initial=0.0), -along[np.isfinite(self.lower)].min(initial=0.0)
        )
        return max(curvature, approach) <= CERTIFICATE_TOLERANCE and float(
            self.g @ direction
        ) > CERTIFICATE_TOLERANCE * max_norm(self.g)

    def polished(self, interior: Solution) -> Solution:
        """The minimiser on the bounds that are active at the interior point, unless it is worse than that point.

        It may be worse where bounds depend on each other and it is uncertain which are active; there the interior point
        is accurate enough in most cases.
        """
        values, bound_multipliers = apply(self.G, interior.x), interior.multipliers[len(self.b) :]
        above = (bound_multipliers > self.upper - values) | self.is_equation
        below = (-bound_multipliers > values - self.lower) & ~self.is_equation
        found = self.with_active_bounds(above, below, interior)
        least, size = self.objective(interior.x)
        is_least = self.objective(found.x)[0] <= least + POLISH_TOLERANCE * size
        if is_least and found.violation <= max(self.tolerance, interior.violation):
            interior = found
        is_inaccurate = interior.reason is Reason.CONVERGED and interior.violation > self.tolerance
        return replace(interior, reason=Reason.INACCURATE) if is_inaccurate else interior

    def with_active_bounds(self, above: BoolArray, below: BoolArray, near: Solution) -> Solution:
        """The minimiser that is found from a solution `near` with the active bounds as equations and without the
        others.

        CONVERGED where all multipliers have the sign of an active bound: then it is the minimiser, unless it violates
        another bound.
        """
        active = above | below
        rows = csr_array(vstack([self.A, self.G[active]]))
        bounds = np.concatenate([self.b, np.where(above, self.upper, self.lower)[active]])
        size = max(max_norm(near.x), max_norm(bounds))
        # a tenth of the tolerance, so that the order of summation does not decide
        accuracy = self.tolerance / (10 * (size or 1.0))
        found = minimise_semidefinite(self.H, self.g, rows, bounds, near.x, accuracy=accuracy)
        multipliers = np.zeros(len(self.b) + len(self.lower))
        multipliers[np.concatenate([np.ones(len(self.b), dtype=bool), active])] = found.multipliers
        bound_multipliers = multipliers[len(self.b) :]
        wrong_sign = (above & (bound_multipliers < 0) | below & (bound_multipliers > 0)) & ~self.is_equation
        if wrong_sign.any():  # multipliers of dependent bounds are not unique
            return Solution(found.x, near.multipliers, self.violation(found.x), near.steps, near.reason)
        reason = near.reason if found.reason is not Reason.CONVERGED else Reason.CONVERGED
        return Solution(found.x, multipliers, self.violation(found.x), near.steps, reason)

    def violation(self, x: FloatArray) -> float:
        values = apply(self.G, x)
        violations = [np.abs(apply(self.A, x) - self.b), values - self.upper, self.lower - values]
        return float(max(part.max(initial=0.0) for part in violations))

    def objective(self, x: FloatArray) -> tuple[float, float]:
        """The value of the objective, and the size of its terms."""
        quadratic, linear = float(x @ apply(self.H, x)) / 2, float(self.g @ x)
        return quadratic - linear, quadratic + abs(linear)


def _settings(max_steps: int) -> clarabel.DefaultSettings:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = max_steps
    settings.direct_solve_method = "qdldl"  # three times as fast on meshes as the alternative
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = INTERIOR_POINT_ACCURACY
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = ACCEPTED_ACCURACY
    return settings
