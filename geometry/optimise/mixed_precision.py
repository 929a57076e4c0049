"""Minimising a large quadratic under equality constraints: a factor in single precision, accuracy from iteration.

The saddle point system of minimising x H x / 2 - g x under A x = b, with multipliers y,

    H x + A^T y = g,   A x = b,

is preconditioned by K = H + w A^T A, factored in single precision: in half the memory and about half the time of
double precision. Krylov iterations on the system itself, applied in double precision, take away what the factor rounds
and what the penalty leaves. Rows of A that depend on each other do no harm.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator, SuperLU, gcrotmk, splu

from geometry.arrays import FloatArray
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.solution import Reason, Solution

__all__ = ["SaddlePoint"]

PENALTY = 1e5
"""w over the mean of the diagonal of H. The factor rounds by 1e-7 w: with more, a solve gains less than two digits."""

CYCLE = 30
"""Iterations, one solve each, before the Krylov space is begun anew; it holds that many vectors of x and y."""

CYCLES = 5
"""At most. Mostly one is enough; a mesh of a million vertices takes about 14 iterations."""


@dataclass(frozen=True, eq=False)
class SaddlePoint:
    """x H x / 2 - g x under A x = b, for any g and b; H and A as in `constrained.ConstrainedQuadratic`."""

    H: SparseMatrix
    A: SparseMatrix

    def minimise(self, g: FloatArray, b: FloatArray, *, tolerance: float) -> Solution:
        """The x with the least violation met; steps are cycles of iterations."""
        operator, preconditioner = self._operators
        n = len(g)
        target, z = np.concatenate([g, self._scale * b]), np.zeros(n + len(b))
        aim = self._scale * tolerance * np.sqrt(len(b))  # a norm over all residuals
        best = Solution(z[:n], z[n:], np.inf, 0, Reason.STEP_LIMIT)
        for cycle in range(1, CYCLES + 1):
            z = gcrotmk(operator, target, z, rtol=0.0, atol=aim, m=CYCLE, maxiter=1, M=preconditioner)[0]
            violation = float(np.abs(apply(self.A, z[:n]) - b).max(initial=0.0))
            if violation >= best.violation:
                return Solution(best.x, best.multipliers, best.violation, cycle, Reason.STALLED)
            reason = Reason.CONVERGED if violation <= tolerance else Reason.STEP_LIMIT
            best = Solution(z[:n], self._scale * z[n:], violation, cycle, reason)
            if reason is Reason.CONVERGED:
                break
            aim /= 10  # the largest residual is above the mean one, which the norm bounds
        return best

    @cached_property
    def _transposed(self) -> SparseMatrix:
        return csr_array(self.A.T)

    @cached_property
    def _scale(self) -> float:
        """sqrt(w): A and y are scaled by it, so that residuals weigh as in the penalty function."""
        return float(np.sqrt(PENALTY * self.H.diagonal().mean()))

    @cached_property
    def _factor(self) -> SuperLU:
        K = csr_array(self.H + self._scale**2 * (self._transposed @ self.A))
        options = {"SymmetricMode": True}
        K32 = K.astype(np.float32).tocsc()
        return splu(K32, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, relax=1, panel_size=20, options=options)

    @cached_property
    def _operators(self) -> tuple[LinearOperator, LinearOperator]:
        size = sum(self.A.shape)
        return (
            LinearOperator((size, size), matvec=self._apply, dtype=np.float64),
            LinearOperator((size, size), matvec=self._precondition, dtype=np.float64),
        )

    def _apply(self, z: FloatArray) -> FloatArray:
        x, y = np.split(z, [self.H.shape[0]])
        gradient = apply(self.H, x) + self._scale * apply(self._transposed, y)
        return np.concatenate([gradient, self._scale * apply(self.A, x)])

    def _precondition(self, z: FloatArray) -> FloatArray:
        gradient, violation = np.split(z, [self.H.shape[0]])
        target = gradient + self._scale * apply(self._transposed, violation)
        x = self._factor.solve(target.astype(np.float32)).astype(np.float64)
        return np.concatenate([x, self._scale * apply(self.A, x) - violation])
