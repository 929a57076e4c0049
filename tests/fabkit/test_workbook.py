"""The workbook, read back by openpyxl, and as the pages that LibreOffice prints."""

from __future__ import annotations

import html
import re
import shutil
import subprocess
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from fabkit.formats.workbook import CUT_OFF, LONGEST_CELL, write_xlsx
from fabkit.parts import Assembly, Cell, Column
from fabkit.production import BuildFacts, Nest, Sheet, Table, build_facts, cut_list, nest_panels, piece_tables
from fabkit.rules import TitleBlock
from tests.fabkit.gridshell import gridshell, gridshell_summary

RED = "FFFF0000"
NO_FACTS = BuildFacts((), (), ())

office, to_text = shutil.which("soffice"), shutil.which("pdftotext")


@pytest.fixture(scope="module")
def parts() -> Assembly:
    return gridshell(3, 2, left_out=2)


@pytest.fixture(scope="module")
def nest(parts: Assembly) -> Nest:
    return nest_panels(parts["panels"], Sheet(6000.0, 3210.0), gap_mm=10, border_mm=15)


@pytest.fixture(scope="module")
def lists(parts: Assembly, nest: Nest) -> list[Table]:
    return [*(table.of_single_values() for table in cut_list(parts, nest).tables), *piece_tables(parts, nest)]


def test_xlsx_reads_back(parts: Assembly, lists: list[Table], nest: Nest, tmp_path: Path) -> None:
    summary = gridshell_summary(3, 2, mended=("2 doubled vertices were merged",))
    write_xlsx(tmp_path / "list.xlsx", lists, summary, build_facts(summary, parts, nest))
    book = openpyxl.load_workbook(tmp_path / "list.xlsx")
    assert book.sheetnames == [
        "Legend",
        "Summary",
        "Beams",
        "Nodes",
        "Panels",
        "Pieces",
        "Placements",
        "Survey",
        "Node facets",
        "Panel edges",
    ]
    for table, sheet in zip(lists, book.worksheets[2:], strict=True):
        head, *rows = sheet.iter_rows(values_only=True)
        assert head == table.columns
        assert sheet.freeze_panes == "B2"
        assert sheet.auto_filter.ref == f"A1:{sheet.cell(table.n_rows + 1, len(head)).coordinate}"
        for row, cells in zip(rows, [*table.rows, table.totals], strict=False):
            for value, cell in zip(row, cells, strict=True):
                if isinstance(cell, float):
                    assert value == pytest.approx(cell, rel=1e-14)  # the writer keeps sixteen digits
                else:
                    assert value == cell or (value in (None, "") and cell in (None, ""))
        for number, sentence in enumerate(table.left_out, start=table.n_rows + 3):
            assert sheet.cell(number, 1).value == sentence
            assert sheet.cell(number, 1).font.color.rgb == RED
        for place, decimals in enumerate(table.decimals, start=1):
            form = "@" if decimals is None else "0." + "0" * decimals if decimals else "0"
            assert sheet.cell(2, place).number_format == form
    lines = dict(book["Summary"].iter_rows(max_col=2, values_only=True))
    assert lines["Mesh file"] == "roof.obj"
    assert lines["Beams"] == len(gridshell(3, 2, left_out=2)["beams"])
    assert lines["Panels, mass (kg)"] == pytest.approx(lists[2].totals[lists[2].columns.index("Mass (kg)")], 0.1)
    assert lines["Sheets used"] == nest.n_sheets
    assert lines["Utilisation (%)"] == pytest.approx(100 * nest.utilisation, abs=0.0501)  # to one decimal
    assert "2 doubled vertices were merged" in lines
    reds = [row[0].value for row in book["Summary"].iter_rows() if row[0].font.color and row[0].font.color.rgb == RED]
    assert reds == list(lists[0].left_out)


