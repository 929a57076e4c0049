"""Factors of sparse positive definite matrices, and the order in which they eliminate."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array, kron

from geometry.optimise.functional import SparseMatrix
from geometry.optimise.saddle_point import factorise

seeds = st.integers(0, 2**32 - 1)


def random_matrix(seed: int, n: int = 30) -> SparseMatrix:
    rng = np.random.default_rng(seed)
    half = csr_array(np.where(rng.uniform(size=(n, n)) < 0.1, rng.normal(size=(n, n)), 0.0))
    return csr_array(half @ half.T + eye_array(n))


@given(seeds)
def test_an_earlier_order_leads_to_the_same_solution(seed: int) -> None:
    matrix, later = random_matrix(seed), random_matrix(seed)
    later.data = later.data * 2.0
    values = np.random.default_rng(seed).normal(size=(30, 2))
    first = factorise(matrix)
    again = factorise(later, order=first.elimination)
    np.testing.assert_allclose(matrix @ first.solve(values), values, atol=1e-12)  # rounding
    np.testing.assert_allclose(later @ again.solve(values), values, atol=1e-12)
    np.testing.assert_allclose(later @ again.solve(values[:, 0]), values[:, 0], atol=1e-12)
    np.testing.assert_array_equal(again.elimination, first.elimination)


def test_an_earlier_order_keeps_factors_sparse() -> None:
    n = 40
    path = csr_array(2.1 * eye_array(n) - eye_array(n, k=1) - eye_array(n, k=-1))
    grid = csr_array(kron(path, eye_array(n)) + kron(eye_array(n), path))
    first = factorise(grid)
    assert factorise(grid, order=first.elimination).lu.nnz <= 1.05 * first.lu.nnz  # ties of its own in between
    assert factorise(grid, order=np.arange(n * n)).lu.nnz > 1.5 * first.lu.nnz
