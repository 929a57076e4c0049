"""Trimmed node blocks: no higher than the beams ask, what they leave uncovered is said, and panels clear them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit import Project
from fabkit.checking.placed_parts import violations
from fabkit.detailing.assembling import detail
from fabkit.errors import ProjectError
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, LayerRules, NodeRules
from geometry.gauss import Pair
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh import Mesh
from geometry.mesh.shapes import dome
from tests.fabkit.test_detail import flat_grid


def leaning_grid(lean: float, nx: int = 4, ny: int = 4) -> SupportStructure:
    """A translational surface of planar quads, whose node axes lean to one side by this many mm a mm."""
    x, y = np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0), indexing="ij")
    z = -0.05 * x**2 - 0.08 * y**2
    points = 1500 * np.stack([x, y, z], axis=-1).reshape(-1, 3)
    number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    quads = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    mesh = Mesh.from_faces(points, np.stack([q.ravel() for q in quads], axis=1).tolist())
    axis = np.array([lean, 0.6 * lean, 1.0])
    return SupportStructure(Pair(mesh, mesh.with_vertices(mesh.vertices / 2e4 + axis)), 120.0)


def rules(top: str, reference: str = "outer", bottom: str = "enclosing", **panels: float) -> DetailingRules:
    return DetailingRules(
        beams=BeamRules(section="flat 120x60", reference=reference),
        connection=ConnectionRules(kind="welded"),
        nodes=NodeRules(top=top, bottom=bottom),
        layers=(LayerRules(**{"seat_mm": 12, **panels}),),
    )


@settings(max_examples=15, deadline=None)
@given(lean=st.floats(-0.6, 0.6))
def test_the_lift_is_what_the_beams_ask_and_nothing_collides(lean: float) -> None:
    structure = leaning_grid(lean)
    made = detail(structure, rules("trimmed"), name="grid")
    assert not violations(made.assembly)
    c = structure.mesh.combinatorics
    asked = 0.0  # of all four corners of both ends of each beam, on the side of each face
    for face, edges in enumerate(np.split(c.corner_edge, c.face_starts[1:-1])):
        normal, middle = structure.mesh.face_normals[face], structure.mesh.vertices[c.edges[edges]].mean(axis=(0, 1))
        for edge in edges.tolist():
            start = structure.mesh.vertices[c.edges[edge, 0]]
            for side in (-30.0, 30.0):
                across = side * structure.width_directions[edge]
                if across @ (middle - start) > 0:
                    asked = max(asked, float(across @ normal))
    assert made.underside_mm == pytest.approx(asked + 12.0, abs=1e-9)
    lying_on_them = detail(structure, rules("trimmed", seat_mm=0), name="grid")  # blocks, too, touch panels at most
    assert not violations(lying_on_them.assembly)
    enclosing = detail(structure, rules("enclosing"), name="grid")
    assert made.underside_mm <= enclosing.underside_mm + 1e-9


def test_what_stands_above_the_block_is_measured_on_the_solids() -> None:
    made = detail(leaning_grid(0.5), rules("trimmed"), name="grid").assembly
    nodes, beams = made["nodes"].details, made["beams"]
    assert nodes.uncovered_percent.values.max() > 1.0
    worst = int(nodes.uncovered_percent.values.argmax())
    node, edge = made["nodes"][int(nodes.beams.row[worst])], int(nodes.beams.values[worst])
    beam = beams[int(beams.find(np.array(edge)))]
    radial = np.radians(nodes.azimuths_deg.values[worst])
    direction = np.array([np.cos(radial), np.sin(radial), 0.0])
    aside = np.array([-np.sin(radial), np.cos(radial), 0.0])

    def flat(points: np.ndarray) -> shapely.Polygon:
        local = (points - node.placement.origin) @ node.placement.axes.T
        on = np.abs(local @ direction - nodes.setbacks_mm.values[worst]) < 1e-6
        return shapely.MultiPoint(np.c_[local[on] @ aside, local[on, 2]]).convex_hull

    end, facet = (flat(part.placement.to_world(part.solid.vertices)) for part in (beam, node))
    share = 100 * (1 - shapely.intersection(end, facet).area / end.area)
    assert share == pytest.approx(nodes.uncovered_percent.values[worst], abs=1e-6)


def test_a_share_that_is_not_said_is_a_violation() -> None:
    made = detail(leaning_grid(0.5), rules("trimmed"), name="grid").assembly

    details = made["nodes"].details
    silent = replace(
        details, uncovered_percent=details.uncovered_percent.with_values(0 * details.uncovered_percent.values)
    )
    found = violations(made.with_group(replace(made["nodes"], details=silent)))
    assert found
    assert all("over the facet" in violation.finding for violation in found)


@settings(max_examples=15, deadline=None)
@given(lean=st.floats(-0.6, 0.6), top=st.sampled_from(["enclosing", "trimmed"]))
def test_trimmed_bottoms_enclose_the_beams_and_touch_one(lean: float, top: str) -> None:
    made = detail(leaning_grid(lean), rules(top, bottom="trimmed"), name="grid").assembly
    assert not violations(made)
    beams = {beam.element: beam for beam in made["beams"]}
    for node in made["nodes"]:
        below = node.solid.topology.loops(0)[0]
        corner, normal = node.solid.vertices[below[0]], -node.solid.normals[0]
        heights = []
        for edge in node.details.beams.tolist():
            corners = node.placement.to_local(beams[edge].placement.to_world(beams[edge].solid.vertices))
            nearest = np.argsort(np.linalg.norm(corners[:, :2], axis=1))[:4]
            heights.append(((corners[nearest] - corner) @ normal).min())
        assert min(heights) == pytest.approx(0.0, abs=1e-6)  # rounding of some metres


def test_trimmed_bottoms_save_steel_where_beams_differ_in_level() -> None:
    masses = [
        detail(leaning_grid(0.5), rules("trimmed", bottom=each), name="grid").assembly["nodes"].masses_kg.sum()
        for each in ("trimmed", "enclosing")
    ]
    assert masses[0] < 0.95 * masses[1]  # 9 % less


def test_trimmed_bottoms_carry_nothing() -> None:
    for stands in ({"second_layer": {"distance_mm": -600}}, {"supports": {"loop": "rim"}}):
        with pytest.raises(ProjectError, match="struts and stubs stand on bottoms that are square"):
            Project(mesh=dome(6, 2), mean_edge_mm=1500, nodes={"bottom": "trimmed"}, **stands)


def test_level_tops_stay_as_they_are() -> None:
    both = [detail(flat_grid(), rules(top), name="level").assembly["nodes"].details for top in ("trimmed", "enclosing")]
    assert both[0].height_mm == pytest.approx(both[1].height_mm, abs=1e-9)
    assert both[0].uncovered_percent.values == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("top", ["enclosing", "trimmed"])
def test_glass_lies_on_the_mesh(top: str) -> None:
    mesh = dome(8, 3) * 9000
    structure = SupportStructure(Pair(mesh, dome(8, 3)), 120.0)
    made = detail(structure, rules(top, "glass"), name="dome")
    assert not violations(made.assembly)
    normals, c = mesh.face_normals, mesh.combinatorics
    for panel in made.assembly["panels"]:
        outer = panel.placement.to_world(panel.solid.vertices)[len(panel.solid.vertices) // 2 :]
        at = mesh.vertices[c.corners[c.face_starts[panel.element]]]
        assert np.abs((outer - at) @ normals[panel.element]).max() < 1e-6
    least = made.assembly["panels"].details.underside_mm.min()
    assert least == pytest.approx(made.underside_mm)
    assert least >= 12.0 - 1e-9
