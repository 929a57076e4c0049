"""Functionals of other unknowns y, where x = A y + b."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

from geometry.arrays import BoolArray, FloatArray, floats
from geometry.optimise.functional import Functional, SparseMatrix, apply

__all__ = ["AffineMap", "ComposedFunctional"]


@dataclass(frozen=True, eq=False)
class AffineMap:
    """y (k,) -> x = matrix y + offset (n,).

    >>> x, is_fixed = np.array([1.0, 2.0, 3.0]), np.array([True, False, False])
    >>> AffineMap.fixing(x, is_fixed)(np.array([7.0, 8.0])).tolist()
    [1.0, 7.0, 8.0]
    """

    matrix: SparseMatrix
    offset: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "offset", floats(self.offset))

    @classmethod
    def fixing(cls, x: FloatArray, is_fixed: BoolArray) -> AffineMap:
        """y: the entries of x (n,) that are not fixed; the others keep their values exactly."""
        return cls(csr_array(csr_array(eye_array(len(x)))[:, np.flatnonzero(~is_fixed)]), np.where(is_fixed, x, 0.0))

    @classmethod
    def scaling(cls, factor: float, offset: FloatArray) -> AffineMap:
        """x = factor y + offset, entry by entry."""
        return cls(csr_array(diags_array(np.full(len(offset), factor))), offset)

    def __call__(self, y: FloatArray) -> FloatArray:
        return apply(self.matrix, y) + self.offset


@dataclass(frozen=True, eq=False)
class ComposedFunctional:
    """y -> r(A y + b), the functional after the affine map.

    >>> from geometry.optimise import LinearFunctional
    >>> r = LinearFunctional(csr_array(np.eye(2)), np.array([1.0, 1.0]))
    >>> doubled = ComposedFunctional(r, AffineMap.scaling(2.0, np.zeros(2)))
    >>> doubled.residual(np.array([3.0, 4.0])).tolist(), doubled.jacobian(np.zeros(2)).diagonal().tolist()
    ([5.0, 7.0], [2.0, 2.0])
    """

    functional: Functional
    map: AffineMap

    def residual(self, y: FloatArray) -> FloatArray:
        return self.functional.residual(self.map(y))

    def jacobian(self, y: FloatArray) -> SparseMatrix:
        return csr_array(self.functional.jacobian(self.map(y)) @ self.map.matrix)
