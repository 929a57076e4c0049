"""Bolted connections, measured back from the written STEP file, whose cylinders are read without our solids."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.linalg import norm

from fabkit.checking import violations
from fabkit.detailing import detail
from fabkit.errors import DetailingError
from fabkit.kinds import BOLT, END_PLATE
from fabkit.parts import Part, Surroundings
from fabkit.production import piece_tables, share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, NodeRules
from geometry.arrays import FloatArray
from tests.fabkit.part21 import StepText, coordinates, written
from tests.fabkit.test_detail import SIDE, flat_grid

FILE_MM = 1e-6
"""Coordinates are written with this accuracy at least."""


def rules(**connection: Any) -> DetailingRules:
    return DetailingRules(
        beams=BeamRules(section="rhs 120x60x5"),
        connection=ConnectionRules(kind="bolted", **connection),
        nodes=NodeRules(top="enclosing"),
    )


@pytest.fixture(scope="module")
def grid() -> Any:
    return detail(flat_grid(), rules(), name="grid").assembly


@dataclass(frozen=True)
class Cylinder:
    radius: float
    centres: FloatArray
    """Of the circles on it, (n, 3)."""


def cylinders(part: Part) -> Iterator[Cylinder]:
    """Of the faces of a part file: each with its circles, from the text alone."""
    file = written(replace(part, mark="P"))
    for face in file.all("ADVANCED_FACE"):
        surface = file[face.values[2]]
        if surface.kind == "CYLINDRICAL_SURFACE":
            yield Cylinder(round(float(surface.values[2]), 9), np.array(list(centres(file, face.values[1]))))


def centres(file: StepText, bounds: list[int]) -> Iterator[FloatArray]:
    for reference in set(reached(file, bounds)):
        if file[reference].kind == "CIRCLE":
            placement = file[file[reference].values[1]]
            yield coordinates(file, placement.values[1])


def reached(file: StepText, value: Any) -> Iterator[int]:
    for reference in file.references(value):
        yield reference
        yield from reached(file, file[reference].values)


def test_an_end_has_a_plate_a_bolt_and_a_dowel(grid: Any) -> None:
    counts = {group.kind.group: len(group) for group in grid.groups}
    assert counts == {"beams": 17, "nodes": 12, "panels": 6, "end plates": 34, "bolts": 34, "dowels": 34}
    assert not violations(grid)
    two = detail(flat_grid(), rules(bolts="2xM16"), name="grid").assembly
    assert len(two["bolts"]) == 68
    assert "dowels" not in {group.kind.group for group in two.groups}
    assert not violations(two)


def test_bores_of_a_written_plate_keep_their_edges(grid: Any) -> None:
    found = sorted((each.radius, tuple(np.ptp(each.centres, axis=0))) for each in cylinders(grid["end plates"][0]))
    assert found == [(5.0, pytest.approx((15.0, 0, 0))), (11.0, pytest.approx((15.0, 0, 0)))]
    for each in cylinders(grid["end plates"][0]):
        y, z = np.abs(each.centres[0, 1:])
        assert min(30 - y, 60 - z) >= 1.2 * 2 * each.radius - FILE_MM


def test_bores_of_a_written_node_keep_their_walls(grid: Any) -> None:
    """All bores lie in planes across the axis: as strips in a plane, where their levels overlap."""
    node = grid["nodes"][int(grid["nodes"].details.beams.sizes.argmax())]
    bores = list(cylinders(node))
    assert Counter(each.radius for each in bores) == {10.0: 4, 5.0: 4}
    strips = [shapely.LineString(each.centres[:, :2]).buffer(each.radius, cap_style="flat") for each in bores]
    for k, one in enumerate(strips):
        for m in range(k):
            apart = abs(bores[k].centres[0, 2] - bores[m].centres[0, 2]) - bores[k].radius - bores[m].radius
            assert max(apart, one.distance(strips[m])) >= 6 - FILE_MM
    depths = {each.radius: norm(np.ptp(each.centres, axis=0)) for each in bores}
    assert depths == {10.0: pytest.approx(39.0), 5.0: pytest.approx(15.0)}


def test_a_written_bolt_fills_its_bores(grid: Any) -> None:
    bolt, node = grid["bolts"][0], grid["nodes"][int(grid["nodes"].find(grid["bolts"].details.nodes[:1])[0])]
    assert bolt.details.size == "M20x40"
    shank = next(each for each in cylinders(bolt) if each.radius == 10.0)
    ends = bolt.placement.to_world(shank.centres)
    bores = [each for each in cylinders(node) if each.radius == 10.0]
    axes = [node.placement.to_world(each.centres) for each in bores]
    off = [np.abs(np.cross(axis[1] - axis[0], ends - axis[0])).max() / norm(axis[1] - axis[0]) for axis in axes]
    assert min(off) < FILE_MM
    inside = min(norm(ends[:, None] - axis[None], axis=2).min() for axis in axes)
    assert inside == pytest.approx(39 - 25)  # the bolt engages 25 of 39 mm


def test_slots_between_plates_are_as_wide_as_the_rules_ask() -> None:
    thin = detail(flat_grid(), rules(slot_mm=40.0), name="grid").assembly
    plates = thin[END_PLATE.group]
    at = np.flatnonzero(plates.details.nodes == thin["nodes"].elements[thin["nodes"].details.beams.sizes.argmax()])
    seen = [
        shapely.convex_hull(
            shapely.MultiPoint(plates[int(k)].placement.to_world(plates[int(k)].solid.vertices)[:8, :2])
        )
        for k in at
    ]
    distances = [one.distance(other) for n, one in enumerate(seen) for other in seen[:n]]
    assert min(distances) == pytest.approx(40.0)


def test_beams_have_a_hand_hole_at_either_end_on_the_side_where_a_left_hand_is(grid: Any) -> None:
    beam = grid["beams"][0]
    length = float(beam.details.long_point_mm)
    y = beam.solid.vertices[:, 1]
    inside = beam.solid.vertices[(np.abs(beam.solid.vertices[:, 2] + 60) < 35.5)]
    assert {tuple(sorted({round(v, 3) for v in inside[inside[:, 0] * s > s * length / 2, 1]})) for s in (-1, 1)} == {
        (25.0, 30.0),
        (-30.0, -25.0),
    }
    assert np.abs(y).max() == 30
    solid = 1700.0 * length
    hole = (70 * 110 - 2 * 15 * 15) * 5
    assert beam.solid.volume_mm3 == pytest.approx(solid - 2 * hole)
    assert_hand_holes_are_where_the_details_say(grid["beams"])


def assert_hand_holes_are_where_the_details_say(beams: Any) -> None:
    """Their corners lie on both sides of the middle at each end; seen from end A those of end A are on the left."""
    for beam in beams:
        x, y, z = beam.solid.vertices.T
        in_a_side = (np.abs(z + 60) < 35.5) & (np.abs(y) > 24.9)
        for end, (hole, side, start) in enumerate(
            zip(beam.details.hand_holes_mm, (1, -1), (x.min(), x.max()), strict=True)
        ):
            corners = np.abs(x[in_a_side & (side * y > 0)] - start)
            if np.isnan(hole):
                assert (end, len(corners)) == (1, 0)
            else:
                assert (corners.min(), corners.max()) == pytest.approx((hole - 55, hole + 55))


def test_short_beams_have_one_hand_hole_and_shorter_ones_are_refused() -> None:
    structure = flat_grid()
    r = detail(structure, rules(), name="grid").assembly["nodes"].details.setbacks_mm.values.max()
    one = detail(structure, rules(gap_mm=(SIDE - 350) / 2 - r - 15, longest_setback_mm=1e3), name="grid").assembly
    hole = (70 * 110 - 2 * 15 * 15) * 5
    lengths = one["beams"].details.long_point_mm
    assert lengths.min() == pytest.approx(350, abs=0.5)
    short = int(lengths.argmin())
    assert one["beams"].volumes_mm3[short] == pytest.approx(1700 * lengths[short] - hole)
    assert_hand_holes_are_where_the_details_say(one["beams"])
    assert np.isnan(one["beams"].details.hand_holes_mm[short, 1])
    with pytest.raises(DetailingError, match="at least 300 mm are needed"):
        detail(structure, rules(gap_mm=(SIDE - 290) / 2 - r - 15, longest_setback_mm=1e3), name="grid")


def test_equal_plates_bolts_and_dowels_share_marks_and_lists_count_them(grid: Any) -> None:
    shared = share_equal_parts(grid)
    assert [shared[name].counts.tolist() for name in ("end plates", "bolts", "dowels")] == [[34], [34], [34]]
    assert len(shared["nodes"].mark_names) == 3  # of corners, rims and inside
    row = {column.title: column.cells[0] for column in BOLT.columns(shared["bolts"], Surroundings(shared))}
    assert (row["Mark"], row["Count"], row["Size"]) == ("S001", 34, "M20x40")
    table = next(each for each in piece_tables(shared, None) if each.title == "node_facets")
    assert {row[-2:] for row in table.rows} == {(1, "M20x40")}


def test_a_socket_without_room_is_found(grid: Any) -> None:
    """A socket that is longer than the hollow section is wide, across it."""
    bolts = grid.of(BOLT)
    turned = replace(bolts, axes=bolts.axes[:, [1, 0, 2]] * np.array([1.0, -1.0, 1.0])[:, None])
    found = [each.finding for each in violations(grid.with_group(turned))]
    assert any("the socket for bolt" in each for each in found)


def test_bores_too_near_an_edge_are_found(grid: Any) -> None:
    plates = grid.of(END_PLATE)
    narrow = plates.solids.vertices.values.copy()
    box = plates.solids.vertices.place < 8
    narrow[box, 1] *= 0.8
    changed = replace(plates, solids=replace(plates.solids, vertices=plates.solids.vertices.with_values(narrow)))
    found = [each.finding for each in violations(grid.with_group(changed))]
    assert any("an edge within 1.09 of its diameter, least 1.2" in each for each in found)


def test_a_bore_along_the_axis_keeps_its_walls_too() -> None:
    made = detail(flat_grid(), rules(axial_bore_mm=18.0), name="grid").assembly
    assert not violations(made)
    node = made["nodes"][int(made["nodes"].details.beams.sizes.argmax())]
    bores = list(cylinders(node))
    assert Counter(each.radius for each in bores) == {9.0: 1, 10.0: 4, 5.0: 4}
    for each in bores:
        if each.radius == 10.0:
            assert norm(each.centres[:, :2], axis=1).min() >= 9 + 6 - FILE_MM
    assert len(share_equal_parts(made)["nodes"].mark_names) == 3
