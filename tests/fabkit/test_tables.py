"""Lists read back by csv and by openpyxl."""

from __future__ import annotations

import csv
import re
from io import StringIO
from pathlib import Path

import openpyxl
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fabkit.formats.tables import CUT_OFF, LONGEST_CELL, spreadsheet_safe, write_csv, write_xlsx
from fabkit.parts import Assembly
from fabkit.production.cut_lists import CutList, Table, cut_list
from fabkit.production.facts import BuildFacts, build_facts
from fabkit.production.nests import Nest, Sheet
from fabkit.production.sheet_nesting import nest_panels
from tests.fabkit.gridshell import gridshell, gridshell_summary

RED = "FFFF0000"
NO_FACTS = BuildFacts((), (), ())


@pytest.fixture(scope="module")
def parts() -> Assembly:
    return gridshell(3, 2, left_out=2)


@pytest.fixture(scope="module")
def nest(parts: Assembly) -> Nest:
    return nest_panels(parts["panels"], Sheet(6000.0, 3210.0), gap_mm=10, border_mm=15)


@pytest.fixture(scope="module")
def lists(parts: Assembly, nest: Nest) -> CutList:
    return cut_list(parts, nest)


def test_csv_reads_back(lists: CutList, tmp_path: Path) -> None:
    for table in lists.tables:
        write_csv(tmp_path / "table.csv", table)
        data = (tmp_path / "table.csv").read_bytes()
        assert b"\r" not in data
        assert data.isascii()
        head, *rows = csv.reader(StringIO(data.decode()))
        assert tuple(head) == table.columns
        assert all(len(row) == len(head) for row in rows)
        body, (totals, *left_out) = rows[: len(table.rows)], rows[len(table.rows) :]
        for row, cells in zip(body, table.rows, strict=True):
            for text, cell, decimals in zip(row, cells, table.decimals, strict=True):
                if isinstance(cell, int | float):
                    assert decimals is not None
                    assert float(text) == pytest.approx(cell, abs=0.5001 * 10**-decimals)  # half the last digit
                else:
                    assert text == spreadsheet_safe(cell or "")
        assert totals[:2] == ["Total", str(table.totals[1])]
        assert [row[0] for row in left_out] == list(table.left_out)
        stream = StringIO()
        write_csv(stream, table)
        assert stream.getvalue().encode() == data
    assert len(lists["beams"].left_out) == 2


def test_xlsx_reads_back(parts: Assembly, lists: CutList, nest: Nest, tmp_path: Path) -> None:
    summary = gridshell_summary(3, 2, mended=("2 doubled vertices were merged",))
    write_xlsx(tmp_path / "list.xlsx", lists, summary, build_facts(summary, parts, nest))
    book = openpyxl.load_workbook(tmp_path / "list.xlsx")
    assert book.sheetnames == ["Summary", "Beams", "Nodes", "Panels"]
    for table, sheet in zip(lists.tables, book.worksheets[1:], strict=True):
        head, *rows = sheet.iter_rows(values_only=True)
        assert head == table.columns
        assert sheet.freeze_panes == "B2"
        assert sheet.auto_filter.ref == f"A1:{sheet.cell(len(table.rows) + 1, len(head)).coordinate}"
        for row, cells in zip(rows, [*table.rows, table.totals], strict=False):
            for value, cell in zip(row, cells, strict=True):
                # the writer keeps sixteen digits
                assert value == (pytest.approx(cell, rel=1e-14) if isinstance(cell, float) else (cell or None))
        for number, sentence in enumerate(table.left_out, start=len(table.rows) + 3):
            assert sheet.cell(number, 1).value == sentence
            assert sheet.cell(number, 1).font.color.rgb == RED
        decimals = table.decimals[head.index("Mass (kg)")]
        assert sheet.cell(2, head.index("Mass (kg)") + 1).number_format == "0." + "0" * (decimals or 0)
    lines = dict(book["Summary"].iter_rows(max_col=2, values_only=True))
    assert lines["Mesh file"] == "roof.obj"
    assert lines["Beams"] == len(gridshell(3, 2, left_out=2)["beams"])
    assert lines["Panels, mass (kg)"] == pytest.approx(
        lists["panels"].totals[lists["panels"].columns.index("Mass (kg)")], 0.1
    )
    assert lines["Sheets used"] == nest.n_sheets
    assert lines["Utilisation (%)"] == pytest.approx(100 * nest.utilisation, abs=0.0501)  # to one decimal
    assert "2 doubled vertices were merged" in lines
    reds = [row[0].value for row in book["Summary"].iter_rows() if row[0].font.color and row[0].font.color.rgb == RED]
    assert reds == list(lists["beams"].left_out)


