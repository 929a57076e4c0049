"""Columns of the tables of nodes: where they stand, and what is on each of their facets; and cells that other tables of
pieces have too."""

from __future__ import annotations

from typing import Any

import numpy as np

from fabkit.kinds import BEAM, BOLT, LEFT_OUT, BeamDetails, NodeDetails, beam_faces, block_ends
from fabkit.parts import Assembly, Cell, Column, Frame, Parts
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["at_ends", "coordinates", "directions", "facet_numbers", "named", "node_facets", "survey"]

COORDINATE_DECIMALS, TURN_DECIMALS, DIRECTION_DECIMALS = 3, 6, 9
"""Decimals in tables of coordinates in mm, turns in degrees and unit vectors: together they place a piece of 10 m to
0.001 mm."""


def survey(nodes: Parts[NodeDetails], assembly: Assembly, site: Frame) -> list[Column]:
    """Of each node its point on the mesh of its layer, its axis outwards and the direction of facet 1, in the
    coordinates of the site, and the heights of the block's top and bottom along the axis from that point."""
    tops, bottoms = block_ends(nodes)
    return [
        Column("Node", None, nodes.piece_names),
        Column("Mark", None, nodes.marks),
        Column("Zone", None, assembly.zones.named(nodes)),
        *coordinates("Point", site.to_world(nodes.origins + assembly.origin_mm)),
        *directions("Axis", nodes.axes[:, 2] @ site.axes),
        *directions("Facet 1", nodes.axes[:, 0] @ site.axes),
        Column("Top (mm)", COORDINATE_DECIMALS, tops.tolist()),
        Column("Bottom (mm)", COORDINATE_DECIMALS, bottoms.tolist()),
    ]


def node_facets(nodes: Parts[NodeDetails], assembly: Assembly) -> list[Column]:
    """Of each facet of each node, counted from 1 counter-clockwise seen from outside, the beam there, the end of the
    beam that meets it, its place and size on the block as it is made, and the bolts in it."""
    beams = assembly.beside(nodes, BEAM)
    own, made = nodes.details, nodes.details[nodes.firsts[nodes.mark]]
    around, row = own.beams, own.beams.row
    met = beams.find(around.values)
    heads = np.append(beams.details.nodes[:, 0], -1)[met] == nodes.elements[row]
    ends = ["" if k < 0 else "A" if head else "B" for k, head in zip(met.tolist(), heads, strict=True)]
    names, marks = nodes.piece_names, nodes.marks
    sizes = _sizes(nodes)
    on_tubes = np.isnan(sizes[:, 0])
    sizes[on_tubes] = _on_tubes(nodes, beams, np.where(on_tubes, met, -1), heads)[on_tubes]
    return [
        Column("Node", None, [names[k] for k in row.tolist()]),
        Column("Mark", None, [marks[k] for k in row.tolist()]),
        Column("Facet", 0, (around.place + 1).tolist()),
        Column("Beam", None, named(beams, around.values)),
        Column("End", None, ends),
        Column("Azimuth (deg)", 3, made.azimuths_deg.values.tolist()),
        Column("Setback (mm)", 3, made.setbacks_mm.values.tolist()),
        Column("Inclination (deg)", 3, own.inclinations_deg.values.tolist()),
        *(
            Column(
                f"Facet {what} (mm)",
                COORDINATE_DECIMALS,
                [None if value != value else value for value in sizes[:, k].tolist()],
            )
            for k, what in enumerate(("top", "bottom", "width"))
        ),
        Column("Beam level (mm)", 2, _beam_levels(nodes, beams, met)),
        *_bolts(nodes, assembly),
    ]


def _beam_levels(nodes: Parts[NodeDetails], beams: Parts[Any], met: IntArray) -> list[Cell]:
    """Where the middle of the outer side of the beam on each facet meets it, in mm along the axis from the point on the
    mesh. met (K,): the row of each beam, -1 where there is none."""
    made = nodes.details[nodes.firsts[nodes.mark]]
    azimuths, row = np.radians(made.azimuths_deg.values), nodes.details.beams.row
    facet = np.stack([np.cos(azimuths), np.sin(azimuths), np.zeros(len(azimuths))], axis=1)
    turned, known = nodes.axes[row], np.flatnonzero(met >= 0)
    starts, along = np.zeros_like(facet), facet.copy()
    starts[known] = np.einsum("kij,kj->ki", turned[known], beams.origins[met[known]] - nodes.origins[row[known]])
    along[known] = np.einsum("kij,kj->ki", turned[known], beams.axes[met[known], 0])
    reach = (made.setbacks_mm.values - (starts * facet).sum(axis=1)) / (along * facet).sum(axis=1)
    levels = (starts + reach[:, None] * along)[:, 2].tolist()
    return [level if k >= 0 else None for level, k in zip(levels, met.tolist(), strict=True)]


def _sizes(nodes: Parts[NodeDetails]) -> FloatArray:
    """(K, 3) level of the middle of the upper and of the lower side of each facet above the point on the mesh, and its
    width, in mm; NaN on a tube."""
    own = nodes.details[nodes.firsts[nodes.mark]]
    azimuths = np.radians(own.azimuths_deg.values)
    middles = own.setbacks_mm.values[:, None] * np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    found = np.full((len(azimuths), 3), np.nan)
    for batch in nodes.solids.by_topology(nodes.shape):
        n = len(np.unique(batch.topology.corners)) // 2
        facets = np.flatnonzero(np.isin(own.beams.row, batch.parts))
        if not n or not len(facets):
            continue
        block = np.searchsorted(batch.parts, own.beams.row[facets])
        here = batch.vertices[:, : 2 * n].reshape(-1, 2, n, 3)  # the lower corners, then the upper ones
        sides = (here + np.roll(here, -1, axis=2)) / 2
        off = np.linalg.norm(sides[block, 0, :, :2] - middles[facets, None], axis=2)
        side = off.argmin(axis=1)
        widths = np.linalg.norm((np.roll(here, -1, axis=2) - here)[block, 0, side, :2], axis=1)
        found[facets] = np.stack([sides[block, 1, side, 2], sides[block, 0, side, 2], widths], axis=1)
    return found


