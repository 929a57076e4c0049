"""A nearby point on which constraints hold, by Newton's method with a line search."""

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
"""Penalty of a linearised step; high, so that one solve is enough for most steps."""

STEP_ACCURACY = 1e-8
"""Violation that a linearised step may leave, over the violation before: too little to slow quadratic convergence."""

MAX_STEP_CORRECTIONS = 20
"""Corrections of a linearised step, one solve each. Most need one or two, nearly contradictory constraints more."""

MAX_LINE_SEARCH_HALVINGS = 12
"""Halvings of a step in the line search before the solver gives up."""

MAX_ACTIVE_SET_ROUNDS = 6
"""Rounds in which inequalities that a step violates are added to its problem; the line search handles the others."""

SETTLED_MOVE_RATIO = 1e-4
"""Longest move in a step, over the longest one allowed, below which the soft terms count as minimised."""


def nearest_feasible(
    constraint: Functional,
    start: FloatArray,
    metric: SparseMatrix,
    *,
    soft_terms: Sequence[tuple[float, Functional]] = (),
    inequality: Functional | None = None,
    lower_bound: float = 0.0,
    tolerance: float,
    longest_step: float,
    blocks: Blocks | None = None,
    anchored_steps: int,
    max_steps: int,
) -> Solution:
    """A point x near `start` (n,) with c(x) = 0 and, if there is an inequality, e(x) >= `lower_bound`, to `tolerance`.

    Near: x - start is short in the metric (n, n), positive definite, and the sum of weight |r(x)|^2 over the soft terms
    is small. The first `anchored_steps` steps minimise both; each later one is the shortest step to c = 0, which
    converges quadratically. With soft terms, all anchored steps are made, unless they become short. No point of the
    blocks of x moves by more than `longest_step` in one step, so that the result does not depend on the orientation of
    the coordinate axes; without blocks, no entry of x does. A step is halved until it lowers an exact penalty function.

    The multipliers of the solution are those of c, then those of the inequalities that were active in the last step.

    >>> class OnUnitCircle:
    ...     def residual(self, x):
    ...         return np.array([x @ x - 1])
    ...     def jacobian(self, x):
    ...         return csr_array(2 * x[None])
    >>> found = nearest_feasible(
    ...     OnUnitCircle(), np.array([3.0, 4.0]), csr_array(np.eye(2)),
    ...     tolerance=1e-12, longest_step=1.0, anchored_steps=8, max_steps=30,
    ... )
    >>> found.x.round(6).tolist(), found.reason.name
    ([0.6, 0.8], 'CONVERGED')
    """
    blocks = blocks or Blocks({"numbers": (len(start), 1)})
    problem = _Problem(constraint, inequality, lower_bound, metric, tuple(soft_terms), start, longest_step, blocks)
    here, multipliers, order = problem.state(start), np.zeros(0), None
    soft_terms_settled = not soft_terms
    for step in range(max_steps + 1):
        if here.violation <= tolerance and (soft_terms_settled or step >= anchored_steps):
            return Solution(here.x, multipliers, here.violation, step, Reason.CONVERGED)
        if step == max_steps:
            break
        anchored = step < anchored_steps
        move, found, order = problem.newton_step(here, anchored, order)
        if found.reason is Reason.INFEASIBLE:
            return Solution(here.x, multipliers, here.violation, step, Reason.INFEASIBLE)
        multipliers = found.multipliers
        moved = problem.search(here, move, anchored, multipliers)
        if moved is None and anchored:  # terms that draw x back to the start prevent progress
            anchored_steps = 0
        elif moved is None:
            return Solution(here.x, multipliers, here.violation, step, Reason.STALLED)
        else:
            soft_terms_settled = (
                soft_terms_settled or blocks.longest_point(moved.x - here.x) <= SETTLED_MOVE_RATIO * longest_step
            )
            here = moved
    return Solution(here.x, multipliers, here.violation, max_steps, Reason.STEP_LIMIT)


