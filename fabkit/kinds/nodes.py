"""Nodes: prisms along the node axes, with a facet for each beam."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.spatial import cKDTree

from fabkit.kinds.columns import (
    counted,
    each_value,
    files,
    joined,
    marks_and_counts,
    marks_in,
    masses,
    materials,
    of_first,
    over_all,
)
from fabkit.kinds.faces import node_faces
from fabkit.kinds.look_alikes import look_alikes
from fabkit.parts import Column, Details, Kind, Measure, Parts, Ragged, Surroundings, Symmetry, Topology, Turns, shifted
from fabkit.parts.symmetry import Corners
from geometry.arrays import BoolArray, FloatArray, IntArray, floats

__all__ = ["NODE", "NodeDetails", "block_ends", "smallest_gaps"]


@dataclass(frozen=True, eq=False)
class NodeDetails(Details):
    """Data of n nodes.

    Own frame of a node: origin at the mesh vertex, z along the node axis outwards, x towards the first beam. Each row
    has a value for each of its beams, counter-clockwise seen from outside.

    beams: mesh edges. azimuths_deg: directions of the beams about the axis, the first one zero. inclinations_deg:
    angles of the beams' axes above the plane perpendicular to the node axis. setbacks_mm: distances of the facets from
    the axis. uncovered_percent: how much of the end of each beam stands above the block, of its width times its height.
    height_mm (n,): from bottom to top. top_step_mm (n,): largest difference in level between the tops of the
    beams at their ends. axis_misalignment_mm (n,): largest distance between the points in which the centre lines of the
    beams' outer sides, or of their inner sides, meet the axis. It is zero in edge offset meshes, even where some beams
    descend from the node and others rise, so that their ends differ in level.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> nodes = built.assembly["nodes"].details
    >>> nodes.beams[0].tolist(), nodes.azimuths_deg[0].round(1).tolist(), round(nodes.height_mm[0])
    ([0, 3, 27], [0.0, 84.0, 168.0], 146)
    """

    beams: Ragged
    azimuths_deg: Ragged
    inclinations_deg: Ragged
    setbacks_mm: Ragged
    uncovered_percent: Ragged
    height_mm: FloatArray
    top_step_mm: FloatArray
    axis_misalignment_mm: FloatArray

    @cached_property
    def look_alikes(self) -> tuple[BoolArray, BoolArray]:
        """(n,) whether each node could be mounted turned, and (n,) upside down: it looks as if it was in place then,
        but its beams would not fit."""
        return look_alikes(self.azimuths_deg, self.inclinations_deg, self.setbacks_mm)

    def uncovered_at(self, edges: IntArray, nodes: IntArray) -> FloatArray:
        """(K,) how much of the end of the beam on each edge (K,) stands above each node (K,), in per cent; 0 for a beam
        that is not at that node."""
        pairs = (self.beams.row << 32) + self.beams.values
        order = np.argsort(pairs)
        wanted = (nodes << 32) + edges
        place = np.minimum(np.searchsorted(pairs[order], wanted), max(len(pairs) - 1, 0))
        if not len(pairs):
            return np.zeros(len(edges))
        return np.where(pairs[order][place] == wanted, self.uncovered_percent.values[order][place], 0.0)


def _turns(nodes: Parts[NodeDetails], corners: FloatArray) -> Turns:
    """The turns of nodes: each of their beams in turn is the first."""
    topology = nodes.solids.topologies[nodes.solids.topology[nodes.shape[0]]]
    azimuths = np.radians(nodes.details.azimuths_deg.values).reshape(len(nodes), -1)
    forwards = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=2)
    facets = forwards * nodes.details.setbacks_mm.values.reshape(len(nodes), -1, 1)
    n = len(np.unique(topology.corners)) // 2
    first = np.zeros(forwards.shape[:2], dtype=np.int64)
    if n:
        first = _nearest((corners[:, :n, :2] + np.roll(corners[:, :n, :2], -1, axis=1)) / 2, facets)
    first[:, :1] = 0
    return Turns(np.zeros_like(forwards), forwards, _renumbered(topology, shifted(first, n), forwards.shape[1]))


def _renumbered(topology: Topology, of_prism: Corners, n_beams: int) -> Corners:
    """The renumbering of the vertices of a block or hub. Those of the prism turn with it, and those in the middle of
    the node, and the dot that says which facet is the first, stay; the others belong to its beams, equally many to
    each, beam after beam: bores in facets, or points at which beams are welded to a tube."""
    in_middle = topology.rounds[topology.rounds[:, 4] < 2, :4].ravel()
    n_prism = len(np.unique(topology.corners))
    own = np.setdiff1d(np.arange(n_prism, topology.n_vertices), in_middle)
    place = np.full(topology.n_vertices, -1, dtype=np.int64)
    place[own] = np.arange(len(own))

    def corners(parts: IntArray, turns: IntArray, chosen: IntArray) -> IntArray:
        result = np.tile(chosen, (len(parts), 1))
        prism = chosen < n_prism
        if prism.any():
            result[:, prism] = of_prism(parts, turns, chosen[prism])
        of_beams = place[chosen] >= 0
        moved = place[chosen[of_beams]] + turns[:, None] * (len(own) // n_beams)
        result[:, of_beams] = own[moved % max(1, len(own))] if len(own) else result[:, of_beams]
        return result

    return corners


def _directions(nodes: Parts[NodeDetails]) -> Ragged:
    """Normals of the facets, which are parallel to the node axis: inclinations are in the cuts of the beams."""
    azimuths = np.radians(nodes.details.azimuths_deg.values)
    units = [np.cos(azimuths), np.sin(azimuths), np.zeros(len(azimuths))]
    return nodes.details.azimuths_deg.with_values(np.stack(units, axis=1))


def _nearest(points: FloatArray, targets: FloatArray) -> IntArray:
    """(m, t) number of the nearest of its own points (m, n, 2) to each of its targets (m, t, 2), for m nodes."""
    spacing = 4 * np.abs(targets).max(initial=0.0) + 4 * np.abs(points).max(initial=0.0)
    layer = spacing * np.arange(len(points), dtype=np.float64)[:, None, None]

    def in_layers(flat: FloatArray) -> FloatArray:
        return np.concatenate([flat, np.broadcast_to(layer, (*flat.shape[:2], 1))], axis=2).reshape(-1, 3)

    found = cKDTree(in_layers(points)).query(in_layers(targets))[1]
    nearest: IntArray = found.reshape(targets.shape[:2]) % points.shape[1]
    return nearest


def _columns(nodes: Parts[NodeDetails], around: Surroundings) -> list[Column]:
    own = nodes.details
    beams = joined(marks_in(around, nodes.kind.named("beams"), own.beams.values), own.beams.starts)
    return [
        *marks_and_counts(nodes),
        of_first("Valence", 0, nodes, own.beams.sizes),
        materials(nodes),
        counted("Beams", nodes, beams),
        each_value("Azimuths (deg)", 2, nodes, own.azimuths_deg),
        each_value("Inclinations (deg)", 2, nodes, own.inclinations_deg),
        each_value("Setbacks (mm)", 2, nodes, own.setbacks_mm),
        each_value("Uncovered (%)", 1, nodes, own.uncovered_percent),
        of_first("Height (mm)", 2, nodes, own.height_mm),
        *_ends(nodes),
        _could_be_mounted(nodes),
        *over_all("Step between tops (mm)", 2, nodes, own.top_step_mm),
        *over_all("Axis misalignment (mm)", 2, nodes, own.axis_misalignment_mm),
        *masses(nodes),
        files(nodes, "parts/{}.step"),
    ]


def _ends(nodes: Parts[NodeDetails]) -> list[Column]:
    return [
        of_first(f"{name} (mm)", 2, nodes, values)
        for name, values in zip(("Top", "Bottom"), block_ends(nodes), strict=True)
    ]


def block_ends(nodes: Parts[NodeDetails]) -> tuple[FloatArray, FloatArray]:
    """(n,) levels in mm of the top and of the bottom of each block along its axis, from the point on the mesh.

    >>> from fabkit import Project, design
    >>> from fabkit.kinds import block_ends
    >>> from geometry.mesh.shapes import dome
    >>> nodes = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["nodes"]
    >>> tops, bottoms = block_ends(nodes)
    >>> np.allclose(tops - bottoms, nodes.details.height_mm)
    True
    """
    levels = nodes.solids.vertices.with_values(nodes.solids.vertices.values[:, 2])
    top, bottom = (floats(levels.reduced(function)[nodes.shape]) for function in (np.maximum, np.minimum))
    return top, bottom


def _could_be_mounted(nodes: Parts[NodeDetails]) -> Column:
    turned, upside_down = (each[nodes.firsts].tolist() for each in nodes.details.look_alikes)
    words = {True: "turned", False: ""}, {True: "upside down", False: ""}
    cells = [" or ".join(filter(None, (words[0][a], words[1][b]))) for a, b in zip(turned, upside_down, strict=True)]
    return Column("Could be mounted", None, cells)


def _measures(nodes: Parts[NodeDetails]) -> list[Measure]:
    own, measure = nodes.details, partial(Measure, nodes.kind.group)
    return [
        measure("Step between beam tops", "mm", 2, own.top_step_mm),
        measure("Misalignment at the node axis", "mm", 2, own.axis_misalignment_mm),
        measure("Largest setback", "mm", 1, own.setbacks_mm.reduced(np.maximum)),
        measure("Uncovered part of a beam's end", "%", 1, own.uncovered_percent.reduced(np.maximum)),
        measure("Smallest angle between beams", "°", 1, smallest_gaps(own.azimuths_deg)),
        measure("Height of a node", "mm", 1, own.height_mm),
        measure("Mass of a node", "kg", 2, nodes.masses_kg),
    ]


def smallest_gaps(azimuths_deg: Ragged) -> FloatArray:
    """(n,) smallest angle in degrees between neighbouring beams about the axis; NaN for fewer than two beams.

    >>> from fabkit.parts import Ragged
    >>> from fabkit.kinds import smallest_gaps
    >>> smallest_gaps(Ragged.of([[0, 80, 230], [0, 90]])).tolist()
    [80.0, 90.0]
    """
    following = azimuths_deg.rolled(np.ones(len(azimuths_deg), dtype=np.int64)).values
    is_last = azimuths_deg.place == azimuths_deg.sizes[azimuths_deg.row] - 1
    gaps = azimuths_deg.with_values(np.where(is_last, following + 360.0, following) - azimuths_deg.values)
    return np.where(azimuths_deg.sizes < 2, np.nan, gaps.reduced(np.minimum))


def _labels(nodes: Parts[NodeDetails], around: Surroundings) -> list[str]:
    names = [f"{each.name}; vertex" for each in nodes.materials]
    rows = zip(nodes.material.tolist(), nodes.elements.tolist(), nodes.details.beams.sizes.tolist(), strict=True)
    return [f"{names[material]} {vertex}, {n_beams} beams" for material, vertex, n_beams in rows]


NODE = Kind(
    name="node",
    group="nodes",
    element="vertex",
    letter="N",
    colour=(0.80, 0.42, 0.16),
    form="block",
    frame="Origin at the vertex of the mesh of its layer, z along the node axis outwards, x towards facet 1.",
    empty_details=NodeDetails(
        beams=Ragged.of([], dtype=np.int64),
        azimuths_deg=Ragged.of([]),
        inclinations_deg=Ragged.of([]),
        setbacks_mm=Ragged.of([]),
        uncovered_percent=Ragged.of([]),
        height_mm=np.zeros(0),
        top_step_mm=np.zeros(0),
        axis_misalignment_mm=np.zeros(0),
    ),
    symmetry=Symmetry(
        ("beams", "azimuths_deg", "inclinations_deg", "setbacks_mm", "uncovered_percent"), ("azimuths_deg",), _turns
    ),
    columns=_columns,
    measures=_measures,
    labels=_labels,
    faces=node_faces,
    directions=_directions,
)
