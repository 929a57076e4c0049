"""Constrained minimisers against dense linear algebra and against problems with known answers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.optimise.affine import AffineMap, ComposedFunctional
from geometry.optimise.constrained_quadratic import minimise_quadratic
from geometry.optimise.functional import LinearFunctional, SparseMatrix, StackedFunctional, normal_equations
from geometry.optimise.newton import nearest_feasible
from geometry.optimise.solution import Reason, Solution

seeds = st.integers(0, 2**32 - 1)


def random_problem(seed: int, n: int = 8, m: int = 4) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """H positive definite with eigenvalues of 1 and more, g, A with unit rows, and b that A reaches."""
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(n, n))
    A = rng.normal(size=(m, n))
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    return half @ half.T + np.eye(n), rng.normal(size=n), A, A @ rng.normal(size=n)


def by_elimination(H: FloatArray, g: FloatArray, A: FloatArray, b: FloatArray) -> FloatArray:
    """The minimiser by a dense basis of the null space of A."""
    particular = np.linalg.lstsq(A, b)[0]
    _, values, rows = np.linalg.svd(A)
    null = rows[int((values > 1e-10).sum()) :].T
    return particular + null @ np.linalg.solve(null.T @ H @ null, null.T @ (g - H @ particular))


@given(seeds)
def test_quadratic_minimum_is_the_one_by_elimination(seed: int) -> None:
    H, g, A, b = random_problem(seed)
    solution = minimise_quadratic(csr_array(H), g, csr_array(A), b, tolerance=1e-12)
    assert solution.reason is Reason.CONVERGED
    assert np.abs(A @ solution.x - b).max() <= 1.001e-12  # summed in another order than by the solver
    # rounding, with room for the conditioning of random matrices; the penalty of 1e7 leaves no trace
    np.testing.assert_allclose(solution.x, by_elimination(H, g, A, b), atol=1e-10)
    np.testing.assert_allclose(H @ solution.x - g + A.T @ solution.multipliers, 0, atol=1e-11)


@given(seeds)
def test_dependent_constraints_do_no_harm(seed: int) -> None:
    H, g, A, b = random_problem(seed, m=3)
    doubled, both = np.concatenate([A, A[:2]]), np.concatenate([b, b[:2]])
    solution = minimise_quadratic(csr_array(H), g, csr_array(doubled), both, tolerance=1e-12)
    assert solution.reason is Reason.CONVERGED
    np.testing.assert_allclose(solution.x, by_elimination(H, g, A, b), atol=1e-5)


def test_constraints_that_hardly_differ_are_met_all_the_same() -> None:
    # singular values down to 1e-5: a fixed penalty with plain multiplier steps would need thousands of them
    n = 30
    rng = np.random.default_rng(0)
    left, right = (np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(2))
    A = left[:, :12] @ np.diag(np.geomspace(1, 1e-5, 12)) @ right[:12]
    b = A @ rng.normal(size=n)
    solution = minimise_quadratic(csr_array(eye_array(n)), np.zeros(n), csr_array(A), b, tolerance=1e-13)
    assert solution.reason is Reason.CONVERGED
    assert solution.steps < 40
    np.testing.assert_allclose(solution.x, np.linalg.lstsq(A, b)[0], atol=1e-7)  # 1e-13 over 1e-5, and room


def test_constraints_that_contradict_each_other_are_reported() -> None:
    A = np.array([[1.0, 0.0], [1.0, 0.0]])
    solution = minimise_quadratic(
        csr_array(eye_array(2)), np.zeros(2), csr_array(A), np.array([0.0, 1e-3]), tolerance=1e-12
    )
    assert solution.reason is Reason.STALLED
    assert solution.violation == pytest.approx(5e-4, rel=1e-3)  # the compromise


def test_a_step_limit_is_reported() -> None:
    H, g, A, b = random_problem(1)
    solution = minimise_quadratic(csr_array(H), g, csr_array(A), b, tolerance=0.0, max_steps=1)
    assert solution.reason is Reason.STEP_LIMIT


@given(seeds, st.floats(0.1, 10), st.floats(0.1, 10))
def test_normal_equations_are_the_gradient_of_the_weighted_squares(seed: int, first: float, second: float) -> None:
    rng = np.random.default_rng(seed)
    terms = [(w, LinearFunctional(csr_array(rng.normal(size=(5, 4))), rng.normal(size=5))) for w in (first, second)]
    H, g = normal_equations([(0.0, terms[0][1]), *terms])
    x = rng.normal(size=4)
    gradient = sum(w * (term.jacobian(x).T @ term.residual(x)) for w, term in terms)
    np.testing.assert_allclose(H @ x - g, gradient, atol=1e-12 * 100)  # sums of some ten numbers up to 100


class OnSphere:
    """c(x) = |x|^2 - r2: the sphere of radius sqrt(r2), empty for negative r2."""

    def __init__(self, squared_radius: float) -> None:
        self.squared_radius = squared_radius

    def residual(self, x: FloatArray) -> FloatArray:
        return np.array([x @ x - self.squared_radius])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return csr_array(2 * x[None, :])


def find(
    squared_radius: float, start: FloatArray, *, anchored_steps: int = 0, max_steps: int = 50, longest: float = 0.5
):
    return nearest_feasible(
        OnSphere(squared_radius),
        start,
        csr_array(eye_array(len(start))),
        tolerance=1e-13,
        longest_step=longest,
        anchored_steps=anchored_steps,
        max_steps=max_steps,
    )


@given(seeds, st.floats(0.3, 3.0), st.integers(0, 6))
def test_nearest_point_of_a_sphere(seed: int, distance: float, anchored_steps: int) -> None:
    normal = np.random.default_rng(seed).normal(size=5)
    normal /= np.linalg.norm(normal)
    solution = find(1.0, distance * normal, anchored_steps=anchored_steps)
    assert solution.reason is Reason.CONVERGED
    np.testing.assert_allclose(solution.x, normal, atol=1e-6)  # across the normal, penalty 1e8 times rounding
    assert abs(np.linalg.norm(solution.x) - 1) < 1e-13


def test_convergence_is_quadratic() -> None:
    start = np.array([1.3, 0.0])
    errors = []
    for steps in range(1, 4):
        errors.append(find(1.0, start, max_steps=steps).violation)
    assert errors[1] < errors[0] ** 1.5 < 1
    assert errors[2] < errors[1] ** 1.5


def test_no_coordinate_moves_further_than_allowed_in_one_step() -> None:
    solution = find(100.0, np.array([1.0, 0.2]), max_steps=1, longest=0.25)
    assert np.abs(solution.x - [1.0, 0.2]).max() == pytest.approx(0.25)
    assert solution.reason is Reason.STEP_LIMIT


@pytest.mark.parametrize("anchored_steps", [0, 8])
def test_an_empty_constraint_set_is_given_up(anchored_steps: int) -> None:
    solution = find(-1.0, np.array([0.3, 0.1]), anchored_steps=anchored_steps)
    assert solution.reason is not Reason.CONVERGED
    assert solution.violation >= 1.0


def test_a_point_from_which_no_direction_helps_is_given_up() -> None:
    solution = find(1.0, np.zeros(3))  # the centre of the sphere
    assert solution.reason is Reason.STALLED
    np.testing.assert_array_equal(solution.x, 0)


def test_a_feasible_start_is_left_alone() -> None:
    start = np.array([0.6, 0.8])
    solution = find(1.0, start)
    assert solution.steps == 0
    np.testing.assert_array_equal(solution.x, start)


# --- fewer unknowns, several functionals


@given(seeds)
def test_stacked_functionals_of_fewer_unknowns_have_the_derivatives_of_their_residuals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, held = rng.normal(size=6), rng.random(6) < 0.5
    linear = LinearFunctional(csr_array(rng.normal(size=(3, 6))), rng.normal(size=3))
    free = AffineMap.fixing(x, held)
    functional = ComposedFunctional(
        ComposedFunctional(StackedFunctional([OnSphere(2.0), linear]), AffineMap.scaling(3.0, rng.normal(size=6))), free
    )
    y, change = x[~held], rng.normal(size=int((~held).sum()))
    np.testing.assert_array_equal(free(y), x)
    np.testing.assert_array_equal(free(y + change)[held], x[held])
    # all residuals are quadratic, so central differences are exact up to rounding
    differences = (functional.residual(y + change) - functional.residual(y - change)) / 2
    np.testing.assert_allclose(functional.jacobian(y) @ change, differences, atol=1e-9)


@given(seeds, st.floats(0.01, 100.0))
def test_linear_soft_terms_are_weighed_against_the_distance_from_the_start(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    H, _, A, b = random_problem(seed)
    B, wanted, start = rng.normal(size=(5, 8)), rng.normal(size=5), rng.normal(size=8)
    solution = nearest_feasible(
        LinearFunctional(csr_array(A), b),
        start,
        csr_array(H),
        soft_terms=[(weight, LinearFunctional(csr_array(B), wanted))],
        tolerance=1e-12,
        longest_step=100.0,
        anchored_steps=20,
        max_steps=40,
    )
    assert solution.reason is Reason.CONVERGED
    expected = by_elimination(H + weight * B.T @ B, H @ start + weight * B.T @ wanted, A, b)
    # the penalty of 1e8 times rounding, and the conditioning of random matrices
    np.testing.assert_allclose(solution.x, expected, atol=1e-5)


def bounded(least: float, start: list[float]) -> Solution:
    """The point of the unit circle nearest to the start with a first coordinate of `least` and more."""
    return nearest_feasible(
        OnSphere(1.0),
        np.array(start),
        csr_array(eye_array(2)),
        inequality=LinearFunctional(csr_array([[1.0, 0.0]]), np.zeros(1)),
        lower_bound=least,
        tolerance=1e-12,
        longest_step=0.5,
        anchored_steps=8,
        max_steps=40,
    )


@given(st.floats(-0.9, 0.9), st.floats(-1.4, 1.4), st.floats(0.5, 1.5))
def test_inequalities_hold_where_they_are_asked_for(least: float, angle: float, distance: float) -> None:
    start = np.array([np.cos(angle), np.sin(angle)]) * distance
    solution = bounded(least, start.tolist())
    assert solution.reason is Reason.CONVERGED
    assert solution.x[0] >= least - 1e-12
    if np.cos(angle) < least:  # held by the bound
        expected = [least, np.copysign((1 - least**2) ** 0.5, np.sin(angle))]
        np.testing.assert_allclose(solution.x, expected, atol=1e-6)


def test_inequalities_that_contradict_the_equations_are_reported() -> None:
    solution = bounded(1.5, [0.9, 0.1])
    assert solution.reason is not Reason.CONVERGED
    assert solution.violation > 0.1
