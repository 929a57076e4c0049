"""What bolts and hubs ask of a section is said before anything is made."""

from __future__ import annotations

from typing import Any

import pytest

from fabkit import Project
from fabkit.errors import ProjectError
from geometry.mesh.shapes import dome


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
