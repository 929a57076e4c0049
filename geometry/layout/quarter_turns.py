"""Arrays of complex numbers, which are vectors of tangent planes, and turns by quarters."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from geometry.arrays import IntArray

__all__ = ["ComplexArray", "complexes", "quarter_turned"]

ComplexArray: TypeAlias = npt.NDArray[np.complex128]


def complexes(values: Any) -> ComplexArray:
    """A read-only complex array of its own with these values."""
    array = np.array(values, dtype=np.complex128)
    array.flags.writeable = False
    return array


def quarter_turned(pairs: IntArray, turns: IntArray) -> IntArray:
    """Pairs (..., 2) turned counter-clockwise by quarters of a full turn (...)."""
    x, y = pairs[..., 0], pairs[..., 1]
    cosine, sine = np.array([1, 0, -1, 0])[turns % 4], np.array([0, 1, 0, -1])[turns % 4]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