def test_long_tables_are_files_and_the_summary_says_where(lists: list[Table], tmp_path: Path) -> None:
    write_xlsx(tmp_path / "list.xlsx", lists, gridshell_summary(3, 2), NO_FACTS, apart=("pieces", "placements"))
    book = openpyxl.load_workbook(tmp_path / "list.xlsx")
    assert {"Pieces", "Placements"}.isdisjoint(book.sheetnames)
    assert {"Beams", "Survey"} <= {*book.sheetnames}
    rows = {row[0]: row[1:3] for row in book["Summary"].iter_rows(values_only=True)}
    for table in lists:
        where = "rows; not in this workbook" if table.title in ("pieces", "placements") else "rows"
        assert rows[f"{table.title}.csv"] == (table.n_rows, where)


def test_xlsx_without_nest_says_so(parts: Assembly, lists: list[Table], tmp_path: Path) -> None:
    write_xlsx(
        tmp_path / "list.xlsx", lists, gridshell_summary(3, 2), build_facts(gridshell_summary(3, 2), parts, None)
    )
    lines = dict(openpyxl.load_workbook(tmp_path / "list.xlsx")["Summary"].iter_rows(max_col=2, values_only=True))
    assert "Panels were not nested" in lines
    assert "nothing" in lines


def test_texts_are_no_formulas(tmp_path: Path) -> None:
    issued, left_out = TitleBlock(author='=HYPERLINK("x")'), ("=2+2", "http://a", "{=1}")
    table = Table("t", marked(["=1+1"], [1], [2.5]), left_out)
    lists = [table, replace(table, title="u"), replace(table, title="p", by_column=marked([], [], []))]
    write_xlsx(tmp_path / "a.xlsx", lists, gridshell_summary(), NO_FACTS, issued)
    book = openpyxl.load_workbook(tmp_path / "a.xlsx")
    assert (book["T"]["A2"].value, book["T"]["A2"].data_type) == ("=1+1", "s")
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row]
    assert [cell.coordinate for cell in cells if cell.data_type == "f"] == []
    assert {cell.value for cell in cells} >= {issued.author, *left_out}


def test_the_legend_prints_on_upright_pages(tmp_path: Path) -> None:
    write_xlsx(tmp_path / "a.xlsx", [], gridshell_summary(), NO_FACTS)
    setup = openpyxl.load_workbook(tmp_path / "a.xlsx")["Legend"].page_setup
    assert (setup.orientation, setup.paperSize) == ("portrait", 9)  # A4


def test_columns_that_say_nothing_are_hidden(tmp_path: Path) -> None:
    columns = ("Mark", "Flange (mm)", "Mass (kg)", "File")
    cells, totals = (["B1"], [None], [2.5], ["parts/B1.step"]), ("Total", None, 2.5, None)
    table = Table("t", tuple(map(Column, columns, (None, 1, 1, None), cells, totals)))
    write_xlsx(tmp_path / "a.xlsx", [table], gridshell_summary(), NO_FACTS)
    sheet = openpyxl.load_workbook(tmp_path / "a.xlsx")["T"]
    assert tuple(cell.value for cell in sheet[1]) == columns
    assert [sheet.column_dimensions[letter].hidden for letter in "ABCD"] == [False, True, False, True]


def test_any_text_and_number_reads_back_from_xlsx(tmp_path: Path) -> None:
    texts = (" <b>&amp;\x07 _x0041_\n", "x" * 40_000)
    columns = marked(texts, (3, "1.0 to 2.0"), (-1.25e-7, None))
    table = Table("t", columns)
    lists = [table, replace(table, title="u"), replace(table, title="p", by_column=marked([], [], []))]
    write_xlsx(tmp_path / "a.xlsx", lists, gridshell_summary(), NO_FACTS)
    first, second, totals = openpyxl.load_workbook(tmp_path / "a.xlsx")["T"].iter_rows(min_row=2, values_only=True)
    read = str(first[0]).replace("_x0007_", "\x07")  # which openpyxl leaves as it is written
    assert (read, *first[1:]) == table.rows[0]
    assert second == ("x" * (LONGEST_CELL - len(CUT_OFF)) + CUT_OFF, "1.0 to 2.0", None)
    assert totals == table.totals
    sheet = openpyxl.load_workbook(tmp_path / "a.xlsx")["T"]
    assert [[cell.number_format for cell in row] for row in sheet.iter_rows(min_row=2)] == [["@", "0", "0.0"]] * 3


