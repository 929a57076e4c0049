"""A layer of beams and nodes, with the parts that its connection adds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from fabkit.detailing.beams import BeamShapes, beam_shapes, make_beams
from fabkit.detailing.bolted import bolted_nodes, fasteners
from fabkit.detailing.ends import Ends, beam_ends
from fabkit.detailing.going_in import going_in_gaps
from fabkit.detailing.hubs import caps, on_tubes
from fabkit.detailing.joining import not_joinable
from fabkit.detailing.nodes import NodeShapes, make_nodes
from fabkit.detailing.shapes.drilling import bored_along_axis
from fabkit.parts import Parts, in_layer
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray
from geometry.gauss import Pair, SupportStructure

__all__ = ["LeaveOut", "fit_beams", "layer_parts", "on_parallel_mesh"]

LeaveOut = Callable[[dict[int, str]], None]
"""Leaves out the beams on these edges for these reasons, or raises DetailingError."""


def on_parallel_mesh(structure: SupportStructure, distance: float) -> SupportStructure:
    """The structure of the mesh M + d S, with the heights of the given one."""
    pair = structure.pair
    return SupportStructure(Pair(pair.offset_mesh(distance), pair.gauss_image), structure.distance)


def fit_beams(
    structure: SupportStructure, made: BoolArray, rules: DetailingRules, leave_out: LeaveOut
) -> tuple[Ends, BeamShapes]:
    """The ends and side views of the beams on the edges `made` (E,), from which leave_out removes those that cannot be
    joined or are too short."""
    while True:
        ends = beam_ends(structure, made, rules)
        if reasons := not_joinable(structure.mesh, ends, rules):
            leave_out(reasons)
            continue
        shapes = beam_shapes(structure, ends, ends.bars.levels)
        short = np.flatnonzero(made & ~(shapes.short_point >= rules.least_length_mm))
        if not len(short):
            return ends, shapes
        leave_out({int(edge): _too_short(structure, int(edge), ends, shapes, rules) for edge in short})


def _too_short(structure: SupportStructure, edge: int, ends: Ends, shapes: BeamShapes, rules: DetailingRules) -> str:
    i, j = structure.mesh.combinatorics.edges[edge].tolist()
    setbacks = ends.setback[2 * edge : 2 * edge + 2]
    worst = 2 * edge + int(setbacks.argmax())
    preceding = int(np.flatnonzero(ends.following == worst)[0])
    angle = np.degrees(np.nanmin(ends.gap[[worst, preceding]]))
    return (
        f"the beam on edge {edge} from vertex {i} to vertex {j} is too short: the edge is "
        f"{structure.mesh.edge_lengths[edge]:.1f} mm long and the setbacks are {setbacks[0]:.1f} and "
        f"{setbacks[1]:.1f} mm{_behind_facets(rules)}, which leaves {shapes.short_point[edge]:.1f} mm between the "
        f"cuts; at least {rules.least_length_mm:g} mm are needed (beams at vertex {ends.vertex[worst]} are "
        f"{angle:.1f} degrees apart; counted from 0)"
    )


def _behind_facets(rules: DetailingRules) -> str:
    """What there is between a facet and the end of its beam, in words."""
    connection = rules.connection
    plate = [f"an end plate of {connection.plate_mm:g} mm"] if connection.kind == "bolted" else []
    gap = [f"a gap of {connection.gap_mm:g} mm"] if connection.gap_mm else []
    return f", each with {' and '.join(plate + gap)}" if plate or gap else ""


def layer_parts(
    structure: SupportStructure,
    made: BoolArray,
    ends: Ends,
    shapes: BeamShapes,
    nodes: NodeShapes,
    rules: DetailingRules,
    layer: str = "",
) -> tuple[Parts[Any], ...]:
    """The beams on the edges `made` (E,) and the nodes of a layer, and the parts that the connection adds. layer: word
    for it, as in `Kind`."""
    edges, vertices = np.flatnonzero(made), np.flatnonzero(np.diff(ends.ring_starts) > 0)
    steel = rules.material(rules.nodes.material)
    gaps = going_in_gaps(ends, nodes)
    beams = make_beams(structure, ends, shapes, edges, gaps, rules, rules.material(rules.beams.material))
    blocks = make_nodes(structure, ends, nodes, vertices, steel)
    kind, axial = rules.connection.kind, rules.connection.axial_bore_mm
    if axial > 0 and kind != "hub":
        blocks = replace(blocks, solids=bored_along_axis(blocks.solids, axial))
    added: tuple[Parts[Any], ...] = ()
    if kind == "bolted":
        blocks, added = bolted_nodes(blocks, ends, rules), fasteners(structure, ends, rules, steel)
    elif kind == "hub":
        blocks = on_tubes(blocks, ends, rules)
        added = (caps(blocks, rules.connection, steel),)
    groups: tuple[Parts[Any], ...] = (beams, blocks, *added)
    return tuple(replace(parts, kind=in_layer(parts.kind, layer)) for parts in groups)
