"""Minimising a quadratic under equality constraints where the minimiser may not be unique.

Iterations as in `saddle_point` begin at a given point and never move in directions without curvature, since K = H +
regularisation + w A^T A maps these directions to themselves and the residual has no component in them. So of many
minimisers the nearest one is found. Where there is no minimiser, K also finds the direction that proves this.
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
"""Multiple of the identity in K, over the mean diagonal of H. Each curvature below it takes one iteration more; with a
smaller one, the factor rounds too much."""

SEMIDEFINITE_PENALTY = 1e4
"""w over the mean of the diagonal of H. With a smaller one, each small singular value of A takes one iteration more; a
larger one rounds more."""

MEMORY_SAVING_UNKNOWNS = 300_000
"""Number of unknowns above which the factor is in single precision, to save memory."""

LEAST_SIZE_RATIO = 1e-2
"""Size of the minimiser over the size of the start, below which accuracy is relative to the size of the start."""

GRADIENT_TOLERANCE = 1e-13
"""Largest entry of the gradient at a minimiser, over the size of its terms; iterations end at a tenth. With 1e-11,
minimisers of symmetric problems were symmetric to 1e-9 only, so that equal parts of a roof got different marks."""

STALLED_TOLERANCE = 1e-9
"""Largest entry of the gradient, over the size of its terms, that is accepted where rounding prevents progress."""

CYCLE_REDUCTION = 1e-8
"""Reduction of the error by a cycle at which it ends: below it, iterations would follow rounding."""

DIVERGENCE_RATIO = 1e6
"""Size of x over the size that the data suggest, above which the solver checks whether there is a minimiser."""

POWER_ITERATIONS = 20
"""Solves of the power iteration that finds directions without curvature, or rows of A that cancel."""

CERTIFICATE_TOLERANCE = 1e-6
"""Curvature or constraint value that counts as zero in a proof that there is no minimiser, over that of a general
direction."""


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
    cycle of up to 30 solves with one factor. noise: the part of A x - b that is rounding, over the size of x. It is not
    reduced further, since combinations of rows that cancel up to rounding would move x far.

    The reason is CONVERGED where the largest |A x - b| is at most `accuracy` times the largest |x|, |b|, |near|/100;
    UNBOUNDED where there is no least value, INFEASIBLE where the constraints contradict each other, STALLED where
    rounding prevents progress.

    >>> from scipy.sparse import csr_array
    >>> H, A = csr_array(np.diag([1.0, 0.0])), csr_array((0, 2))  # the second entry of x is free
    >>> minimise_semidefinite(H, np.array([3.0, 0.0]), A, np.zeros(0), np.array([0.0, 7.0]), accuracy=1e-12).x.round(
    ...     6
    ... ).tolist()
    [3.0, 7.0]
    """
    system = SaddlePoint(
        H, A, SEMIDEFINITE_PENALTY, SEMIDEFINITE_REGULARISATION, single=len(g) > MEMORY_SAVING_UNKNOWNS
    )
    least_size = max(max_norm(b), LEAST_SIZE_RATIO * max_norm(near))
    start = here = _state(system, near, np.zeros(len(b)), g, b, least_size)
    longest = np.inf
    for step in range(1, max_steps + 1):
        if here.error(accuracy) <= 1:
            return here.solution(step - 1, Reason.CONVERGED)
        target = _target_error(system, here, accuracy, noise)
        x, y = system.correction(*here.unsolved(accuracy), absolute=target, relative=CYCLE_REDUCTION)
        if max_norm(x) > longest:  # rounding in directions without curvature, which nothing limits
            x = x - _part_without_curvature(system, x)
        there = _state(system, here.x + x, here.y + y, g, b, least_size)
        if there.error(accuracy) > here.error(accuracy) / 2 or _diverges(system, there, start):
            best = min(here, there, key=lambda state: state.error(accuracy))
            return best.solution(step, _reason(system, start, best, accuracy))
        here, longest = there, max_norm(x)
    return here.solution(max_steps, Reason.STEP_LIMIT)


