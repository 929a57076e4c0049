"""Beams on hubs: round tubes, caps, and tees whose flanges are cut back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

from fabkit import Project, design
from fabkit.checking import violations
from fabkit.connections import TUBE_DIAMETERS_MM
from fabkit.detailing import beam_ends, detail
from fabkit.errors import DetailingError
from fabkit.production import piece_tables, share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules
from geometry.mesh.shapes import dome
from tests.fabkit.test_bolted import cylinders
from tests.fabkit.test_detail import SIDE, fan, flat_grid

TEE = "tee 120x80x10x8"


def rules(section: str = TEE, **connection: Any) -> DetailingRules:
    return DetailingRules(beams=BeamRules(section=section), connection=ConnectionRules(kind="hub", **connection))


@pytest.fixture(scope="module")
def grid() -> Any:
    return detail(flat_grid(), rules(), name="grid").assembly


def test_a_node_is_a_tube_of_the_table_with_two_caps(grid: Any) -> None:
    assert not violations(grid)
    assert {group.kind.group: len(group) for group in grid.groups} == {
        "beams": 17,
        "nodes": 12,
        "panels": 6,
        "caps": 24,
    }
    outside, inside = sorted(cylinders(grid["nodes"][0]), key=lambda each: -each.radius)
    assert 2 * outside.radius in TUBE_DIAMETERS_MM
    assert outside.radius - inside.radius == pytest.approx(8.0)
    cap = next(iter(cylinders(grid["caps"][0])))
    assert cap.radius == outside.radius
    assert np.ptp(cap.centres[:, 2]) == pytest.approx(5.0)


@pytest.mark.parametrize(("angle", "diameter"), [(89, 60.3), (60, 76.1), (45, 88.9), (33, 139.7)])
def test_the_tube_is_the_next_one_for_the_slot_between_webs(angle: float, diameter: float) -> None:
    structure = fan(angle)
    made = structure.mesh.combinatorics.edges.max(axis=1) < 3  # of the triangle
    ends = beam_ends(structure, made, rules())
    radius = np.nanmax(ends.setback[ends.vertex == 0])
    assert 2 * radius == pytest.approx(diameter)
    half = np.radians(angle) / 2
    assert 2 * radius * np.sin(half) - 8 * np.cos(half) >= 25


def test_flanges_are_apart_by_ten_and_end_before_their_webs(grid: Any) -> None:
    node = int(grid["nodes"].details.beams.sizes.argmax())
    flanges, webs = [], []
    for edge in grid["nodes"].details.beams[node].tolist():
        beam = grid["beams"][int(grid["beams"].find(np.array([edge]))[0])]
        points = beam.placement.to_world(beam.solid.vertices)
        wide = np.abs(beam.solid.vertices[:, 1]) > 30
        flanges.append(shapely.convex_hull(shapely.MultiPoint(points[wide, :2])))
        webs.append(shapely.convex_hull(shapely.MultiPoint(points[~wide, :2])))
    apart = [one.distance(other) for n, one in enumerate(flanges) for other in flanges[:n]]
    slots = [one.distance(other) for n, one in enumerate(webs) for other in webs[:n]]
    assert min(apart) == pytest.approx(10.0)
    assert min(slots) >= 25
    for flange, web in zip(flanges, webs, strict=True):
        assert flange.length < web.length + 2 * 72  # shorter than its web


def test_a_tee_weighs_what_its_two_plates_weigh(grid: Any) -> None:
    beam = grid["beams"][0]
    radius = TUBE_DIAMETERS_MM[0] / 2
    x = np.unique(beam.solid.vertices[:, 0].round(6))
    flange, web = x[2] - x[1], x[3] - x[0]
    assert web == pytest.approx(SIDE - 2 * radius)
    assert beam.solid.volume_mm3 == pytest.approx(110 * 8 * web + 80 * 10 * flange)


def test_the_table_of_facets_has_the_webs_on_the_tubes() -> None:
    """Webs of tees 120x80x10x8 are 110 high and 8 thick, and are cut along the tube."""
    built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, beams={"section": TEE}, connection={"kind": "hub"}))
    tables = {each.title: each for each in piece_tables(built.assembly, None)}
    rows: list[Any] = [dict(zip(tables["node_facets"].columns, row, strict=True)) for row in tables["node_facets"].rows]
    tubes: dict[Any, Any] = {row[0]: row for row in tables["survey"].rows}
    assert len(rows) == 2 * len(built.assembly["beams"])
    for row in rows:
        top, bottom = row["Facet top (mm)"], row["Facet bottom (mm)"]
        along = 110 / np.cos(np.radians(row["Inclination (deg)"]))
        assert top - bottom == pytest.approx(along, abs=2 * built.summary.equal_within_mm)
        assert row["Facet width (mm)"] == pytest.approx(8)
        high, low = tubes[row["Node"]][-2:]
        assert low - 0.5 <= bottom < top <= high + 0.5  # of beams of one mark, made alike to half a millimetre


def test_hubs_whose_tubes_are_equal_differ_where_their_beams_are_welded() -> None:
    built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, beams={"section": TEE}, connection={"kind": "hub"}))
    assert built.assembly["caps"].counts.tolist() == [18, 18]  # the upper ones have a dot
    for beam in built.assembly["beams"]:
        own = beam.solid.vertices[np.abs(beam.solid.vertices[:, 1]) > 30]
        reaches = [np.ptp(own[np.isclose(own[:, 2], level)][:, 0]) for level in (0.0, -10.0)]
        assert sorted(beam.details.flange_points_mm) == pytest.approx(sorted(reaches))
        under = beam.solid.vertices[np.isclose(beam.solid.vertices[:, 2], -10.0)]
        web, flange = under[:, 0], under[np.abs(under[:, 1]) > 30, 0]
        backs = (flange.min() - web.min(), web.max() - flange.max())
        assert beam.details.flange_backs_mm.tolist() == pytest.approx(backs)
    contact = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    assert np.isnan(contact.assembly["beams"].details.flange_points_mm).all()
    assert len(built.assembly["nodes"].mark_names) == len(contact.assembly["nodes"].mark_names)
    assert built.assembly["beams"].counts.tolist() == contact.assembly["beams"].counts.tolist()


def test_a_bore_along_the_axis_goes_through_both_caps() -> None:
    made = detail(flat_grid(), rules(axial_bore_mm=22.0), name="grid").assembly
    assert {each.radius for each in cylinders(made["caps"][0])} == {11.0, TUBE_DIAMETERS_MM[0] / 2}
    assert not violations(made)
    assert not violations(share_equal_parts(made))


def test_narrow_angles_and_large_tubes_are_refused_by_name() -> None:
    with pytest.raises(DetailingError, match=r"edge 0 cannot be welded to a hub at vertex 0: it is 29.0 degrees"):
        detail(fan(29), rules(), name="fan")
    with pytest.raises(DetailingError, match=r"cannot be welded to a hub .* where at most 40.0 mm are possible"):
        detail(fan(40), rules(longest_setback_mm=40.0), name="fan")
