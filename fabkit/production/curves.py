"""Polylines one after another in one array, so that a million strokes are not as many arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers

__all__ = ["Curves"]


@dataclass(frozen=True, eq=False)
class Curves:
    """points (n, 2) in mm; starts (k+1,): curve c has the points starts[c] .. starts[c+1] - 1.

    A closed curve ends where it begins.
    """

    points: FloatArray
    starts: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", floats(self.points))
        object.__setattr__(self, "starts", integers(self.starts))

    @classmethod
    def of(cls, curves: Sequence[FloatArray]) -> Curves:
        """From curves (k, 2)."""
        return cls(np.concatenate([np.empty((0, 2)), *curves]), np.cumsum([0, *map(len, curves)]))

    @classmethod
    def joined(cls, several: Iterable[Curves]) -> Curves:
        """All the curves of several."""
        points, counts = zip(*((each.points, np.diff(each.starts)) for each in several), strict=True)
        return cls(np.concatenate(points), np.concatenate([[0], np.cumsum(np.concatenate(counts))]))

    def __len__(self) -> int:
        return len(self.starts) - 1

    def __getitem__(self, curve: int) -> FloatArray:
        """(k, 2) the points of one curve."""
        return self.points[slice(*self.starts[range(len(self))[curve] :][:2])]

    def __iter__(self) -> Iterator[FloatArray]:
        return (self[curve] for curve in range(len(self)))

    @cached_property
    def curve_of_point(self) -> IntArray:
        """(n,) the curve of each point."""
        return integers(np.repeat(np.arange(len(self)), np.diff(self.starts)))

    @cached_property
    def is_closed(self) -> BoolArray:
        """(k,) whether a curve has more than two points and ends where it begins."""
        first, last = self.points[self.starts[:-1]], self.points[self.starts[1:] - 1]
        closed: BoolArray = (first == last).all(axis=1) & (np.diff(self.starts) > 2)
        return closed

    def take(self, chosen: IntArray) -> Curves:
        """The curves of these numbers."""
        counts = np.diff(self.starts)[chosen]
        starts = np.concatenate([[0], np.cumsum(counts)])
        places = np.arange(starts[-1]) + np.repeat(self.starts[chosen] - starts[:-1], counts)
        return Curves(self.points[places], starts)

    def grouped(self, group: IntArray, n_groups: int) -> list[Curves]:
        """The curves of each group 0 .. n_groups - 1, by the group of each, in their order."""
        order = np.argsort(group, kind="stable")
        sorted_ = self.take(order)
        ends = np.searchsorted(group[order], np.arange(n_groups + 1)).tolist()
        bounds = sorted_.starts[ends].tolist()
        return [
            Curves(sorted_.points[first:last], sorted_.starts[start : end + 1] - first)
            for start, end, first, last in zip(ends[:-1], ends[1:], bounds[:-1], bounds[1:], strict=True)
        ]
