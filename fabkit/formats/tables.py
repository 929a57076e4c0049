"""Cut lists as CSV, for programs, and as one XLSX workbook, for people. The same lists give the same bytes."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

import xlsxwriter

from fabkit.parts import Cell
from fabkit.production import WORKBOOK, BuildFacts, CutList, Fact, Summary, Table

__all__ = ["spreadsheet_safe", "write_csv", "write_xlsx"]

CREATED = datetime(2000, 1, 1)
"""Time of creation written into workbooks, so that the same lists give the same bytes."""
MAX_SHEET_COLUMN_LETTERS = 48
"""Largest width of a column of the workbook, in letters."""

LONGEST_CELL, CUT_OFF = 32767, " ..."
"""Largest number of letters of a cell of a workbook; end of a text that was longer."""

_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", re.ASCII)
_POSSIBLE_FORMULA = re.compile(r"[-=+@\t\r\n\uff1d\uff0b\uff0d\uff20]")
_FORMULA_START = re.compile(r"(?:^|(?<=[;\t\n]))(?=[-=+@\t\n\uff1d\uff0b\uff0d\uff20])")


def write_csv(target: Path | TextIO, table: Table) -> None:
    """The rows, the totals, then one row for each part left out, with its sentence in the first column.

    UTF-8 without a mark (everything but names is ASCII), commas, decimal points, lines end in \\n. Numbers are as they
    are; a text that a spreadsheet would take for a formula has an apostrophe before it, as `spreadsheet_safe` says.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import write_csv
    >>> from fabkit.production import cut_list
    >>> write_csv(Path("beams.csv"), cut_list(built.assembly, built.nest)["beams"])
    >>> Path("beams.csv").read_text().splitlines()[1][:27]
    'B001,6,flat 50x120,steel,23'
    """
    rows: list[Sequence[str]] = [table.columns, *table.texts, table.total_texts]
    rows += [[sentence] + [""] * (len(table.columns) - 1) for sentence in table.left_out]
    rows = [[spreadsheet_safe(cell) for cell in row] for row in rows]
    if isinstance(target, Path):
        with target.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows(rows)
    else:
        csv.writer(target, lineterminator="\n").writerows(rows)


def spreadsheet_safe(cell: str) -> str:
    """The text of a cell, with an apostrophe before what a spreadsheet would run if it began a cell there.

    What begins with = + - @, a tab or a line end is run, also after a semicolon, tab or line end, at which spreadsheets
    of other countries part cells [OWASP, CSV Injection]. Numbers are no formulas.
    """
    if not _POSSIBLE_FORMULA.search(cell) or _NUMBER.fullmatch(cell):
        return cell
    lines = cell.replace("\r\n", "\n").replace("\r", "\n")  # of which csv.writer quotes no \r
    return _FORMULA_START.sub("'", lines)


def write_xlsx(path: Path, lists: CutList, summary: Summary, facts: BuildFacts) -> None:
    """A sheet Summary and one sheet for each table: header frozen and filtered, numbers as numbers, the totals below,
    then in red what was left out.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import write_xlsx
    >>> from fabkit.production import cut_list
    >>> write_xlsx(Path("list.xlsx"), cut_list(built.assembly, built.nest), built.summary, built.facts)
    >>> Path("list.xlsx").read_bytes()[:2]
    b'PK'
    """
    with xlsxwriter.Workbook(path, {"in_memory": True}) as workbook:
        workbook.set_properties({"title": summary.name, "created": CREATED})
        _write_summary(workbook, lists, summary, facts)
        for table in lists.tables:
            _write_table(workbook, table)


def _write_table(workbook: Any, table: Table) -> None:
    sheet = workbook.add_worksheet(table.title.capitalize())
    head = workbook.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "top"})
    patterns = [{"num_format": _pattern(decimals)} for decimals in table.decimals]
    formats = [workbook.add_format(pattern) for pattern in patterns]
    total_formats = [workbook.add_format({"bold": True, "top": 1, **pattern}) for pattern in patterns]
    for column, (name, *shown) in enumerate(zip(table.columns, *table.texts, table.total_texts, strict=True)):
        sheet.write_string(0, column, name, head)
        sheet.set_column(column, column, min(MAX_SHEET_COLUMN_LETTERS, max(map(len, (name[:14], *shown)))) + 2)
    for number, row in enumerate(table.rows, start=1):
        _write_row(sheet, number, row, formats)
    _write_row(sheet, len(table.rows) + 1, table.totals, total_formats)
    red = workbook.add_format({"font_color": "red"})
    for number, sentence in enumerate(table.left_out, start=len(table.rows) + 2):
        sheet.write_string(number, 0, _cut(sentence), red)
    sheet.freeze_panes(1, 1)
    sheet.autofilter(0, 0, len(table.rows), len(table.columns) - 1)
    sheet.set_landscape()
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(0)


def _write_row(sheet: Any, number: int, row: Sequence[Cell], formats: Sequence[Any]) -> None:
    for column, (cell, form) in enumerate(zip(row, formats, strict=True)):
        _write_cell(sheet, number, column, cell, form)


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST_CELL else text[: LONGEST_CELL - len(CUT_OFF)] + CUT_OFF


def _write_cell(sheet: Any, number: int, column: int, cell: Cell, form: Any) -> None:
    """Said by type, so that no text is taken for a formula or a number."""
    if cell is None:
        sheet.write_blank(number, column, None, form)
    elif isinstance(cell, str):
        sheet.write_string(number, column, _cut(cell), form)
    else:
        sheet.write_number(number, column, cell, form)


def _pattern(decimals: int | None) -> str:
    if decimals is None:
        return "@"
    return "0." + "0" * decimals if decimals else "0"


def _write_summary(workbook: Any, lists: CutList, summary: Summary, facts: BuildFacts) -> None:
    """Headings, below them facts in two columns, notes in a third one, and sentences."""
    sheet = workbook.add_worksheet("Summary")
    for column, width in enumerate((48, 24, 48)):
        sheet.set_column(column, column, width)
    bold = workbook.add_format({"bold": True})
    left = workbook.add_format({"align": "left"})
    red = workbook.add_format({"font_color": "red"})
    left_out = [sentence for table in lists.tables for sentence in table.left_out]
    blocks: list[tuple[str, Sequence[tuple[str, Cell, str]], Any]] = [
        (summary.name, _shown(facts.mesh), None),
        ("Parts", _shown(facts.parts), None),
        ("Sheets", _shown(facts.sheets), None),
        ("Findings, noted or accepted", _findings(summary), None),
        ("Mended in the mesh file", [(text, None, "") for text in summary.mended or ["nothing"]], None),
        ("Left out", [(text, None, "") for text in left_out or ["nothing"]], red if left_out else None),
    ]
    line = 0
    for heading, lines, form in blocks:
        sheet.write_string(line, 0, heading, bold)
        for number, (name, value, note) in enumerate(lines, start=line + 1):
            sheet.write_string(number, 0, name, form)
            _write_cell(sheet, number, 1, value, left)
            _write_cell(sheet, number, 2, note or None, None)
        line += len(lines) + 2


def _shown(facts: Sequence[Fact]) -> list[tuple[str, Cell, str]]:
    """Name with unit, value, note; one number is a number, rounded as it is shown elsewhere."""
    lines: list[tuple[str, Cell, str]] = []
    for fact in facts:
        value: Cell = fact.figures or None
        if len(fact.values) == 1 and not isinstance(fact.values[0], str):
            value = float(fact.figures.replace(",", "")) if fact.form else fact.values[0]
        lines.append((f"{fact.name} ({fact.unit})" if fact.unit else fact.name, value, fact.note))
    return [line for line, fact in zip(lines, facts, strict=True) if WORKBOOK in fact.shown]


def _findings(summary: Summary) -> list[tuple[str, Cell, str]]:
    findings: list[tuple[str, Cell, str]]
    findings = [(f"{each.name} ({each.level})", each.sentence, "") for each in summary.fitness]
    return findings or [("nothing", None, "")]
