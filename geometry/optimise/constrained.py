"""Minimising a quadratic under equality constraints, with sparse positive definite factors only.

A quadratic x H x / 2 - g x under A x = b is minimised through K = H + w A^T A, which leaves the minimiser where it is.
With w large, little violation is left after one solve, and conjugate gradients on the multipliers remove it,
one solve with the same factor each: almost all eigenvalues of w A K^-1 A^T are 1, so few steps are needed beyond
one for each constraint direction of small singular value. Dependent constraints do no harm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import SuperLU, splu

from geometry.arrays import FloatArray
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.solution import Reason, Solution

__all__ = ["minimise_quadratic"]

PENALTY = 1e7
"""w over the mean of the diagonal of H. Larger: fewer corrections, more rounding."""

PATIENCE = 10
"""Corrections without a smaller violation before giving up; conjugate gradients need not gain at each step."""


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
    """Minimise x H x / 2 - g x under A x = b; the x with the least violation met.

    H (n, n) symmetric, positive definite; A (m, n) with rows of about unit length, dependent or not. Stops when
    the largest |A x - b| is at most `tolerance` or falls no further, as it does not where constraints contradict
    each other by rounding. A step is one solve with the factor.
    """
    w = penalty * float(H.diagonal().mean())
    transposed = csr_array(A.T)
    factor = factorise(csr_array(H + w * (transposed @ A)))
    x = factor.solve(g + w * apply(transposed, b))
    direction = residual = apply(A, x) - b
    multipliers = np.zeros(len(b))  # H x - g + A^T (multipliers + w residual) = 0 at every x
    best = Solution(x, w * residual, _largest(residual), 0, Reason.STEP_LIMIT)
    for step in range(1, max_steps + 1):
        if best.violation <= tolerance:
            break
        change = factor.solve(apply(transposed, direction))
        curvature = float(direction @ apply(A, change))
        if curvature <= 0 or step - best.steps > PATIENCE:
            best = replace(best, reason=Reason.STALLED)
            break
        squared = float(residual @ residual)
        length = squared / curvature
        x, multipliers = x - length * change, multipliers + length * direction
        residual = apply(A, x) - b
        direction = residual + float(residual @ residual) / squared * direction
        if _largest(residual) < best.violation:
            best = Solution(x, multipliers, _largest(residual), step, Reason.STEP_LIMIT)
    return _refined(best, H, g, A, b, w, factor, tolerance)


def _refined(
    best: Solution,
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    w: float,
    factor: SuperLU,
    tolerance: float,
) -> Solution:
    """One more solve, for what is left of the gradient: the factor rounds by the size of the penalty, this does not."""
    transposed = csr_array(A.T)
    multipliers = best.multipliers + w * (apply(A, best.x) - b)
    change = factor.solve(g - apply(H, best.x) - apply(transposed, multipliers))
    x = best.x + change
    violation = _largest(apply(A, x) - b)
    if violation <= max(tolerance, best.violation):
        best = replace(best, x=x, multipliers=multipliers + w * apply(A, change), violation=violation)
    return best if best.violation > tolerance else replace(best, reason=Reason.CONVERGED)


def _largest(values: FloatArray) -> float:
    return float(np.abs(values).max(initial=0.0))
