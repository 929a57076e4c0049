"""Hubs: round tubes along the node axes, to which beams are welded, with a cap at either end."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from fabkit.detailing.beams import end_levels
from fabkit.detailing.ends import Ends
from fabkit.detailing.shapes.dots import DOT_INSET_MM, drilled_dots
from fabkit.kinds import CAP, CapDetails, NodeDetails
from fabkit.parts import Material, Parts, Ragged, Solids, Topology, bore_vertices, shaft_topology
from fabkit.rules import ConnectionRules, DetailingRules
from geometry.arrays import FloatArray, IntArray

__all__ = ["caps", "circumscribed_sections", "on_tubes"]

SIDES_ABOUT_TUBE = 24
"""Number of sides of the polygon about the tube of a hub over which panels are lifted: its corners are 1 % outside."""

TUBE_VERTICES = 8
"""Number of vertices of a tube: centres and rims of both ends of its outside and inside."""

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def circumscribed_sections(ends: Ends, n_vertices: int) -> tuple[FloatArray, IntArray]:
    """Corners (K, 2) of polygons about the tubes, and starts (N+1,), as in `NodeShapes`."""
    radius = np.zeros(n_vertices)
    radius[ends.vertex[ends.ring]] = ends.setback[ends.ring]
    has_tube = np.flatnonzero(radius > 0)
    angles = 2 * np.pi / SIDES_ABOUT_TUBE * np.arange(SIDES_ABOUT_TUBE)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1) / np.cos(np.pi / SIDES_ABOUT_TUBE)
    counts = np.zeros(n_vertices, dtype=np.int64)
    counts[has_tube] = SIDES_ABOUT_TUBE
    return (radius[has_tube, None, None] * circle).reshape(-1, 2), np.concatenate([[0], np.cumsum(counts)])


def on_tubes(nodes: Parts[NodeDetails], ends: Ends, rules: DetailingRules) -> Parts[NodeDetails]:
    """The nodes with tubes as long as their blocks without the caps, in place of these.

    After the tube's own vertices come the points at which the beams are welded to it; they bound nothing, but tell hubs
    apart whose tubes are equal.
    """
    details, connection = nodes.details, rules.connection
    beams, azimuth, radius = details.beams, np.radians(details.azimuths_deg.values), _radii(nodes)
    levels = nodes.solids.vertices.with_values(nodes.solids.vertices.values[:, 2])
    bottoms = levels.reduced(np.minimum)[nodes.shape] + connection.cap_mm
    tops = levels.reduced(np.maximum)[nodes.shape] - connection.cap_mm
    starts = np.concatenate([[0], np.cumsum(TUBE_VERTICES + beams.sizes)])
    values = np.empty((starts[-1], 3))
    stretch = bottoms[:, None] * Z, tops[:, None] * Z
    rounds = [bore_vertices(*stretch, each, X) for each in (radius, radius - connection.tube_wall_mm)]
    values[starts[:-1, None] + np.arange(TUBE_VERTICES)] = np.concatenate(rounds, axis=1)
    welds = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(len(azimuth))], axis=1) * radius[beams.row, None]
    welds[:, 2] = end_levels(ends)[ends.at(nodes.elements[beams.row], beams.values)]
    values[starts[beams.row] + TUBE_VERTICES + beams.place] = welds
    different, topology = np.unique(beams.sizes, return_inverse=True)
    topologies = tuple(_tube_topology(size) for size in different.tolist())
    return replace(
        nodes,
        solids=Solids(topologies, topology, Ragged(values, starts)),
        shape=np.arange(len(nodes)),
        details=replace(details, height_mm=tops - bottoms, uncovered_percent=beams.with_values(np.zeros(len(azimuth)))),
    )


def _radii(nodes: Parts[NodeDetails]) -> FloatArray:
    """(n,) outer radii of the tubes in mm."""
    return np.asarray(nodes.details.setbacks_mm.reduced(np.maximum))


@lru_cache(maxsize=64)
def _tube_topology(n_beams: int) -> Topology:
    return replace(shaft_topology(hollow=True), n_vertices=TUBE_VERTICES + n_beams)


def caps(nodes: Parts[NodeDetails], connection: ConnectionRules, material: Material) -> Parts[CapDetails]:
    """The caps on the tubes of these nodes: all lower ones, then all upper ones, with a dot where the hub could be
    mounted turned or upside down."""
    n, thickness = len(nodes), connection.cap_mm
    firsts = nodes.solids.vertices.starts[:-1]
    corners = nodes.solids.vertices.values
    levels = np.concatenate([corners[firsts, 2] - thickness, corners[firsts + 2, 2]])
    radii = np.tile(_radii(nodes), 2)
    vertices = bore_vertices(0.0 * Z, thickness * Z, radii, X)
    bored = connection.axial_bore_mm > 0
    if bored:
        bore = bore_vertices(0.0 * Z, thickness * Z, connection.axial_bore_mm / 2, X)
        vertices = np.concatenate([vertices, np.broadcast_to(bore, (2 * n, 4, 3))], axis=1)
    upper = n + np.flatnonzero(np.logical_or(*nodes.details.look_alikes))
    solids = drilled_dots(Solids.alike(vertices, shaft_topology(hollow=bored)), upper, radii[upper] - DOT_INSET_MM)
    return Parts.each_its_own(
        CAP,
        np.tile(nodes.elements, 2),
        solids,
        origins=np.tile(nodes.origins, (2, 1)) + levels[:, None] * np.tile(nodes.axes[:, 2], (2, 1)),
        axes=np.tile(nodes.axes, (2, 1, 1)),
        material=material,
        details=CapDetails(diameter_mm=2 * radii, thickness_mm=np.full(2 * n, thickness)),
    )
