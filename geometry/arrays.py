"""Array types of the whole package, and how values that hold arrays are shown. Arrays held by a value are read-only."""

from __future__ import annotations

from collections.abc import Sized
from dataclasses import MISSING, fields
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = [
    "BoolArray",
    "ComplexArray",
    "FloatArray",
    "IntArray",
    "angles_between",
    "complexes",
    "floats",
    "integers",
    "short_repr",
]

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


def angles_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angles in radians between vectors (..., 3), accurate for small angles too.

    >>> angles_between(np.array([1.0, 0.0, 0.0]), np.array([[1.0, 1e-12, 0.0], [0.0, 2.0, 0.0]])).round(13).tolist()
    [1e-12, 1.5707963267949]
    """
    crossed = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.asarray(np.arctan2(crossed, np.sum(first * second, axis=-1)))


LONGEST_REPR = 96
"""Characters of what a value with arrays is shown as, before "..." and a bracket."""

LONGEST_WORD = 40
"""Characters of a text within it; longer ones are left out."""


def short_repr(value: Any) -> str:
    """How a dataclass with arrays is shown, in one line below 100 characters; assigned to its `__repr__`.

    What is or has a mesh begins with its counts. Then come numbers and texts that are not the defaults; sequences by
    their lengths and arrays by their shapes, where there is no mesh that tells them. What has no room becomes "...".

    >>> from geometry import Guides
    >>> Guides(fairness=0.01, fixed=[0, 8, 72, 80])
    Guides(fairness=0.01, 4 fixed)
    """
    counted = getattr(value, "mesh", value)
    has_counts = hasattr(counted, "n_edges")
    parts = [f"{counted.n_vertices} vertices, {counted.n_faces} faces, {counted.n_edges} edges"] if has_counts else []
    for field in fields(value):
        if has_counts and field.name == "n_vertices":
            continue
        held = getattr(value, field.name)
        default = field.default_factory() if field.default_factory is not MISSING else field.default
        parts += _shown_field(field.name, held, default, has_counts)
    text = f"{type(value).__name__}({parts[0] if parts else ''}"
    for part in parts[1:]:
        if len(text) + len(part) + 2 > LONGEST_REPR:
            return f"{text}, ...)"
        text += f", {part}"
    return f"{text})"


def _shown_field(name: str, held: Any, default: Any, has_counts: bool) -> list[str]:
    """A field as `short_repr` shows it, if it does."""
    if isinstance(held, np.ndarray):
        return [] if has_counts else [f"{name} {held.shape}"]
    if held is default or (isinstance(held, (int, float, str)) and held == default):
        return []
    if isinstance(held, (float, np.floating)):
        return [f"{name}={held:.4g}"]
    if isinstance(held, (int, str)):
        return [f"{name}={held!r}"] if len(str(held)) <= LONGEST_WORD else []
    if isinstance(held, Sized):
        return [f"{len(held)} {name}"]
    return [] if has_counts or held is None else [f"{name}={type(held).__name__}"]
