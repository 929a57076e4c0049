"""Minimisers under equations and bounds, judged by the conditions of Karush, Kuhn and Tucker and by closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.optimise import bounded_quadratic
from geometry.optimise.bounded_quadratic import minimise_bounded
from geometry.optimise.constrained_quadratic import minimise_quadratic
from geometry.optimise.solution import Reason, Solution

seeds = st.integers(0, 2**32 - 1)
scales = st.sampled_from([1e-5, 1.0, 1e5])


def minimise(H: FloatArray, g: FloatArray, lower: FloatArray, upper: FloatArray) -> Solution:
    """Under bounds on each unknown."""
    n = len(g)
    identity = csr_array(eye_array(n))
    return minimise_bounded(
        csr_array(H), g, csr_array((0, n)), np.zeros(0), identity, lower, upper, tolerance=1e-12 * np.abs(g).max()
    )


@given(seeds, scales, scales, st.integers(1, 20))
def test_conditions_of_a_minimum(seed: int, x_size: float, size: float, rank: int) -> None:
    rng = np.random.default_rng(seed)
    n, m, k = 20, 5, 12
    half = rng.normal(size=(n, rank)) / np.sqrt(rank)
    H = half @ half.T * size
    A, G = rng.normal(size=(m, n)), rng.normal(size=(k, n))
    A, G = (rows / np.linalg.norm(rows, axis=1, keepdims=True) for rows in (A, G))
    feasible = rng.normal(size=n) * x_size
    lower, upper = (G @ feasible + sign * rng.uniform(0, 0.3, k) * x_size for sign in (-1, 1))
    lower[:3], upper[3:5], lower[5] = -np.inf, np.inf, upper[5]
    g = H @ rng.normal(size=n) * (3 * x_size)  # in the range of H: there is a minimum
    A = np.concatenate([A, A[:2]])  # dependent rows
    found = minimise_bounded(
        csr_array(H), g, csr_array(A), A @ feasible, csr_array(G), lower, upper, tolerance=1e-12 * x_size
    )
    assume(np.abs(found.x).max() < 100 * x_size)  # of many minimisers, one far away may be found, and rounds more
    assert found.reason is Reason.CONVERGED
    assert np.abs(A @ found.x - A @ feasible).max() <= 1.001e-12 * x_size  # summed in another order
    values = G @ found.x
    assert (values - upper).max() <= 1.001e-12 * x_size >= (lower - values).max()
    gradient = H @ found.x - g + np.concatenate([A, G]).T @ found.multipliers
    assert np.abs(gradient).max() <= 1e-9 * size * x_size  # rounding in terms of up to 100
    # a multiplier only where a bound holds, and of its sign
    of_bounds = found.multipliers[len(A) :]
    free = (values < upper - 1e-6 * x_size) & (values > lower + 1e-6 * x_size)
    assert np.abs(of_bounds[free]).max(initial=0.0) <= 1e-6 * size * x_size
    one_sided = lower < upper
    assert (of_bounds[one_sided & (values < upper - 1e-6 * x_size)] <= 1e-8 * size * x_size).all()
    assert (of_bounds[one_sided & (values > lower + 1e-6 * x_size)] >= -1e-8 * size * x_size).all()


@given(seeds, scales)
def test_nearest_point_of_a_box_is_the_clipped_point(seed: int, size: float) -> None:
    g = np.random.default_rng(seed).normal(size=6) * size
    found = minimise(np.eye(6), g, np.full(6, -0.5 * size), np.full(6, 0.25 * size))
    np.testing.assert_allclose(found.x, np.clip(g, -0.5 * size, 0.25 * size), atol=1e-12 * size)


@given(seeds)
def test_linear_programmes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = 8, 3
    A, g = rng.normal(size=(m, n)), rng.normal(size=n)
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    b = A @ rng.uniform(0, 1, n)
    found = minimise_bounded(
        csr_array((n, n)), g, csr_array(A), b, csr_array(eye_array(n)), np.zeros(n), np.ones(n), tolerance=1e-12
    )
    assert found.reason is Reason.CONVERGED
    judge = linprog(-g, A_eq=A, b_eq=b, bounds=(0, 1))
    assert -g @ found.x == pytest.approx(judge.fun, abs=1e-6)  # the judge's own tolerance is 1e-7


def test_without_bounds_it_is_the_minimiser_under_equations() -> None:
    rng = np.random.default_rng(0)
    A, g = csr_array(rng.normal(size=(3, 10)) / 3), rng.normal(size=10)
    H, b = csr_array(eye_array(10)), rng.normal(size=3)
    free = np.full(10, np.inf)
    found = minimise_bounded(H, g, A, b, H, -free, free, tolerance=1e-12)
    np.testing.assert_allclose(found.x, minimise_quadratic(H, g, A, b, tolerance=1e-12).x, atol=1e-12)


def test_bounds_that_leave_nothing_are_reported() -> None:
    A = csr_array(np.ones((1, 3)) / 3)
    found = minimise_bounded(
        csr_array(eye_array(3)),
        np.zeros(3),
        A,
        np.array([2.0]),
        csr_array(eye_array(3)),
        np.zeros(3),
        np.ones(3),
        tolerance=1e-12,
    )
    assert found.reason is Reason.INFEASIBLE


@pytest.mark.parametrize("H", [np.zeros((2, 2)), np.diag([1.0, 0.0])])
def test_a_function_without_least_value_is_reported(H: FloatArray) -> None:
    found = minimise(H, np.array([0.0, 1.0]), np.zeros(2), np.array([1.0, np.inf]))
    assert found.reason is Reason.UNBOUNDED


@given(seeds, st.integers(2, 6), st.floats(0.01, 1e3))
def test_falling_for_ever_between_bounds_is_reported_and_a_far_minimum_found(seed: int, n: int, far: float) -> None:
    rng = np.random.default_rng(seed)
    away = rng.normal(size=n)
    away /= np.linalg.norm(away)
    G = rng.normal(size=(2 * n, n))
    G *= np.sign(G @ away)[:, None]  # no lower bound is in the way
    across = np.eye(n) - np.outer(away, away)
    H = csr_array(across @ np.diag(rng.uniform(1, 2, n)) @ across)
    g = H @ rng.normal(size=n) + away
    lower, free = np.full(2 * n, -1.0), np.full(2 * n, np.inf)
    nothing = csr_array((0, n)), np.zeros(0)
    found = minimise_bounded(H, g, *nothing, csr_array(G), lower, free, tolerance=1e-9)
    assert found.reason is Reason.UNBOUNDED
    G, lower, upper = np.vstack([G, away]), np.append(lower, -1.0), np.append(free, far)
    found = minimise_bounded(H, g, *nothing, csr_array(G), lower, upper, tolerance=1e-9 * max(1, far))
    assert found.reason is Reason.CONVERGED
    assert away @ found.x == pytest.approx(far, rel=1e-6)


def test_a_step_limit_is_reported() -> None:
    rng = np.random.default_rng(0)
    n = 40
    half, bound = rng.normal(size=(n, n)), np.full(n, 0.1)
    problem = csr_array(half @ half.T), 10 * rng.normal(size=n), csr_array((0, n)), np.zeros(0), csr_array(eye_array(n))
    assert minimise_bounded(*problem, -bound, bound, tolerance=1e-12).reason is Reason.CONVERGED
    assert minimise_bounded(*problem, -bound, bound, tolerance=1e-12, max_steps=2).reason is Reason.STEP_LIMIT


def test_a_polish_that_is_feasible_but_worse_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    def at_zero(problem: object, above: object, below: object, near: Solution) -> Solution:
        return replace(near, x=np.zeros(3), violation=0.0)

    monkeypatch.setattr(bounded_quadratic._Problem, "with_active_bounds", at_zero)
    found = minimise(np.eye(3), np.array([2.0, 0.5, -0.5]), np.full(3, -1.0), np.ones(3))
    np.testing.assert_allclose(found.x, [1.0, 0.5, -0.5], atol=1e-9)


def test_active_bounds_hold_to_rounding() -> None:
    rng = np.random.default_rng(1)
    half = rng.normal(size=(20, 20))
    H, g = half @ half.T / 20 + np.eye(20) / 10, rng.normal(size=20)
    found = minimise(H, g, np.full(20, -1.0), np.ones(20))
    at_bound = np.abs(found.x) > 1 - 1e-6
    assert 3 < at_bound.sum() < 17
    np.testing.assert_allclose(np.abs(found.x[at_bound]), 1.0, atol=1e-15)
    # the gradient is left at 1e-11 of the size of its terms, about 1: further down there is rounding
    np.testing.assert_allclose((H @ found.x - g)[~at_bound], 0, atol=1e-11)
