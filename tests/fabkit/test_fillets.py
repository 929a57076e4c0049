"""Rectangular hollow sections with rounded corners: measured against integrals that know nothing of fillets, found by
their working pieces, turned end for end, and refused where they cannot be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.checking import violations
from fabkit.checking.solid_rules import solid_rules
from fabkit.detailing import detail
from fabkit.errors import ProjectError
from fabkit.parts import (
    Measures,
    Section,
    Solid,
    SolidArray,
    Topology,
    prism_topology,
    profile_topology,
    profile_vertices,
)
from fabkit.production import share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, LayerRules, NodeRules
from geometry.arrays import FloatArray
from tests.fabkit.round_solids import SOLIDS, profile
from tests.fabkit.solids import frame
from tests.fabkit.test_detail import flat_grid
from tests.fabkit.test_trimmed_nodes import leaning_grid

each = settings(max_examples=30, deadline=None)
slopes = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))


def strips(width: float, height: float, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nodes y, weights, and half the heights there, of a rectangle with rounded corners. Along y = -w/2 + r (1 - cos a)
    all integrals of polynomials are smooth in a, so 40 nodes give them to rounding."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    angle = (nodes + 1) * np.pi / 4
    left = -width / 2 + radius * (1 - np.cos(angle))
    of_left = weights * np.pi / 4 * radius * np.sin(angle)
    half = height / 2 - radius + radius * np.sin(angle)
    flat = width / 2 - radius
    return (
        np.concatenate([left, flat * nodes, -left]),
        np.concatenate([of_left, flat * weights, of_left]),
        np.concatenate([half, np.full(40, height / 2), half]),
    )


def moments(box: tuple[float, float, float], first: FloatArray, second: FloatArray) -> FloatArray:
    """Integrals of 1, x, y, z over such a box between planes, as in `profile_vertices`: along z, these are polynomials
    of the third degree, for which three nodes are exact."""
    y, weights, half = strips(*box)
    nodes, along = np.polynomial.legendre.leggauss(3)
    z, dz = half[:, None] * nodes, half[:, None] * along
    low, high = (plane[0] + plane[1] * y[:, None] + plane[2] * z for plane in (first, second))
    area = weights[:, None] * dz
    values = (high - low, (high**2 - low**2) / 2, (high - low) * y[:, None], (high - low) * z)
    return np.array([(area * value).sum() for value in values])


@each
@given(st.floats(20, 300), st.floats(20, 300), st.floats(0.02, 0.45), st.floats(0.02, 0.9), slopes, slopes)
def test_volume_and_centroid_are_those_of_the_integrals(
    height: float, width: float, wall: float, radius: float, first: tuple[float, float], second: tuple[float, float]
) -> None:
    least = min(height, width)
    section = Section("rhs", (height, width, wall * least), radius * least / 2)
    length = 4 * (height + width)
    planes, radii = (np.array([0.0, *first]), np.array([length, *second])), section.corner_radii
    vertices = profile_vertices(section.loops, *planes, radii=radii)
    solid = Solid(vertices, profile_topology(section.loops, radii))
    t = section.sizes[2]
    whole = moments((width, height, radii[0]), *planes)
    expected = whole - moments((width - 2 * t, height - 2 * t, radii[1]), *planes)
    assert solid.volume_mm3 == pytest.approx(expected[0], rel=1e-11)
    assert solid.volume_mm3 == pytest.approx(section.area_mm2 * length, rel=1e-11)
    np.testing.assert_allclose(solid.centroid, expected[1:] / expected[0], atol=1e-10 * length)
    turned = Solid(frame(3).to_world(solid.vertices), solid.topology)
    assert turned.volume_mm3 == pytest.approx(expected[0], rel=1e-9)
    np.testing.assert_allclose(turned.centroid, frame(3).to_world(solid.centroid[None])[0], atol=1e-7)


@each
@given(slopes, slopes)
def test_a_single_fillet_is_that_of_many_chords(first: tuple[float, float], second: tuple[float, float]) -> None:
    """With fillets of one radius all around, a part of the integrals cancels; not so with one. The area between an arc
    of 30 mm and its 1000 chords is 7e-5 mm2 of 4600."""
    planes = np.array([0.0, *first]), np.array([500.0, *second])

    def at(outline: FloatArray) -> FloatArray:
        return np.concatenate([np.column_stack([plane[0] + outline @ plane[1:], outline]) for plane in planes])

    corners = np.array([[0.0, 0], [80, 0], [80, 30], [50, 60], [0, 60], [80, 60]])  # the last one is the tip
    loop = np.arange(5)
    sides = [[k, (k + 1) % 5, (k + 1) % 5 + 6, k + 6] for k in range(5)]
    faces = [loop[::-1], loop + 6, *sides]
    sizes = np.cumsum([0, *map(len, faces)])
    topology = Topology(12, np.concatenate(faces), sizes, np.arange(8), fillets=np.array([[4, 5, 11, 1]]))
    solid = Solid(at(corners), topology)
    angles = np.linspace(0, np.pi / 2, 1001)
    arc = np.array([50.0, 30]) + 30 * np.column_stack([np.cos(angles), np.sin(angles)])
    outline = np.concatenate([corners[:2], arc, corners[4:5]])
    judge = Solid(at(outline), prism_topology(len(outline)))
    assert solid.volume_mm3 == pytest.approx(judge.volume_mm3, rel=1e-7)
    np.testing.assert_allclose(solid.centroid, judge.centroid, atol=1e-5)
    areas = [Measures(each.topology, each.vertices[None]).surface_areas[0] for each in (solid, judge)]
    assert areas[0] == pytest.approx(areas[1], rel=1e-6)


def test_a_hollow_corner_adds_to_an_angle() -> None:
    angle = np.array([[0.0, 0], [80, 0], [80, 40], [40, 40], [40, 120], [0, 120]])
    planes = np.zeros(3), np.array([500.0, 0, 0])
    solid = Solid(profile_vertices([angle], *planes, radii=[15.0]), profile_topology([angle], [15.0]))
    assert solid.topology.fillets[:, 3].tolist() == [1, 1, 1, -1, 1, 1]
    assert solid.volume_mm3 == pytest.approx(500 * (6400 - 4 * (1 - np.pi / 4) * 15**2), rel=1e-12)


@pytest.mark.parametrize("name", ["rhs 120x60x5 r10", "rhs 120x60x5 r4", "rhs 100x100x12.5 r25"])
def test_working_pieces_contain_the_section(name: str) -> None:
    """Seen along the bar they cover it, and of the hollow inside no more than the corners between radius and
    tangents."""
    section, solid = Section.of(name), profile(name)
    box = [shapely.box(-w / 2, -h / 2, w / 2, h / 2) for w, h in ((section.width_mm, section.height_mm),)]
    wall, (outer, inner) = section.sizes[2], section.corner_radii
    hole = box[0].buffer(-wall)
    rounded, hollow = (
        each.buffer(-r).buffer(r, quad_segs=200) if r else each for each, r in ((box[0], outer), (hole, inner))
    )
    covered = shapely.union_all(
        [shapely.convex_hull(shapely.multipoints(solid.vertices[numbers, 1:])) for numbers, _ in solid.topology.pieces]
    )
    chords = 1e-4 * section.width_mm**2  # of the arcs of 200 chords
    assert rounded.difference(hollow).difference(covered).area < chords
    assert covered.intersection(hollow).area < 4 * (np.pi / 4 - 1 / 2) * inner**2 + chords


def rules(section: str, kind: Any = "welded", **nodes: Any) -> DetailingRules:
    return DetailingRules(
        beams=BeamRules(section=section),
        connection=ConnectionRules(kind=kind),
        nodes=NodeRules(**nodes),
        layers=(LayerRules(joint_mm=20.0),),
    )


@pytest.mark.parametrize("kind", ["welded", "bolted"])
def test_bars_turned_end_for_end_are_equal_and_fit(kind: str) -> None:
    """A flat grid has as many kinds of beams with rounded corners as with sharp ones, with hand holes too."""
    marks = []
    for section in ("rhs 120x60x5", "rhs 120x60x5 rounded"):
        found = share_equal_parts(detail(flat_grid(), rules(section, kind), name="grid").assembly)
        assert violations(found) == ()
        marks.append(found["beams"].mark_names)
    assert marks[0] == marks[1]


def test_what_stands_above_a_trimmed_node_is_told_of_the_whole_end() -> None:
    """The node says how much of width times height it leaves uncovered, and check finds as much from the solids."""
    found = detail(leaning_grid(0.5), rules("rhs 120x60x5 rounded", top="trimmed"), name="grid").assembly
    assert found["nodes"].details.uncovered_percent.values.max() > 1
    assert violations(found) == ()


def test_a_hand_hole_must_lie_between_the_radii() -> None:
    with pytest.raises(ValueError, match=r"70.0 mm are needed from radius to radius of a side, for the hand hole"):
        rules("rhs 120x120x10 r30", "bolted")
    assert rules("rhs 120x120x10", "bolted").beams.profile.radius_mm == 0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "rhs 120x60x5 r30",
            "the radius of the section rhs 120x60x5 r30 is 30 mm, .*flat sides: it must be below 30 mm",
        ),
        ("rhs 120x60x12 rounded", "the radius of the section rhs 120x60x12 r36 is 36 mm"),
        ("tee 120x80x10x8 r5", "only rectangular hollow sections have rounded corners, not tee 120x80x10x8 r5"),
        ("rhs 120x60x5 r", "is no section"),
        ("rhs 120x60x5 round", "is no section"),
    ],
)
def test_impossible_corners_are_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        Section.of(text)


def test_radii_of_cold_formed_sections() -> None:
    """Masses in the tables of EN 10219-2, in kg/m to one decimal."""
    tables = {"rhs 120x60x5": 12.8, "rhs 200x200x8": 46.5, "rhs 200x200x10": 57.0, "rhs 200x200x12.5": 68.3}
    for name, kg_m in tables.items():
        assert Section.of(f"{name} rounded").mass_kg_m(7850) == pytest.approx(kg_m, abs=0.05)


@pytest.mark.parametrize(("moved", "words"), [("tip", "off its plane"), ("corner", "off its plane")])
def test_what_is_no_quarter_of_a_cylinder_is_found(moved: str, words: str) -> None:
    solid = SOLIDS["rounded section"]
    number = solid.topology.fillets[0, 1] if moved == "tip" else solid.topology.fillet_corners[0, 0]
    vertices = solid.vertices.copy()
    vertices[number] += [0.01, 0, 0] if moved == "tip" else [0, 0.01, 0]
    batch = SolidArray(solid.topology, np.zeros(1, dtype=np.int64), vertices[None])
    broken = [rule.words for rule in solid_rules(np.eye(3)[None], batch, 1e-6, 1e-3) if not rule.holds.all()]
    assert words in broken[0]
    off = Measures(solid.topology, vertices[None]).fillet_misfits.max()
    assert off == pytest.approx(0.01, rel=0.5)


def test_fillets_need_a_face_and_tips_of_their_own() -> None:
    section = Section.of("rhs 120x60x5 r10")
    t = profile_topology(section.loops, section.corner_radii)
    for fillets, words in (
        ([[10, 0, 40, 1]], "none of them a corner"),
        ([[10, 16, 16, 1]], "two tips of its own"),
        ([[0, 17, 41, 1]], "one loop of four corners"),
    ):
        with pytest.raises(ValueError, match=words):
            Topology(48, t.corners, t.loop_starts, t.face_starts, fillets=np.array(fillets))
