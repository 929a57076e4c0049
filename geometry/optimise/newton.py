"""From a point to a nearby one on which constraints hold: Newton's method with a line search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray
from geometry.optimise.constrained import minimise_quadratic
from geometry.optimise.functional import Functional, SparseMatrix, apply
from geometry.optimise.solution import Reason, Solution

__all__ = ["nearest_feasible"]

STEP_PENALTY = 1e8
"""Penalty of a linearised step: high, so that one solve makes most steps."""

STEP_ACCURACY = 1e-8
"""Violation a linearised step may leave, over what it finds: too little to slow quadratic convergence."""

HALVINGS = 12
"""How often a step may be halved in search of progress."""


def nearest_feasible(
    constraint: Functional,
    start: FloatArray,
    metric: SparseMatrix,
    *,
    tolerance: float,
    longest_step: float,
    held_steps: int,
    max_steps: int,
) -> Solution:
    """A point x with c(x) = 0, to `tolerance`, near to `start` (n,) in the metric (n, n), positive definite.

    The first `held_steps` also pull back towards the start; each later one takes the shortest way to c = 0, which is
    what converges quadratically. No coordinate moves by more than `longest_step` in one step, and a step
    is halved until it lowers an exact penalty function.
    """
    problem = _Problem(constraint, metric, longest_step)
    x = target = start
    residual, multipliers = constraint.residual(start), np.zeros(0)
    for step in range(max_steps + 1):
        violation = float(np.abs(residual).max(initial=0.0))
        if violation <= tolerance:
            return Solution(x, multipliers, violation, step, Reason.CONVERGED)
        if step == max_steps:
            break
        target = target if step < held_steps else x
        move, multipliers = problem.newton_step(x, target, residual)
        moved = problem.search(x, move, target, residual, multipliers)
        if moved is None and target is not x:  # the pull back is in the way
            held_steps = 0
        elif moved is None:
            return Solution(x, multipliers, violation, step, Reason.STALLED)
        else:
            x, residual = moved
    return Solution(x, multipliers, violation, max_steps, Reason.STEP_LIMIT)


@dataclass(frozen=True, eq=False)
class _Problem:
    constraint: Functional
    metric: SparseMatrix
    longest_step: float

    def newton_step(self, x: FloatArray, target: FloatArray, residual: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The move towards the point of the linearised constraint nearest to the target, and its multipliers."""
        solution = minimise_quadratic(
            self.metric,
            apply(self.metric, target - x),
            self.constraint.jacobian(x),
            -residual,
            tolerance=STEP_ACCURACY * float(np.abs(residual).max()),
            penalty=STEP_PENALTY,
            max_steps=3,
        )
        longest = max(self.longest_step, float(np.abs(solution.x).max()))
        return solution.x * (self.longest_step / longest), solution.multipliers

    def search(
        self, x: FloatArray, move: FloatArray, target: FloatArray, residual: FloatArray, multipliers: FloatArray
    ) -> tuple[FloatArray, FloatArray] | None:
        """The first of x + move, x + move/2, ... that lowers the penalty function, and the residual there."""
        weight = 1.5 * float(np.abs(multipliers).max())  # more than the largest multiplier: the penalty is exact
        before = self._penalty(x, target, residual, weight)
        for _ in range(HALVINGS):
            there = self.constraint.residual(x + move)
            if self._penalty(x + move, target, there, weight) < before:
                return x + move, there
            move = move / 2
        return None

    def _penalty(self, x: FloatArray, target: FloatArray, residual: FloatArray, weight: float) -> float:
        away = x - target
        return float(away @ apply(self.metric, away)) / 2 + weight * float(np.abs(residual).sum())