def test_xlsx_without_nest_says_so(parts: Assembly, lists: CutList, tmp_path: Path) -> None:
    write_xlsx(
        tmp_path / "list.xlsx", lists, gridshell_summary(3, 2), build_facts(gridshell_summary(3, 2), parts, None)
    )
    lines = dict(openpyxl.load_workbook(tmp_path / "list.xlsx")["Summary"].iter_rows(max_col=2, values_only=True))
    assert "Panels were not nested" in lines
    assert "nothing" in lines


def test_texts_are_no_formulas(tmp_path: Path) -> None:
    table = Table("t", ("Mark", "Count", "Mass (kg)"), (None, 0, 1), (("=1+1", 1, 2.5),), ("Total", 1, 2.5), ())
    panels = Table("p", ("Mark", "Count", "Mass (kg)", "Area (m2)"), (None, 0, 1, 1), (), ("Total", 0, 0.0, 0.0), ())
    write_xlsx(
        tmp_path / "a.xlsx", CutList((table, Table("u", *table_parts(table)), panels)), gridshell_summary(), NO_FACTS
    )
    cell = openpyxl.load_workbook(tmp_path / "a.xlsx")["T"]["A2"]
    assert (cell.value, cell.data_type) == ("=1+1", "s")


def test_any_text_and_number_reads_back_from_xlsx(tmp_path: Path) -> None:
    rows = ((" <b>&amp;\x07 _x0041_\n", -1.25e-7, 3), ("x" * 40_000, None, "1.0 to 2.0"))
    table = Table("t", ("Mark", "Mass (kg)", "Count"), (None, 3, 0), rows, ("Total", 0.1, 3), ())
    empty = Table("p", ("Mark", "Count", "Mass (kg)", "Area (m2)"), (None, 0, 1, 1), (), ("Total", 0, 0.0, 0.0), ())
    write_xlsx(
        tmp_path / "a.xlsx", CutList((table, Table("u", *table_parts(table)), empty)), gridshell_summary(), NO_FACTS
    )
    first, second, totals = openpyxl.load_workbook(tmp_path / "a.xlsx")["T"].iter_rows(min_row=2, values_only=True)
    assert (str(first[0]).replace("_x0007_", "\x07"), *first[1:]) == rows[0]  # which openpyxl leaves as it is written
    assert second == ("x" * (LONGEST_CELL - len(CUT_OFF)) + CUT_OFF, None, "1.0 to 2.0")
    assert totals == table.totals
    sheet = openpyxl.load_workbook(tmp_path / "a.xlsx")["T"]
    assert [[cell.number_format for cell in row] for row in sheet.iter_rows(min_row=2)] == [["@", "0.000", "0"]] * 3


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
    write_csv(stream, Table("t", ("Mark", "=Head"), (None, None), ((text, "x"),), ("Total", text), (text,)))
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
    write_csv(stream, Table("t", ("Mark", "Angle"), (None, decimals), (("A", number),), ("Total", None), ()))
    _, row, _ = csv.reader(StringIO(stream.getvalue()))
    assert float(row[1]) == float(f"{round(number, decimals):.{decimals}f}")


def is_number(text: str) -> bool:
    return bool(re.fullmatch(r"[-+]?[0-9]+(\.[0-9]*)?(e[-+]?[0-9]+)?", text))


def table_parts(table: Table) -> tuple[object, ...]:
    return table.columns, table.decimals, table.rows, table.totals, table.left_out


def test_the_same_lists_give_the_same_bytes(parts: Assembly, lists: CutList, nest: Nest, tmp_path: Path) -> None:
    for name in ("a.xlsx", "b.xlsx"):
        write_xlsx(tmp_path / name, lists, gridshell_summary(3, 2), build_facts(gridshell_summary(3, 2), parts, nest))
    first = (tmp_path / "a.xlsx").read_bytes()
    assert first == (tmp_path / "b.xlsx").read_bytes()
    properties = openpyxl.load_workbook(tmp_path / "a.xlsx").properties
    assert properties.created.year == 2000
