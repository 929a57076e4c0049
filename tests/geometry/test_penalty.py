"""Minimising by a penalty that grows, on problems with known answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.optimise import LinearFunctional, Reason, SparseMatrix, StackedFunctional, minimise_by_penalty

PENALTIES = [10.0**k for k in range(1, 7)]


@dataclass(frozen=True)
class OnSpheres:
    """|x_k|^2 - 1 for points x (n, 3)."""

    n: int

    def residual(self, x: FloatArray) -> FloatArray:
        return np.square(x.reshape(-1, 3)).sum(axis=1) - 1.0

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return csr_array((2 * x, np.arange(3 * self.n), np.arange(0, 3 * self.n + 1, 3)), shape=(self.n, 3 * self.n))


@pytest.mark.parametrize("start", [[0.3, 0.0, 0.0], [0.0, 2.0, 0.1], [-1.0, 0.2, 0.1]])
def test_the_nearest_point_of_a_sphere_is_found_from_anywhere(start: list[float]) -> None:
    target = np.array([1.0, 2.0, 2.0])
    term = LinearFunctional(csr_array(eye_array(3)), target)
    metric = csr_array(1e-9 * eye_array(3))
    found = minimise_by_penalty(
        [(1.0, term)], metric, OnSpheres(1), np.array(start), penalties=PENALTIES, tolerance=1e-14, max_newton_steps=5
    )
    assert found.reason is Reason.CONVERGED
    assert found.violation <= 1e-14
    np.testing.assert_allclose(found.x, target / 3, atol=5e-3)  # three steps with each penalty


def test_what_only_the_metric_decides_stays_where_it_was() -> None:
    start = np.array([0.5, 0.5, 0.5, 4.0, 5.0, 6.0])
    sphere = OnSpheres(1)

    class First:
        def residual(self, x: FloatArray) -> FloatArray:
            return sphere.residual(x[:3])

        def jacobian(self, x: FloatArray) -> SparseMatrix:
            return csr_array(np.concatenate([2 * x[:3], np.zeros(3)])[None])

    term = LinearFunctional(csr_array(np.eye(6)[:1]), np.array([0.0]))
    metric = csr_array(1e-3 * eye_array(6))
    found = minimise_by_penalty(
        [(1.0, term)], metric, First(), start, penalties=PENALTIES, tolerance=1e-14, max_newton_steps=5
    )
    assert found.reason is Reason.CONVERGED
    np.testing.assert_allclose(found.x[3:], start[3:], atol=1e-9)
    assert abs(found.x[0]) < 1e-2


@pytest.mark.parametrize("apart", [1e-4, 0.0])
def test_constraints_that_nearly_or_quite_repeat_each_other_do_no_harm(apart: float) -> None:
    rows = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, apart]])
    constraint = StackedFunctional([OnSpheres(1), LinearFunctional(csr_array(rows), np.array([1.0, 1.0]))])
    term = LinearFunctional(csr_array(eye_array(3)), np.array([1.0, 0.0, 0.0]))
    found = minimise_by_penalty(
        [(1.0, term)],
        csr_array(1e-6 * eye_array(3)),
        constraint,
        np.array([0.9, 0.3, 0.0]),
        penalties=PENALTIES,
        tolerance=1e-12,
        max_newton_steps=6,
    )
    assert found.reason is Reason.CONVERGED
    np.testing.assert_allclose(found.x, [1.0, 0.0, 0.0], atol=1e-6)


def test_constraints_that_contradict_each_other_end_after_the_allowed_steps() -> None:
    rows = np.array([[1.0, 0.0], [1.0, 0.0]])
    constraint = LinearFunctional(csr_array(rows), np.array([0.0, 1.0]))
    term = LinearFunctional(csr_array(eye_array(2)), np.zeros(2))
    found = minimise_by_penalty(
        [(1.0, term)],
        csr_array(eye_array(2)),
        constraint,
        np.zeros(2),
        penalties=PENALTIES,
        tolerance=1e-12,
        max_newton_steps=3,
    )
    assert found.reason is Reason.STEP_LIMIT
    assert found.steps == 3
    assert found.violation == pytest.approx(0.5, abs=1e-3)
