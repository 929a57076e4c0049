"""What bolts and hubs ask of a section is said before anything is made."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest

from fabkit import Project, design
from fabkit.detailing import detail
from fabkit.errors import DetailingError, ProjectError
from fabkit.kinds import NODE
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, LayerRules, NodeRules
from geometry.mesh.shapes import dome
from tests.fabkit.test_detail import flat_grid


def project(section: str, **connection: Any) -> Project:
    return Project(mesh=dome(6, 2), mean_edge_mm=1500, beams={"section": section}, connection=connection)


@pytest.mark.parametrize(
    ("section", "bolts"),
    [("rhs 120x60x5", "1xM20"), ("rhs 120x60x5", "2xM16"), ("rhs 200x100x8", "1xM30"), ("rhs 150x70x5", "2 x m20")],
)
def test_bolts_that_fit_a_section_are_accepted(section: str, bolts: str) -> None:
    assert project(section, kind="bolted", bolts=bolts).rules.connection.bolts == bolts.lower().replace(
        " ", ""
    ).replace("m", "M")


@pytest.mark.parametrize(
    ("section", "bolts", "said"),
    [
        ("flat 120x60", "1xM20", "hollow section"),
        ("tee 120x80x10x8", "1xM20", "hollow section"),
        ("rhs 120x60x5", "1xM24", "31.2 mm are needed .*edge.* there are 30.0"),
        ("rhs 120x60x8", "1xM20", "23.0 mm are needed .*side inside.* there are 22.0"),
        ("rhs 110x60x5", "2xM20", "edge"),
        ("rhs 114x60x6", "2xM20", "top inside"),
        ("rhs 75x60x5", "1xM16", "hand hole"),
        ("rhs 84x60x5", "1xM20", "the bolt to its dowel"),
        ("rhs 120x60x5", "3xM16", "1x or 2x"),
    ],
)
def test_bolts_that_do_not_fit_are_refused_in_one_sentence(section: str, bolts: str, said: str) -> None:
    with pytest.raises(ProjectError, match=said) as refused:
        project(section, kind="bolted", bolts=bolts)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("section", ["rhs 120x60x5", "chs 60.3x4", "i 120x80x10x8"])
def test_hubs_take_flats_and_tees_only(section: str) -> None:
    with pytest.raises(ProjectError, match="tee 120x80x10x8"):
        project(section, kind="hub")


def test_tees_on_a_hub_and_flats_are_accepted() -> None:
    for section in ("tee 120x80x10x8", "flat 120x12"):
        assert project(section, kind="hub").rules.beams.profile.name == section


@pytest.mark.parametrize(
    ("section", "connection", "said", "cure"),
    [
        ("rhs 120x60x5", {"dowel_mm": 30}, "a thinner dowel", {"dowel_mm": 10}),
        ("rhs 120x60x5", {"hand_hole_height_mm": 115}, "a lower hand hole", {"hand_hole_height_mm": 110}),
        ("rhs 120x60x5", {"hand_hole_length_mm": 40}, "46.0 .* 40.0 mm; .* larger hand", {"hand_hole_length_mm": 46}),
        ("flat 120x60", {"kind": "hub"}, "452.0 mm, .* has 273 mm: take a thinner", {"kind": "hub"}),
        ("tee 120x80x10x8", {"kind": "hub", "axial_bore_mm": 300}, "316.0 mm, .* smaller bore", {"kind": "hub"}),
    ],
)
def test_cures_that_are_named_work(section: str, connection: Any, said: str, cure: Any) -> None:
    with pytest.raises(ProjectError, match=said):
        project(section, **{"kind": "bolted", **connection})
    project(section.replace("flat 120x60", "flat 120x46"), **{"kind": "bolted", **cure})


def test_tables_are_named_without_their_contents() -> None:
    with pytest.raises(ProjectError, match=r"^\[beams\] section is 'rhs 120x60x5' and width_mm given too"):
        Project(mesh=dome(6, 2), mean_edge_mm=1500, beams={"section": "rhs 120x60x5", "width_mm": 3})


def roof(section: str, joint: float) -> Project:
    return project(section, kind="welded").model_copy(update={"layers": (LayerRules(joint_mm=joint),)})


@pytest.mark.parametrize(("section", "joint"), [("rhs 120x60x5", 55.0), ("flat 120x12", 20.0)])
def test_a_section_that_cannot_carry_the_joint_is_told_with_sizes_that_can(section: str, joint: float) -> None:
    with pytest.raises(DetailingError, match=r"panel on face 0 lies .* at least 10 mm are needed") as refused:
        design(roof(section, joint))
    width = re.search(r"a section at least (\d+) mm wide", str(refused.value))
    narrower = re.search(r"a joint of at most (\d+) mm", str(refused.value))
    assert width
    assert bool(narrower) == (joint == 55.0)  # no joint is narrow enough for a flat of 12
    design(roof(f"flat 120x{width[1]}", joint))
    if narrower:
        design(roof(section, float(narrower[1])))


@pytest.mark.parametrize("kind", ["welded", "contact"])
def test_blocks_have_room_for_a_bore_along_their_axes(kind: str) -> None:
    rules = DetailingRules(
        BeamRules(width_mm=50), ConnectionRules(kind=kind, axial_bore_mm=15), NodeRules(top="enclosing")
    )
    made = detail(flat_grid(), rules, name="grid").assembly
    assert made.of(NODE).details.setbacks_mm.values.min() >= 18 - 1e-9
    with pytest.raises(DetailingError, match=r"(a bore of 200 mm along the axis its end|has a bore)"):
        detail(flat_grid(), replace(rules, connection=ConnectionRules(kind=kind, axial_bore_mm=200)), name="grid")


def test_what_lies_between_facet_and_beam_is_said_of_a_beam_that_is_too_short() -> None:
    connection = ConnectionRules(kind="bolted", plate_mm=900, gap_mm=3)
    with pytest.raises(DetailingError, match="each with an end plate of 900 mm and a gap of 3 mm, which leaves"):
        detail(flat_grid(), DetailingRules(BeamRules(section="rhs 120x60x5"), connection), name="grid")
