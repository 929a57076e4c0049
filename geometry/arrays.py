"""The array types of this package, and the short text that shows objects with arrays. Arrays in objects are
read-only."""

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
"""Largest number of characters in the short text of an object with arrays, before "..." and a bracket."""

LONGEST_WORD = 40
"""Largest number of characters of a string within it; longer strings are left out."""


def short_repr(value: Any) -> str:
    """A dataclass with arrays as one line below 100 characters; it is assigned to `__repr__` of the class.

    A mesh, or an object with a mesh, begins with the counts of the mesh. Numbers and strings follow unless they are
    the defaults; sequences are shown by their lengths, and arrays by their shapes if there is no mesh. What does not
    fit becomes "...".

    >>> from geometry import Guides
    >>> Guides(fairness=0.01, fixed=[0, 8, 72, 80])
    Guides(fairness=0.01, 4 fixed)
    """
    mesh = getattr(value, "mesh", value)
    has_counts = hasattr(mesh, "n_edges")
    parts = [f"{mesh.n_vertices} vertices, {mesh.n_faces} faces, {mesh.n_edges} edges"] if has_counts else []
    for field in fields(value):
        if has_counts and field.name == "n_vertices":
            continue
        content = getattr(value, field.name)
        default = field.default_factory() if field.default_factory is not MISSING else field.default
        parts += _shown_field(field.name, content, default, has_counts)
    text = f"{type(value).__name__}({parts[0] if parts else ''}"
    for part in parts[1:]:
        if len(text) + len(part) + 2 > LONGEST_REPR:
            return f"{text}, ...)"
        text += f", {part}"
    return f"{text})"


def _shown_field(name: str, content: Any, default: Any, has_counts: bool) -> list[str]:
    """The text of a field in `short_repr`, as a list with one entry or none."""
    if isinstance(content, np.ndarray):
        return [] if has_counts else [f"{name} {content.shape}"]
    if content is default or (isinstance(content, (int, float, str)) and content == default):
        return []
    if isinstance(content, (float, np.floating)):
        return [f"{name}={content:.4g}"]
    if isinstance(content, (int, str)):
        return [f"{name}={content!r}"] if len(str(content)) <= LONGEST_WORD else []
    if isinstance(content, Sized):
        return [f"{len(content)} {name}"]
    return [] if has_counts or content is None else [f"{name}={type(content).__name__}"]
