"""What is asked of an unknown vector x (n,), as residuals: |r(x)|^2 is made small, or r(x) = 0 is demanded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from scipy.sparse import csr_array, vstack

from geometry.arrays import FloatArray, floats

__all__ = [
    "Functional",
    "LinearFunctional",
    "SparseMatrix",
    "StackedFunctional",
    "apply",
    "max_norm",
    "normal_equations",
]

SparseMatrix: TypeAlias = "csr_array[np.float64, tuple[int, int]]"


def apply(matrix: SparseMatrix, x: FloatArray) -> FloatArray:
    """The product (m,) of a sparse matrix (m, n) and a vector (n,)."""
    return np.asarray(matrix @ x)


def max_norm(values: FloatArray) -> float:
    """The largest absolute value; zero of none."""
    return float(np.abs(values).max(initial=0.0))


class Functional(Protocol):
    """Residuals r(x) (m,) and their Jacobian (m, n), sparse."""

    def residual(self, x: FloatArray) -> FloatArray: ...

    def jacobian(self, x: FloatArray) -> SparseMatrix: ...


@dataclass(frozen=True, eq=False)
class LinearFunctional:
    """r(x) = matrix x - target: |r|^2 is quadratic."""

    matrix: SparseMatrix
    target: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", floats(self.target))

    def residual(self, x: FloatArray) -> FloatArray:
        return apply(self.matrix, x) - self.target

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return self.matrix


@dataclass(frozen=True, eq=False)
class StackedFunctional:
    """The residuals of several functionals of the same unknowns, one after the other."""

    parts: Sequence[Functional]

    def residual(self, x: FloatArray) -> FloatArray:
        return np.concatenate([part.residual(x) for part in self.parts])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return csr_array(vstack([part.jacobian(x) for part in self.parts], format="csr"))


def normal_equations(terms: Iterable[tuple[float, LinearFunctional]]) -> tuple[SparseMatrix, FloatArray]:
    """H (n, n) and g (n,) such that the sum of weight |r(x)|^2 over the terms is x H x - 2 g x + constant.

    Terms of weight zero are left out, so that they cost nothing; at least one weight must be positive.
    """
    kept = [(weight, term) for weight, term in terms if weight > 0]
    hessian, gradient = _quadratic(*kept[0])
    for weight, term in kept[1:]:
        more_hessian, more_gradient = _quadratic(weight, term)
        hessian, gradient = csr_array(hessian + more_hessian), gradient + more_gradient
    return hessian, gradient


def _quadratic(weight: float, term: LinearFunctional) -> tuple[SparseMatrix, FloatArray]:
    transposed = csr_array(term.matrix.T)
    return csr_array(weight * (transposed @ term.matrix)), weight * apply(transposed, term.target)
