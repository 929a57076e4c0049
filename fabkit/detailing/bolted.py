"""Bolted connections: end plates on the beams, bolts through them into blind threaded bores of the node blocks, and
dowels.

All of them have their places in the frame of a beam's end at its node: x along the normal of the facet, away from the
axis; z along the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fabkit.detailing.beams import end_levels
from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import facet_sides
from fabkit.detailing.shapes.drilling import BLIND, Bores, drilled
from fabkit.kinds import BOLT, DOWEL, END_PLATE, BoltDetails, DowelDetails, EndPlateDetails, NodeDetails
from fabkit.parts import (
    SHAFT,
    Material,
    Parts,
    Section,
    Solids,
    Topology,
    bore_vertices,
    prism_topology,
    profile_vertices,
    shaft_topology,
)
from fabkit.rules import ConnectionRules, DetailingRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["bolted_nodes", "fasteners"]

DOWEL_DEPTH_RATIO = 1.5
"""Depth of a dowel in the node over its diameter, so that it bears over its whole width (ISO 8734 has lengths from
there on)."""

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class _Places:
    """The n ends that are made. ends (n,): their numbers; origins (n, 3): points of the axes at the levels of the
    middles of the end plates; axes (n, 3, 3): their frames."""

    ends: IntArray
    origins: FloatArray
    axes: FloatArray

    def at(self, x: FloatArray, z: float) -> FloatArray:
        """(n, 3) points at x (n,) and the level z in the frames of the ends."""
        return self.origins + x[:, None] * self.axes[:, 0] + z * self.axes[:, 2]


def _places(structure: SupportStructure, ends: Ends, rules: DetailingRules) -> _Places:
    own = np.sort(ends.ring)
    radial, axis = ends.radial[own], structure.axes[ends.vertex[own]]
    middles = structure.mesh.vertices[ends.vertex[own]] + end_levels(ends)[own, None] * axis
    return _Places(own, middles, np.stack([radial, np.cross(axis, radial), axis], axis=1))


def fasteners(
    structure: SupportStructure, ends: Ends, rules: DetailingRules, material: Material
) -> tuple[Parts[Any], ...]:
    """End plates, bolts and dowels."""
    places, connection = _places(structure, ends, rules), rules.connection
    groups: tuple[Parts[Any], ...] = (_end_plates(places, ends, rules, material), _bolts(places, ends, rules, material))
    return (*groups, _dowels(places, ends, rules, material)) if connection.has_dowel else groups


def _dowel_offset(connection: ConnectionRules, sections: Sequence[Section]) -> float:
    """Level of the dowels below the middles of the plates, the same for beams of all sections, in mm."""
    return min(connection.dowel_offset_mm(section.height_mm) for section in sections)


def _bores(connection: ConnectionRules, sections: Sequence[Section]) -> list[tuple[float, float, float, float]]:
    """Of one end: level above the middle of the plate, diameter in the plate, diameter and depth in the node."""
    size = connection.group.size
    bores = [(z, size.clearance_mm, size.diameter_mm, size.bore_depth_mm) for z in connection.group.offsets_mm]
    if connection.has_dowel:
        own = connection.dowel_mm
        bores.append((-_dowel_offset(connection, sections), own, own, DOWEL_DEPTH_RATIO * own))
    return bores


def _end_plates(places: _Places, ends: Ends, rules: DetailingRules, material: Material) -> Parts[EndPlateDetails]:
    connection, n, edges = rules.connection, len(places.ends), places.ends // 2
    thickness, widths = connection.plate_mm, ends.bars.widths[edges]
    heights = np.ptp(ends.bars.levels[edges], axis=1) / np.cos(ends.inclination[places.ends])
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    boxes = profile_vertices([square], np.zeros((n, 3)), np.tile(thickness * X, (n, 1)))
    boxes[..., 1] *= widths[:, None]
    boxes[..., 2] *= heights[:, None]
    bores = _bores(connection, ends.bars.sections)
    holes = [bore_vertices(z * Z, z * Z + thickness * X, diameter / 2, Z) for z, diameter, _, _ in bores]
    vertices = np.concatenate([boxes, np.broadcast_to(np.concatenate(holes), (n, 4 * len(holes), 3))], axis=1)
    group, dowel = connection.group, 1.0 if connection.has_dowel else np.nan
    return Parts.each_its_own(
        END_PLATE,
        places.ends // 2,
        Solids.alike(vertices, prism_topology(4).bored([(0, 1)] * len(bores))),
        origins=places.at(ends.cut[places.ends] - thickness, 0.0),
        axes=places.axes,
        material=material,
        details=EndPlateDetails(
            nodes=ends.vertex[places.ends],
            height_mm=heights,
            width_mm=widths,
            thickness_mm=np.full(n, thickness),
            n_bolts=np.full(n, group.count),
            bolt_bore_mm=np.full(n, group.size.clearance_mm),
            bolt_pitch_mm=np.full(n, group.size.spacing_mm if group.count > 1 else np.nan),
            dowel_bore_mm=np.full(n, dowel * connection.dowel_mm),
            dowel_depth_mm=np.full(n, dowel * _dowel_offset(connection, ends.bars.sections)),
        ),
    )


def _bolts(places: _Places, ends: Ends, rules: DetailingRules, material: Material) -> Parts[BoltDetails]:
    connection, offsets = rules.connection, rules.connection.group.offsets_mm
    size, n = connection.group.size, len(places.ends) * len(offsets)
    length = size.length(connection.end_distance_mm)
    head = bore_vertices(-size.head_height_mm * X, 0.0 * X, size.head_diameter_mm / 2, Z)
    shank = bore_vertices(0.0 * X, length * X, size.diameter_mm / 2, Z)
    topology = shaft_topology().bored([(1, None)], sense=SHAFT)
    cuts = ends.cut[places.ends]
    return _pins(
        BOLT,
        places,
        np.concatenate([head, shank]),
        topology,
        np.stack([places.at(cuts, z) for z in offsets], axis=1).reshape(-1, 3),
        material,
        BoltDetails(
            nodes=np.repeat(ends.vertex[places.ends], len(offsets)),
            size=np.full(n, f"{size.name}x{length:g}", dtype=object),
            tool_radius_mm=np.full(n, size.tool_radius_mm),
            tool_length_mm=np.full(n, size.tool_length_mm),
        ),
    )


def _dowels(places: _Places, ends: Ends, rules: DetailingRules, material: Material) -> Parts[DowelDetails]:
    connection, n = rules.connection, len(places.ends)
    length = connection.end_distance_mm + DOWEL_DEPTH_RATIO * connection.dowel_mm
    offset = -_dowel_offset(connection, ends.bars.sections)
    return _pins(
        DOWEL,
        places,
        bore_vertices(0.0 * X, length * X, connection.dowel_mm / 2, Z),
        shaft_topology(),
        places.at(ends.cut[places.ends], offset),
        material,
        DowelDetails(
            nodes=ends.vertex[places.ends],
            diameter_mm=np.full(n, connection.dowel_mm),
            length_mm=np.full(n, length),
        ),
    )


def _pins(
    kind: Any,
    places: _Places,
    vertices: FloatArray,
    topology: Topology,
    origins: FloatArray,
    material: Material,
    details: Any,
) -> Parts[Any]:
    """Equal pins at origins (k n, 3), k on each end after the other, that point to the axes of the nodes."""
    x, z = -places.axes[:, 0], places.axes[:, 2]
    axes, per_end = np.stack([x, np.cross(z, x), z], axis=1), len(origins) // len(places.ends)
    return Parts.each_its_own(
        kind,
        np.repeat(places.ends // 2, per_end),
        Solids.alike(np.tile(vertices, (len(origins), 1, 1)), topology),
        origins=origins,
        axes=np.repeat(axes, per_end, axis=0),
        material=material,
        details=details,
    )


# --- node blocks


def bolted_nodes(nodes: Parts[NodeDetails], ends: Ends, rules: DetailingRules) -> Parts[NodeDetails]:
    """The node blocks with the bores in their facets for bolts and dowels."""
    around, bores = nodes.details.beams, _bores(rules.connection, ends.bars.sections)
    solid, azimuth = around.row, np.radians(nodes.details.azimuths_deg.values)
    end = ends.at(nodes.elements[solid], around.values)
    radial = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(len(end))], axis=1)
    aside = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros(len(end))], axis=1)
    facets = ends.setback[end, None] * radial + end_levels(ends)[end, None] * Z
    starts = np.stack([facets + z * Z for z, *_ in bores], axis=1)
    depths = np.array([depth for *_, depth in bores])
    stops = starts - depths[:, None] * radial[:, None]
    k = len(bores)
    faces = np.stack([np.repeat(facet_sides(ends)[end], k), np.full(k * len(end), BLIND)], axis=1)
    solids = drilled(
        nodes.solids,
        Bores(
            solids=np.repeat(solid, k),
            faces=faces,
            starts=starts.reshape(-1, 3),
            stops=stops.reshape(-1, 3),
            radii=np.tile([diameter / 2 for *_, diameter, _ in bores], len(end)),
            across=np.repeat(aside, k, axis=0),
        ),
    )
    return replace(nodes, solids=solids)
