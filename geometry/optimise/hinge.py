"""A functional that is zero where another one is above a lower bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from geometry.arrays import FloatArray
from geometry.optimise.functional import Functional, SparseMatrix

__all__ = ["Hinge"]


@dataclass(frozen=True, eq=False)
class Hinge:
    """x -> min(0, r(x) - lower_bound), entry by entry: how far r is below the bound, one number or one for each entry.

    The sparsity pattern of the Jacobian does not depend on x: rows of entries above the bound are stored as zeros.

    >>> from geometry.optimise import LinearFunctional
    >>> hinge = Hinge(LinearFunctional(csr_array(np.eye(3)), np.zeros(3)), lower_bound=1.0)
    >>> hinge.residual(np.array([0.25, 1.0, 5.0])).tolist()
    [-0.75, 0.0, 0.0]
    """

    functional: Functional
    lower_bound: float | FloatArray

    def residual(self, x: FloatArray) -> FloatArray:
        return np.minimum(self.functional.residual(x) - self.lower_bound, 0.0)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        below = (self.functional.residual(x) < self.lower_bound).astype(float)
        return csr_array(diags_array(below) @ self.functional.jacobian(x))
