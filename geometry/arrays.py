"""Array types of the whole package. Arrays held by a value are read-only."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["BoolArray", "ComplexArray", "FloatArray", "IntArray", "complexes", "floats", "integers"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
ComplexArray = npt.NDArray[np.complex128]
"""Vectors of a plane as complex numbers."""


def floats(values: Any) -> FloatArray:
    """A read-only copy of the values as an array of floats.

    >>> floats([1, 2]).tolist(), floats([1, 2]).flags.writeable
    ([1.0, 2.0], False)
    """
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def integers(values: Any) -> IntArray:
    """A read-only copy of the values as an array of integers.

    >>> integers([1, 2]).dtype.name, integers([1, 2]).flags.writeable
    ('int64', False)
    """
    array = np.array(values, dtype=np.int64)
    array.flags.writeable = False
    return array


def complexes(values: Any) -> ComplexArray:
    """A read-only copy of the values as an array of complex numbers.

    >>> complexes([1, 2]).tolist()
    [(1+0j), (2+0j)]
    """
    array = np.array(values, dtype=np.complex128)
    array.flags.writeable = False
    return array
