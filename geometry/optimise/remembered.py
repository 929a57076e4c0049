"""A functional that several terms share, evaluated once for all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geometry.arrays import FloatArray
from geometry.optimise.functional import Functional, SparseMatrix

__all__ = ["Remembered"]


@dataclass(frozen=True, eq=False)
class Remembered:
    """The same functional, whose residual and Jacobian at the last x are kept, and given again while x stays equal.

    >>> from scipy.sparse import csr_array
    >>> from geometry.optimise import LinearFunctional
    >>> shared = Remembered(LinearFunctional(csr_array(2 * np.eye(2)), np.zeros(2)))
    >>> shared.residual(np.ones(2)) is shared.residual(np.ones(2)), shared.residual(np.zeros(2)).tolist()
    (True, [0.0, 0.0])
    """

    functional: Functional
    _last: dict[str, tuple[FloatArray, Any]] = field(default_factory=dict, init=False, repr=False)

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(self._kept("residual", x, self.functional.residual))

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        found: SparseMatrix = self._kept("jacobian", x, self.functional.jacobian)
        return found

    def _kept(self, name: str, x: FloatArray, evaluated: Callable[[FloatArray], Any]) -> Any:
        if name not in self._last or not np.array_equal(self._last[name][0], x):
            self._last[name] = (x.copy(), evaluated(x))
        return self._last[name][1]
