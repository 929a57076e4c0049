"""Tables with one row for each physical piece, or for each facet or edge of one; one value a cell, for programs.

A piece has the name that its instance has in model.step: its mark and its mesh element, such as `B001 e7`, or
`C001 v7.2` for the second one of that mark at that element.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fabkit.kinds import BASE_PLATE, BEAM, LEFT_OUT, NODE, PANEL, STUB, BeamDetails, NodeDetails, neighbour_names
from fabkit.parts import Assembly, Cell, Column, Parts
from fabkit.production.cut_lists import Table
from fabkit.production.erection import Erection, erection_order
from fabkit.production.marks import KeptMarks, mark_points
from fabkit.production.nesting.nests import Nest
from geometry.arrays import FloatArray, IntArray

__all__ = ["mark_table", "piece_tables"]

COORDINATE_DECIMALS, TURN_DECIMALS, DIRECTION_DECIMALS = 3, 6, 9
"""Decimals in tables of coordinates in mm, turns in degrees and unit vectors: together they place a piece of 10 m to
0.001 mm."""


def piece_tables(assembly: Assembly, nest: Nest | None, *, panel_file: str = "panels/{}.dxf") -> tuple[Table, ...]:
    """Tables of all pieces, of their placements, of the nodes to set out, of the facets of nodes and edges of panels.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import piece_tables
    >>> tables = piece_tables(built.assembly, built.nest)
    >>> [(table.title, len(table.rows)) for table in tables]
    [('pieces', 60), ('placements', 60), ('survey', 18), ('node_facets', 60), ('panel_edges', 48)]
    >>> tables[0].rows[7][:6]
    ('B001 e7', 'B001', 'beam', 7, 'N001 v3', 'N001 v6')
    """
    erection = erection_order(assembly)
    return (
        _stacked("pieces", [_pieces(parts, assembly, nest, erection, panel_file) for parts in assembly.groups]),
        _stacked("placements", [_placements(parts, assembly.origin_mm) for parts in assembly.groups]),
        _stacked("survey", [_survey(nodes, assembly.origin_mm) for nodes in assembly.of_layers(NODE)]),
        _stacked("node_facets", [_node_facets(nodes, assembly) for nodes in assembly.of_layers(NODE)]),
        _panel_edges(assembly),
        *([_supports(assembly)] if len(assembly.of(BASE_PLATE)) else []),
    )


def mark_table(assembly: Assembly, earlier: Mapping[str, KeptMarks]) -> Table:
    """By what marks are recognised in a later build that keeps them: one row for each corner of each, and for each
    direction of a beam on it. earlier: by groups, the marks that were kept, of which those that no piece has any more
    are listed too, so that their numbers are not used again.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import mark_table
    >>> table = mark_table(built.assembly, {})
    >>> table.columns, len({row[1] for row in table.rows})
    (('Group', 'Mark', 'Material', 'Point', 'x', 'y', 'z'), 10)
    """
    rows: list[tuple[Cell, ...]] = []
    known = {parts.kind.group: mark_points(parts) for parts in assembly.groups}
    for group in dict.fromkeys([*earlier, *known]):
        marks = {**earlier.get(group, KeptMarks()).points, **known.get(group, KeptMarks()).points}
        for name, each in marks.items():
            for what, points in (("corner", each.corners), ("direction", each.directions)):
                rows += [(group, name, each.material, what, *point) for point in points.tolist()]
    decimals = (None, None, None, None, *[DIRECTION_DECIMALS] * 3)
    return Table("mark_points", ("Group", "Mark", "Material", "Point", "x", "y", "z"), decimals, tuple(rows))


def _pieces(
    parts: Parts[Any], assembly: Assembly, nest: Nest | None, erection: Erection, panel_file: str
) -> list[Column]:
    """What each part is, the nodes at its ends, its mass, when and from where it goes in, its file and its place on a
    sheet."""
    n, pattern = len(parts), panel_file if parts.kind.first_edge else "parts/{}.step"
    ends = np.full((n, 2), -1)
    if isinstance(parts.details, BeamDetails):
        ends = parts.details.nodes
    elif parts.kind.element == "vertex":
        ends[:, 0] = parts.elements
    placed = nest.placements if nest is not None and parts.kind is PANEL else ()
    places: list[tuple[Cell, ...]] = [(p.sheet + 1, *p.offset_mm, p.angle_deg) for p in placed]
    places = places or [(None,) * 4] * n
    sheet: list[Sequence[Cell]] = [[row[k] for row in places] for k in range(4)]
    return [
        Column("Piece", None, parts.piece_names),
        Column("Mark", None, parts.marks),
        Column("Kind", None, [parts.kind.name] * n),
        Column("Element", 0, parts.elements.tolist()),
        Column("Node A", None, _named(assembly.beside(parts, NODE), ends[:, 0])),
        Column("Node B", None, _named(assembly.beside(parts, NODE), ends[:, 1])),
        Column("Mass (kg)", 3, parts.masses_kg.tolist()),
        Column("Order", 0, [number or None for number in erection.of(parts).tolist()]),
        *_going_in(parts, erection),
        Column("File", None, [pattern.format(mark) for mark in parts.marks]),
        Column("Sheet", 0, sheet[0]),
        Column("Sheet x (mm)", COORDINATE_DECIMALS, sheet[1]),
        Column("Sheet y (mm)", COORDINATE_DECIMALS, sheet[2]),
        Column("Sheet turn (deg)", TURN_DECIMALS, sheet[3]),
    ]


def _going_in(parts: Parts[Any], erection: Erection) -> list[Column]:
    """Of each beam the side from which it goes in, whether it comes last between two nodes that stand, and the gap that
    it then needs at either end to go in from outside; empty cells for other parts."""
    sides: Sequence[Cell] = [""] * len(parts)
    closing: Sequence[Cell] = sides
    gaps: Sequence[Cell] = [None] * len(parts)
    if isinstance(parts.details, BeamDetails):
        sides, gaps = parts.details.goes_in_from, parts.details.going_in_gaps_mm[:, 0].tolist()
        closing = ["yes" if each else "no" for each in erection.closing(parts).tolist()]
    return [
        Column("Goes in from", None, sides),
        Column("Closing", None, closing),
        Column("Gap from outside (mm)", 1, gaps),
    ]


def _placements(parts: Parts[Any], origin_mm: FloatArray) -> list[Column]:
    """The own frame of each part and its centre of mass, at the coordinates of the mesh file."""
    centroids = parts.solids.centroids[parts.shape]
    centres = parts.origins + (centroids[:, None] @ parts.axes)[:, 0]
    return [
        Column("Piece", None, parts.piece_names),
        Column("Mark", None, parts.marks),
        *_points("Origin", parts.origins + origin_mm),
        *_directions("X axis", parts.axes[:, 0]),
        *_directions("Z axis", parts.axes[:, 2]),
        *_points("Centre", centres + origin_mm),
    ]


def _survey(nodes: Parts[NodeDetails], origin_mm: FloatArray) -> list[Column]:
    """Of each node its point on the mesh of its layer, at the coordinates of the mesh file, its axis outwards, and the
    heights of the block's top and bottom along it from that point."""
    heights = nodes.solids.vertices.with_values(nodes.solids.vertices.values[:, 2])[nodes.shape]
    return [
        Column("Node", None, nodes.piece_names),
        Column("Mark", None, nodes.marks),
        *_points("Point", nodes.origins + origin_mm),
        *_directions("Axis", nodes.axes[:, 2]),
        Column("Top (mm)", COORDINATE_DECIMALS, heights.reduced(np.maximum).tolist()),
        Column("Bottom (mm)", COORDINATE_DECIMALS, heights.reduced(np.minimum).tolist()),
    ]


