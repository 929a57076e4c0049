"""Whether a beam goes straight in between two nodes that are fixed, and the gap that it needs to do so.

In its central plane a beam is a trapezoid between two facets, each parallel to a node axis. Moved along the direction
at an angle psi from the normal of the beam, its end enters the facet by the travel along the facet times the tangent of
the angle between axis and direction. With the two axes at angles a and b from the normal, a direction between them
enters neither facet if a <= b on the way out, so each beam goes in from at least one side: that on which it is longer.
"""

from __future__ import annotations

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes
from geometry.arrays import FloatArray

__all__ = ["going_in_gaps"]


def going_in_gaps(ends: Ends, nodes: NodeShapes) -> FloatArray:
    """(E, 2) gaps in mm that each beam needs at either end to go straight in from outside and from inside, between two
    nodes that are fixed; at least one of the two is 0. NaN for beams that are
    not made."""
    inner, outer = ends.bars.at_ends
    top = nodes.top[ends.vertex] + _rise_at_facets(ends, nodes.slope)
    bottom = nodes.bottom[ends.vertex] - _rise_at_facets(ends, -nodes.bottom_slope)
    to_outside = np.maximum(top - ends.levels(inner), 0.0)
    to_inside = np.maximum(ends.levels(outer) - bottom, 0.0)
    closing_in = ends.inclination.reshape(-1, 2).sum(axis=1)
    gaps = [
        _gap(travel.reshape(-1, 2), np.maximum(sign * closing_in, 0.0))
        for travel, sign in ((to_outside, 1.0), (to_inside, -1.0))
    ]
    return np.stack(gaps, axis=1)


def _rise_at_facets(ends: Ends, slopes: FloatArray) -> FloatArray:
    """(2E,) largest rise in mm, over the width of each beam, of planes with these slopes (N, 2) from the axis to the
    facet."""
    slope, azimuth = slopes[ends.vertex], ends.azimuth
    along = slope[:, 0] * np.cos(azimuth) + slope[:, 1] * np.sin(azimuth)
    aside = slope[:, 1] * np.cos(azimuth) - slope[:, 0] * np.sin(azimuth)
    return np.asarray(ends.setback * along + ends.bars.half_widths * np.abs(aside))


def _gap(travel: FloatArray, angle: FloatArray) -> FloatArray:
    """(E,) least gap that is equal at both ends. travel (E, 2): ways in mm along the facets until an end has left its
    own; angle (E,): by which the two facets close in on that side.

    With the part p of the angle at the first end, the gap is travel_1 tan p = travel_2 tan(angle - p): a quadratic
    equation for tan p.
    """
    first, second = travel.T
    steep, both = np.tan(angle), first + second
    root = np.sqrt(both**2 + 4 * first * second * steep**2)
    return np.asarray(2 * first * second * steep / np.where(root + both > 0, root + both, 1.0))
