"""The solver for large quadratics, judged by dense linear algebra and by the one for small ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array, random_array, vstack

from geometry.arrays import FloatArray
from geometry.gauss import approximate_pair
from geometry.mesh import shapes
from geometry.optimise import constrained_quadratic, saddle_point
from geometry.optimise.constrained_quadratic import minimise_quadratic
from geometry.optimise.functional import SparseMatrix
from geometry.optimise.solution import Reason, Solution

seeds = st.integers(0, 2**32 - 1)


def problem(seed: int, n: int = 30, m: int = 12) -> tuple[SparseMatrix, SparseMatrix, np.random.Generator]:
    """H positive definite and A with rows of unit length, the last of which is the sum of the first two."""
    rng = np.random.default_rng(seed)
    root = random_array((n, n), density=0.1, rng=rng, data_sampler=rng.standard_normal)
    H = csr_array(root @ root.T + np.diag(rng.uniform(0.5, 2, n)))
    A = rng.standard_normal((m, n)) * (rng.random((m, n)) < 0.3) + 0.1 * np.eye(m, n)
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    return H, csr_array(vstack([csr_array(A), csr_array(A[:1] + A[1:2])])), rng


def minimised(H: SparseMatrix, g: FloatArray, A: SparseMatrix, b: FloatArray) -> Solution:
    """As if the problem were large."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(constrained_quadratic, "SINGLE_PRECISION_UNKNOWNS", 0)
        return minimise_quadratic(H, g, A, b, tolerance=1e-12)


@given(seeds)
def test_it_solves_the_equations_of_the_minimiser(seed: int) -> None:
    H, A, rng = problem(seed)
    g, b = rng.standard_normal(H.shape[0]), A @ rng.standard_normal(H.shape[0])
    solution = minimised(H, g, A, b)
    assert solution.reason is Reason.CONVERGED
    assert np.abs(A @ solution.x - b).max() == solution.violation <= 1e-12
    full = np.block([[H.toarray(), A.toarray().T], [A.toarray(), np.zeros((A.shape[0], A.shape[0]))]])
    expected = np.linalg.lstsq(full, np.concatenate([g, b]), rcond=1e-12)[0][: len(g)]
    # the gradient is as good as the violation times sqrt(w), about 1e3; H is no worse conditioned than 1e2
    assert np.abs(solution.x - expected).max() < 1e-7
    assert np.abs(H @ solution.x + A.T @ solution.multipliers - g).max() < 1e-7


@given(seeds)
def test_contradicting_equations_stall(seed: int) -> None:
    H, A, rng = problem(seed)
    b = A @ rng.standard_normal(H.shape[0])
    b[-1] += 1.0  # the last row is the sum of the first two
    solution = minimised(H, np.zeros(H.shape[0]), A, b)
    assert solution.reason is not Reason.CONVERGED
    assert solution.violation > 0.1


def test_large_problems_are_factored_in_single_precision_and_small_ones_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    H, A, rng = problem(0)
    g, b = rng.standard_normal(H.shape[0]), A @ rng.standard_normal(H.shape[0])
    small = minimise_quadratic(H, g, A, b, tolerance=1e-13)
    asked = []
    factorise = saddle_point.factorise
    monkeypatch.setattr(
        saddle_point, "factorise", lambda K, *, single: asked.append(single) or factorise(K, single=single)
    )
    assert np.abs(small.x - minimised(H, g, A, b).x).max() < 1e-8
    assert asked == [True]


def test_a_gauss_image_is_the_same_either_way(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = shapes.dome(40, 30)
    small = approximate_pair(mesh).gauss_image
    monkeypatch.setattr(constrained_quadratic, "SINGLE_PRECISION_UNKNOWNS", 0)
    # the single-precision way stops at a gradient of about 1e-10, which is what separates the two
    assert np.abs(approximate_pair(mesh).gauss_image.vertices - small.vertices).max() < 1e-9