def _node_facets(nodes: Parts[NodeDetails], assembly: Assembly) -> list[Column]:
    """Of each facet of each node, counted from 1 counter-clockwise seen from outside, the beam there and the end of the
    beam that meets it."""
    beams = assembly.beside(nodes, BEAM)
    own = nodes.details
    around, row = own.beams, own.beams.row
    met = beams.find(around.values)
    heads = np.append(beams.details.nodes[:, 0], -1)[met] == nodes.elements[row]
    ends = ["" if k < 0 else "A" if head else "B" for k, head in zip(met.tolist(), heads, strict=True)]
    names, marks = nodes.piece_names, nodes.marks
    return [
        Column("Node", None, [names[k] for k in row.tolist()]),
        Column("Mark", None, [marks[k] for k in row.tolist()]),
        Column("Facet", 0, (around.place + 1).tolist()),
        Column("Beam", None, _named(beams, around.values)),
        Column("End", None, ends),
        Column("Azimuth (deg)", 3, own.azimuths_deg.values.tolist()),
        Column("Setback (mm)", 3, own.setbacks_mm.values.tolist()),
        Column("Inclination (deg)", 3, own.inclinations_deg.values.tolist()),
    ]


def _supports(assembly: Assembly) -> Table:
    """Of each base plate the middle of its underside, at the coordinates of the mesh file, its normal upwards, and the
    direction of two of its edges."""
    plates = assembly.of(BASE_PLATE)
    return _table(
        "supports",
        [
            Column("Support", None, plates.piece_names),
            Column("Mark", None, plates.marks),
            Column("Node", None, _named(assembly.of(NODE), plates.elements)),
            *_points("Point", plates.origins + assembly.origin_mm),
            *_directions("Axis", plates.axes[:, 2]),
            *_directions("Edge", plates.axes[:, 0]),
            Column("Stub", None, _named(assembly.of(STUB), plates.elements)),
        ],
    )


