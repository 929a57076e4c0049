"""Outlines of plates whose upper and lower sides differ."""

from __future__ import annotations

import numpy as np

from fabkit.parts.ragged import Ragged
from geometry.arrays import FloatArray

__all__ = ["blanks"]

NEARLY_PARALLEL_SIDES_SINE = 1e-3
"""Sine of the angle between two edges of an outline below which their corner is moved across them, since the
intersection of their lines is ill-conditioned."""


def blanks(lower: Ragged, upper: Ragged) -> Ragged:
    """Corners (k, 2) in mm of the outlines from which plates are cut before their edges are mitred: each edge lies
    where the outer one of the two sides of the plate has it. lower, upper: corners (k, 2), counter-clockwise, of the
    sides of convex plates, whose edges are parallel; where the sides are equal, the outline is that of the lower one.

    >>> from fabkit.parts import Ragged, blanks
    >>> lower = Ragged.of([[[0, 0], [4, 0], [4, 3], [0, 3]]], shape=(2,))
    >>> blanks(lower, lower.with_values(lower.values + [[1, -1], [1, -1], [1, 0], [1, 0]])).values.tolist()
    [[0.0, -1.0], [5.0, -1.0], [5.0, 3.0], [0.0, 3.0]]
    """
    if np.array_equal(lower.values, upper.values):
        return lower
    ahead, back = np.ones(len(lower), dtype=np.int64), lower.sizes - 1
    along = lower.rolled(ahead).values - lower.values
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    outwards = np.stack([along[:, 1], -along[:, 0]], axis=1)
    before = lower.with_values(outwards).rolled(back).values
    reach = np.maximum(_dot(upper.values - lower.values, outwards), 0.0)
    reach_before = lower.with_values(reach).rolled(back).values
    turn = before[:, 0] * outwards[:, 1] - before[:, 1] * outwards[:, 0]
    straight = np.abs(turn) < NEARLY_PARALLEL_SIDES_SINE
    safe = np.where(straight, 1.0, turn)[:, None]
    across = np.stack([-outwards[:, 1], outwards[:, 0]], axis=1)
    across_before = np.stack([-before[:, 1], before[:, 0]], axis=1)
    meet = (across * reach_before[:, None] - across_before * reach[:, None]) / -safe
    alike = np.maximum(reach, reach_before)[:, None] * outwards
    moved = lower.values + np.where(straight[:, None], alike, meet)
    same = (lower.values == upper.values).all(axis=1)
    whole = lower.with_values(same).reduced(np.logical_and, empty=1.0).astype(bool)
    return lower.with_values(np.where(whole[lower.row][:, None], lower.values, moved))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray((a * b).sum(axis=1))
