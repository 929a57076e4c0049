"""From a functional to one that only speaks up below a bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from geometry.arrays import FloatArray
from geometry.optimise.functional import Functional, SparseMatrix

__all__ = ["Hinge"]


@dataclass(frozen=True, eq=False)
class Hinge:
    """x -> min(0, r(x) - least), entry by entry: how far r is below what it is to be at least.

    The Jacobian keeps its pattern: rows of entries that are above the bound are zeros.
    """

    functional: Functional
    least: float

    def residual(self, x: FloatArray) -> FloatArray:
        return np.minimum(self.functional.residual(x) - self.least, 0.0)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        below = (self.functional.residual(x) < self.least).astype(float)
        return csr_array(diags_array(below) @ self.functional.jacobian(x))
