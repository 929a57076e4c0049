"""A functional that is zero where another one is between two bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from geometry.arrays import FloatArray
from geometry.optimise.functional import Functional, SparseMatrix

__all__ = ["Hinge"]


@dataclass(frozen=True, eq=False)
class Hinge:
    """How far r(x) is below the lower bound, negative, or above the upper one, positive; entry by entry. Bounds are one
    number, or one for each entry.

    The sparsity pattern of the Jacobian does not depend on x: rows of entries between the bounds are stored as zeros.

    >>> from geometry.optimise import LinearFunctional
    >>> hinge = Hinge(LinearFunctional(csr_array(np.eye(3)), np.zeros(3)), lower_bound=1.0, upper_bound=3.0)
    >>> hinge.residual(np.array([0.25, 1.0, 5.0])).tolist()
    [-0.75, 0.0, 2.0]
    """

    functional: Functional
    lower_bound: float | FloatArray
    upper_bound: float | FloatArray = np.inf

    def residual(self, x: FloatArray) -> FloatArray:
        r = self.functional.residual(x)
        return np.minimum(r - self.lower_bound, 0.0) + np.maximum(r - self.upper_bound, 0.0)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        r = self.functional.residual(x)
        is_outside = ((r < self.lower_bound) | (r > self.upper_bound)).astype(float)
        return csr_array(diags_array(is_outside) @ self.functional.jacobian(x))
