"""Beams on the boundary with a section of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fabkit import Project, design
from fabkit.checking import violations
from fabkit.errors import DetailingError, ProjectError
from fabkit.kinds import BEAM, END_PLATE, NODE
from fabkit.parts import Assembly, Section
from geometry.mesh.shapes import dome

MESH = dome(8, 3)
RIM = MESH.combinatorics.is_boundary_edge


def built(section: str, boundary: str, kind: str, **settings: Any) -> Assembly:
    beams = {"section": section, "boundary_section": boundary} | settings.pop("beams", {})
    return design(
        Project(
            mesh=MESH,
            mean_edge_mm=2000,
            beams=beams,
            connection={"kind": kind},
            nesting={"mode": "off"},
            layers=[{"thickness_mm": 8.76, "joint_mm": 20, "least_bearing_mm": -50}],
            **settings,
        )
    ).assembly


CASES = [
    ("rhs 120x60x5", "rhs 160x80x6", "welded"),
    ("rhs 120x60x5", "i 100x50x8x6", "welded"),
    ("rhs 120x60x5", "chs 139.7x5", "contact"),
    ("rhs 160x80x6", "rhs 120x60x5", "bolted"),
    ("tee 120x80x10x8", "flat 150x12", "hub"),
]


@pytest.fixture(scope="module", params=CASES, ids=lambda case: f"{case[2]} {case[1]}")
def roof(request: pytest.FixtureRequest) -> tuple[Assembly, tuple[str, str, str]]:
    return built(*request.param), request.param


def test_all_parts_fit(roof: tuple[Assembly, tuple[str, str, str]]) -> None:
    assert violations(roof[0]) == ()


def test_beams_have_the_section_of_their_edge(roof: tuple[Assembly, tuple[str, str, str]]) -> None:
    assembly, (inner, rim, kind) = roof
    beams = assembly.of(BEAM)
    on_rim = RIM[beams.elements]
    assert 0 < on_rim.sum() < len(beams)
    for own, name in ((on_rim, rim), (~on_rim, inner)):
        section = Section.of(name)
        assert {each.name for each in beams.details.section[own]} == {name}
        for part in beams.take(own):
            low, high = part.solid.vertices.min(axis=0), part.solid.vertices.max(axis=0)
            if not section.is_round:
                assert high[1] - low[1] == pytest.approx(section.width_mm)
                assert [low[2], high[2]] == pytest.approx([-section.height_mm, 0.0])
    if kind in ("welded", "contact"):
        middle = (beams.details.long_point_mm + beams.details.short_point_mm) / 2
        areas = np.array([section.area_mm2 for section in beams.details.section])
        assert beams.volumes_mm3 == pytest.approx(areas * middle, rel=0.02)  # of a tee the middle is not half way


def test_slots_and_ledges_count_the_wider_beam() -> None:
    """Of the corners of two neighbouring end faces, 25 mm apart at least; facets as wide as beam and two ledges."""
    assembly = built("rhs 120x60x5", "rhs 160x80x6", "welded")
    nodes, beams = assembly.of(NODE), assembly.of(BEAM)
    widths = np.array([section.width_mm for section in beams.details.section])
    own = nodes.details
    half = widths[beams.find(own.beams.values)] / 2
    azimuth, setback = np.radians(own.azimuths_deg.values), own.setbacks_mm.values
    radial = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    aside = np.stack([-np.sin(azimuth), np.cos(azimuth)], axis=1)
    left, right = (setback[:, None] * radial + sign * half[:, None] * aside for sign in (1, -1))
    slots, mixed = [], 0
    for first, last in zip(own.beams.starts[:-1], own.beams.starts[1:], strict=True):
        k = np.arange(first, last)
        following = np.roll(k, -1)
        gap = np.mod(azimuth[following] - azimuth[k], 2 * np.pi)
        close = gap < np.pi
        slots += np.linalg.norm(left[k] - right[following], axis=1)[close].tolist()
        mixed += (half[k] != half[following])[close].sum()
        solid = nodes[int(own.beams.row[first])].solid
        corners = solid.vertices[: len(solid.vertices) // 2, :2]
        for j in k:
            on_facet = np.abs(corners @ radial[j] - setback[j]) < 1e-6
            assert np.ptp(corners[on_facet] @ aside[j]) >= 2 * (half[j] + 8) - 1e-9
    assert mixed > 10
    assert min(slots) > 25 - 1e-9


def test_panels_lie_on_the_width_of_their_own_beam() -> None:
    """With a joint of 20, half of a beam less 10 mm, across it; a rim too narrow for that is named."""
    with pytest.raises(DetailingError, match=r"lies .* mm deep on the beam on edge") as error:
        design(
            Project(
                mesh=MESH,
                mean_edge_mm=2000,
                beams={"section": "rhs 120x60x5", "boundary_section": "rhs 120x30x4"},
                layers=[{"joint_mm": 20, "least_bearing_mm": 10}],
            )
        )
    edge = int(str(error.value).split("beam on edge ")[1].split(",")[0])
    assert RIM[edge]


def test_dowels_and_plates_follow_both_sections() -> None:
    assembly = built("rhs 160x80x6", "rhs 120x60x5", "bolted")
    plates = assembly.of(END_PLATE)
    on_rim = RIM[plates.elements]
    assert set(plates.details.width_mm[on_rim].tolist()) == {60.0}
    assert set(plates.details.width_mm[~on_rim].tolist()) == {80.0}


def test_tops_are_aligned_whatever_the_heights() -> None:
    deep = built("rhs 120x60x5", "rhs 200x60x6", "welded").of(NODE)
    same = built("rhs 120x60x5", "rhs 120x60x5", "welded").of(NODE)
    assert deep.details.top_step_mm == pytest.approx(same.details.top_step_mm, abs=1e-9)


def test_the_same_section_is_no_other_one() -> None:
    one, two = (built("rhs 120x60x5", boundary, "welded") for boundary in ("rhs 120x60x5", "RHS 120 x 60 x 5"))
    assert one.of(BEAM).mark_names == two.of(BEAM).mark_names


@pytest.mark.parametrize(
    ("beams", "kind", "sentence"),
    [
        (
            {"boundary_section": "rhs 120x60x5"},
            "hub",
            "beams on hubs are flats or tees, and the section is rhs 120x60x5",
        ),
        ({"section": "rhs 160x80x6", "boundary_section": "flat 150x12"}, "bolted", "the section is flat 150x12"),
        ({"boundary_section": "rhs 120x60x40"}, "welded", "leaves nothing of the hollow inside"),
        ({"boundary_section": "wood"}, "welded", "'wood' is no section"),
    ],
)
def test_bad_sections_are_one_sentence(beams: dict[str, str], kind: str, sentence: str) -> None:
    beams = {"section": "tee 120x80x10x8"} | beams
    with pytest.raises(ProjectError, match=sentence):
        Project(mesh=MESH, mean_edge_mm=2000, beams=beams, connection={"kind": kind})