def marked(marks: Sequence[Cell], counts: Sequence[Cell], masses: Sequence[Cell]) -> tuple[Column, ...]:
    return Column("Mark", None, marks, "Total"), Column("Count", 0, counts, 3), Column("Mass (kg)", 1, masses, 0.1)


def test_the_same_lists_give_the_same_bytes(parts: Assembly, lists: list[Table], nest: Nest, tmp_path: Path) -> None:
    for name in ("a.xlsx", "b.xlsx"):
        write_xlsx(tmp_path / name, lists, gridshell_summary(3, 2), build_facts(gridshell_summary(3, 2), parts, nest))
    first = (tmp_path / "a.xlsx").read_bytes()
    assert first == (tmp_path / "b.xlsx").read_bytes()
    properties = openpyxl.load_workbook(tmp_path / "a.xlsx").properties
    assert properties.created.year == 2000


@pytest.mark.parametrize("name", ["2nd roof", "R&D &10 \n=1", "&" * 300, "Dach (\u00df)" * 40])
def test_heads_of_pages_say_the_project_and_nothing_of_it_is_a_code(
    parts: Assembly, lists: list[Table], tmp_path: Path, name: str
) -> None:
    issued = TitleBlock(organisation="R&D 3", date="2026-03-01", revision="1&2")
    write_xlsx(tmp_path / "a.xlsx", lists, gridshell_summary(3, 2, name=name), NO_FACTS, issued)
    plain = name.replace("\n", " ")
    shown = plain if len(plain) <= 55 else plain[:51] + " ..."
    with zipfile.ZipFile(tmp_path / "a.xlsx") as files:
        for sheet in [name for name in files.namelist() if "worksheets/sheet" in name]:
            text = html.unescape(files.read(sheet).decode())
            head, foot = (text.split(f"<odd{which}>")[1].split(f"</odd{which}>")[0] for which in ("Header", "Footer"))
            assert len(head) <= 255
            left, _, right = re.fullmatch(r"&L(.*)&C([A-Z][a-z ]+)&R(.*)", head).groups()  # type: ignore[union-attr]
            assert left.replace("&&", "") == shown.replace("&", "")
            assert (left.replace("&&", "&"), right) == (shown, "revision 1&&2, 2026-03-01")
            assert foot == "&LR&&D 3&Cmm, degrees, kg&RPage &P of &N"
            assert 'fitToHeight="0"' in text


@pytest.mark.skipif(office is None or to_text is None, reason="no LibreOffice or no pdftotext")
def test_pages_are_readable(parts: Assembly, lists: list[Table], nest: Nest, tmp_path: Path) -> None:
    """As printed by LibreOffice: letters of 8 points or more, no #### for numbers, heading and page on each page."""
    summary = gridshell_summary(3, 2, name="2nd roof")
    issued = TitleBlock(date="2026-03-01", revision="B")
    write_xlsx(tmp_path / "list.xlsx", lists, summary, build_facts(summary, parts, nest), issued)
    home = f"-env:UserInstallation={(tmp_path / 'home').as_uri()}"
    run = [
        str(office),
        home,
        "--headless",
        "--convert-to",
        "pdf",
        "--outdir",
        str(tmp_path),
        str(tmp_path / "list.xlsx"),
    ]
    subprocess.run(run, check=True, capture_output=True, timeout=120)
    pages = _pages(tmp_path / "list.pdf", "-layout")
    assert len(pages) >= 2 + len(lists)
    for number, page in enumerate(pages, start=1):
        assert "###" not in page
        assert "2nd roof" in page
        assert "revision B, 2026-03-01" in page
        assert f"Page {number} of {len(pages)}" in page
    boxes = "".join(_pages(tmp_path / "list.pdf", "-bbox"))
    heights = [float(low) - float(high) for high, low in re.findall(r'yMin="([\d.]+)" .*?yMax="([\d.]+)"', boxes)]
    assert min(heights) > 8 * 1.0  # a box is higher than the size of its letters


def _pages(path: Path, how: str) -> list[str]:
    text = subprocess.run([str(to_text), how, str(path), "-"], check=True, capture_output=True).stdout.decode()
    return text.split("\f")[:-1] if how == "-layout" else [text]
