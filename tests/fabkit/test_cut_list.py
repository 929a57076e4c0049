"""Cut lists of parts made by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from fabkit import Project, design
from fabkit.kinds.beams import ends_glyphs
from fabkit.parts import Assembly, Column, LeftOut
from fabkit.production.cut_lists import Table, cut_list
from fabkit.production.nesting.nests import Sheet
from fabkit.production.nesting.sheet_nesting import nest_panels
from fabkit.project import Nesting
from tests.fabkit.assemblies import assembled, by_name
from tests.fabkit.gridshell import gridshell
from tests.fabkit.plates import bar, block, plate

ROOF = Path(__file__).parents[2] / "examples" / "roof.obj"
SQUARE = np.array([[0.0, 0.0], [1000.0, 0.0], [1000.0, 1000.0], [0.0, 1000.0]])


def assembly() -> Assembly:
    """Three beams of two marks between three nodes, one of them left out; three panels, two of them equal, which
    have a fourth, left out, as a neighbour."""
    return assembled(
        "test",
        beams=(
            bar("B001", 0, (0, 1), dihedral_deg=5.0, cut_angles_deg=(2.5, -0.004)),
            bar("B002", 1, (1, 2), dihedral_deg=math.nan, cut_angles_deg=(-1.0, -2.0), height_deviation_mm=-0.25),
            bar("B001", 2, (1, 0), dihedral_deg=7.126, cut_angles_deg=(2.5, -0.004)),
        ),
        nodes=(
            block("N001", 0, (0, 2), top_step_mm=0.5),
            block("N001", 1, (2, 0), top_step_mm=1.5),
        ),
        panels=(
            plate("P001", SQUARE, element=0, neighbours=(-1, 1, 3, 2), dihedrals=(math.nan, 4.0, 4.0, 4.0)),
            plate("P002", SQUARE / 2, element=1, neighbours=(0, -1, -1, -1)),
            plate("P001", SQUARE, element=2, neighbours=(0, -1, -1, -1), dihedrals=(4.0, 6.0, 4.0, 4.0)),
        ),
        left_out=(
            LeftOut("node", 2, "two beams leave no room"),
            LeftOut("panel", 3, "its node is left out"),
        ),
    )


def alone() -> Assembly:
    return assembled("one panel", panels=assembly()["panels"][:1])


def column(table: Table, name: str) -> list[object]:
    return [row[table.columns.index(name)] for row in table.rows]


def total(table: Table, name: str) -> object:
    return table.totals[table.columns.index(name)]


def test_beams() -> None:
    table = cut_list(assembly(), None)["beams"]
    assert column(table, "Mark") == ["B001", "B002"]
    assert column(table, "Count") == [2, 1]
    assert column(table, "Section") == ["flat 120x50"] * 2
    assert column(table, "Ends") == ["\\_|", "/_\\"]
    assert column(table, "Nodes A B") == ["N001 N001 (x2)", "N001 left out"]
    assert column(table, "Least dihedral (deg)") == [5.0, None]
    assert column(table, "Largest dihedral (deg)") == [7.126, None]
    assert column(table, "Least height deviation (mm)") == [0.0, -0.25]
    mass = 7850 * 0.05 * 0.12 * 1.0
    assert column(table, "Mass each (kg)") == [pytest.approx(mass)] * 2
    assert column(table, "Mass (kg)") == [pytest.approx(2 * mass), pytest.approx(mass)]
    assert column(table, "File") == ["parts/B001.step", "parts/B002.step"]
    assert (total(table, "Mark"), total(table, "Count")) == ("Total", 3)
    assert total(table, "Mass (kg)") == pytest.approx(3 * mass)
    assert total(table, "Long point (mm)") is None
    assert table.left_out == ()


def test_nodes() -> None:
    table = cut_list(assembly(), None)["nodes"]
    assert column(table, "Mark") == ["N001"]
    assert column(table, "Valence") == [2]
    assert column(table, "Beams") == ["B001 / B001 (x2)"]
    assert column(table, "Azimuths (deg)") == ["0.00 / 180.00"]
    assert column(table, "Inclinations (deg)") == ["-2.50 / -2.50"]
    assert column(table, "Setbacks (mm)") == ["40.00 / 40.00"]
    assert column(table, "Least step between tops (mm)") == [0.5]
    assert column(table, "Largest step between tops (mm)") == [1.5]
    assert column(table, "Mass (kg)") == [pytest.approx(2 * 7850 * 0.08 * 0.08 * 0.13)]
    assert table.left_out == ("left out: two beams leave no room",)


def test_panels() -> None:
    parts = assembly()
    nest = nest_panels(parts["panels"], Sheet(1200.0, 1200.0), gap_mm=5, border_mm=10)
    table = cut_list(parts, nest)["panels"]
    assert column(table, "Mark") == ["P001", "P002"]
    assert column(table, "Area (m2)") == [pytest.approx(2.0), pytest.approx(0.25)]
    assert column(table, "Edges (mm)") == [" / ".join(["1000.00"] * 4), " / ".join(["500.00"] * 4)]
    assert column(table, "Corners (deg)") == [" / ".join(["90.00"] * 4)] * 2
    assert column(table, "Dihedrals (deg)")[0] == "4.00 / 4.00 to 6.00 / 4.00 / 4.00"
    assert column(cut_list(alone(), None)["panels"], "Dihedrals (deg)") == ["- / 4.00 / 4.00 / 4.00"]
    assert column(table, "Neighbours") == ["- / P002 / left out / P001; P001 / - / - / -", "P001 / - / - / -"]
    assert column(table, "Sheets") == ["1, 2", "3"]
    assert column(table, "File") == ["panels/P001.dxf", "panels/P002.dxf"]
    assert total(table, "Area (m2)") == pytest.approx(2.25)
    assert table.left_out == ("left out: its node is left out",)
    assert column(cut_list(parts, None)["panels"], "Sheets") == ["", ""]


@pytest.mark.parametrize(
    ("angles", "glyph"),
    [
        ((2.0, 2.0), "\\_/"),
        ((-2.0, 2.0), "/_/"),
        ((0.0, 2.0), "|_/"),
        ((-2.0, -2.0), "/_\\"),
        ((0.004, -0.004), "|_|"),
        ((0.006, -0.006), "\\_\\"),
    ],
)
def test_ends_seen_from_the_side(angles: tuple[float, float], glyph: str) -> None:
    assert ends_glyphs(np.array([angles])) == [glyph]


def test_glyphs_follow_the_solid() -> None:
    """The outer side is the longer one at an end that leans outwards, as the glyph shows it."""
    beams = design(Project(mesh=ROOF, unit="m", nesting=Nesting(mode="off"))).nominal["beams"]
    row = {-1: "/", 0: "|", 1: "\\"}
    for beam in beams:
        corners = beam.solid.vertices
        outer = corners[corners[:, 2] > -1.0, 0]
        inner = corners[corners[:, 2] < 1.0 - beam.details.section.height_mm, 0]
        # what is drawn as square, over the height of the beam
        least = np.tan(np.radians(0.005)) * beam.details.section.height_mm
        leans = [inner.min() - outer.min(), inner.max() - outer.max()]
        signs = [0 if abs(lean) < least else int(np.sign(lean)) for lean in leans]
        assert ends_glyphs(beam.details.cut_angles_deg[None])[0] == row[signs[0]] + "_" + row[signs[1]]
    assert len(set(ends_glyphs(beams.details.cut_angles_deg))) > 1


def test_all_parts_are_counted_once() -> None:
    parts = gridshell(6, 5, left_out=3)
    for table, group in zip(cut_list(parts, None).tables, by_name(parts).values(), strict=True):
        assert sum(column(table, "Count")) == len(group) == total(table, "Count")  # type: ignore[arg-type]
        assert total(table, "Mass (kg)") == pytest.approx(sum(part.mass_kg for part in group), rel=1e-9)
        assert all(len(row) == len(table.columns) == len(table.decimals) for row in [*table.rows, table.totals])
    assert len(cut_list(parts, None)["beams"].left_out) == 3


def test_numbers_are_shown_to_their_decimals() -> None:
    cells, totals = ((1.005001, None), (3, -3), ("x", ""), (-0.04, 1e6)), ("", None, None, -0.06)
    table = Table("t", tuple(map(Column, "abcd", (2, 0, None, 1), cells, totals)))
    assert table.texts == (("1.01", "3", "x", "0.0"), ("", "-3", "", "1000000.0"))
    assert table.total_texts == ("", "", "", "-0.1")


def test_nothing_to_make() -> None:
    lists = cut_list(assembled("empty"), None)
    assert [table.rows for table in lists.tables] == [(), (), ()]
    assert [total(table, "Count") for table in lists.tables] == [0, 0, 0]
