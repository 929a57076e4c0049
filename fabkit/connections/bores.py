"""Setbacks that slots and bores need, and the reach of a tool inside a hollow section.

Seen along the node axis each beam is a strip about its ray from the axis, and so is each bore along the normal of its
facet: what keeps two of them apart is exact in this plane. Two strips that are mirrored in the bisector of their rays
are nearest at a pair of mirrored corners, so each end can be judged by its own distance from the bisector.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray

__all__ = [
    "LEAST_EDGE_RATIO",
    "LEAST_PITCH_RATIO",
    "LEAST_WALL_MM",
    "bored_setbacks",
    "largest_inclination",
    "slot_setbacks",
]

LEAST_WALL_MM = 6.0
"""Least thickness of steel between two bores of a node, in mm: a drill that runs off by 1 mm leaves 5."""

LEAST_EDGE_RATIO = 1.2
"""Least distance of a hole's centre from an edge of its plate over the hole's diameter (EN 1993-1-8, table 3.3)."""

LEAST_PITCH_RATIO = 2.2
"""Least distance of the centres of two holes over their diameter (EN 1993-1-8, table 3.3)."""


def slot_setbacks(gaps: FloatArray, width: FloatArray | float, slot: FloatArray | float) -> FloatArray:
    """Least distances from the axis at which strips of this width begin, so that two neighbours at angles `gaps` have
    `slot` between them: (slot + w cos p) / (2 sin p) with p half of the gap, at most a right angle; infinite for gaps
    of zero.

    >>> from fabkit.connections import slot_setbacks
    >>> slot_setbacks(np.radians([30, 60, 90, 120]), 60.0, 25.0).round().tolist()
    [160.0, 77.0, 48.0, 32.0]
    """
    half, is_open = np.minimum(gaps, np.pi) / 2, gaps >= np.pi
    with np.errstate(divide="ignore"):
        setbacks: FloatArray = (slot + width * np.where(is_open, 0.0, np.cos(half))) / (2 * np.sin(half))
    return setbacks


def bored_setbacks(gaps: FloatArray, diameter: float, depth: float, *, axial_mm: float = 0.0) -> FloatArray:
    """Least setbacks in mm of facets whose bores leave LEAST_WALL_MM between each other, and to a bore of diameter
    `axial_mm` along the axis if there is one. gaps: angles in radians to the next beam, of any shape.

    The bottom of a bore is a strip that begins at the setback minus its depth; bores at different levels are kept apart
    as if they were at one. What holds for both neighbours holds for all beams of a node, as wider angles need less.

    >>> from fabkit.connections import bored_setbacks
    >>> bored_setbacks(np.radians([60, 90, 120, 180]), 16.0, 31.0).round(1).tolist()
    [50.9, 43.2, 39.1, 34.0]
    """
    between = slot_setbacks(gaps, diameter, LEAST_WALL_MM)
    axial = axial_mm / 2 + LEAST_WALL_MM if axial_mm > 0 else 0.0
    return depth + np.maximum(between, axial)


def largest_inclination(clear_height: float, offset: float, tool_radius: float, tool_length: float) -> float:
    """Largest inclination in radians of a beam in which a tool reaches a bolt; negative where it never does.

    The bolt is along the normal of the facet, so that the tool leans against the axis of the hollow section by the
    inclination i: offset cos i + length sin i + radius must fit into half of clear_height. offset: of the bolt from the
    middle of the end plate.

    >>> from fabkit.connections import largest_inclination
    >>> round(np.degrees(largest_inclination(110.0, 0.0, 23.0, 85.0)).item(), 1)
    22.1
    """
    aside = min((clear_height / 2 - tool_radius) / np.hypot(offset, tool_length), 1.0)
    return float(np.arcsin(aside) - np.arctan2(abs(offset), tool_length)) if aside >= 0 else -1.0
