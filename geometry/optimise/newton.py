"""From a point to a nearby one on which constraints hold: Newton's method with a line search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray
from geometry.optimise.blocks import Blocks
from geometry.optimise.bounded_quadratic import minimise_bounded
from geometry.optimise.constrained_quadratic import ConstrainedQuadratic
from geometry.optimise.functional import Functional, LinearFunctional, SparseMatrix, apply, max_norm, normal_equations
from geometry.optimise.solution import Reason, Solution

__all__ = ["nearest_feasible"]

STEP_PENALTY = 1e8
"""Penalty of a linearised step: high, so that one solve makes most steps."""

STEP_ACCURACY = 1e-8
"""Violation a linearised step may leave, over what it finds: too little to slow quadratic convergence."""

MAX_STEP_CORRECTIONS = 20
"""Of a linearised step, one solve each, where constraints nearly contradict each other; elsewhere one or two do."""

MAX_LINE_SEARCH_HALVINGS = 12
"""How often a step may be halved in search of progress."""

MAX_ACTIVE_SET_ROUNDS = 6
"""How often inequalities that a step turns out to break may be added to it; the line search sees to the rest."""

SETTLED_MOVE_RATIO = 1e-4
"""Longest move in a step, over the longest allowed, below which the soft_terms are taken to be met."""


def nearest_feasible(
    constraint: Functional,
    start: FloatArray,
    metric: SparseMatrix,
    *,
    soft_terms: Sequence[tuple[float, Functional]] = (),
    inequality: Functional | None = None,
    least: float = 0.0,
    tolerance: float,
    longest_step: float,
    blocks: Blocks | None = None,
    anchored_steps: int,
    max_steps: int,
) -> Solution:
    """A point x with c(x) = 0 and, where asked, e(x) >= `least`, to `tolerance`, near to `start` (n,).

    Near: x - start is short in the metric (n, n), positive definite, and the sum of weight |r(x)|^2 over the soft terms
    is small. The first `anchored_steps` steps minimise both; each later one is the shortest step to c = 0, which
    converges quadratically. With soft terms, all anchored steps are made, unless they become short. No point of the
    blocks of x moves by more than `longest_step` in one step, so that the result does not depend on the orientation of
    the coordinate axes; without blocks, no entry of x does. A step is halved until it lowers an exact penalty function.

    The multipliers of the solution are those of c, then of the e that held the last step.
    """
    blocks = blocks or Blocks({"numbers": (len(start), 1)})
    problem = _Problem(constraint, inequality, least, metric, tuple(soft_terms), start, longest_step, blocks)
    here, multipliers, order = problem.state(start), np.zeros(0), None
    settled = not soft_terms
    for step in range(max_steps + 1):
        if here.violation <= tolerance and (settled or step >= anchored_steps):
            return Solution(here.x, multipliers, here.violation, step, Reason.CONVERGED)
        if step == max_steps:
            break
        held = step < anchored_steps
        move, found, order = problem.newton_step(here, held, order)
        if found.reason is Reason.INFEASIBLE:
            return Solution(here.x, multipliers, here.violation, step, Reason.INFEASIBLE)
        multipliers = found.multipliers
        moved = problem.search(here, move, held, multipliers)
        if moved is None and held:  # the pull back is in the way
            anchored_steps = 0
        elif moved is None:
            return Solution(here.x, multipliers, here.violation, step, Reason.STALLED)
        else:
            settled = settled or blocks.longest(moved.x - here.x) <= SETTLED_MOVE_RATIO * longest_step
            here = moved
    return Solution(here.x, multipliers, here.violation, max_steps, Reason.STEP_LIMIT)


@dataclass(frozen=True, eq=False)
class _State:
    """A point, c there, and how far e is below what is asked there."""

    x: FloatArray
    residual: FloatArray
    shortfall: FloatArray

    @property
    def violation(self) -> float:
        return max(max_norm(self.residual), max_norm(self.shortfall))


@dataclass(frozen=True, eq=False)
class _Problem:
    constraint: Functional
    inequality: Functional | None
    least: float
    metric: SparseMatrix
    soft_terms: tuple[tuple[float, Functional], ...]
    start: FloatArray
    longest_step: float
    blocks: Blocks

    def state(self, x: FloatArray) -> _State:
        values = np.zeros(0) if self.inequality is None else self.inequality.residual(x) - self.least
        return _State(x, self.constraint.residual(x), np.maximum(-values, 0.0))

    def newton_step(
        self, here: _State, held: bool, order: IntArray | None
    ) -> tuple[FloatArray, Solution, IntArray | None]:
        """The best move under the linearised constraints, cut to the longest step; where it comes from; and the order
        of elimination, which serves the next step too, as all have the same pattern."""
        H, g = self._model(here.x, held)
        jacobian = self.constraint.jacobian(here.x)
        tolerance = STEP_ACCURACY * max(here.violation, self.longest_step * SETTLED_MOVE_RATIO)
        quadratic = ConstrainedQuadratic(H, jacobian, STEP_PENALTY, order)
        found = quadratic.minimise(g, -here.residual, tolerance=tolerance, max_steps=MAX_STEP_CORRECTIONS)
        if self.inequality is not None:
            found = self._bounded(found, here.x, H, g, jacobian, -here.residual, tolerance)
        longest = max(self.longest_step, self.blocks.longest(found.x))
        return found.x * (self.longest_step / longest), found, quadratic.elimination

    def _model(self, x: FloatArray, held: bool) -> tuple[SparseMatrix, FloatArray]:
        """H and g of the objective d H d / 2 - g d of a move d, by Gauss-Newton. Not held: the length of the move."""
        pull = apply(self.metric, self.start - x)
        H = self.metric
        if self.soft_terms:
            linearised = [(w, LinearFunctional(f.jacobian(x), -f.residual(x))) for w, f in self.soft_terms]
            more, gradient = normal_equations(linearised)
            H, pull = csr_array(H + more), pull + gradient
        return H, pull if held else np.zeros(len(x))

    def _bounded(
        self,
        found: Solution,
        x: FloatArray,
        H: SparseMatrix,
        g: FloatArray,
        A: SparseMatrix,
        b: FloatArray,
        tolerance: float,
    ) -> Solution:
        """The same step, kept within those linearised inequalities that it would break."""
        assert self.inequality is not None
        values, rows = self.inequality.residual(x) - self.least, self.inequality.jacobian(x)
        asked = np.zeros(len(values), dtype=bool)
        for _ in range(MAX_ACTIVE_SET_ROUNDS):
            broken = values + apply(rows, found.x) < -tolerance
            if not (broken & ~asked).any():
                break
            asked |= broken
            lower = -values[asked]
            unlimited = np.full(len(lower), np.inf)
            found = minimise_bounded(H, g, A, b, csr_array(rows[asked]), lower, unlimited, tolerance=tolerance)
            if found.reason is Reason.INFEASIBLE:
                break
        return found

    def search(self, here: _State, move: FloatArray, held: bool, multipliers: FloatArray) -> _State | None:
        """The state at the first of x + move, x + move/2, ... that lowers the penalty function."""
        weight = 1.5 * max_norm(multipliers)  # above the largest: the penalty is exact
        origin = self.start if held else here.x
        before = self._penalty(here, origin, held, weight)
        for _ in range(MAX_LINE_SEARCH_HALVINGS):
            there = self.state(here.x + move)
            if self._penalty(there, origin, held, weight) < before:
                return there
            move = move / 2
        return None

    def _penalty(self, state: _State, origin: FloatArray, held: bool, weight: float) -> float:
        away = state.x - origin
        wished = sum(w * float(f.residual(state.x) @ f.residual(state.x)) for w, f in self.soft_terms) if held else 0.0
        violations = float(np.abs(state.residual).sum() + state.shortfall.sum())
        return (float(away @ apply(self.metric, away)) + wished) / 2 + weight * violations
