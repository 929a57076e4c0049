"""Drawings of plates with holes, and of beams and nodes from two sides: read back by ezdxf, and judged by the shadows
of the solids and by rays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ezdxf.filemanagement
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.detailing import detail
from fabkit.formats.drawings import write_dxf
from fabkit.formats.shown.triangles import facets
from fabkit.kinds import plain_kind
from fabkit.parts import Assembly, Frame, Measures, Part, Parts, Section, Solid, Solids
from fabkit.production import CUT, HIDDEN, LABEL, MARK, VISIBLE, cut_list, part_drawings, plate_drawings
from fabkit.production.part_drawing import FROM_ABOVE, FROM_SIDE
from fabkit.production.part_views import views
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, LayerRules, NodeRules
from tests.fabkit.round_solids import SOLIDS, plate_with_bores, profile
from tests.fabkit.solids import STEEL
from tests.fabkit.test_detail import flat_grid

POINTS_MM = 1e-6
"""Accuracy of a written coordinate, at least."""


def made(kind: Any, section: str) -> Assembly:
    rules = DetailingRules(
        beams=BeamRules(section=section),
        connection=ConnectionRules(kind=kind, axial_bore_mm=20.0 if kind == "hub" else 0.0),
        layers=(LayerRules(joint_mm=20.0),),
        nodes=NodeRules(top="enclosing"),
    )
    return detail(flat_grid(2, 1), rules, name="grid").assembly


def of_solid(solid: Solid, form: Any) -> Assembly:
    kind = plain_kind("gusset", letter="G", form=form)
    part = Part(
        kind=kind,
        mark="G1",
        solid=solid,
        placement=Frame.world(),
        material=STEEL,
        element=0,
        details=kind.empty_details,
    )
    return Assembly("one", (Parts.of(kind, [part]),))


@pytest.mark.parametrize("version", ["R12", "R2010", "R2018"])
def test_a_plate_has_its_holes_as_circles_to_cut(version: Any, tmp_path: Path) -> None:
    """The plate kind is none of ours: its form alone gives it a drawing. A blind bore is not cut through."""
    plate = plate_with_bores()
    blind = Solid(np.concatenate([plate.vertices, [[170, 10, 15], [173, 10, 15], [170, 10, 9], [173, 10, 9]]]),
                  plate.topology.bored([(1, None)]))  # fmt: skip
    (drawing,) = plate_drawings(of_solid(blind, "plate"), title="one")
    write_dxf(tmp_path / "plate.dxf", drawing, version=version)
    document = ezdxf.filemanagement.readfile(tmp_path / "plate.dxf")
    assert not document.audit().errors
    found = document.modelspace().query("CIRCLE")
    circles = sorted((c.dxf.layer, round(c.dxf.radius, 6), *np.round(c.dxf.center, 6)[:2].tolist()) for c in found)
    assert circles == [(CUT, 9, 30, 30), (CUT, 11, 150, 40), (CUT, 20, 90, 100), (MARK, 3, 170, 10)]
    (outline,) = document.modelspace().query(f"LWPOLYLINE POLYLINE[layer=='{CUT}']")
    assert outline.is_closed
    points = [tuple(p)[:2] for p in (outline.get_points() if version != "R12" else [v.dxf.location for v in outline])]
    assert shapely.Polygon(points).area == pytest.approx((200 + 180) / 2 * 150)
    assert drawing.title == ("one", "15 mm S355, gusset G1")
    free = shapely.Polygon(points).difference(
        shapely.union_all([shapely.Point(x, y).buffer(r) for _, r, x, y in circles])
    )
    assert all(free.contains(shapely.MultiPoint(stroke)) for stroke in drawing.layers[MARK])


def test_end_plates_and_caps_are_drawn_as_they_are_listed() -> None:
    plates, hubs = made("bolted", "rhs 120x60x5"), made("hub", "tee 120x80x10x8")
    first = plate_drawings(plates)[0]
    assert first.circles[CUT].tolist() == [[0, 0, 11], [0, -45, 5]]
    low, high = first.layers[CUT].values.min(axis=0), first.layers[CUT].values.max(axis=0)
    assert (high - low).tolist() == pytest.approx([60, 120])
    cap = plate_drawings(hubs)[0]
    assert sorted(cap.circles[CUT][:, 2].tolist()) == pytest.approx([10, hubs["caps"].details.diameter_mm[0] / 2])
    assert len(cap.layers[CUT]) == 0
    assert {d.name for d in plate_drawings(plates, labels=False) if len(d.layers[MARK])} == set()


def test_each_mark_of_beams_and_nodes_has_a_drawing_that_reads_back(tmp_path: Path) -> None:
    assembly = made("bolted", "rhs 120x60x5 rounded")
    drawings = list(part_drawings(assembly, cut_list(assembly, None), title="grid"))
    assert [d.name for d in drawings] == [*assembly["beams"].mark_names, *assembly["nodes"].mark_names]
    for drawing in (drawings[0], drawings[-1]):
        write_dxf(tmp_path / "part.dxf", drawing)
        document = ezdxf.filemanagement.readfile(tmp_path / "part.dxf")
        assert not document.audit().errors
        assert document.layers.get(HIDDEN).dxf.linetype == HIDDEN
        assert {each.dxf.layer for each in document.modelspace()} == {VISIBLE, HIDDEN, LABEL, "TITLE"}
        words = [text.dxf.text for text in document.modelspace().query("TEXT")]
        assert words[:2] == ["grid", f"Mark: {drawing.name}"]
        assert [word for word in words if word.startswith("Ends: ")] == [w for w in drawing.title if "Ends: " in w]
        assert words[-1].endswith("Below: from outside.")
    beam = assembly["beams"][0].solid.vertices
    of_beam = np.concatenate([drawings[0].layers[layer].values for layer in (VISIBLE, HIDDEN)])
    upper = of_beam[of_beam[:, 1] >= beam[:, 2].min() - 1]
    np.testing.assert_allclose(np.ptp(upper, axis=0), np.ptp(beam[:, [0, 2]], axis=0), atol=POINTS_MM)


@pytest.mark.parametrize("axes", [FROM_SIDE, FROM_ABOVE])
@pytest.mark.parametrize("name", SOLIDS)
def test_lines_of_a_view_span_the_shadow_of_the_solid(name: str, axes: np.ndarray) -> None:
    """And the visible ones alone do."""
    solid = SOLIDS[name]
    view = views(Measures(solid.topology, solid.vertices[None]), axes)
    (shape,) = facets(Solids.of([solid]), ["N1"])
    shadow = shapely.convex_hull(shapely.MultiPoint(shape.points[0] @ axes[:2].T))
    drawn = [line[0] for line, visible, exists in view.lines if visible[0] and exists[0]]
    rings = [shapely.Point(c[0, :2]).buffer(c[0, 2], 64) for c, visible, _ in view.circles if visible[0]]
    hull = shapely.convex_hull(shapely.union_all([*map(shapely.LineString, drawn), *rings]))
    # 24 chords stand for half an ellipse, up to 0.1 mm inside it; strips stand for rounds up to 0.5 mm inside them
    assert hull.buffer(0.1).contains(shadow)
    assert shadow.buffer(0.6).contains(hull)


@settings(max_examples=20, deadline=None)
@given(
    st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.sampled_from(["rhs 120x60x5", "tee 120x80x10x8", "i 120x80x10x8"])
)
def test_hidden_edges_are_those_with_steel_before_their_middles(first: float, second: float, name: str) -> None:
    """Judged by points on the way to the eye, from a hundredth of a millimetre outside the middle of each edge on: a
    point is in the bar where it is in its section and between its cuts."""
    section, solid = Section.of(name), profile(name, first, second)
    steel = shapely.Polygon(section.loops[0], list(section.loops[1:]))
    of, t = Measures(solid.topology, solid.vertices[None]), solid.topology
    distances = np.geomspace(1e-3, 1000, 1500)[:, None]
    for axes in (FROM_SIDE, FROM_ABOVE):
        found = views(Measures(t, solid.vertices[None]), axes).lines
        for (low, high), (_, visible, _) in zip(t.edges.tolist(), found, strict=False):
            own = [face for face in range(t.n_faces) if {low, high} <= set(np.concatenate(t.loops(face)).tolist())]
            facing = of.normals[0, own] @ axes[2]
            if np.abs(facing).min() < 1e-3:
                continue  # an edge of the outline, or seen along a face: either is right
            start = solid.vertices[[low, high]].mean(axis=0) + 0.01 * of.normals[0, own].sum(axis=0)
            x, y, z = (start + distances * axes[2]).T
            inside = shapely.contains_xy(steel, y, z) & (x > first * z) & (x < 800 + second * z)
            assert visible[0] == ((facing > 0).any() and not inside.any())
