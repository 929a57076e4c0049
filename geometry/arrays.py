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
    """A read-only float array of its own with these values."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def integers(values: Any) -> IntArray:
    """A read-only integer array of its own with these values."""
    array = np.array(values, dtype=np.int64)
    array.flags.writeable = False
    return array


def complexes(values: Any) -> ComplexArray:
    """A read-only complex array of its own with these values."""
    array = np.array(values, dtype=np.complex128)
    array.flags.writeable = False
    return array
