"""Minimising a quadratic under equality constraints where they may not determine the minimiser.

The saddle point system

    H x + A^T y = g,   A x = b

is preconditioned by the factor of K = H + pull + w A^T A and its Krylov iterations begin at a given point. They never
leave it along directions without curvature, since K maps these to themselves, and the residual has no part in them:
so of many minimisers the nearest is found. Where there is none, what remains of the residual is a proof of that.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, SuperLU, gcrotmk

from geometry.arrays import FloatArray
from geometry.optimise.constrained import factorise
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.solution import Reason, Solution

__all__ = ["minimise_semidefinite"]

PULL = 1e-4
"""Over the mean of the diagonal of H. Curvatures below it take an iteration each; with less, the factor rounds."""

PENALTY = 1e4
"""w over the mean of the diagonal of H. Less: an iteration for each small singular value of A; more: rounding."""

CYCLE = 30
"""Iterations before the residual is computed afresh; their vectors are kept until then."""

STATIONARY = 1e-12
"""What may remain of the gradient, over the size of its terms."""

SETTLED = 1e-9
"""The same, and what may remain of the equations over the size of theirs, where rounding lets iterations end before."""

PROOF = 1e-6
"""Curvature and violation along what remains, over those of a general direction, below which they are none."""


def minimise_semidefinite(
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    near: FloatArray,
    *,
    accuracy: float,
    max_steps: int = 20,
) -> Solution:
    """Minimise x H x / 2 - g x under A x = b; of several minimisers, the nearest to `near` (n,).

    H (n, n) symmetric, positive semi-definite; A (m, n) with rows of about unit length, dependent or not. A step is a
    cycle of up to 30 solves with one factor.

    The reason is CONVERGED where the largest |A x - b| is at most `accuracy` times the largest |x| or |b|; UNBOUNDED where there is
    no least value, INFEASIBLE where the constraints contradict each other; STALLED where rounding is in the way.
    """
    problem = _SaddlePoint(H, A)
    here = problem.state(near, np.zeros(len(b)), g, b)
    for step in range(1, max_steps + 1):
        if here.left(accuracy) <= 1:
            return here.solution(step - 1, Reason.CONVERGED)
        x, y = problem.correction(here, accuracy)
        there = problem.state(here.x + x, here.y + y, g, b)
        if there.left(accuracy) > here.left(accuracy) / 2:
            best = min(here, there, key=lambda state: state.left(accuracy))
            return best.solution(step, problem.reason(best, accuracy))
        here = there
    return here.solution(max_steps, Reason.STEP_LIMIT)


@dataclass(frozen=True, eq=False)
class _State:
    """x and y, and what is left of the two equations; gradient_size, residual_size: of their largest terms."""

    x: FloatArray
    y: FloatArray
    gradient: FloatArray
    residual: FloatArray
    gradient_size: float
    residual_size: float

    def left(self, accuracy: float) -> float:
        """At most 1 where it is done."""
        allowed = STATIONARY * self.gradient_size
        gradient = _largest(self.gradient) / allowed if allowed else 0.0
        return max(gradient, _largest(self.residual) / (accuracy * self.residual_size or 1.0))

    def solution(self, steps: int, reason: Reason) -> Solution:
        return Solution(self.x, self.y, _largest(self.residual), steps, reason)


@dataclass(frozen=True, eq=False)
class _SaddlePoint:
    H: SparseMatrix
    A: SparseMatrix

    @cached_property
    def curvature(self) -> float:
        """Of a general direction; 1 where H is zero."""
        return float(self.H.diagonal().mean()) or 1.0

    @cached_property
    def transposed(self) -> SparseMatrix:
        return csr_array(self.A.T)

    @cached_property
    def scale(self) -> float:
        """sqrt(w): A x = b and y are scaled by it, so that both equations weigh as they do in K."""
        return float(np.sqrt(PENALTY * self.curvature))

    @cached_property
    def factor(self) -> SuperLU:
        pull = PULL * self.curvature * eye_array(self.H.shape[0])
        return factorise(csr_array(self.H + pull + self.scale**2 * (self.transposed @ self.A)))

    def state(self, x: FloatArray, y: FloatArray, g: FloatArray, b: FloatArray) -> _State:
        image, hold, values = apply(self.H, x), apply(self.transposed, y), apply(self.A, x)
        sizes = max(_largest(g), _largest(image), _largest(hold)), max(_largest(b), _largest(x))
        return _State(x, y, g - image - hold, b - values, *sizes)

    def correction(self, state: _State, accuracy: float) -> tuple[FloatArray, FloatArray]:
        """By one cycle of iterations."""
        n, size = len(state.x), len(state.x) + len(state.y)
        operator = LinearOperator((size, size), matvec=self._apply, dtype=np.float64)
        inverse = LinearOperator((size, size), matvec=self._precondition, dtype=np.float64)
        target = np.concatenate([state.gradient, self.scale * state.residual])
        aim = min(STATIONARY * state.gradient_size, self.scale * accuracy * state.residual_size)
        aim *= np.sqrt(size) / 3  # a norm over all; the largest is some three times the mean
        z = gcrotmk(operator, target, rtol=0.0, atol=aim, m=CYCLE, maxiter=1, M=inverse)[0]
        return z[:n], self.scale * z[n:]

    def reason(self, state: _State, accuracy: float) -> Reason:
        """Why iterations make no progress. What remains minimises its norm, so that where there is no solution the
        matrix takes it to zero, and it is the proof."""
        gradient, residual = state.gradient, state.residual
        settled = _largest(gradient) <= SETTLED * state.gradient_size
        if settled and _largest(residual) <= accuracy * state.residual_size:
            return Reason.CONVERGED
        contradicts = _largest(apply(self.transposed, residual)) <= PROOF * _largest(residual)
        if contradicts and _largest(residual) > SETTLED * state.residual_size:
            return Reason.INFEASIBLE
        falls = max(_largest(apply(self.H, gradient)) / self.curvature, _largest(apply(self.A, gradient)))
        if falls <= PROOF * _largest(gradient) and not settled:
            return Reason.UNBOUNDED
        return Reason.STALLED

    def _apply(self, z: FloatArray) -> FloatArray:
        x, y = np.split(z, [self.H.shape[0]])
        gradient = apply(self.H, x) + self.scale * apply(self.transposed, y)
        return np.concatenate([gradient, self.scale * apply(self.A, x)])

    def _precondition(self, z: FloatArray) -> FloatArray:
        gradient, residual = np.split(z, [self.H.shape[0]])
        x = self.factor.solve(gradient + self.scale * apply(self.transposed, residual))
        return np.concatenate([x, self.scale * apply(self.A, x) - residual])


def _largest(values: FloatArray) -> float:
    return float(np.abs(values).max(initial=0.0))
