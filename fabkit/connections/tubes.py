"""Round tubes for hubs."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, floats

__all__ = ["TUBE_DIAMETERS_MM", "least_radius_for_end", "next_tube"]

TUBE_DIAMETERS_MM = (
    *(60.3, 76.1, 88.9, 101.6, 114.3, 139.7, 168.3, 193.7, 219.1, 244.5, 273.0, 323.9, 355.6, 406.4, 457.0, 508.0),
)
"""Outer diameters of round hollow sections in EN 10210-2 and EN 10219-2, in mm, from the smallest that takes webs."""

LARGEST_RIM_GAP_MM = 2.0
"""Largest gap in mm between the rim of a plane end and the tube on which its middle lies: the root gap that a fillet
weld bridges (EN ISO 5817, quality level C)."""


def next_tube(radii: FloatArray) -> FloatArray:
    """Outer radius in mm of the smallest tube that has at least these radii (of any shape); NaN where none is so large.

    >>> from fabkit.connections import next_tube
    >>> next_tube(np.array([20.0, 30.15, 30.2, 300.0])).tolist()
    [30.15, 30.15, 38.05, nan]
    """
    table = np.array([*TUBE_DIAMETERS_MM, np.nan]) / 2
    return floats(table[np.searchsorted(table[:-1], radii - 1e-9)])


def least_radius_for_end(width: float) -> float:
    """Least outer radius in mm of a tube on which a plane end of this width can be welded without a cope: the gap at
    its rim, R - sqrt(R^2 - (w/2)^2), is LARGEST_RIM_GAP_MM there.

    >>> from fabkit.connections import least_radius_for_end
    >>> least_radius_for_end(8.0), least_radius_for_end(60.0)
    (5.0, 226.0)
    """
    gap = min(LARGEST_RIM_GAP_MM, width / 2)
    return ((width / 2) ** 2 + gap**2) / (2 * gap)
