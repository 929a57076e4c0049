"""Minimising under constraints by a growing penalty, through points that violate them [Pottmann2007, 4.4].

Steps that stay near the constraints have to follow the curved set on which these hold, and are short where it bends.
With a low penalty, steps leave that set; the growing penalty brings them back. A few Gauss-Newton steps are made with
each penalty, then Newton steps on the constraints alone, each as short as possible. The equations of all steps have the
same sparsity pattern and are factored in single precision; conjugate gradients correct its rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, cg

from geometry.arrays import FloatArray, IntArray
from geometry.optimise.functional import Functional, LinearFunctional, SparseMatrix, apply, max_norm, normal_equations
from geometry.optimise.saddle_point import factorise
from geometry.optimise.solution import Reason, Solution

__all__ = ["minimise_by_penalty"]

MAX_STEPS_PER_PENALTY = 4
"""Gauss-Newton steps with one penalty; after four, the next penalty gains more than a fifth step."""

LEAST_RELATIVE_DESCENT = 1e-3
"""Descent of a step over the objective, below which the next penalty is used."""

MAX_DESCENT_HALVINGS = 8
"""Halvings of a step before the descent with one penalty ends."""

FACTOR_DAMPING = 1e-7
"""Multiple of the identity added before factoring, over the mean diagonal: about the rounding of single precision."""

FIRST_STEP_LENGTH_WEIGHT, LEAST_STEP_LENGTH_WEIGHT = 1e-7, 1e-12
"""Weight of the length of a Newton step over the weight of the constraints, by the means of their diagonals. It decides
where the constraints do not. In the first step it is above the rounding of single precision, which would make long
steps; later it falls with the violation, so that what it leaves is removed even where constraints nearly depend on each
other."""

STEP_EQUATION_ACCURACY = 1e-6
"""Residual of the equations of a step over their right-hand side."""

MAX_CONJUGATE_GRADIENT_STEPS = 100
"""Conjugate gradient steps for one step. One to ten are usual; Newton steps on constraints that nearly depend on each
other take more."""


def minimise_by_penalty(
    terms: Sequence[tuple[float, Functional]],
    metric: SparseMatrix,
    constraint: Functional,
    start: FloatArray,
    *,
    penalties: Sequence[float],
    tolerance: float,
    max_newton_steps: int,
) -> Solution:
    """x (n,) where the sum of weight |r(x)|^2 over the terms is small and c(x) = 0 to `tolerance`, from `start` (n,).

    The objective is that sum plus |x - start|^2 in the metric (n, n), positive definite, plus penalty |c(x)|^2, for
    each of the penalties in turn. No step increases it. If constraints are violated by 1e-3 after the last penalty,
    three or four Newton steps reach rounding; many steps mean that something collapsed.

    In the solution, `steps` counts Newton steps only, and there are no multipliers.

    >>> class OnUnitCircle:
    ...     def residual(self, x):
    ...         return np.array([x @ x - 1])
    ...     def jacobian(self, x):
    ...         return csr_array(2 * x[None])
    >>> low = LinearFunctional(csr_array(np.array([[0.0, 1.0]])), np.array([-3.0]))
    >>> found = minimise_by_penalty(
    ...     [(1.0, low)], csr_array(1e-6 * np.eye(2)), OnUnitCircle(), np.array([0.6, 0.8]),
    ...     penalties=[1.0, 1e2, 1e4], tolerance=1e-12, max_newton_steps=6,
    ... )
    >>> found.reason.name, found.violation < 1e-12, found.x[1].item() < 0
    ('CONVERGED', True, True)
    """
    x, equations = start, _Equations()
    for penalty in penalties:
        x = _descend(_Penalised((*terms, (penalty, constraint)), metric, start), x, equations)
    return _restored(constraint, metric, x, equations, tolerance, max_newton_steps)


@dataclass(frozen=True, eq=False)
class _Penalised:
    terms: tuple[tuple[float, Functional], ...]
    metric: SparseMatrix
    start: FloatArray

    def value(self, x: FloatArray) -> float:
        """The objective; infinite where it is not a number."""
        move = x - self.start
        value = float(move @ apply(self.metric, move))
        value += sum(weight * float(np.square(term.residual(x)).sum()) for weight, term in self.terms)
        return value if np.isfinite(value) else np.inf

    def model(self, x: FloatArray) -> tuple[SparseMatrix, FloatArray]:
        """H and g such that a move d changes the objective by about d H d - 2 g d."""
        linearised = [(w, LinearFunctional(term.jacobian(x), -term.residual(x))) for w, term in self.terms]
        matrix, slope = normal_equations(linearised)
        return csr_array(matrix + self.metric), slope + apply(self.metric, self.start - x)


class _Equations:
    """Systems H x = g of one sparsity pattern; the order of elimination is found for the first one only."""

    def __init__(self) -> None:
        self._order: IntArray | None = None

    def solution(self, matrix: SparseMatrix, slope: FloatArray) -> FloatArray:
        """x to the accuracy that conjugate gradients reach."""
        damping = FACTOR_DAMPING * float(matrix.diagonal().mean())
        damped = csr_array(matrix + damping * eye_array(len(slope)))
        factor = factorise(damped, single=True, order=self._order)
        self._order = factor.elimination

        def precondition(z: FloatArray) -> FloatArray:
            return factor.solve(z.ravel().astype(np.float32)).astype(np.float64)

        inverse = LinearOperator(matrix.shape, matvec=precondition, dtype=np.float64)
        return np.asarray(
            cg(matrix, slope, rtol=STEP_EQUATION_ACCURACY, maxiter=MAX_CONJUGATE_GRADIENT_STEPS, M=inverse)[0]
        )


def _descend(problem: _Penalised, x: FloatArray, equations: _Equations) -> FloatArray:
    """A few steps, each the first of d, d/2, ... that decreases the objective."""
    value = problem.value(x)
    for _ in range(MAX_STEPS_PER_PENALTY):
        move, reached = equations.solution(*problem.model(x)), np.inf
        for _ in range(MAX_DESCENT_HALVINGS):
            reached = problem.value(x + move)
            if reached < value:
                break
            move = move / 2
        if not reached < value:
            break
        has_settled = value - reached < LEAST_RELATIVE_DESCENT * value
        x, value = x + move, reached
        if has_settled:
            break
    return x


def _restored(
    constraint: Functional, metric: SparseMatrix, x: FloatArray, equations: _Equations, tolerance: float, max_steps: int
) -> Solution:
    """Levenberg-Marquardt steps on c alone, in the metric."""
    residual = constraint.residual(x)
    first, steps = max_norm(residual), 0
    while tolerance < max_norm(residual) < np.inf and steps < max_steps:
        jacobian = constraint.jacobian(x)
        transposed = csr_array(jacobian.T)
        matrix = csr_array(transposed @ jacobian)
        weight = max(FIRST_STEP_LENGTH_WEIGHT * max_norm(residual) / first, LEAST_STEP_LENGTH_WEIGHT)
        short = weight * float(matrix.diagonal().mean()) / float(metric.diagonal().mean())
        slope = -apply(transposed, residual)
        x = x + equations.solution(csr_array(matrix + short * metric), slope)
        residual = constraint.residual(x)
        steps += 1
    violation = max_norm(residual)
    reason = Reason.CONVERGED if violation <= tolerance else Reason.STEP_LIMIT
    return Solution(x, np.zeros(0), violation, steps, reason)
