"""Tables read back by csv."""

from __future__ import annotations

import csv
import re
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fabkit import Project, design
from fabkit.detailing.shapes.dots import DOT_DEPTH_MM, DOT_DIAMETER_MM, DOT_INSET_MM
from fabkit.errors import ProjectError
from fabkit.formats.legend_table import legend
from fabkit.formats.tables import spreadsheet_safe, write_csv
from fabkit.kinds import BEAM, BOLT
from fabkit.parts import Assembly, Column, in_layer
from fabkit.production import Nest, Sheet, Table, cut_list, nest_panels, piece_tables
from fabkit.project import project_from
from fabkit.rules import TableRules
from geometry.mesh.shapes import dome
from tests.fabkit.gridshell import gridshell

DIALECTS = [
    TableRules(separator=separator, decimal=decimal, bom=bom)  # type: ignore[arg-type]
    for separator in (",", ";", "tab", "|")
    for decimal in (".", ",")
    for bom in (False, True)
    if separator != decimal
]


@pytest.fixture(scope="module")
def parts() -> Assembly:
    return gridshell(3, 2, left_out=2)


@pytest.fixture(scope="module")
def nest(parts: Assembly) -> Nest:
    return nest_panels(parts["panels"], Sheet(6000.0, 3210.0), gap_mm=10, border_mm=15)


@pytest.fixture(scope="module")
def tables(parts: Assembly, nest: Nest) -> list[Table]:
    of_marks = [table.of_single_values() for table in cut_list(parts, nest).tables]
    return [legend(), *of_marks, *piece_tables(parts, nest)]


@pytest.mark.parametrize("rules", DIALECTS, ids=str)
def test_csv_reads_back_in_every_dialect(tables: list[Table], rules: TableRules, tmp_path: Path) -> None:
    for table in tables:
        write_csv(tmp_path / "table.csv", table, rules)
        data = (tmp_path / "table.csv").read_bytes()
        assert data.startswith(b"\xef\xbb\xbf") == rules.bom
        text = data.decode("utf-8-sig")
        assert "\r" not in text
        head, *rows = csv.reader(StringIO(text, newline=""), delimiter=rules.delimiter)
        assert tuple(head) == table.columns
        assert all(len(row) == len(head) for row in rows)
        body, rest = rows[: table.n_rows], rows[len(table.rows) :]
        for row, cells in zip(body, table.rows, strict=True):
            for shown, cell, decimals in zip(row, cells, table.decimals, strict=True):
                if isinstance(cell, int | float):
                    assert decimals is not None
                    number = float(shown.replace(rules.decimal, "."))
                    assert number == pytest.approx(cell, abs=0.5001 * 10**-decimals)  # half the last digit
                else:
                    assert shown == spreadsheet_safe(cell or "")
        if table.totals:
            assert rest.pop(0)[:2] == ["Total", str(table.totals[1])]
        assert [row[0] for row in rest] == list(table.left_out)
        stream = StringIO()
        write_csv(stream, table, rules)
        assert stream.getvalue() == text
    assert len(tables[1].left_out) == 2


def test_every_cell_has_one_value_and_none_needs_an_apostrophe(tables: list[Table]) -> None:
    for table in tables[1:]:
        for row in table.texts:
            for text in row:
                assert spreadsheet_safe(text) == text
                assert " / " not in text
                assert "; " not in text
                assert " to " not in text


def test_a_dialect_that_cannot_be_read_back_is_refused() -> None:
    for separator, decimal in ((",", ","), ("x", "."), (";", ";"), (";", "")):
        with pytest.raises(ProjectError) as refused:
            project_from({"mesh": "a.obj", "unit": "m", "tables": {"separator": separator, "decimal": decimal}})
        assert "separator" in str(refused.value) or "decimal" in str(refused.value)


def test_pieces_lie_where_the_tables_say(parts: Assembly, nest: Nest) -> None:
    """Each corner of each solid, from the frame in the table; a piece of 2 m to 0.001 mm."""
    pieces, placements, survey, facets, edges = piece_tables(parts, nest)
    assert len(pieces.rows) == len(placements.rows) == sum(map(len, parts.groups))
    assert len({row[0] for row in pieces.rows}) == len(pieces.rows)
    rows = {row[0]: [float(text) for text in row[2:]] for row in placements.texts}
    for group in parts.groups:
        for part in group:
            numbers = np.array(rows[f"{part.mark} {part.kind.element[0]}{part.element}"]).reshape(4, 3)
            origin, x, z, centre = numbers
            corners = part.solid.vertices @ np.array([x, np.cross(z, x), z]) + origin
            expected = part.placement.to_world(part.solid.vertices) + parts.origin_mm
            np.testing.assert_allclose(corners, expected, atol=1e-3)
            np.testing.assert_allclose(centre, expected.mean(axis=0), atol=50)  # of solids that are nearly prisms
    assert len(survey.rows) == len(parts["nodes"])
    beams = {row[0]: row for row in pieces.rows if row[2] == BEAM.name}
    for node, _, number, beam, end, *_ in facets.rows:
        if beam != "left out":
            place = pieces.columns.index(f"Node {end}")
            assert beams[beam][place : place + 2] == (node, number)
    edge = edges.columns.index("Edge")
    assert [row[edge] for row in edges.rows if row[0] == edges.rows[0][0]] == [1, 2, 3, 4]


