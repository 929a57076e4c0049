"""Beams that cannot be joined to their nodes, and the connections by which they could."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fabkit.connections import LEAST_WALL_MM, largest_inclination
from fabkit.detailing.ends import Ends
from fabkit.detailing.shapes.setbacks import LONGEST_SETBACK_SHARE, longest_setbacks, needed_setbacks
from fabkit.rules import CONNECTION_KINDS, ConnectionKind, ConnectionRules, DetailingRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh

__all__ = ["not_joinable"]

LEAST_ANGLE_ROUNDING = 1e-9
"""Difference in radians up to which an angle between beams is the least one: rounding in regular patterns."""

TO_JOIN = {
    "welded": "welded",
    "bolted": "bolted",
    "hub": "welded to a hub",
    "contact": "in contact with its block",
}
"""What a beam is that is joined by each kind of connection."""


def not_joinable(mesh: Mesh, ends: Ends, rules: DetailingRules) -> dict[int, str]:
    """The edges whose beams cannot be joined, and a reason for each: the angle to a neighbour is too small, the end
    would be too far from the axis, or a bolt is out of reach."""
    if rules.connection.kind == "contact":
        return {}
    found = _failing(mesh, ends, rules)
    if not len(found):
        return {}
    would_do: dict[ConnectionKind, IntArray] = {}
    for kind in CONNECTION_KINDS:
        other = ConnectionRules(kind=kind)
        if kind != rules.connection.kind and not any(map(other.problems_with, ends.bars.sections)):
            would_do[kind] = np.setdiff1d(found, _failing(mesh, ends, replace(rules, connection=other)))
    reasons = {}
    for end in found[np.argsort(ends.setback[found], kind="stable")].tolist():
        others = [TO_JOIN[kind] for kind, good in would_do.items() if end in good]
        reasons[end // 2] = _reason(mesh, ends, end, others, rules)
    return dict(sorted(reasons.items()))


def _failing(mesh: Mesh, ends: Ends, rules: DetailingRules) -> IntArray:
    """The ends that cannot be joined by these rules."""
    needed = np.full(len(ends.vertex), np.nan)
    needed[ends.ring] = needed_setbacks(ends.ring, ends.following, ends.gap, ends.bars, rules)
    failing = needed > np.minimum(longest_setbacks(mesh.edge_lengths, rules), np.repeat(mesh.edge_lengths / 2, 2))
    if rules.connection.kind in ("welded", "hub"):
        failing |= _smallest_gaps(ends) < np.radians(rules.connection.least_angle_deg) - LEAST_ANGLE_ROUNDING
    if rules.connection.kind == "hub":
        failing |= _on_too_large_tubes(mesh, ends, failing, rules)
    if rules.connection.kind == "bolted":
        failing[ends.ring] |= np.abs(ends.inclination[ends.ring]) > _reach(ends, rules)[ends.ring]
    return np.flatnonzero(failing)


def _on_too_large_tubes(mesh: Mesh, ends: Ends, failing: BoolArray, rules: DetailingRules) -> BoolArray:
    """(2E,) ends at nodes where none fails by itself that are too far from the axis on the tube for all, or with their
    flanges."""
    others = np.zeros(mesh.n_vertices, dtype=bool)
    others[ends.vertex[failing]] = True
    half = (np.repeat(mesh.edge_lengths, 2) - rules.least_length_mm) / 2
    with np.errstate(invalid="ignore"):
        too_far = ends.setback > longest_setbacks(mesh.edge_lengths, rules)
        too_far |= ~(ends.flange_cut <= half) & np.isfinite(ends.cut)
    return ~others[ends.vertex] & too_far


def _reach(ends: Ends, rules: DetailingRules) -> FloatArray:
    """(2E,) largest inclinations in radians at which all bolts of an end are in reach."""
    group = rules.connection.group
    sizes = max(group.offsets_mm), group.size.tool_radius_mm, group.size.tool_length_mm
    clear = [section.height_mm - 2 * (section.wall_mm or 0.0) for section in ends.bars.sections]
    return np.repeat(np.array([largest_inclination(each, *sizes) for each in clear])[ends.bars.of_edge], 2)


def _smallest_gaps(ends: Ends) -> FloatArray:
    """(2E,) smaller of the angles to the two neighbours; NaN for ends in no ring."""
    smallest = ends.gap.copy()
    np.minimum.at(smallest, ends.following[ends.ring], ends.gap[ends.ring])
    return smallest


def _what_sets_back(rules: DetailingRules) -> str:
    """What keeps ends from the axis besides the angle, in words."""
    connection = rules.connection
    by_kind = {
        "welded": f"ledges of {connection.ledge_mm:g} mm",
        "hub": "the next tube of the table",
        "bolted": f"walls of {LEAST_WALL_MM:g} mm between bores",
    }
    axial = [f"a bore of {connection.axial_bore_mm:g} mm along the axis"] if connection.axial_bore_mm else []
    *others, last = [f"a slot of {connection.slot:g} mm", by_kind[connection.kind], *axial]
    return f"with {', '.join(others)} and {last}"


def _reason(mesh: Mesh, ends: Ends, end: int, others: list[str], rules: DetailingRules) -> str:
    edge, vertex, connection = end // 2, int(ends.vertex[end]), rules.connection
    reach = _reach(ends, rules)[end]
    could = f"it could be {' or '.join(others)} (--connection)" if others else "no other connection would work"
    begin = f"the beam on edge {edge} cannot be {TO_JOIN[connection.kind]} at vertex {vertex}"
    if connection.kind == "bolted" and abs(ends.inclination[end]) > reach:
        return (
            f"{begin}: it is {np.degrees(abs(ends.inclination[end])):.1f} degrees from the normal of its facet, and a "
            f"socket inside the beam reaches {connection.bolts} up to {np.degrees(reach):.1f} degrees; {could}"
        )
    preceding = int(np.flatnonzero(ends.following == end)[0])
    neighbour = int(ends.following[end]) if ends.gap[end] <= ends.gap[preceding] else preceding
    angle = np.degrees(min(ends.gap[end], ends.gap[preceding]))
    joined = connection.kind in ("welded", "hub")
    if joined and angle < connection.least_angle_deg - np.degrees(LEAST_ANGLE_ROUNDING):
        why = f"at least {connection.least_angle_deg:g} degrees are needed"
    else:
        longest = min(LONGEST_SETBACK_SHARE * mesh.edge_lengths[edge], connection.longest_setback_mm)
        why = (
            f"so {_what_sets_back(rules)} its end would be {ends.setback[end]:.1f} mm from the axis, where at most "
            f"{longest:.1f} mm are possible ([connection] longest_setback_mm = {connection.longest_setback_mm:g}, or "
            f"{LONGEST_SETBACK_SHARE:.0%} of the edge)"
        )
    return (
        f"{begin}: it is {angle:.1f} degrees from the beam on edge {neighbour // 2} about the node axis, {why}; {could}"
    )
