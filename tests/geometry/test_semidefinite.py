"""Minimisers where there are many, one or none, against dense linear algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from geometry.arrays import FloatArray
from geometry.optimise.semidefinite_quadratic import minimise_semidefinite
from geometry.optimise.solution import Reason

seeds = st.integers(0, 2**32 - 1)


def minimise(H: FloatArray, g: FloatArray, A: FloatArray, b: FloatArray, near: FloatArray):
    return minimise_semidefinite(csr_array(H), g, csr_array(A), b, near, accuracy=1e-12)


def random_problem(seed: int, n: int, m: int, rank: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """H of a rank with eigenvalues about 1, A with unit rows, two of them twice, and b that A reaches."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(n, rank)))[0]
    A = rng.normal(size=(m, n))
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    A = np.concatenate([A, A[:2]])
    return axes @ np.diag(rng.uniform(0.3, 2, rank)) @ axes.T, A, A @ rng.normal(size=n)


def nearest_minimiser(H: FloatArray, g: FloatArray, A: FloatArray, b: FloatArray, near: FloatArray) -> FloatArray:
    """By dense decompositions: of all x that satisfy the saddle point system the one nearest to `near`."""
    n, m = len(g), len(b)
    system = np.block([[H, A.T], [A, np.zeros((m, m))]])
    right = np.concatenate([g - H @ near, b - A @ near])
    x = np.linalg.lstsq(system, right, rcond=1e-10)[0][:n]
    flat = np.linalg.svd(np.concatenate([H, A]))
    null = flat[2][int((flat[1] > 1e-10).sum()) :]
    return near + x - null.T @ (null @ x)


@given(seeds, st.integers(1, 12), st.integers(2, 6), st.sampled_from([1e-4, 1.0, 1e4]), st.sampled_from([1e-3, 1e3]))
@example(seed=252910449, rank=2, m=3, x_size=1e-4, size=1e-3)  # where only rounding is left, a step may go far away
def test_the_nearest_of_all_minimisers_is_found(seed: int, rank: int, m: int, x_size: float, size: float) -> None:
    H, A, b = random_problem(seed, 12, m, rank)
    seen = np.linalg.svd(np.concatenate([H, A]), compute_uv=False)
    assume(not ((seen > 1e-12) & (seen < 1e-2)).any())  # either it counts or it does not
    rng = np.random.default_rng(seed + 1)
    g, near = H @ rng.normal(size=12) * x_size, rng.normal(size=12) * x_size
    found = minimise(size * H, size * g, A, x_size * b, near)
    assert found.reason is Reason.CONVERGED
    assert found.violation <= 1.001e-12 * max(np.abs(found.x).max(), x_size * np.abs(b).max())
    expected = nearest_minimiser(H, g, A, x_size * b, near)
    if rank >= 4:  # with less there are few directions to iterate in, and rounding has its way in all the others
        # rounding over squared least singular values of random matrices, and in directions without curvature
        np.testing.assert_allclose(found.x, expected, atol=1e-5 * np.abs(expected).max())
    gradient = size * (H @ found.x - g) + A.T @ found.multipliers
    np.testing.assert_allclose(gradient, 0, atol=1e-8 * size * max(np.abs(expected).max(), np.abs(found.x).max()))


@given(seeds)
def test_what_falls_without_end_is_reported(seed: int) -> None:
    H, A, b = random_problem(seed, 12, 4, 5)
    stacked = np.concatenate([H, A])
    flat = np.linalg.svd(stacked)[2][-1]  # 5 + 4 of 12 dimensions are held
    found = minimise(H, H @ np.ones(12) + 0.1 * flat, A, b, np.zeros(12))
    assert found.reason is Reason.UNBOUNDED


@given(seeds)
def test_something_linear_is_least_where_equations_leave_one_point_or_nowhere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    point, A = rng.normal(size=6), np.linalg.qr(rng.normal(size=(6, 6)))[0]
    zero, g = np.zeros((6, 6)), rng.normal(size=6)
    found = minimise(zero, g, A, A @ point, np.zeros(6))
    assert found.reason is Reason.CONVERGED
    np.testing.assert_allclose(found.x, point, atol=1e-11)
    assert minimise(zero, g, A[:5], A[:5] @ point, np.zeros(6)).reason is Reason.UNBOUNDED


@pytest.mark.parametrize("amount", [1e-4, 1.0])
def test_constraints_that_contradict_each_other_are_reported(amount: float) -> None:
    A = np.array([[1.0, 0.0], [1.0, 0.0]])
    found = minimise(np.eye(2), np.zeros(2), A, np.array([0.0, amount]), np.zeros(2))
    assert found.reason is Reason.INFEASIBLE
    assert found.violation == pytest.approx(amount / 2, rel=1e-3)  # the compromise


def test_a_minimiser_is_left_alone() -> None:
    H, A, b = random_problem(0, 12, 4, 5)
    start = nearest_minimiser(H, np.zeros(12), A, b, np.ones(12))
    found = minimise(H, np.zeros(12), A, b, start)
    np.testing.assert_allclose(found.x, start, atol=1e-11)


def test_a_step_limit_is_reported() -> None:
    H, A, b = random_problem(0, 12, 4, 12)
    found = minimise_semidefinite(csr_array(H), np.ones(12), csr_array(A), b, np.zeros(12), accuracy=1e-13, max_steps=0)
    assert found.reason is Reason.STEP_LIMIT
