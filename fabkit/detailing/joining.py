"""Beams that cannot be joined to their nodes, and the connections by which they could."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.setbacks import LONGEST_SETBACK_SHARE, longest_setbacks, needed_setbacks
from fabkit.rules import CONNECTION_KINDS, ConnectionKind, ConnectionRules, DetailingRules
from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh

__all__ = ["not_joinable"]

TO_JOIN = {
    "welded": "welded",
    "bolted": "bolted",
    "hub": "welded to a hub",
    "contact": "in contact with its block",
}
"""What a beam is that is joined by each kind of connection."""


def not_joinable(mesh: Mesh, ends: Ends, rules: DetailingRules) -> dict[int, str]:
    """The edges whose beams cannot be joined, and a reason for each: the angle to a neighbour is too small, or the end
    would be too far from the axis."""
    if rules.connection.kind == "contact":
        return {}
    found = _failing(mesh, ends, rules)
    if not len(found):
        return {}
    would_do: dict[ConnectionKind, IntArray] = {}
    for kind in CONNECTION_KINDS:
        if kind != rules.connection.kind:
            other = replace(rules, connection=ConnectionRules(kind=kind))
            would_do[kind] = np.setdiff1d(found, _failing(mesh, ends, other))
    reasons = {}
    for end in found[np.argsort(ends.setback[found], kind="stable")].tolist():
        others = [TO_JOIN[kind] for kind, good in would_do.items() if end in good]
        reasons[end // 2] = _reason(mesh, ends, end, others, rules)
    return dict(sorted(reasons.items()))


def _failing(mesh: Mesh, ends: Ends, rules: DetailingRules) -> IntArray:
    """The ends that cannot be joined by these rules."""
    needed = np.full(len(ends.vertex), np.nan)
    needed[ends.ring] = needed_setbacks(ends.ring, ends.following, ends.gap, rules)
    failing = needed > np.minimum(longest_setbacks(mesh.edge_lengths, rules), np.repeat(mesh.edge_lengths / 2, 2))
    if rules.connection.kind in ("welded", "hub"):
        failing |= _smallest_gaps(ends) < np.radians(rules.connection.least_angle_deg)
    return np.flatnonzero(failing)


def _smallest_gaps(ends: Ends) -> FloatArray:
    """(2E,) smaller of the angles to the two neighbours; NaN for ends in no ring."""
    smallest = ends.gap.copy()
    np.minimum.at(smallest, ends.following[ends.ring], ends.gap[ends.ring])
    return smallest


def _reason(mesh: Mesh, ends: Ends, end: int, others: list[str], rules: DetailingRules) -> str:
    edge, vertex, connection = end // 2, int(ends.vertex[end]), rules.connection
    preceding = int(np.flatnonzero(ends.following == end)[0])
    neighbour = int(ends.following[end]) if ends.gap[end] <= ends.gap[preceding] else preceding
    angle = np.degrees(min(ends.gap[end], ends.gap[preceding]))
    joined = connection.kind in ("welded", "hub")
    if joined and angle < connection.least_angle_deg:
        why = f"at least {connection.least_angle_deg:g} degrees are needed"
    else:
        longest = min(LONGEST_SETBACK_SHARE * mesh.edge_lengths[edge], connection.longest_setback_mm)
        why = (
            f"so its end would be {ends.setback[end]:.1f} mm from the axis, where at most {longest:.1f} mm are "
            f"possible ({connection.longest_setback_mm:g} mm, or {LONGEST_SETBACK_SHARE:.0%} of the edge)"
        )
    could = f"it could be {' or '.join(others)}" if others else "no other connection would work"
    return (
        f"the beam on edge {edge} cannot be {TO_JOIN[connection.kind]} at vertex {vertex}: it is {angle:.1f} degrees "
        f"from the beam on edge {neighbour // 2} about the node axis, {why}; {could}"
    )