@dataclass(frozen=True, eq=False)
class _State:
    """x and y with the residuals of the two equations; gradient_size, residual_size: the sizes of their terms."""

    x: FloatArray
    y: FloatArray
    gradient: FloatArray
    residual: FloatArray
    gradient_size: float
    residual_size: float

    def error(self, accuracy: float) -> float:
        """At most 1 where both equations are solved."""
        return max(self._gradient_error, self._residual_error(accuracy))

    def unsolved(self, accuracy: float) -> tuple[FloatArray, FloatArray]:
        """The gradient and the residual, zero for an equation that is solved, so that its rounding is left alone."""
        gradient = self.gradient if self._gradient_error > 1 else np.zeros_like(self.gradient)
        return gradient, self.residual if self._residual_error(accuracy) > 1 else np.zeros_like(self.residual)

    @property
    def _gradient_error(self) -> float:
        return max_norm(self.gradient) / (GRADIENT_TOLERANCE * self.gradient_size or 1.0)

    def _residual_error(self, accuracy: float) -> float:
        return max_norm(self.residual) / (accuracy * self.residual_size or 1.0)

    def solution(self, steps: int, reason: Reason) -> Solution:
        return Solution(self.x, self.y, max_norm(self.residual), steps, reason)


def _state(
    system: SaddlePoint, x: FloatArray, y: FloatArray, g: FloatArray, b: FloatArray, least_size: float
) -> _State:
    multipliers_part, size = apply(system.transposed, y), max(least_size, max_norm(x))
    gradient_size = max(max_norm(g), max_norm(multipliers_part), system.curvature * size)
    return _State(x, y, g - apply(system.H, x) - multipliers_part, b - apply(system.A, x), gradient_size, size)


def _target_error(system: SaddlePoint, state: _State, accuracy: float, noise: float) -> float:
    """The norm of all residuals at which a cycle ends; the largest residual is some three times the mean one."""
    target = min(GRADIENT_TOLERANCE / 10 * state.gradient_size, system.scale * accuracy * state.residual_size)
    target = max(target, system.scale * noise * state.residual_size)
    return float(target * np.sqrt(len(state.x) + len(state.y)) / 3)


def _diverges(system: SaddlePoint, state: _State, start: _State) -> bool:
    """Whether x is very much larger than the data suggest."""
    return max_norm(state.x) > DIVERGENCE_RATIO * max(start.gradient_size / system.curvature, start.residual_size)


def _reason(system: SaddlePoint, start: _State, end: _State, accuracy: float) -> Reason:
    """The reason why iterations make no progress."""
    is_accurate = max_norm(end.gradient) <= STALLED_TOLERANCE * end.gradient_size
    is_accurate = is_accurate and max_norm(end.residual) <= accuracy * end.residual_size
    if is_accurate and not _diverges(system, end, start):
        return Reason.CONVERGED
    if _is_infeasible(system, start):
        return Reason.INFEASIBLE
    return Reason.UNBOUNDED if _has_no_minimum(system, start) else Reason.STALLED


def _is_infeasible(system: SaddlePoint, start: _State) -> bool:
    """Whether a combination of the rows of A is zero while the same combination of the residual is not.

    The part of the residual that a change of x can remove is removed step by step.
    """
    rest = start.residual
    for _ in range(POWER_ITERATIONS):
        rest = rest - apply(system.A, system.solve(system.scale**2 * apply(system.transposed, rest)))
    cancels = max_norm(apply(system.transposed, rest)) <= CERTIFICATE_TOLERANCE * max_norm(rest)
    return cancels and max_norm(rest) > STALLED_TOLERANCE * start.residual_size


def _has_no_minimum(system: SaddlePoint, start: _State) -> bool:
    """Whether there is a direction with a slope but without curvature in A x = 0."""
    direction = _part_without_curvature(system, start.gradient)
    curvature = max(max_norm(apply(system.H, direction)) / system.curvature, max_norm(apply(system.A, direction)))
    return (
        curvature <= CERTIFICATE_TOLERANCE * max_norm(direction)
        and max_norm(direction) > STALLED_TOLERANCE * start.gradient_size
    )


def _part_without_curvature(system: SaddlePoint, x: FloatArray) -> FloatArray:
    """The part of x (n,) without curvature in A x = 0, which powers of regularisation / K leave unchanged."""
    for _ in range(POWER_ITERATIONS):
        x = system.solve(SEMIDEFINITE_REGULARISATION * system.curvature * x)
    return x
