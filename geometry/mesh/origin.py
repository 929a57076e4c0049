"""The origin of a mesh: whole numbers that are subtracted from coordinates far from zero, where doubles are coarse.

At map coordinates of 5e6 m doubles are 1e-9 m apart, and differences, products and means of them are rounded at every
step. So the origin is subtracted, exactly, before anything is computed, and added where the result is written.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, floats

__all__ = ["rounding", "whole_origin"]

FREE_BITS_FACTOR = 4.0
"""Multiples of this many spacings of doubles have two zero bits at their end, which one in four rounded numbers has."""


def whole_origin(points: FloatArray) -> FloatArray:
    """(3,) the whole numbers nearest to the middle of the bounding box of points (n, 3), if there are any.

    It moves with points that move by whole numbers. It is zero along an axis where subtracting it would round a
    coordinate; this happens only where points are nearer to zero than about their extent, so that no accuracy is lost.
    """
    if not len(points):
        return floats(np.zeros(3))
    middle = np.floor((points.min(axis=0) + points.max(axis=0)) / 2 + 0.5)
    return floats(np.where(_exact(points, middle).all(axis=0), middle, 0.0))


def _exact(points: FloatArray, origin: FloatArray) -> BoolArray:
    """(n, 3) whether points - origin is exact in doubles: its rounding error, computed by the two-sum algorithm of
    Moller and Knuth, is zero."""
    difference = points - origin
    subtracted = points - difference
    is_exact: BoolArray = (points - (difference + subtracted)) + (subtracted - origin) == 0
    return is_exact


def rounding(points: FloatArray) -> float:
    """The spacing of doubles at the largest coordinate that was rounded; zero if none was.

    Rounded coordinates use all their bits; a coordinate whose last bits are zero counts as exact, as those of a mesh
    that was moved far away by whole numbers.
    """
    spacing = np.spacing(np.abs(points))
    return float(np.where(np.mod(points / spacing, FREE_BITS_FACTOR) == 0, 0.0, spacing).max(initial=0.0))