@given(st.text(st.sampled_from("=+-@\t\r\n;,' 0.5eA\uff1d\uff20")))
@example('=HYPERLINK("http://x","y")')
@example("-2+3|cmd")
@example("steel;=1+1")
@example("-4.21 / -4.26 / 0.04")
def test_no_cell_of_a_csv_is_run(text: str) -> None:
    """Read with commas, and as spreadsheets do whose lists have semicolons, or that part cells at tabs and line ends.

    Only numbers begin with a sign; and what was there is there, but for the apostrophes.
    """
    stream = StringIO()
    write_csv(stream, Table("t", (Column("Mark", None, [text], "Total"), Column("=Head", None, ["x"], text)), (text,)))
    head, row, totals, left_out = csv.reader(StringIO(stream.getvalue(), newline=""))
    assert head == ["Mark", "'=Head"]
    assert row[0] == totals[1] == left_out[0]
    for cell in (row[0], *re.split("[;\t\r\n]", row[0])):
        assert cell[:1] not in set("=+-@\t\r\n\uff1d\uff20") or is_number(cell)
    lines = text.replace("\r\n", "\n").replace("\r", "\n")
    assert row[0].replace("'", "") == lines.replace("'", "")
    assert row[0] == text or not is_number(text)


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers(0, 6))
def test_numbers_stay_numbers(number: float, decimals: int) -> None:
    stream = StringIO()
    write_csv(stream, Table("t", (Column("Mark", None, ["A"], "Total"), Column("Angle", decimals, [number]))))
    _, row, _ = csv.reader(StringIO(stream.getvalue()))
    assert float(row[1]) == float(f"{round(number, decimals):.{decimals}f}")


def is_number(text: str) -> bool:
    return bool(re.fullmatch(r"[-+]?[0-9]+(\.[0-9]*)?(e[-+]?[0-9]+)?", text))


@pytest.fixture(scope="module")
def welded() -> Assembly:
    return design(Project(mesh=dome(4, 2), mean_edge_mm=1500)).assembly


SETTINGS: list[dict[str, Any]] = [
    {"mesh": dome(4, 2), "second_layer": {"distance_mm": -600}, "fins": {"from_mm": 150, "to_mm": 300}},
    {"mesh": dome(12, 3), "beams": {"section": "rhs 120x60x5"}, "connection": {"kind": "bolted"}},
    {
        "mesh": dome(6, 2),
        "beams": {"section": "tee 120x80x10x8"},
        "connection": {"kind": "hub"},
        "supports": {"loop": "rim"},
    },
]


@pytest.mark.parametrize("settings", SETTINGS, ids=["welded", "bolted", "hubs"])
def test_the_legend_explains_every_heading(settings: dict[str, Any]) -> None:
    assembly = design(Project(mean_edge_mm=2000, **settings)).assembly
    signs = {sign.lower() for row in legend().rows for sign in str(row[0]).split(", ")}
    headings = {
        re.sub(r"^(Least|Largest) |( each| [xyz])?( \(.*\))?$", "", name).lower()
        for table in [*cut_list(assembly, None).tables, *piece_tables(assembly, None)]
        for name in table.of_single_values().columns
    }
    assert headings - signs == set()


def test_the_legend_knows_the_dots_of_nodes() -> None:
    (dot,) = (str(row[1]) for row in legend().rows if row[0] == "Could be mounted")
    sizes = re.findall(r"(\d+) mm", dot)
    assert sizes == [f"{size:g}" for size in (DOT_INSET_MM, DOT_DIAMETER_MM, DOT_DEPTH_MM)]


def test_beams_end_on_the_levels_of_their_facets(welded: Assembly) -> None:
    """The middle of the outer side of an end, from its solid, is that level above the point on the mesh."""
    (facets,) = (table for table in piece_tables(welded, None) if table.title == "node_facets")
    beams, nodes = (dict(zip(welded[group].piece_names, welded[group], strict=True)) for group in ("beams", "nodes"))
    column = facets.columns.index
    checked = 0
    for row in facets.rows:
        node, beam = nodes[str(row[column("Node")])].placement, beams[str(row[column("Beam")])]
        corners = beam.solid.vertices
        outer = corners[np.isclose(corners[:, 2], 0.0, atol=1e-6)]
        at_end = np.argsort(outer[:, 0])[:2] if row[column("End")] == "A" else np.argsort(outer[:, 0])[-2:]
        middle = beam.placement.to_world(outer[at_end].mean(axis=0))
        assert row[column("Beam level (mm)")] == pytest.approx((middle - node.origin) @ node.axes[2], abs=0.01)
        checked += 1
    assert checked == 2 * len(beams)


def test_the_legend_tells_of_the_frames_of_the_kinds_that_there_are() -> None:
    rows = dict(legend(kinds=(BEAM, in_layer(BEAM, "lower"), BOLT)).rows)
    assert rows["Mark"].startswith("B beam, LB lower beam, S bolt. ")  # type: ignore[union-attr]
    assert {"Own frame of beams, lower beams", "Own frame of bolts"} <= set(rows)
    assert "Own frame of panels" not in rows