def _panel_edges(assembly: Assembly) -> Table:
    """One row for each edge of each panel, counted from 1, the longest, counter-clockwise seen from outside; the corner
    is that at its start."""
    panels = assembly.of(PANEL)
    own = panels.details
    row = own.edge_lengths_mm.row
    names, marks = panels.piece_names, panels.marks
    dihedrals: list[Cell] = [None if value != value else value for value in own.dihedrals_deg.values.tolist()]
    return _table(
        "panel_edges",
        [
            Column("Panel", None, [names[k] for k in row.tolist()]),
            Column("Mark", None, [marks[k] for k in row.tolist()]),
            Column("Edge", 0, (own.edge_lengths_mm.place + 1).tolist()),
            Column("Length (mm)", 3, own.edge_lengths_mm.values.tolist()),
            Column("Corner (deg)", 3, own.corner_angles_deg.values.tolist()),
            Column("Dihedral (deg)", 3, dihedrals),
            Column("Beam", None, _named(assembly.of(BEAM), own.beams.values)),
            Column("Neighbour", None, neighbour_names(panels, names, LEFT_OUT, "")),
        ],
    )


def _named(parts: Parts[Any], elements: IntArray) -> list[str]:
    """The piece on each of these mesh elements: nothing for a negative one, LEFT_OUT without a part."""
    names = [*parts.piece_names, LEFT_OUT, ""]
    found = np.where(elements < 0, len(parts) + 1, parts.find(elements))
    return [names[k if k >= 0 else -2] for k in found.tolist()]


def _points(name: str, points: FloatArray) -> list[Column]:
    return [Column(f"{name} {axis} (mm)", COORDINATE_DECIMALS, points[:, k].tolist()) for k, axis in enumerate("xyz")]


def _directions(name: str, units: FloatArray) -> list[Column]:
    return [Column(f"{name} {axis}", DIRECTION_DECIMALS, units[:, k].tolist()) for k, axis in enumerate("xyz")]


def _stacked(title: str, groups: Sequence[Sequence[Column]]) -> Table:
    """The rows of all groups, one after the other."""
    same = zip(*groups, strict=True)
    return _table(
        title,
        [Column(own[0].title, own[0].decimals, [cell for each in own for cell in each.cells]) for own in same],
    )


def _table(title: str, columns: Sequence[Column]) -> Table:
    rows = tuple(zip(*(column.cells for column in columns), strict=True))
    return Table(title, tuple(column.title for column in columns), tuple(column.decimals for column in columns), rows)