def _on_tubes(nodes: Parts[NodeDetails], beams: Parts[BeamDetails], met: IntArray, at_head: BoolArray) -> FloatArray:
    """(K, 3) as `_sizes`, of the end faces of the beams that are welded to tubes: levels of their highest and lowest
    corner, and their thickness; NaN without a beam. met (K,): the beam at each facet, -1 for none; at_head (K,):
    whether its end A is there."""
    row, found = nodes.details.beams.row, np.full((len(met), 3), np.nan)
    for batch in beams.solids.by_topology(beams.shape):
        t, here = batch.topology, np.flatnonzero(np.isin(met, batch.parts))
        if not len(here):
            continue
        names = beam_faces(beams.take(batch.parts), batch)
        own = np.searchsorted(batch.parts, met[here])
        of_end = names[own] == np.where(at_head[here], "END A", "END B")[:, None]
        is_in = of_end[:, t.corner_face]
        points = batch.vertices[own[:, None], t.corners[None]]
        across = points[..., 1]
        world = np.einsum("kci,kij->kcj", points, beams.axes[met[here]]) + beams.origins[met[here], None]
        levels = np.einsum("kcj,kj->kc", world - nodes.origins[row[here], None], nodes.axes[row[here], 2])
        for column, values in ((0, levels), (1, -levels), (2, across)):
            found[here, column] = np.where(is_in, values, -np.inf).max(axis=1)
        found[here, 1] *= -1
        found[here, 2] -= np.where(is_in, across, np.inf).min(axis=1)
    return found


def _bolts(nodes: Parts[NodeDetails], assembly: Assembly) -> list[Column]:
    """The number and the size of the bolts in each facet, which are all alike."""
    around = nodes.details.beams
    bolts = assembly.beside(nodes, BOLT)
    facet = facet_numbers(nodes, bolts.details.nodes, bolts.elements) - 1
    at = nodes.find(bolts.details.nodes)
    there = np.flatnonzero((facet >= 0) & (at >= 0))
    numbers = around.starts[at[there]] + facet[there]
    counts, sizes = np.bincount(numbers, minlength=len(around.values)), np.full(len(around.values), "", dtype=object)
    sizes[numbers] = bolts.details.size[there]
    return [
        Column("Bolts", 0, [count or None for count in counts.tolist()]),
        Column("Bolt size", None, sizes.tolist()),
    ]


def facet_numbers(nodes: Parts[NodeDetails], vertices: IntArray, edges: IntArray) -> IntArray:
    """(k,) number of the facet, counted from 1, for the beam on each of these edges (k,) at the node on each of these
    vertices (k,); 0 where there is none."""
    around = nodes.details.beams
    if not len(around.values) or not len(edges):
        return np.zeros(len(edges), dtype=np.int64)
    size = int(max(around.values.max(), edges.max())) + 1
    keys = nodes.elements[around.row] * size + around.values
    order = np.argsort(keys)
    wanted = vertices * size + edges
    place = order[np.minimum(np.searchsorted(keys[order], wanted), len(order) - 1)]
    found: IntArray = np.where(keys[place] == wanted, around.place[place] + 1, 0)
    return found


def at_ends(parts: Parts[Any], nodes: Parts[NodeDetails]) -> list[Column]:
    """The nodes at end A and end B of each part, or that to which it belongs, and the numbers of the facets there."""
    ends = np.full((len(parts), 2), -1)
    own = getattr(parts.details, "nodes", None)
    if own is not None:
        n_ends = 1 if own.ndim == 1 else 2
        ends[:, :n_ends] = own.reshape(len(parts), n_ends)
    elif parts.kind.element == "vertex":
        ends[:, 0] = parts.elements
    facets = np.zeros((len(parts), 2), dtype=np.int64)
    if parts.kind.element == "edge":
        facets = np.stack([facet_numbers(nodes, end, parts.elements) for end in ends.T], axis=1)
    numbers: list[list[Cell]] = [[number or None for number in column] for column in facets.T.tolist()]
    return [
        Column("Node A", None, named(nodes, ends[:, 0])),
        Column("Facet A", 0, numbers[0]),
        Column("Node B", None, named(nodes, ends[:, 1])),
        Column("Facet B", 0, numbers[1]),
    ]


def named(parts: Parts[Any], elements: IntArray) -> list[str]:
    """The piece on each of these mesh elements: nothing for a negative one, LEFT_OUT without a part."""
    names = [*parts.piece_names, LEFT_OUT, ""]
    found = np.where(elements < 0, len(parts) + 1, parts.find(elements))
    return [names[k if k >= 0 else -2] for k in found.tolist()]


def coordinates(name: str, points: FloatArray) -> list[Column]:
    return [Column(f"{name} {axis} (mm)", COORDINATE_DECIMALS, points[:, k].tolist()) for k, axis in enumerate("xyz")]


def directions(name: str, units: FloatArray) -> list[Column]:
    return [Column(f"{name} {axis}", DIRECTION_DECIMALS, units[:, k].tolist()) for k, axis in enumerate("xyz")]
