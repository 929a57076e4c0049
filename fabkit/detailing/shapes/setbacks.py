"""Setbacks: the distance from the node axis at which a beam ends, so that it can be joined to its node there."""

from __future__ import annotations

import numpy as np

from fabkit.connections import (
    LEAST_EDGE_RATIO,
    TUBE_DIAMETERS_MM,
    bored_setbacks,
    least_radius_for_end,
    next_tube,
    slot_setbacks,
)
from fabkit.detailing.shapes.bar_sections import BarSections
from fabkit.rules import DetailingRules
from geometry.arrays import FloatArray, IntArray

__all__ = ["facet_half_widths", "flange_setbacks", "longest_setbacks", "needed_setbacks", "setbacks"]

LEVEL_ENDS_MM = 0.01
"""Difference in level in mm up to which the beam ends of a node count as level with equal setbacks. Meshes with six
digits are accurate to 1e-3 mm, and no saw is accurate to 0.01 mm."""

ALIGNED_ENDS_TOLERANCE = 1e-9
"""Difference in level between beam ends that count as aligned already, over the height of the beams."""

LONGEST_SETBACK_SHARE = 0.35
"""Largest setback of a beam over the length of its edge: two of them leave a third of the edge to the beam."""

FLANGE_SLOT_MM = 10.0
"""Least clear distance in mm between the flanges of neighbouring tees, for tolerances and paint."""

STEPPED_FACETS_MM = 10.0
"""Difference in mm between the setbacks at a node from which all are made equal: a facet that lies this much behind its
neighbour is in a corner of the block, where a torch has little room."""


def facet_half_widths(bars: BarSections, rules: DetailingRules) -> FloatArray:
    """(2E,) halves of the widths in mm of the facets of blocks: those of the beams, and the ledges beside welded
    ones."""
    ledge = rules.connection.ledge_mm if rules.connection.kind == "welded" else 0.0
    return bars.half_widths + ledge


def needed_setbacks(
    ring: IntArray, following: IntArray, gap: FloatArray, bars: BarSections, rules: DetailingRules
) -> FloatArray:
    """(R,) least setbacks in mm of the ends in the rings, see `Ends`.

    Two beams of width w at an angle of 2 p about the axis have a slot of 2 r sin(p) - w cos(p) between them, and each
    facet shows r tan(p) - w / 2 beside its beam; of two widths the larger one counts. A beam whose neighbours are more
    than half a turn away is as free as with half a turn. Beams in contact with their block have no slot, but a
    clearance.
    """
    connection = rules.connection
    width = _wider(ring, following, bars.webs if connection.kind == "hub" else bars.widths)
    ledge = connection.ledge_mm if connection.kind == "welded" else 0.0
    needed = np.maximum(
        slot_setbacks(gap[ring], width, connection.slot), slot_setbacks(gap[ring], width + 2 * ledge, 0.0)
    )
    if connection.kind == "bolted":
        size, axial = connection.group.size, connection.axial_bore_mm
        bored = bored_setbacks(gap[ring], size.diameter_mm, size.bore_depth_mm, axial_mm=axial)
        needed = np.maximum(needed, bored)
    needed = _for_both_neighbours(ring, following, needed)
    if connection.kind == "contact":
        needed = needed + rules.nodes.clearance
    return np.asarray(np.maximum(needed, _least_setbacks(bars, rules)[ring]))


def _wider(ring: IntArray, following: IntArray, widths: FloatArray) -> FloatArray:
    """(R,) the larger of the widths (E,) of the beams of each end and the next one of its ring."""
    return np.asarray(np.maximum(widths[ring // 2], widths[following[ring] // 2]))


def _for_both_neighbours(ring: IntArray, following: IntArray, needed: FloatArray) -> FloatArray:
    """(R,) the larger of what each end needs (R,) beside the next one of its ring, and beside the one before."""
    setback = np.full(len(following), np.nan)
    setback[ring] = needed
    np.maximum.at(setback, following[ring], needed)
    return setback[ring]


def _least_setbacks(bars: BarSections, rules: DetailingRules) -> FloatArray:
    """(2E,) least setbacks in mm whatever the angles: the radius of a tube for the ends of the beams and for a bore
    along the axis; where beams are joined to a block, half of their width; the distance of that bore from an edge of
    the block."""
    connection = rules.connection
    if connection.kind == "hub":
        radii = np.array([least_radius_for_end(section.web_mm) for section in bars.sections])
        bored = connection.axial_bore_mm / 2 + connection.tube_wall_mm
        return np.asarray(np.maximum(np.repeat(radii[bars.of_edge], 2), bored))
    half = 0.0 * bars.half_widths if connection.kind == "contact" else bars.half_widths
    return np.asarray(np.maximum(half, LEAST_EDGE_RATIO * connection.axial_bore_mm))


def flange_setbacks(ring: IntArray, following: IntArray, gap: FloatArray, bars: BarSections) -> FloatArray:
    """(R,) least distances in mm from the axis at which the flanges of tees on hubs begin, so that they are apart."""
    needed = slot_setbacks(gap[ring], _wider(ring, following, bars.widths), FLANGE_SLOT_MM)
    return _for_both_neighbours(ring, following, needed)


def setbacks(
    vertex: IntArray,
    inclination: FloatArray,
    height: FloatArray,
    needed: FloatArray,
    longest: FloatArray,
    rules: DetailingRules,
) -> FloatArray:
    """(R,) setbacks by the rules, in mm. vertex, inclination, height, needed, longest (R,): node, inclination, height
    of the beam, least and largest setback of the ends in the rings; one that needs more than the largest has what it
    needs."""
    if not len(vertex) or (rules.nodes.setbacks == "least" and rules.connection.kind != "hub"):
        return needed
    starts = np.flatnonzero(np.diff(vertex, prepend=-1))
    of_ring = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(vertex)))
    if rules.connection.kind == "hub":
        return next_tube(np.maximum.reduceat(needed, starts))[of_ring]
    equal: FloatArray = np.maximum(needed, np.minimum(np.maximum.reduceat(needed, starts)[of_ring], longest))
    if rules.nodes.setbacks == "equal":
        return equal
    slope = np.abs(np.tan(inclination))
    off_level = _spread(needed * slope, starts) > ALIGNED_ENDS_TOLERANCE * np.maximum.reduceat(height, starts)
    on_cone = np.maximum(_spread(equal * slope, starts), _spread(height / np.cos(inclination), starts)) <= LEVEL_ENDS_MM
    stepped = (rules.connection.kind != "contact") & (_spread(needed, starts) > STEPPED_FACETS_MM)
    return np.where((off_level & on_cone | stepped)[of_ring], equal, needed)


def longest_setbacks(edge_lengths: FloatArray, rules: DetailingRules) -> FloatArray:
    """(2E,) largest setback in mm of either end of each beam (E,) that is joined, infinite for beams in contact."""
    if rules.connection.kind == "contact":
        return np.full(2 * len(edge_lengths), np.inf)
    longest = rules.connection.longest_setback_mm
    if rules.connection.kind == "hub":
        longest = min(longest, TUBE_DIAMETERS_MM[-1] / 2)
    return np.repeat(np.minimum(LONGEST_SETBACK_SHARE * edge_lengths, longest), 2)


def _spread(values: FloatArray, starts: IntArray) -> FloatArray:
    """Largest minus smallest value of each run."""
    return np.asarray(np.maximum.reduceat(values, starts) - np.minimum.reduceat(values, starts))
