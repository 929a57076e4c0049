"""Residuals r(x) of an unknown vector x (n,): |r(x)|^2 is minimised, or r(x) = 0 is a constraint."""

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
    """The product (m,) of a sparse matrix (m, n) and a vector (n,).

    >>> apply(csr_array(np.diag([1.0, 2.0])), np.array([3.0, 4.0])).tolist()
    [3.0, 8.0]
    """
    return np.asarray(matrix @ x)


def max_norm(values: FloatArray) -> float:
    """The largest absolute value; 0 for an empty array.

    >>> max_norm(np.array([3.0, -4.0])), max_norm(np.zeros(0))
    (4.0, 0.0)
    """
    return float(np.abs(values).max(initial=0.0))


class Functional(Protocol):
    """Residuals r(x) (m,) and their Jacobian (m, n), sparse: what any functional provides.

    >>> class OnUnitCircle:
    ...     def residual(self, x):
    ...         return np.array([x @ x - 1])
    ...     def jacobian(self, x):
    ...         return csr_array(2 * x[None])
    >>> both: Functional = StackedFunctional([OnUnitCircle(), OnUnitCircle()])
    >>> both.residual(np.array([1.0, 1.0])).tolist()
    [1.0, 1.0]
    """

    def residual(self, x: FloatArray) -> FloatArray: ...

    def jacobian(self, x: FloatArray) -> SparseMatrix: ...


@dataclass(frozen=True, eq=False)
class LinearFunctional:
    """r(x) = matrix x - target, so that |r|^2 is quadratic.

    >>> r = LinearFunctional(csr_array(np.diag([1.0, 2.0])), np.array([1.0, 1.0]))
    >>> r.residual(np.array([1.0, 1.0])).tolist()
    [0.0, 1.0]
    """

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
    """The residuals of several functionals of the same unknowns, one after the other.

    >>> r = LinearFunctional(csr_array(np.eye(2)), np.array([1.0, 2.0]))
    >>> StackedFunctional([r, r]).residual(np.zeros(2)).tolist()
    [-1.0, -2.0, -1.0, -2.0]
    """

    parts: Sequence[Functional]

    def residual(self, x: FloatArray) -> FloatArray:
        return np.concatenate([part.residual(x) for part in self.parts])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return csr_array(vstack([part.jacobian(x) for part in self.parts], format="csr"))


def normal_equations(terms: Iterable[tuple[float, LinearFunctional]]) -> tuple[SparseMatrix, FloatArray]:
    """H (n, n) and g (n,) such that the sum of weight |r(x)|^2 over the terms is x H x - 2 g x + constant.

    Terms of weight zero are skipped; at least one weight must be positive.

    >>> r = LinearFunctional(csr_array(np.eye(2)), np.array([1.0, 2.0]))
    >>> H, g = normal_equations([(3.0, r), (0.0, r)])
    >>> H.toarray().tolist(), g.tolist()
    ([[3.0, 0.0], [0.0, 3.0]], [3.0, 6.0])
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
