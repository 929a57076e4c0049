"""Build-ups of glass: text and panes agree, masses are those of a calculation by hand, wrong ones name a right one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit.errors import ProjectError
from fabkit.parts import BuildUp, Material

BY_HAND = [  # as written, its name, thickness in mm, mass in kg/m2: 2.5 for a mm of glass, 1.07 for one of PVB
    ("8", "8", 8.0, 20.0),
    ("8 ESG", "8T", 8.0, 20.0),
    ("ESG-H 10", "10HST", 10.0, 25.0),
    ("33.1", "33.1", 6.38, 15.4066),
    ("44.2", "44.2", 8.76, 20.8132),
    ("VSG 66.4 TVG", "66.4HS", 13.52, 31.6264),
    ("1010.4", "1010.4", 21.52, 51.6264),
    ("64.2", "64.2", 10.76, 25.8132),
    ("444.22", "444.22", 13.52, 31.6264),
    ("6/12/6", "6/12/6", 24.0, 30.0),
    ("4-18 Kr-4", "4/18Kr/4", 26.0, 20.0),
    ("8/16Ar/44.2", "8/16Ar/44.2", 32.76, 40.8132),
    ("8T / 16 Argon / 88.2", "8T/16Ar/88.2", 40.76, 60.8132),
    ("8/16Ar/6/16Ar/66.4", "8/16Ar/6/16Ar/66.4", 59.52, 66.6264),
]


@pytest.mark.parametrize(("written", "name", "thickness", "mass"), BY_HAND)
def test_common_build_ups_have_the_thickness_and_mass_of_a_calculation_by_hand(
    written: str, name: str, thickness: float, mass: float
) -> None:
    unit = BuildUp.of(written)
    assert unit.name == name
    assert BuildUp.of(unit.name) == unit
    assert unit.thickness_mm == pytest.approx(thickness, abs=1e-9)  # sums of numbers with two decimals
    assert unit.mass_kg_m2(2500.0) == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize(
    ("written", "problem", "right"),
    [
        ("7", "no float glass of 7 mm", "8"),
        ("44", "a laminate without its number of foils", "44.2"),
        ("4.2", "only one ply", "44.2"),
        ("47.2", "a ply of 7 mm", "48.2"),
        ("44.9", "9 foils", "44.8"),
        ("444.2", "2 numbers of foils", "444.22"),
        ("8/16Xe/44.2", "XE is no gas", "8/16Ar/44.2"),
        ("8/5Ar/44.2", "a gap of 5 mm", "8/6Ar/44.2"),
        ("8/44.2", "44.2 stands where a gap", "8/16Ar/44.2"),
        ("8/16Ar", "a pane at either end", "8/16Ar/8"),
        ("16Ar/8", "16AR stands where a pane", "8"),
        ("8//6", "nothing stands where a gap", "8/16Ar/6"),
        ("4/16/4/16/4/16/4/16/4", "more than 4 panes", "4/16/4/16/4/16/4"),
        ("", "nothing stands where a pane", "44.2"),
        ("safety glass", "SAFETY GLASS stands where a pane", "44.2"),
    ],
)
def test_a_wrong_build_up_is_refused_with_the_nearest_right_one(written: str, problem: str, right: str) -> None:
    with pytest.raises(ProjectError, match=problem) as raised:
        BuildUp.of(written)
    assert str(raised.value).endswith(f"write {right}")


@given(st.text(alphabet="0123456789./-ATHSrKxe ", max_size=14) | st.text(max_size=8))
def test_any_text_is_read_or_refused_with_one_that_can_be_read(written: str) -> None:
    right = written
    try:
        BuildUp.of(written)
    except ProjectError as error:
        right = str(error).rpartition("; write ")[2]
    assert BuildUp.of(right).panes


@given(st.sampled_from(BY_HAND))
def test_panes_and_gaps_follow_each_other_from_the_outside(case: tuple[str, str, float, float]) -> None:
    unit = BuildUp.of(case[0])
    tops = [level + pane.thickness_mm for level, pane in zip(unit.levels_mm, unit.panes, strict=True)]
    assert tops[0] == pytest.approx(unit.thickness_mm)
    assert unit.levels_mm[-1] == 0.0
    for level, top, (width, _) in zip(unit.levels_mm, tops[1:], unit.gaps, strict=False):
        assert level - top == pytest.approx(width)


def test_a_pane_is_a_material_as_heavy_as_its_plies_and_foils() -> None:
    glass = Material("glass", 2400.0)
    outer, inner = (pane.material(glass) for pane in BuildUp.of("8T/16Ar/44.2").panes)
    assert (outer.name, outer.density_kg_m3) == ("glass T", 2400.0)
    assert inner.name == "glass 44.2"
    assert inner.mass_kg(8.76e6) == pytest.approx(8 * 2.4 + 0.76 * 1.07)