@dataclass(frozen=True, eq=False)
class _State:
    """A point x, c(x), and how far e(x) is below its lower bound."""

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
    lower_bound: float
    metric: SparseMatrix
    soft_terms: tuple[tuple[float, Functional], ...]
    start: FloatArray
    longest_step: float
    blocks: Blocks

    def state(self, x: FloatArray) -> _State:
        values = np.zeros(0) if self.inequality is None else self.inequality.residual(x) - self.lower_bound
        return _State(x, self.constraint.residual(x), np.maximum(-values, 0.0))

    def newton_step(
        self, here: _State, anchored: bool, order: IntArray | None
    ) -> tuple[FloatArray, Solution, IntArray | None]:
        """The best move under the linearised constraints, shortened to the longest step; the solution of its problem;
        and the order of elimination, which the next step reuses, since all steps have the same sparsity pattern."""
        H, g = self._model(here.x, anchored)
        jacobian = self.constraint.jacobian(here.x)
        tolerance = STEP_ACCURACY * max(here.violation, self.longest_step * SETTLED_MOVE_RATIO)
        quadratic = ConstrainedQuadratic(H, jacobian, STEP_PENALTY, order)
        found = quadratic.minimise(g, -here.residual, tolerance=tolerance, max_steps=MAX_STEP_CORRECTIONS)
        if self.inequality is not None:
            found = self._bounded(found, here.x, H, g, jacobian, -here.residual, tolerance)
        longest = max(self.longest_step, self.blocks.longest_point(found.x))
        return found.x * (self.longest_step / longest), found, quadratic.elimination

    def _model(self, x: FloatArray, anchored: bool) -> tuple[SparseMatrix, FloatArray]:
        """H and g of the objective d H d / 2 - g d of a move d, by Gauss-Newton; g = 0 where it is not anchored."""
        slope = apply(self.metric, self.start - x)
        H = self.metric
        if self.soft_terms:
            linearised = [(w, LinearFunctional(f.jacobian(x), -f.residual(x))) for w, f in self.soft_terms]
            more, gradient = normal_equations(linearised)
            H, slope = csr_array(H + more), slope + gradient
        return H, slope if anchored else np.zeros(len(x))

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
        """The same step under those linearised inequalities that it would violate."""
        assert self.inequality is not None
        values, rows = self.inequality.residual(x) - self.lower_bound, self.inequality.jacobian(x)
        active = np.zeros(len(values), dtype=bool)
        for _ in range(MAX_ACTIVE_SET_ROUNDS):
            violated = values + apply(rows, found.x) < -tolerance
            if not (violated & ~active).any():
                break
            active |= violated
            lower = -values[active]
            unlimited = np.full(len(lower), np.inf)
            found = minimise_bounded(H, g, A, b, csr_array(rows[active]), lower, unlimited, tolerance=tolerance)
            if found.reason is Reason.INFEASIBLE:
                break
        return found

    def search(self, here: _State, move: FloatArray, anchored: bool, multipliers: FloatArray) -> _State | None:
        """The state at the first of x + move, x + move/2, ... that lowers the penalty function."""
        weight = 1.5 * max_norm(multipliers)  # above the largest: the penalty is exact
        origin = self.start if anchored else here.x
        before = self._penalty(here, origin, anchored, weight)
        for _ in range(MAX_LINE_SEARCH_HALVINGS):
            there = self.state(here.x + move)
            if self._penalty(there, origin, anchored, weight) < before:
                return there
            move = move / 2
        return None

    def _penalty(self, state: _State, origin: FloatArray, anchored: bool, weight: float) -> float:
        move = state.x - origin
        soft = (
            sum(w * float(f.residual(state.x) @ f.residual(state.x)) for w, f in self.soft_terms) if anchored else 0.0
        )
        violations = float(np.abs(state.residual).sum() + state.shortfall.sum())
        return (float(move @ apply(self.metric, move)) + soft) / 2 + weight * violations
