"""Minimising a quadratic under equality constraints, with factors of sparse positive definite matrices only.

A quadratic x H x / 2 - g x under A x = b is minimised with K = H + w A^T A, which has the same minimiser. With a large
w, the violation after one solve is small; conjugate gradients on the multipliers remove it, with one solve with the
same factor for each step. Almost all eigenvalues of w A K^-1 A^T are 1, so that about one step is needed for each
constraint direction of small singular value. Constraints may depend on each other. Large problems use a factor in
single precision and more solves, see `saddle_point`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray
from geometry.optimise.functional import SparseMatrix, apply, max_norm
from geometry.optimise.saddle_point import Factor, SaddlePoint, factorise
from geometry.optimise.solution import Reason, Solution

__all__ = ["ConstrainedQuadratic", "minimise_quadratic"]

DEFAULT_PENALTY = 1e7
"""w over the mean of the diagonal of H. A larger one needs fewer corrections and rounds more."""

MAX_STAGNANT_CORRECTIONS = 10
"""Corrections in a row without a smaller violation before the solver gives up; not every one gains."""

CAREFUL_PENALTY = 1e11
"""The penalty where constraints nearly depend on each other: singular values down to 1e-6 need no correction of their
own. The factor then rounds by 1e-5, so the solver restarts from the residuals of both equations."""

CAREFUL_STAGNANT_CORRECTIONS = 50
"""Corrections in a row without a smaller violation where constraints nearly depend on each other."""

MAX_REFINEMENTS = 20
"""Restarts from the residuals of both equations. Mostly one is enough; a high penalty, or an H that nearly vanishes in
some directions, needs more."""

REFINEMENT_TOLERANCE = 1e-6
"""Change of x by a restart, over x, below which it is the last one: the next would change x by the square of that."""

SINGLE_PRECISION_UNKNOWNS = 60_000
"""Number of unknowns above which factors in single precision are faster altogether."""

SINGLE_PRECISION_PENALTY = 1e5
"""The penalty with factors in single precision, which round by 1e-7 w: with a higher one, solves gain too little."""

LEAST_DIAGONAL_RATIO = 1e-2
"""Least entry of the diagonal of H over its mean for which single precision is used. Iterations end at a gradient of
about 1e-10 for each entry, which must still determine the minimum."""

MAX_SINGLE_PRECISION_CYCLES = 3
"""Cycles of iterations with a factor in single precision. Mostly two are enough; a mesh of a million vertices takes 14
solves in all. Where H varies so much that its smallest values vanish in single precision, double precision follows."""


def minimise_quadratic(
    H: SparseMatrix,
    g: FloatArray,
    A: SparseMatrix,
    b: FloatArray,
    *,
    tolerance: float,
    penalty: float = DEFAULT_PENALTY,
    max_steps: int = 200,
) -> Solution:
    """Minimise x H x / 2 - g x under A x = b, as `ConstrainedQuadratic` does, for one g and b.

    >>> H, A = csr_array(np.eye(2)), csr_array(np.array([[1.0, 1.0]]))
    >>> minimise_quadratic(H, np.array([2.0, 0.0]), A, np.array([1.0]), tolerance=1e-9).x.round(6).tolist()
    [1.5, -0.5]
    """
    return ConstrainedQuadratic(H, A, penalty).minimise(g, b, tolerance=tolerance, max_steps=max_steps)


@dataclass(eq=False)
class ConstrainedQuadratic:
    """x H x / 2 - g x under A x = b, for any g and b. The factor is computed once and kept.

    H (n, n) symmetric, positive definite; A (m, n) with rows of about unit length, dependent or not. order (n,): the
    `elimination` of an earlier problem with the same sparsity pattern, which saves time. careful: for constraints that
    nearly depend on each other, with `CAREFUL_PENALTY`; takes more time and memory.

    >>> problem = ConstrainedQuadratic(csr_array(np.eye(2)), csr_array(np.array([[1.0, 1.0]])))
    >>> [problem.minimise(np.zeros(2), np.array([b]), tolerance=1e-9).x.round(6).tolist() for b in (1.0, 4.0)]
    [[0.5, 0.5], [2.0, 2.0]]
    """

    H: SparseMatrix
    A: SparseMatrix
    penalty: float = DEFAULT_PENALTY
    order: IntArray | None = None
    careful: bool = False

    def minimise(self, g: FloatArray, b: FloatArray, *, tolerance: float, max_steps: int = 200) -> Solution:
        """The x with the least violation of all steps. A step is one solve with the factor.

        Stops where the largest |A x - b| is at most `tolerance` or no longer decreases, as where constraints contradict
        each other by rounding.
        """
        if len(g) > SINGLE_PRECISION_UNKNOWNS and not self.careful and self._is_uniform:
            found = self._minimise_large(g, b, tolerance)
            if found.reason is Reason.CONVERGED:
                return found
            del self._saddle_point  # frees memory for the factor in double precision
        best = self._corrected(g, b, tolerance, max_steps)
        for _ in range(MAX_REFINEMENTS):
            stalled = best.violation > tolerance and not self.careful
            further = self._refined(best, g, b, tolerance, 0 if stalled else max_steps)
            if further.violation > max(tolerance, best.violation):
                break
            change, best = max_norm(further.x - best.x), further
            if stalled or change <= REFINEMENT_TOLERANCE * max_norm(best.x):
                break
        return best if best.violation > tolerance else replace(best, reason=Reason.CONVERGED)

    def _corrected(self, g: FloatArray, b: FloatArray, tolerance: float, max_steps: int) -> Solution:
        """One solve, and conjugate gradients on the multipliers."""
        factor, w = self._factor, self._weight
        max_stagnant = CAREFUL_STAGNANT_CORRECTIONS if self.careful else MAX_STAGNANT_CORRECTIONS
        x = factor.solve(g + w * apply(self._transposed, b))
        direction = residual = apply(self.A, x) - b
        multipliers = np.zeros(len(b))  # H x - g + A^T (multipliers + w residual) = 0 at every x
        best = Solution(x, w * residual, max_norm(residual), 0, Reason.STEP_LIMIT)
        for step in range(1, max_steps + 1):
            if best.violation <= tolerance:
                break
            change = factor.solve(apply(self._transposed, direction))
            curvature = float(direction @ apply(self.A, change))
            if curvature <= 0 or step - best.steps > max_stagnant:
                best = replace(best, reason=Reason.STALLED)
                break
            squared = float(residual @ residual)
            length = squared / curvature
            x, multipliers = x - length * change, multipliers + length * direction
            residual = apply(self.A, x) - b
            direction = residual + float(residual @ residual) / squared * direction
            if max_norm(residual) < best.violation:
                best = Solution(x, multipliers + w * residual, max_norm(residual), step, Reason.STEP_LIMIT)
        return best

    def _refined(self, best: Solution, g: FloatArray, b: FloatArray, tolerance: float, max_steps: int) -> Solution:
        """The solution after a restart from both residuals, which removes the rounding of the factor."""
        gradient = g - apply(self.H, best.x) - apply(self._transposed, best.multipliers)
        more = self._corrected(gradient, b - apply(self.A, best.x), tolerance, max_steps)
        x = best.x + more.x
        return replace(
            best,
            x=x,
            multipliers=best.multipliers + more.multipliers,
            violation=max_norm(apply(self.A, x) - b),
            steps=best.steps + more.steps,
        )

    @cached_property
    def _transposed(self) -> SparseMatrix:
        return csr_array(self.A.T)

    @cached_property
    def _weight(self) -> float:
        penalty = CAREFUL_PENALTY if self.careful else self.penalty
        return penalty * float(self.H.diagonal().mean())

    @property
    def elimination(self) -> IntArray | None:
        """(n,) the order in which unknowns were eliminated in double precision; the given order before that."""
        return self._factor.elimination if "_factor" in self.__dict__ else self.order

    @cached_property
    def _factor(self) -> Factor:
        K = csr_array(self.H + self._weight * (self._transposed @ self.A))
        return factorise(K, order=self.order)

    def _minimise_large(self, g: FloatArray, b: FloatArray, tolerance: float) -> Solution:
        """A step is a cycle of iterations; each restarts from the residuals of both equations."""
        system = self._saddle_point
        x, y = np.zeros(len(g)), np.zeros(len(b))
        best = Solution(x, y, np.inf, 0, Reason.STEP_LIMIT)
        accuracy = system.scale * tolerance * np.sqrt(len(b))  # of the norm over all residuals
        for cycle in range(1, MAX_SINGLE_PRECISION_CYCLES + 1):
            gradient = g - apply(self.H, x) - apply(self._transposed, y)
            dx, dy = system.correction(gradient, b - apply(self.A, x), absolute=accuracy)
            x, y = x + dx, y + dy
            violation = max_norm(apply(self.A, x) - b)
            if violation >= best.violation:
                return replace(best, steps=cycle, reason=Reason.STALLED)
            reason = Reason.CONVERGED if violation <= tolerance else Reason.STEP_LIMIT
            best = Solution(x, y, violation, cycle, reason)
            if reason is Reason.CONVERGED:
                break
            accuracy /= 10  # the norm bounds the mean residual, and the largest one is above it
        return best

    @property
    def _is_uniform(self) -> bool:
        """Whether no entry of x has a very much smaller weight than others, by the diagonal of H."""
        diagonal = self.H.diagonal()
        return bool(diagonal.min() > LEAST_DIAGONAL_RATIO * diagonal.mean())

    @cached_property
    def _saddle_point(self) -> SaddlePoint:
        return SaddlePoint(self.H, self.A, SINGLE_PRECISION_PENALTY, single=True)
