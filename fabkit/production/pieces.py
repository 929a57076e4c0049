"""Tables with one row for each physical piece, or for each facet or edge of one; one value a cell, for programs.

A piece has the name that its instance has in model.step: its mark and its mesh element, such as `B001 e7`, or
`C001 v7.2` for the second one of that mark at that element.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain, repeat
from typing import Any

import numpy as np

from fabkit.kinds import (
    BASE_PLATE,
    BEAM,
    LEFT_OUT,
    NODE,
    PANEL,
    STUB,
    BeamDetails,
    PanelDetails,
    neighbour_names,
    panel_sides,
)
from fabkit.parts import Assembly, Cell, Column, Frame, Parts
from fabkit.production.cut_lists import Table
from fabkit.production.erection import Erection, erection_order
from fabkit.production.marks import MARK_POINTS, KeptMarks, mark_points
from fabkit.production.nesting.nests import Nest
from fabkit.production.node_tables import (
    COORDINATE_DECIMALS,
    DIRECTION_DECIMALS,
    TURN_DECIMALS,
    at_ends,
    coordinates,
    directions,
    named,
    node_facets,
    survey,
)
from geometry.arrays import FloatArray

__all__ = ["mark_table", "piece_tables"]

BEVEL_DECIMALS = 4
"""Decimals of bevels in degrees: 5e-5 degrees are 1e-4 mm at the far side of a pane of 100 mm."""

SAME_SHAPE_MM = 1e-6
"""Largest difference in mm of a kept mark from its first shape that is rounding; these have 9 decimals."""


def piece_tables(
    assembly: Assembly, nest: Nest | None, *, panel_file: str = "panels/{}.dxf", site: Frame | None = None
) -> tuple[Table, ...]:
    """Tables of all pieces, of their placements, of the nodes to set out, of the facets of nodes and edges of panels.

    site: the frame of the mesh file on the site, in whose coordinates nodes are set out; by default it is the same.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import piece_tables
    >>> tables = piece_tables(built.assembly, built.nest)
    >>> [(table.title, table.n_rows) for table in tables]
    [('pieces', 60), ('placements', 60), ('survey', 18), ('node_facets', 60), ('panel_edges', 48)]
    >>> tables[0].rows[7][:7]
    ('B001 e7', 'B001', 'beam', '', 7, 'N001 v3', 1)
    """
    erection, on_site = erection_order(assembly), site or Frame.world()
    return (
        _stacked("pieces", [_pieces(parts, assembly, nest, erection, panel_file) for parts in assembly.groups]),
        _stacked("placements", [_placements(parts, assembly.origin_mm) for parts in assembly.groups]),
        _stacked("survey", [survey(nodes, assembly, on_site) for nodes in assembly.of_layers(NODE)]),
        _stacked("node_facets", [node_facets(nodes, assembly) for nodes in assembly.of_layers(NODE)]),
        _panel_edges(assembly),
        *([_supports(assembly, on_site)] if len(assembly.of(BASE_PLATE)) else []),
    )


def mark_table(assembly: Assembly, earlier: Mapping[str, KeptMarks]) -> Table:
    """By what marks are recognised in a later build that keeps them: one row for each corner of each, and for each
    direction of a beam on it; the same of the shape under which a kept mark was first given, where it is another one.
    earlier: by groups, the marks that were kept, of which those that no piece has any more are listed too, so that
    their numbers are not used again.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import mark_table
    >>> table = mark_table(built.assembly, {})
    >>> table.columns, len({row[1] for row in table.rows})
    (('Group', 'Mark', 'Material', 'Point', 'x', 'y', 'z'), 10)
    """
    known = {parts.kind.group: mark_points(parts) for parts in assembly.groups}
    words, points = [], [np.zeros((0, 3))]
    for group in dict.fromkeys([*earlier, *known]):
        before, now = (of.get(group, KeptMarks()).points for of in (earlier, known))
        for name, each in (before | now).items():
            first = before.get(name, each)
            shapes = (each, first) if each.apart_mm(first, 1.0) > SAME_SHAPE_MM else (each,)
            points += chain.from_iterable((shape.corners, shape.directions) for shape in shapes)
            words += [(group, name, each.material, what) for what in MARK_POINTS[: 2 * len(shapes)]]
    counts, xyz = list(map(len, points[1:])), np.concatenate(points).T.tolist()
    labels = [
        Column(title, None, [*chain.from_iterable(map(repeat, (row[k] for row in words), counts))])
        for k, title in enumerate(("Group", "Mark", "Material", "Point"))
    ]
    numbers = [Column(axis, DIRECTION_DECIMALS, cells) for axis, cells in zip("xyz", xyz, strict=True)]
    return Table("mark_points", (*labels, *numbers))


def _pieces(
    parts: Parts[Any], assembly: Assembly, nest: Nest | None, erection: Erection, panel_file: str
) -> list[Column]:
    """What each part is, the nodes at its ends, its mass, when and from where it goes in, its file and its place on a
    sheet."""
    n, pattern = len(parts), panel_file if parts.kind.first_edge else "parts/{}.step"
    placed = nest.placements if nest is not None and parts.kind is PANEL else ()
    places: list[tuple[Cell, ...]] = [(p.sheet + 1, *p.offset_mm, p.angle_deg) for p in placed]
    places = places or [(None,) * 4] * n
    sheet: list[Sequence[Cell]] = [[row[k] for row in places] for k in range(4)]
    return [
        Column("Piece", None, parts.piece_names),
        Column("Mark", None, parts.marks),
        Column("Kind", None, [parts.kind.name] * n),
        Column("Zone", None, assembly.zones.named(parts)),
        Column("Element", 0, parts.elements.tolist()),
        *at_ends(parts, assembly.beside(parts, NODE)),
        Column("Mass (kg)", 3, parts.masses_kg.tolist()),
        Column("Order", 0, [*erection.numbers[parts.kind.group].tolist()]),
        *_going_in(parts, erection),
        Column("File", None, [pattern.format(mark) for mark in parts.marks]),
        Column("Sheet", 0, sheet[0]),
        Column("Sheet x (mm)", COORDINATE_DECIMALS, sheet[1]),
        Column("Sheet y (mm)", COORDINATE_DECIMALS, sheet[2]),
        Column("Sheet turn (deg)", TURN_DECIMALS, sheet[3]),
        Column("Turned over", None, ["yes" if over else "" for over in parts.turned_over.tolist()]),
        Column("Hidden difference (mm)", 3, parts.hidden_mm[:, 0].tolist()),
        Column(
            "Hidden at far ends (mm)",
            3,
            [None] * n if parts.kind.directions is None else parts.hidden_mm[:, 1].tolist(),
        ),
    ]


def _going_in(parts: Parts[Any], erection: Erection) -> list[Column]:
    """Of each beam the side from which it goes in, whether it comes last between two nodes that stand, and the gap that
    it then needs at either end to go in from outside; empty cells for other parts."""
    sides: Sequence[Cell] = [""] * len(parts)
    closing: Sequence[Cell] = sides
    gaps: Sequence[Cell] = [None] * len(parts)
    if isinstance(parts.details, BeamDetails):
        sides, gaps = parts.details.goes_in_from, parts.details.going_in_gaps_mm[:, 0].tolist()
        closing = ["yes" if each else "no" for each in erection.is_closing[parts.kind.group].tolist()]
    return [
        Column("Goes in from", None, sides),
        Column("Closing", None, closing),
        Column("Gap from outside (mm)", 1, gaps),
    ]


def _placements(parts: Parts[Any], origin_mm: FloatArray) -> list[Column]:
    """The own frame of each part and its centre of mass, at the coordinates of the mesh file."""
    return [
        Column("Piece", None, parts.piece_names),
        Column("Mark", None, parts.marks),
        *coordinates("Origin", parts.origins + origin_mm),
        *directions("X axis", parts.axes[:, 0]),
        *directions("Z axis", parts.axes[:, 2]),
        *coordinates("Centre", parts.centres_mm + origin_mm),
    ]


def _supports(assembly: Assembly, site: Frame) -> Table:
    """Of each base plate the middle of its underside, its normal upwards, and the direction of two of its edges, in the
    coordinates of the site."""
    plates = assembly.of(BASE_PLATE)
    return Table(
        "supports",
        (
            Column("Support", None, plates.piece_names),
            Column("Mark", None, plates.marks),
            Column("Zone", None, assembly.zones.named(plates)),
            Column("Node", None, named(assembly.of(NODE), plates.elements)),
            *coordinates("Point", site.to_world(plates.origins + assembly.origin_mm)),
            *directions("Axis", plates.axes[:, 2] @ site.axes),
            *directions("Edge", plates.axes[:, 0] @ site.axes),
            Column("Stub", None, named(assembly.of(STUB), plates.elements)),
        ),
    )


def _panel_edges(assembly: Assembly) -> Table:
    """One row for each edge of each panel, counted from 1, the longest, counter-clockwise seen from outside; length,
    corner, that at its start, and bevel are those of the panel as it is made."""
    panels = assembly.of(PANEL)
    own, made = panels.details, panels.details[panels.firsts[panels.mark]]
    row = own.edge_lengths_mm.row
    names, marks = panels.piece_names, panels.marks
    return Table(
        "panel_edges",
        (
            Column("Panel", None, [names[k] for k in row.tolist()]),
            Column("Mark", None, [marks[k] for k in row.tolist()]),
            Column("Layer", 0, own.layer[row].tolist()),
            Column("Pane", 0, own.pane[row].tolist()),
            Column("Edge", 0, (own.edge_lengths_mm.place + 1).tolist()),
            Column("Length (mm)", 3, made.edge_lengths_mm.values.tolist()),
            Column("Corner (deg)", TURN_DECIMALS, made.corner_angles_deg.values.tolist()),
            Column("Bevel (deg)", BEVEL_DECIMALS, _bevels(panels)),
            Column("Dihedral (deg)", 3, _cells(own.dihedrals_deg.values)),
            Column("Least seat (mm)", 3, _cells(own.least_seats_mm.values)),
            Column("Largest seat (mm)", 3, _cells(own.largest_seats_mm.values)),
            Column("Step (mm)", 3, _cells(own.steps_mm.values)),
            Column("Beam", None, named(assembly.of(BEAM), own.beams.values)),
            Column("Neighbour", None, neighbour_names(panels, names, LEFT_OUT, "")),
        ),
    )


def _bevels(panels: Parts[PanelDetails]) -> list[Cell]:
    """Of each edge of each panel the angle from the square cut, positive where the upper side reaches further; nothing
    where it is square."""
    lower, upper = panel_sides(panels)
    along = lower.rolled(np.ones(len(lower), dtype=np.int64)).values - lower.values
    off = upper.values - lower.values
    reach = (off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0]) / np.linalg.norm(along, axis=1)
    bevels = np.degrees(np.arctan2(reach, panels.details.thickness_mm[lower.row]))
    return _cells(np.where(np.abs(bevels) < 10.0**-BEVEL_DECIMALS / 2, np.nan, bevels))


def _cells(values: FloatArray) -> list[Cell]:
    """Numbers, and nothing for what is none."""
    return [None if value != value else value for value in values.tolist()]


def _stacked(title: str, groups: Sequence[Sequence[Column]]) -> Table:
    """The rows of all groups, one after the other."""
    same = zip(*groups, strict=True)
    return Table(
        title,
        tuple(Column(own[0].title, own[0].decimals, [cell for each in own for cell in each.cells]) for own in same),
    )
