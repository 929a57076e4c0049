"""Pairs of whole numbers turned by quarters."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray

__all__ = ["quarter_turned"]


def quarter_turned(pairs: IntArray, turns: IntArray) -> IntArray:
    """Pairs (..., 2) turned counter-clockwise by quarters of a full turn (...)."""
    x, y = pairs[..., 0], pairs[..., 1]
    cosine, sine = np.array([1, 0, -1, 0])[turns % 4], np.array([0, 1, 0, -1])[turns % 4]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
