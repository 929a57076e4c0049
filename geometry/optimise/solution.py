"""The result of a solver, and the error that is raised where it is not accurate enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError

__all__ = ["ConvergenceError", "Reason", "Solution"]


class Reason(Enum):
    """Why a solver stopped; the value completes the sentence "it stopped because ...".

    >>> Reason.STEP_LIMIT.value
    'the allowed number of steps is used up'
    """

    CONVERGED = "the constraints hold"
    INACCURATE = "rounding prevents more accuracy"
    STALLED = "no step makes progress"
    STEP_LIMIT = "the allowed number of steps is used up"
    INFEASIBLE = "the constraints contradict each other"
    UNBOUNDED = "there is no least value"


@dataclass(frozen=True, eq=False)
class Solution:
    """The state at which a constrained solver stopped.

    x (n,); multipliers (m,) of the constraints; violation: the largest absolute residual of the constraints at x;
    steps: their number; reason: why it stopped. The caller judges whether x is accurate enough.

    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> from geometry.optimise import minimise_quadratic
    >>> H, A = csr_array(np.eye(2)), csr_array(np.array([[1.0, 1.0]]))
    >>> found = minimise_quadratic(H, np.zeros(2), A, np.array([1.0]), tolerance=1e-9)
    >>> found.x.round(6).tolist(), found.multipliers.round(6).tolist(), found.reason.name
    ([0.5, 0.5], [-0.5], 'CONVERGED')
    """

    x: FloatArray
    multipliers: FloatArray
    violation: float
    steps: int
    reason: Reason

    def __post_init__(self) -> None:
        object.__setattr__(self, "x", floats(self.x))
        object.__setattr__(self, "multipliers", floats(self.multipliers))


class ConvergenceError(GeometryError):
    """A solver stopped before it reached the required accuracy; `solution` holds its last state and the reason.

    >>> import geometry
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(6, 6)
    >>> shell = grid.with_vertices([(x, y, -0.05 * (x * x + x * y / 4 + y * y)) for x, y, _ in grid.vertices])
    >>> try:
    ...     geometry.planarise(shell, effort=geometry.Effort(max_steps=1))
    ... except ConvergenceError as error:
    ...     error.solution.steps, error.solution.reason.name
    (1, 'STEP_LIMIT')
    """

    def __init__(
        self, message: str, *, solution: Solution, elements: Sequence[int] = (), value: float, bound: float
    ) -> None:
        super().__init__(message, elements=elements, value=value, bound=bound)
        self.solution = solution
