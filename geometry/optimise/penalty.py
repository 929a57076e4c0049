"""Minimising under constraints through points that do not fulfil them: a penalty that grows [Pottmann2007, 4.4].

Steps that stay near the constraints must follow the curved set on which these hold, and crawl where it bends. With a low
penalty they pass beside it, and a growing one draws them back. At each penalty a few Gauss-Newton steps are made, by
conjugate gradients with one factor in single precision. Constraints hold in the end as nearly as the last penalty makes
them: `nearest_feasible` sees to the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, cg

from geometry.arrays import FloatArray
from geometry.optimise.functional import Functional, LinearFunctional, SparseMatrix, apply, normal_equations
from geometry.optimise.saddle_point import Factor, factorise

__all__ = ["minimise_by_penalty"]

STEPS = 3
"""Gauss-Newton steps at most with one penalty: the next one changes more than a fourth would."""

SETTLED = 1e-3
"""Part of the objective that a step gains, below which the next penalty is taken."""

HALVINGS = 8
"""How often a step may be halved in search of progress."""

DAMPING = 1e-7
"""Of the factor, over the mean of its diagonal: about what single precision rounds."""

ACCURACY = 1e-8
"""Of a step: what is left of its equations, over their right-hand side, which the penalty dominates."""

ITERATIONS = 200
"""Of conjugate gradients for a step, at most."""


def minimise_by_penalty(
    terms: Sequence[tuple[float, Functional]],
    metric: SparseMatrix,
    constraint: Functional,
    start: FloatArray,
    *,
    penalties: Sequence[float],
) -> FloatArray:
    """x (n,) where the sum of weight |r(x)|^2 over the terms is small and c(x) = 0 nearly holds, found from `start`.

    |x - start|^2 in the metric (n, n), positive definite, is added to the sum, and penalty |c(x)|^2 for each of the
    penalties in turn. No step makes the sum larger.
    """
    x = start
    for penalty in penalties:
        problem = _Penalised((*terms, (penalty, constraint)), metric, start)
        value, factor = problem.value(x), None
        for _ in range(STEPS):
            matrix, slope = problem.model(x)
            factor = factor or _single_factor(matrix)
            found = problem.search(x, _solution(matrix, slope, factor), value)
            if found is None:
                break
            x, reached = found
            enough = value - reached < SETTLED * value
            value = reached
            if enough:
                break
    return x


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

    def search(self, x: FloatArray, move: FloatArray, value: float) -> tuple[FloatArray, float] | None:
        """The first of x + move, x + move/2, ... that lowers the value, and its value."""
        for _ in range(HALVINGS):
            reached = self.value(x + move)
            if reached < value:
                return x + move, reached
            move = move / 2
        return None


def _single_factor(matrix: SparseMatrix) -> Factor:
    damping = DAMPING * float(matrix.diagonal().mean())
    return factorise(csr_array(matrix + damping * eye_array(matrix.shape[0])), single=True)


def _solution(matrix: SparseMatrix, slope: FloatArray, factor: Factor) -> FloatArray:
    """H^-1 g, or as near as conjugate gradients come."""
    inverse = LinearOperator(
        matrix.shape, matvec=lambda z: factor.solve(z.ravel().astype(np.float32)).astype(np.float64), dtype=np.float64
    )
    return np.asarray(cg(matrix, slope, rtol=ACCURACY, maxiter=ITERATIONS, M=inverse)[0])
