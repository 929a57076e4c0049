"""Minimising a quadratic under equality constraints, with sparse positive definite factors only.

A quadratic x H x / 2 - g x under A x = b is minimised through K = H + w A^T A, which leaves the minimiser where it is.
With w large, little violation is left after one solve, and conjugate gradients on the multipliers remove it,
one solve with the same factor each: almost all eigenvalues of w A K^-1 A^T are 1, so few steps are needed beyond
one for each constraint direction of small singular value. Dependent constraints do no harm. Large problems take a
factor in single precision and more solves instead, see `mixed_precision`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import SuperLU, splu

from geometry.arrays import FloatArray
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.mixed_precision import SaddlePoint
from geometry.optimise.solution import Reason, Solution

__all__ = ["ConstrainedQuadratic", "factorise", "minimise_quadratic"]

PENALTY = 1e7
"""w over the mean of the diagonal of H. Larger: fewer corrections, more rounding."""

PATIENCE = 10
"""Corrections without a smaller violation before giving up; conjugate gradients need not gain at each step."""

LARGE = 60_000
"""Unknowns above which factors in single precision are faster on the whole."""


def factorise(matrix: SparseMatrix) -> SuperLU:
    """The factor of a sparse symmetric positive definite matrix."""
    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def minimise_quadratic(
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    *,
    tolerance: float,
    penalty: float = PENALTY,
    max_steps: int = 200,
) -> Solution:
    """Minimise x H x / 2 - g x under A x = b: `ConstrainedQuadratic`, once."""
    return ConstrainedQuadratic(H, A, penalty).minimise(g, b, tolerance=tolerance, max_steps=max_steps)


@dataclass(frozen=True, eq=False)
class ConstrainedQuadratic:
    """x H x / 2 - g x under A x = b, for any g and b: one factor serves them all.

    H (n, n) symmetric, positive definite; A (m, n) with rows of about unit length, dependent or not.
    """

    H: SparseMatrix
    A: SparseMatrix
    penalty: float = PENALTY

    def minimise(self, g: FloatArray, b: FloatArray, *, tolerance: float, max_steps: int = 200) -> Solution:
        """The x with the least violation met. A step is one solve with the factor.

        Stops when the largest |A x - b| is at most `tolerance` or falls no further, as it does not where constraints
        contradict each other by rounding.
        """
        if len(g) > LARGE:
            return self._saddle_point.minimise(g, b, tolerance=tolerance)
        factor, w = self._factor, self._weight
        x = factor.solve(g + w * apply(self._transposed, b))
        direction = residual = apply(self.A, x) - b
        multipliers = np.zeros(len(b))  # H x - g + A^T (multipliers + w residual) = 0 at every x
        best = Solution(x, w * residual, _largest(residual), 0, Reason.STEP_LIMIT)
        for step in range(1, max_steps + 1):
            if best.violation <= tolerance:
                break
            change = factor.solve(apply(self._transposed, direction))
            curvature = float(direction @ apply(self.A, change))
            if curvature <= 0 or step - best.steps > PATIENCE:
                best = replace(best, reason=Reason.STALLED)
                break
            squared = float(residual @ residual)
            length = squared / curvature
            x, multipliers = x - length * change, multipliers + length * direction
            residual = apply(self.A, x) - b
            direction = residual + float(residual @ residual) / squared * direction
            if _largest(residual) < best.violation:
                best = Solution(x, multipliers, _largest(residual), step, Reason.STEP_LIMIT)
        return self._refined(best, g, b, tolerance)

    def _refined(self, best: Solution, g: FloatArray, b: FloatArray, tolerance: float) -> Solution:
        """One more solve, for what is left of the gradient: the factor rounds by the penalty's size, this does not."""
        multipliers = best.multipliers + self._weight * (apply(self.A, best.x) - b)
        change = self._factor.solve(g - apply(self.H, best.x) - apply(self._transposed, multipliers))
        x = best.x + change
        violation = _largest(apply(self.A, x) - b)
        if violation <= max(tolerance, best.violation):
            multipliers = multipliers + self._weight * apply(self.A, change)
            best = replace(best, x=x, multipliers=multipliers, violation=violation)
        return best if best.violation > tolerance else replace(best, reason=Reason.CONVERGED)

    @cached_property
    def _transposed(self) -> SparseMatrix:
        return csr_array(self.A.T)

    @cached_property
    def _weight(self) -> float:
        return self.penalty * float(self.H.diagonal().mean())

    @cached_property
    def _factor(self) -> SuperLU:
        return factorise(csr_array(self.H + self._weight * (self._transposed @ self.A)))

    @cached_property
    def _saddle_point(self) -> SaddlePoint:
        return SaddlePoint(self.H, self.A)


def _largest(values: FloatArray) -> float:
    return float(np.abs(values).max(initial=0.0))
