"""Unknowns of several kinds in one vector x (n,), such as two meshes and a distance: blocks with names and shapes."""

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
    """shapes: of the blocks, by name, in the order of their entries in x: (k, 3) for k points, () for a number.

    A functional of some blocks becomes one of all unknowns by `of`. Methods raise GeometryError for a name that is not
    among the blocks.

    >>> blocks = Blocks({"M": (2, 3), "S": (2, 3), "distance": ()})
    >>> x = blocks.join(M=np.ones((2, 3)), S=np.zeros((2, 3)), distance=0.5)
    >>> len(x), blocks.split(x)["distance"].item(), blocks.columns("S").tolist()
    (13, 0.5, [6, 7, 8, 9, 10, 11])
    """

    shapes: Mapping[str, tuple[int, ...]]

    def __post_init__(self) -> None:
        object.__setattr__(self, "shapes", MappingProxyType(dict(self.shapes)))

    @property
    def n_unknowns(self) -> int:
        return sum(map(prod, self.shapes.values()))

    def join(self, **values: ArrayLike) -> FloatArray:
        """x (n,) from a value for each block. Raises GeometryError for a missing block or a value of another shape."""
        self._check_names(values)
        missing = [name for name in self.shapes if name not in values]
        if missing:
            raise GeometryError(f"a value is missing for {listed(missing, len(missing))}: give one for each block")
        parts = {name: np.asarray(values[name], dtype=np.float64) for name in self.shapes}
        for name, part in parts.items():
            if part.shape != self.shapes[name]:
                raise GeometryError(f"the value of block {name} has shape {part.shape}, it must be {self.shapes[name]}")
        return np.concatenate([np.zeros(0), *(part.ravel() for part in parts.values())])

    def split(self, x: FloatArray) -> dict[str, FloatArray]:
        """The blocks of x (n,) as views, each in its shape."""
        return {name: x[self._slices[name]].reshape(shape) for name, shape in self.shapes.items()}

    def columns(self, *names: str) -> IntArray:
        """(k,) indices in x of the entries of some blocks, in the order of the names."""
        self._check_names(names)
        indices = np.arange(self.n_unknowns)
        return integers(np.concatenate([indices[:0], *(indices[self._slices[name]] for name in names)]))

    def rows(self, matrix: SparseMatrix, *names: str) -> SparseMatrix:
        """(m, n) for all unknowns, from a matrix (m, k) for some blocks; see `columns`."""
        return _scattered(matrix, self.columns(*names), self.n_unknowns)

    def of(self, functional: Functional, *names: str) -> BlockFunctional:
        """A functional of some blocks, joined in the order of the names, as a functional of all unknowns."""
        return BlockFunctional(functional, self.columns(*names), self.n_unknowns)

    def longest_point(self, x: FloatArray) -> float:
        """The length of the longest point of x (n,): rows of blocks are points, and so is the entry of a block ()."""
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
                raise GeometryError(f"there is no block {name}: the blocks are {listed(self.shapes, len(self.shapes))}")


@dataclass(frozen=True, eq=False)
class BlockFunctional:
    """x -> r(x[columns]): a functional of k unknowns as a functional of n, with the indices `columns` (k,)."""

    functional: Functional
    columns: IntArray
    n_unknowns: int

    def residual(self, x: FloatArray) -> FloatArray:
        return self.functional.residual(x[self.columns])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return _scattered(self.functional.jacobian(x[self.columns]), self.columns, self.n_unknowns)


def _scattered(matrix: SparseMatrix, columns: IntArray, n_columns: int) -> SparseMatrix:
    """(m, n_columns) the matrix (m, k) with its columns moved to `columns` (k,), without any computation."""
    shape = (matrix.shape[0], n_columns)
    return csr_array((matrix.data, columns[matrix.indices], matrix.indptr), shape=shape)
