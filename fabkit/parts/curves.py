"""Many polylines in one array of points: a million strokes in separate arrays would be slow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from fabkit.parts.ragged import Ragged
from geometry.arrays import BoolArray

__all__ = ["Curves"]


@dataclass(frozen=True, eq=False)
class Curves(Ragged):
    """Rows of points in mm, values (n, 2); a closed curve ends where it begins.

    >>> from fabkit.parts import Curves
    >>> curves = Curves.of([[[0, 0], [5, 0], [5, 5], [0, 0]], [[1, 1], [2, 2]]])
    >>> len(curves), curves.is_closed.tolist()
    (2, [True, False])
    """

    SHAPE = (2,)

    @cached_property
    def is_closed(self) -> BoolArray:
        """(k,) whether a curve has more than two points and ends where it begins."""
        first, last = self.values[self.starts[:-1]], self.values[self.starts[1:] - 1]
        closed: BoolArray = (first == last).all(axis=1) & (self.sizes > 2)
        return closed
