"""Minimising a quadratic under equality constraints where they may not determine the minimiser.

Iterations as in `saddle_point` begin at a given point. They never leave it along directions without curvature, since
K = H + pull + w A^T A maps these to themselves, and the residual has no part in them: so of many minimisers the nearest
is found. Where there is none, K also finds the direction that proves it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.saddle_point import SaddlePoint
from geometry.optimise.solution import Reason, Solution

__all__ = ["minimise_semidefinite"]

PULL = 1e-4
"""Over the mean of the diagonal of H. Curvatures below it take an iteration each; with less, the factor rounds."""

PENALTY = 1e4
"""w over the mean of the diagonal of H. Less: an iteration for each small singular value of A; more: rounding."""

STATIONARY = 1e-11
"""What may remain of the gradient, over the size of its terms; iterations aim at a tenth of it."""

SETTLED = 1e-9
"""The same, and what may remain of the equations over the size of theirs, where rounding lets iterations end before."""

DIGITS = 1e-10
"""What a cycle may leave: beyond it there is rounding, which iterations would turn into directions of their own."""

AWAY = 1e6
"""Size of x over the size of what it depends on, at which it is asked whether there is a minimiser."""

POWER = 20
"""Solves for a proof that there is no minimiser."""

PROOF = 1e-6
"""What is taken for zero in it, over the size of a general direction."""


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

    The reason is CONVERGED where the largest |A x - b| is at most `accuracy` times the largest |x| or |b|; UNBOUNDED
    where there is no least value, INFEASIBLE where the constraints contradict each other; STALLED where rounding is in
    the way.
    """
    system = SaddlePoint(H, A, PENALTY, PULL)
    start = here = _state(system, near, np.zeros(len(b)), g, b)
    longest = np.inf
    for step in range(1, max_steps + 1):
        if here.left(accuracy) <= 1:
            return here.solution(step - 1, Reason.CONVERGED)
        x, y = system.correction(here.gradient, here.residual, aim=_aim(system, here, accuracy), digits=DIGITS)
        there = here if _largest(x) > longest else _state(system, here.x + x, here.y + y, g, b)
        if there.left(accuracy) > here.left(accuracy) / 2 or _runs_away(system, there, start):
            best = min(here, there, key=lambda state: state.left(accuracy))
            return best.solution(step, _reason(system, start, best, accuracy))
        here, longest = there, _largest(x)  # where there is only rounding left to correct, moves become longer
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


def _state(system: SaddlePoint, x: FloatArray, y: FloatArray, g: FloatArray, b: FloatArray) -> _State:
    hold = apply(system.transposed, y)
    sizes = max(_largest(g), system.curvature * _largest(x), _largest(hold)), max(_largest(b), _largest(x))
    return _State(x, y, g - apply(system.H, x) - hold, b - apply(system.A, x), *sizes)


def _aim(system: SaddlePoint, state: _State, accuracy: float) -> float:
    """A norm over all that is left; the largest is some three times the mean."""
    aim = min(STATIONARY / 10 * state.gradient_size, system.scale * accuracy * state.residual_size)
    return float(aim * np.sqrt(len(state.x) + len(state.y)) / 3)


def _runs_away(system: SaddlePoint, state: _State, start: _State) -> bool:
    """Whether x is very much larger than all it depends on."""
    return _largest(state.x) > AWAY * max(start.gradient_size / system.curvature, start.residual_size)


def _reason(system: SaddlePoint, start: _State, end: _State, accuracy: float) -> Reason:
    """Why iterations make no progress."""
    settled = _largest(end.gradient) <= SETTLED * end.gradient_size
    settled = settled and _largest(end.residual) <= accuracy * end.residual_size
    if settled and not _runs_away(system, end, start):
        return Reason.CONVERGED
    if _contradicts(system, start):
        return Reason.INFEASIBLE
    return Reason.UNBOUNDED if _falls(system, start) else Reason.STALLED


def _contradicts(system: SaddlePoint, start: _State) -> bool:
    """Whether there is a combination of the rows of A that is zero, while that of the residual is not.

    Step by step, the part that a change of x can take away is taken away.
    """
    rest = start.residual
    for _ in range(POWER):
        rest = rest - apply(system.A, system.solve(system.scale**2 * apply(system.transposed, rest)))
    is_void = _largest(apply(system.transposed, rest)) <= PROOF * _largest(rest)
    return is_void and _largest(rest) > SETTLED * start.residual_size


def _falls(system: SaddlePoint, start: _State) -> bool:
    """Whether there is a direction with a slope, but without curvature, in A x = 0: powers of pull / K find it."""
    direction = start.gradient
    for _ in range(POWER):
        direction = system.solve(PULL * system.curvature * direction)
    bends = max(_largest(apply(system.H, direction)) / system.curvature, _largest(apply(system.A, direction)))
    return bends <= PROOF * _largest(direction) and _largest(direction) > SETTLED * start.gradient_size


def _largest(values: FloatArray) -> float:
    return float(np.abs(values).max(initial=0.0))
