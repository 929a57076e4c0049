"""Sections: text and sizes agree, outlines are what shapely makes of them, impossible sizes are refused."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fabkit.errors import ProjectError
from fabkit.parts import Section
from fabkit.rules import BeamRules, ConnectionRules

size = st.floats(1, 500).map(lambda x: round(x, 2))
share = st.floats(0.02, 0.95)


@st.composite
def sections(draw: st.DrawFn) -> Section:
    height, width = draw(size), draw(size)
    a, b = draw(share), draw(share)
    return draw(
        st.sampled_from(
            [
                Section("flat", (height, width)),
                Section("rhs", (height, width, a * min(height, width) / 2)),
                Section("tee", (height, width, a * height, b * width)),
                Section("i", (height, width, a * height / 2, b * width)),
                Section("round", (height,)),
                Section("chs", (height, a * height / 2)),
            ]
        )
    )


def filled(section: Section) -> shapely.Polygon:
    return shapely.Polygon(section.loops[0], list(section.loops[1:]))


@given(sections())
def test_the_name_says_the_sizes(section: Section) -> None:
    again = Section.of(section.name.upper().replace("X", " X "))
    assert again.shape == section.shape
    assert again.sizes == pytest.approx(section.sizes, rel=1e-9)


@given(sections().filter(lambda section: not section.is_round))
def test_outlines_have_the_area_and_the_sizes_that_the_name_says(section: Section) -> None:
    whole = filled(section)
    rounding = 1e-9 * section.height_mm * section.width_mm  # of coordinates of 16 digits, over an outline as large
    assert section.area_mm2 == pytest.approx(whole.area, abs=rounding)
    assert [shapely.is_ccw(shapely.LinearRing(loop)) for loop in section.loops] == [True, False][: len(section.loops)]
    low, high = section.loops[0].min(axis=0), section.loops[0].max(axis=0)
    assert (high - low).tolist() == pytest.approx([section.width_mm, section.height_mm])
    assert np.abs(low + high).max() < 1e-9


@given(sections().filter(lambda section: not section.is_round))
def test_outlines_are_their_own_mirror_images(section: Section) -> None:
    """So a bar turned end for end has its corners in reverse order, which marks rely on."""
    for loop in section.loops:
        back = loop[::-1] * [-1, 1]
        assert any(np.allclose(np.roll(back, k, axis=0), loop) for k in range(len(loop)))


@pytest.mark.parametrize(
    ("text", "kg_m"),
    [("rhs 120x60x5", 13.35), ("flat 120x12", 11.30), ("round 60", 22.20), ("chs 60.3x4", 5.55)],
)
def test_masses_are_those_of_the_tables_of_the_trade(text: str, kg_m: float) -> None:
    """With sharp corners, so the hollow section is 1700 mm2."""
    assert Section.of(text).mass_kg_m(7850) == pytest.approx(kg_m, abs=0.01)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("rhs 120x60x30", "the wall of the section rhs 120x60x30 is 30 mm, .* must be below 30 mm"),
        ("chs 60.3x31", "the wall of the section chs 60.3x31 is 31 mm, .* must be below 30.15 mm"),
        ("tee 120x80x120x8", "the flange of the section tee 120x80x120x8 is 120 mm, which leaves nothing of the web"),
        ("i 120x80x60x8", "the flange of the section i 120x80x60x8 is 60 mm"),
        ("i 120x80x10x80", "the web of the section i 120x80x10x80 is 80 mm"),
        ("flat 0x12", "the height of the section flat 0x12 is 0 mm: it must be above 0"),
        ("flat 120", "the section flat 120 has 1 sizes in place of 2: after flat write height x width in mm"),
        ("rhs 120x60x5x4", "the section rhs 120x60x5x4 has 4 sizes in place of 3: .* height x width x wall"),
        ("angle 50x50x5", "'angle 50x50x5' is no section: write one like flat 120x12"),
        ("", "'' is no section"),
        ("rhs 120x-60x5", "the width of the section rhs 120x-60x5 is -60 mm: it must be above 0"),
        ("rhs 120xwidex5", "is no section"),
        ("rhs 1e9x60x5", "is no section"),
    ],
)
def test_impossible_sections_are_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        Section.of(text)


def test_a_section_or_sizes_of_a_bar_not_both() -> None:
    assert BeamRules(height_mm=140).profile == Section("flat", (140, 50))
    assert BeamRules(section="rhs 120x60x5").profile.wall_mm == 5
    with pytest.raises(ValueError, match="section is 'rhs 120x60x5' and width_mm given too"):
        BeamRules(section="rhs 120x60x5", width_mm=50)


def test_slots_by_the_kind_of_connection() -> None:
    assert [ConnectionRules(kind=kind).slot for kind in ("welded", "hub", "bolted", "contact")] == [25, 25, 10, 0]
    with pytest.raises(ValueError, match="beams in contact have no slot"):
        ConnectionRules(kind="contact", slot_mm=5)
