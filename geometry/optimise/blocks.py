"""Unknowns of several kinds in one vector x (n,), such as two meshes and a shift: blocks with names and shapes.

    >>> blocks = Blocks({"M": (2, 3), "S": (2, 3), "distance": ()})
    >>> x = blocks.join(M=np.ones((2, 3)), S=np.zeros((2, 3)), distance=0.5)
    >>> blocks.split(x)["distance"]
    array(0.5)

A functional of some of them is one of all: `blocks.of(ParallelEdges(combinatorics), "M", "S")`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import GeometryError, listed
from geometry.optimise.functional import Functional, SparseMatrix

__all__ = ["BlockFunctional", "Blocks"]


@dataclass(frozen=True, eq=False)
class Blocks:
    """shapes: of the blocks, by their names, in the order in which they stand in x: (k, 3) of k points, () of a number.

    Whoever names a block that there is not gets a GeometryError.
    """

    shapes: Mapping[str, tuple[int, ...]]

    def __post_init__(self) -> None:
        object.__setattr__(self, "shapes", MappingProxyType(dict(self.shapes)))

    @property
    def n_unknowns(self) -> int:
        return sum(map(prod, self.shapes.values()))

    def join(self, **values: ArrayLike) -> FloatArray:
        """x (n,) from a value of each block. Raises GeometryError for a block left out or of another shape."""
        self._check_names(values)
        left_out = [name for name in self.shapes if name not in values]
        if left_out:
            raise GeometryError(f"nothing is said of {listed(left_out, len(left_out))}: each block needs a value")
        parts = {name: np.asarray(values[name], dtype=np.float64) for name in self.shapes}
        for name, part in parts.items():
            if part.shape != self.shapes[name]:
                raise GeometryError(f"{name} has the shape {part.shape}, the block of that name {self.shapes[name]}")
        return np.concatenate([np.zeros(0), *(part.ravel() for part in parts.values())])

    def split(self, x: FloatArray) -> dict[str, FloatArray]:
        """The blocks of x (n,), each in its shape, as views."""
        return {name: x[self._slices[name]].reshape(shape) for name, shape in self.shapes.items()}

    def columns(self, *names: str) -> IntArray:
        """(k,) where the entries of some blocks are in x, block after block as named."""
        self._check_names(names)
        at = np.arange(self.n_unknowns)
        return integers(np.concatenate([at[:0], *(at[self._slices[name]] for name in names)]))

    def rows(self, matrix: SparseMatrix, *names: str) -> SparseMatrix:
        """(m, n) of all unknowns, from a matrix (m, k) of some blocks; see `columns`."""
        return _placed(matrix, self.columns(*names), self.n_unknowns)

    def of(self, functional: Functional, *names: str) -> BlockFunctional:
        """A functional of some blocks, one after the other as named, as one of all unknowns."""
        return BlockFunctional(functional, self.columns(*names), self.n_unknowns)

    def longest(self, x: FloatArray) -> float:
        """The length of the longest point of x (n,): points are the last axes of the blocks, numbers those of ()."""
        parts = self.split(x).values()
        return max(
            (float(np.linalg.norm(np.atleast_1d(part), axis=-1).max(initial=0.0)) for part in parts), default=0.0
        )

    @cached_property
    def _slices(self) -> dict[str, slice]:
        ends = np.cumsum([0, *map(prod, self.shapes.values())]).tolist()
        return dict(zip(self.shapes, map(slice, ends[:-1], ends[1:]), strict=True))

    def _check_names(self, names: Mapping[str, ArrayLike] | tuple[str, ...]) -> None:
        for name in names:
            if name not in self.shapes:
                raise GeometryError(f"there is no block {name}, but {listed(self.shapes, len(self.shapes))}")


@dataclass(frozen=True, eq=False)
class BlockFunctional:
    """x -> r(x[columns]): a functional of k unknowns as one of n, at the columns (k,)."""

    functional: Functional
    columns: IntArray
    n_unknowns: int

    def residual(self, x: FloatArray) -> FloatArray:
        return self.functional.residual(x[self.columns])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return _placed(self.functional.jacobian(x[self.columns]), self.columns, self.n_unknowns)


def _placed(matrix: SparseMatrix, columns: IntArray, n_columns: int) -> SparseMatrix:
    """The matrix (m, k) with its columns at `columns` (k,) of n: no entry is computed."""
    shape = (matrix.shape[0], n_columns)
    return csr_array((matrix.data, columns[matrix.indices], matrix.indptr), shape=shape)
