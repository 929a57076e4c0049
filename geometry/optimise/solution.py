"""What a solver hands back, and what is raised where that is not good enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError

__all__ = ["ConvergenceError", "Reason", "Solution"]


class Reason(Enum):
    """Why a solver stopped; the value finishes the sentence "it stopped because ..."."""

    CONVERGED = "the constraints hold"
    INACCURATE = "rounding is in the way of more accuracy"
    STALLED = "no step makes progress"
    STEP_LIMIT = "the allowed number of steps is used up"
    INFEASIBLE = "the constraints contradict each other"
    UNBOUNDED = "there is no least value"


@dataclass(frozen=True, eq=False)
class Solution:
    """Where a constrained solver stopped.

    x (n,); multipliers (m,) of the constraints; violation: largest absolute constraint residual at x;
    steps taken; reason to stop. Whoever asked judges whether x is good enough.
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
    """A solver stopped before it reached what was asked of it: `solution` is where, and says the reason."""

    def __init__(
        self, message: str, *, solution: Solution, elements: Sequence[int] = (), value: float, bound: float
    ) -> None:
        super().__init__(message, elements=elements, value=value, bound=bound)
        self.solution = solution
