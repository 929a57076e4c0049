"""Minimising under constraints through points that do not fulfil them: a penalty that grows [Pottmann2007, 4.4].

Steps that stay near the constraints must follow the curved set on which these hold, and crawl where it bends. With a
low penalty they pass beside it, and a growing one draws them back. With each penalty a few Gauss-Newton steps are made.
Last come Newton steps on the constraints alone, each as short as can be. All have equations of one pattern, factored in
single precision; conjugate gradients mend what that rounds.
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

MAX_STEPS_PER_PENALTY = 3
"""Gauss-Newton steps at most with one penalty: the next one changes more than a fourth would."""

LEAST_RELATIVE_DESCENT = 1e-3
"""Part of the objective that a step gains, below which the next penalty is taken."""

MAX_DESCENT_HALVINGS = 8
"""How often a step may be halved in search of progress."""

FACTOR_DAMPING = 1e-7
"""Of the factor, over the mean of its diagonal: about what single precision rounds."""

STEP_LENGTH_WEIGHT = 1e-12
"""Weight of the length of a Newton step over that of the constraints, as means of diagonals: it decides where they do
not, and leaves a part of them that the next step finds."""

STEP_EQUATION_ACCURACY = 1e-6
"""Of a step: what is left of its equations, over their right-hand side."""

MAX_CONJUGATE_GRADIENT_STEPS = 100
"""Of conjugate gradients for a step, at most. One to ten do, and more for Newton steps on constraints that nearly
depend on each other."""


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

    |x - start|^2 in the metric (n, n), positive definite, is added to the sum, and penalty |c(x)|^2 for each of the
    penalties in turn. No step makes the sum larger. Where constraints are missed by 1e-3 after the last penalty, three
    or four Newton steps find them to rounding; where it takes many, something collapsed.

    Solution: steps counts Newton steps only; no multipliers.
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
        """Infinite where something is no number."""
        away = x - self.start
        value = float(away @ apply(self.metric, away))
        value += sum(weight * float(np.square(term.residual(x)).sum()) for weight, term in self.terms)
        return value if np.isfinite(value) else np.inf

    def model(self, x: FloatArray) -> tuple[SparseMatrix, FloatArray]:
        """H and g: a move d changes the value by about d H d - 2 g d."""
        linearised = [(w, LinearFunctional(term.jacobian(x), -term.residual(x))) for w, term in self.terms]
        matrix, slope = normal_equations(linearised)
        return csr_array(matrix + self.metric), slope + apply(self.metric, self.start - x)


class _Equations:
    """Systems H x = g of one pattern, one after the other: the order of elimination is found once."""

    def __init__(self) -> None:
        self._order: IntArray | None = None

    def solution(self, matrix: SparseMatrix, slope: FloatArray) -> FloatArray:
        """As near as conjugate gradients come."""
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
    """A few steps, each the first of d, d/2, ... that lowers the value."""
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
        enough = value - reached < LEAST_RELATIVE_DESCENT * value
        x, value = x + move, reached
        if enough:
            break
    return x


def _restored(
    constraint: Functional, metric: SparseMatrix, x: FloatArray, equations: _Equations, tolerance: float, max_steps: int
) -> Solution:
    """Levenberg-Marquardt on c alone, in the metric."""
    residual = constraint.residual(x)
    steps = 0
    while tolerance < max_norm(residual) < np.inf and steps < max_steps:
        jacobian = constraint.jacobian(x)
        transposed = csr_array(jacobian.T)
        matrix = csr_array(transposed @ jacobian)
        short = STEP_LENGTH_WEIGHT * float(matrix.diagonal().mean()) / float(metric.diagonal().mean())
        slope = -apply(transposed, residual)
        x = x + equations.solution(csr_array(matrix + short * metric), slope)
        residual = constraint.residual(x)
        steps += 1
    violation = max_norm(residual)
    reason = Reason.CONVERGED if violation <= tolerance else Reason.STEP_LIMIT
    return Solution(x, np.zeros(0), violation, steps, reason)
