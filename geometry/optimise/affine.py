"""Functionals of fewer unknowns: of y, where x = A y + b."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

from geometry.arrays import BoolArray, FloatArray, floats
from geometry.optimise.functional import Functional, SparseMatrix, apply

__all__ = ["AffineMap", "ComposedFunctional"]


@dataclass(frozen=True, eq=False)
class AffineMap:
    """y (k,) -> x = matrix y + offset (n,)."""

    matrix: SparseMatrix
    offset: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "offset", floats(self.offset))

    @classmethod
    def fixing(cls, x: FloatArray, held: BoolArray) -> AffineMap:
        """y: the entries of x (n,) that are not held; the others stay as they are in x, to the last bit."""
        return cls(csr_array(csr_array(eye_array(len(x)))[:, np.flatnonzero(~held)]), np.where(held, x, 0.0))

    @classmethod
    def scaling(cls, factor: float, offset: FloatArray) -> AffineMap:
        """x = factor y + offset, entry by entry."""
        return cls(csr_array(diags_array(np.full(len(offset), factor))), offset)

    def __call__(self, y: FloatArray) -> FloatArray:
        return apply(self.matrix, y) + self.offset


@dataclass(frozen=True, eq=False)
class ComposedFunctional:
    """y -> r(A y + b)."""

    functional: Functional
    map: AffineMap

    def residual(self, y: FloatArray) -> FloatArray:
        return self.functional.residual(self.map(y))

    def jacobian(self, y: FloatArray) -> SparseMatrix:
        return csr_array(self.functional.jacobian(self.map(y)) @ self.map.matrix)
