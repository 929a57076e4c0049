"""Minimising a quadratic under equality constraints where they may not determine the minimiser.

Iterations as in `saddle_point` begin at a given point. They never leave it along directions without curvature, since
K = H + pull + w A^T A maps these to themselves, and the residual has no part in them: so of many minimisers the nearest
is found. Where there is none, K also finds the direction that proves it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray
from geometry.optimise.functional import SparseMatrix, apply, max_norm
from geometry.optimise.saddle_point import SaddlePoint
from geometry.optimise.solution import Reason, Solution

__all__ = ["minimise_semidefinite"]

SEMIDEFINITE_REGULARISATION = 1e-4
"""Over the mean of the diagonal of H. Curvatures below it take an iteration each; with less, the factor rounds."""

SEMIDEFINITE_PENALTY = 1e4
"""w over the mean of the diagonal of H. Less: an iteration for each small singular value of A; more: rounding."""

MEMORY_SAVING_UNKNOWNS = 300_000
"""Unknowns above which the factor is in single precision, to save memory."""

LEAST_SIZE_RATIO = 1e-2
"""Part of the size of the point begun at, below which a minimiser is not asked to be accurate for its own size."""

GRADIENT_TOLERANCE = 1e-13
"""What may remain of the gradient, over the size of its terms; iterations aim at a tenth of it. With 1e-11, symmetric
problems had minimisers that were symmetric to 1e-9 only, so that equal parts of a roof had marks of their own."""

STALLED_TOLERANCE = 1e-9
"""The same, and what may remain of the equations over the size of theirs, where rounding lets iterations end before."""

CYCLE_REDUCTION = 1e-8
"""What a cycle may leave: beyond it there is rounding, which iterations would turn into directions of their own."""

DIVERGENCE_RATIO = 1e6
"""Size of x over the size of what it depends on, at which it is asked whether there is a minimiser."""

POWER_ITERATIONS = 20
"""Solves that tell directions without curvature, or combinations of A without effect, from others."""

CERTIFICATE_TOLERANCE = 1e-6
"""What is taken for zero in it, over the size of a general direction."""


def minimise_semidefinite(
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    near: FloatArray,
    *,
    accuracy: float,
    noise: float = 0.0,
    max_steps: int = 20,
) -> Solution:
    """Minimise x H x / 2 - g x under A x = b; of several minimisers, the nearest to `near` (n,).

    H (n, n) symmetric, positive semi-definite; A (m, n) with rows of about unit length, dependent or not. A step is a
    cycle of up to 30 solves with one factor. noise: what rounding leaves of A x - b, over the size of x: iterations are
    not to fit that, as combinations of rows that are zero but for rounding would take x far.

    The reason is CONVERGED where the largest |A x - b| is at most `accuracy` times the largest |x|, |b|, |near|/100;
    UNBOUNDED where there is no least value, INFEASIBLE where the constraints contradict each other; STALLED where
    rounding is in the way.
    """
    system = SaddlePoint(
        H, A, SEMIDEFINITE_PENALTY, SEMIDEFINITE_REGULARISATION, single=len(g) > MEMORY_SAVING_UNKNOWNS
    )
    least_size = max(max_norm(b), LEAST_SIZE_RATIO * max_norm(near))
    start = here = _state(system, near, np.zeros(len(b)), g, b, least_size)
    longest = np.inf
    for step in range(1, max_steps + 1):
        if here.left(accuracy) <= 1:
            return here.solution(step - 1, Reason.CONVERGED)
        x, y = system.correction(
            *here.wanting(accuracy), aim=_aim(system, here, accuracy, noise), digits=CYCLE_REDUCTION
        )
        if max_norm(x) > longest:  # rounding in directions without curvature, where nothing stops it
            x = x - _flat_part(system, x)
        there = _state(system, here.x + x, here.y + y, g, b, least_size)
        if there.left(accuracy) > here.left(accuracy) / 2 or _runs_away(system, there, start):
            best = min(here, there, key=lambda state: state.left(accuracy))
            return best.solution(step, _reason(system, start, best, accuracy))
        here, longest = there, max_norm(x)
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
        return max(self._gradient_left, self._residual_left(accuracy))

    def wanting(self, accuracy: float) -> tuple[FloatArray, FloatArray]:
        """The gradient and the residual, or zero for what is done: rounding is not to be corrected too."""
        gradient = self.gradient if self._gradient_left > 1 else np.zeros_like(self.gradient)
        return gradient, self.residual if self._residual_left(accuracy) > 1 else np.zeros_like(self.residual)

    @property
    def _gradient_left(self) -> float:
        return max_norm(self.gradient) / (GRADIENT_TOLERANCE * self.gradient_size or 1.0)

    def _residual_left(self, accuracy: float) -> float:
        return max_norm(self.residual) / (accuracy * self.residual_size or 1.0)

    def solution(self, steps: int, reason: Reason) -> Solution:
        return Solution(self.x, self.y, max_norm(self.residual), steps, reason)


def _state(
    system: SaddlePoint, x: FloatArray, y: FloatArray, g: FloatArray, b: FloatArray, least_size: float
) -> _State:
    hold, size = apply(system.transposed, y), max(least_size, max_norm(x))
    gradient_size = max(max_norm(g), max_norm(hold), system.curvature * size)
    return _State(x, y, g - apply(system.H, x) - hold, b - apply(system.A, x), gradient_size, size)


def _aim(system: SaddlePoint, state: _State, accuracy: float, noise: float) -> float:
    """A norm over all that is left; the largest is some three times the mean."""
    aim = min(GRADIENT_TOLERANCE / 10 * state.gradient_size, system.scale * accuracy * state.residual_size)
    aim = max(aim, system.scale * noise * state.residual_size)
    return float(aim * np.sqrt(len(state.x) + len(state.y)) / 3)


def _runs_away(system: SaddlePoint, state: _State, start: _State) -> bool:
    """Whether x is very much larger than all it depends on."""
    return max_norm(state.x) > DIVERGENCE_RATIO * max(start.gradient_size / system.curvature, start.residual_size)


def _reason(system: SaddlePoint, start: _State, end: _State, accuracy: float) -> Reason:
    """Why iterations make no progress."""
    settled = max_norm(end.gradient) <= STALLED_TOLERANCE * end.gradient_size
    settled = settled and max_norm(end.residual) <= accuracy * end.residual_size
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
    for _ in range(POWER_ITERATIONS):
        rest = rest - apply(system.A, system.solve(system.scale**2 * apply(system.transposed, rest)))
    is_void = max_norm(apply(system.transposed, rest)) <= CERTIFICATE_TOLERANCE * max_norm(rest)
    return is_void and max_norm(rest) > STALLED_TOLERANCE * start.residual_size


def _falls(system: SaddlePoint, start: _State) -> bool:
    """Whether there is a direction with a slope, but without curvature, in A x = 0."""
    direction = _flat_part(system, start.gradient)
    bends = max(max_norm(apply(system.H, direction)) / system.curvature, max_norm(apply(system.A, direction)))
    return (
        bends <= CERTIFICATE_TOLERANCE * max_norm(direction)
        and max_norm(direction) > STALLED_TOLERANCE * start.gradient_size
    )


def _flat_part(system: SaddlePoint, x: FloatArray) -> FloatArray:
    """The part of x (n,) in A x = 0 that is without curvature, as powers of pull / K leave it alone."""
    for _ in range(POWER_ITERATIONS):
        x = system.solve(SEMIDEFINITE_REGULARISATION * system.curvature * x)
    return x
