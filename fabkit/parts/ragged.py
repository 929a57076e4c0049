"""Rows of different lengths in one flat array, as corners of faces are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, Self, overload

import numpy as np
import numpy.typing as npt

from geometry.arrays import IntArray, integers
from geometry.mesh.ragged_arrays import row_of_entry

__all__ = ["Ragged"]


@dataclass(frozen=True, eq=False)
class Ragged:
    """values (K, ...), row after row, read-only; starts (n+1,): row r has values[starts[r]:starts[r+1]].

    >>> around = Ragged.of([[3, 1], [4], [1, 5]], dtype=np.int64)
    >>> len(around), around[2].tolist(), around.rolled(np.array([1, 0, 1])).values.tolist()
    (3, [1, 5], [1, 3, 4, 5, 1])
    """

    SHAPE: ClassVar[tuple[int, ...]] = ()
    """Of one value, where nothing else is said."""

    values: npt.NDArray[Any]
    starts: IntArray

    def __post_init__(self) -> None:
        values, starts = np.asarray(self.values), np.asarray(self.starts, dtype=np.int64)
        if values.flags.writeable:
            values = values.copy()
            values.flags.writeable = False
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "starts", integers(starts) if starts.flags.writeable else starts)

    @classmethod
    def of(
        cls, rows: Sequence[Any], *, dtype: npt.DTypeLike = np.float64, shape: tuple[int, ...] | None = None
    ) -> Self:
        """Of sequences, each an array of values of this type and shape."""
        shape = cls.SHAPE if shape is None else shape
        arrays = [np.asarray(row, dtype=dtype).reshape(-1, *shape) for row in rows]
        starts = np.cumsum([0, *map(len, arrays)])
        return cls(np.concatenate([np.zeros((0, *shape), dtype=dtype), *arrays]), starts)

    @classmethod
    def joined(cls, several: Iterable[Self]) -> Self:
        """The rows of several objects, at least one, in one."""
        values, starts = zip(*((each.values, each.starts) for each in several), strict=True)
        borders = np.cumsum([len(each) for each in starts])[:-1]
        sizes = np.delete(np.diff(np.concatenate(starts)), borders - 1)
        return cls(np.concatenate(values), np.concatenate([[0], np.cumsum(sizes)]))

    def __len__(self) -> int:
        return len(self.starts) - 1

    def __iter__(self) -> Iterator[npt.NDArray[Any]]:
        return (self[row] for row in range(len(self)))

    @overload
    def __getitem__(self, chosen: int) -> npt.NDArray[Any]: ...
    @overload
    def __getitem__(self, chosen: npt.NDArray[Any]) -> Self: ...
    def __getitem__(self, chosen: int | npt.NDArray[Any]) -> npt.NDArray[Any] | Self:
        """One row (k, ...), or the rows chosen by indices or by a mask (n,)."""
        if not isinstance(chosen, np.ndarray):
            row = range(len(self))[chosen]
            return self.values[self.starts[row] : self.starts[row + 1]]
        sizes = self.sizes[chosen]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        places = np.repeat(self.starts[:-1][chosen] - starts[:-1], sizes) + np.arange(starts[-1])
        return type(self)(self.values[places], starts)

    @cached_property
    def sizes(self) -> IntArray:
        """(n,) length of each row."""
        return integers(np.diff(self.starts))

    @cached_property
    def row(self) -> IntArray:
        """(K,) the row of each value."""
        return row_of_entry(self.starts)

    @cached_property
    def place(self) -> IntArray:
        """(K,) the place of each value in its row."""
        return integers(np.arange(len(self.values)) - self.starts[self.row])

    def with_values(self, values: npt.NDArray[Any]) -> Self:
        return type(self)(values, self.starts)

    def rolled(self, places: IntArray) -> Self:
        """Each row from its place places[r] (n,) on, round to the one before it."""
        order = self.starts[self.row] + (self.place + places[self.row]) % self.sizes[self.row]
        return self.with_values(self.values[order])

    def grouped(self, group: IntArray, n_groups: int) -> list[Self]:
        """The rows of each group, from 0 to n_groups - 1, in their order. group (k,): of each row."""
        if not len(self):
            return [self] * n_groups
        order = np.argsort(group, kind="stable")
        sorted_ = self[order]
        ends = np.searchsorted(group[order], np.arange(n_groups + 1))
        bounds, sizes = sorted_.starts[ends], np.diff(ends) + 1
        rows = np.arange(sizes.sum()) - np.repeat(np.arange(n_groups), sizes)
        starts = integers(sorted_.starts[rows] - np.repeat(bounds[:-1], sizes))
        places = zip(pairwise(bounds.tolist()), pairwise((ends + np.arange(n_groups + 1)).tolist()), strict=True)
        return [type(self)(sorted_.values[a:b], starts[c:d]) for (a, b), (c, d) in places]

    def reduced(self, function: np.ufunc, empty: float = np.nan) -> npt.NDArray[Any]:
        """(n, ...) np.minimum, np.maximum or np.add over each row; `empty` for a row without values."""
        full = np.flatnonzero(self.sizes)
        found = np.full((len(self), *self.values.shape[1:]), empty)
        if len(full):
            found[full] = function.reduceat(self.values, self.starts[:-1][full], axis=0)
        return found
