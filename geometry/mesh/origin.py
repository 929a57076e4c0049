"""The place of a mesh: far from zero doubles are coarse, so a whole number is taken out and nothing is rounded.

At map coordinates of 5e6 m a double is 1e-9 m, and what is computed from differences, products and means of such
numbers rounds at every step. The origin of a mesh is taken out before anything is computed, and put back where the
result is written.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, floats

__all__ = ["rounding", "whole_origin"]

FREE_BITS_FACTOR = 4.0
"""Multiples of this many spacings of doubles leave their last two bits free; of rounded numbers a quarter does."""


def whole_origin(points: FloatArray) -> FloatArray:
    """(3,) the whole numbers nearest to the middle of the bounding box of points (n, 3), if there are any.

    Points that move by whole numbers take it along. It is zero in an axis where taking it out would round a
    coordinate: only where the points come nearer to zero than about their own extent, so that nothing is lost.
    """
    if not len(points):
        return floats(np.zeros(3))
    middle = np.floor((points.min(axis=0) + points.max(axis=0)) / 2 + 0.5)
    return floats(np.where(_exact(points, middle).all(axis=0), middle, 0.0))


def _exact(points: FloatArray, origin: FloatArray) -> BoolArray:
    """(n, 3) whether the difference of two doubles is one: what is left of it beside its rounded value is zero [the
    sum with its error of Moller and Knuth]."""
    difference = points - origin
    taken = points - difference
    left: BoolArray = (points - (difference + taken)) + (taken - origin) == 0
    return left


def rounding(points: FloatArray) -> float:
    """How far doubles are apart at the furthest coordinate that had to be rounded to one; zero if none had.

    Coordinates that were rounded use all their bits; those of a mesh that stands far away exactly leave some free.
    """
    spacing = np.spacing(np.abs(points))
    return float(np.where(np.mod(points / spacing, FREE_BITS_FACTOR) == 0, 0.0, spacing).max(initial=0.0))
