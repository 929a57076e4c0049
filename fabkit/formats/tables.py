"""Cut lists as CSV, for programs, and as one XLSX workbook, for people. The same lists give the same bytes."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import Any, TextIO
from zipfile import ZipFile

import xlsxwriter
from xlsxwriter.utility import xl_col_to_name

from fabkit.production import WORKBOOK, BuildFacts, Cell, CutList, Fact, Summary, Table

__all__ = ["not_run", "write_csv", "write_xlsx"]

#: Written as the time of creation, so that the same lists give the same bytes.
CREATED = datetime(2000, 1, 1)
WIDEST = 48

LONGEST, GAP = 32767, " ..."
"""Letters of a cell, at the most; what a text ends with that was longer."""

_NOT_IN_XML = re.compile(r"[&<>]|[\x00-\x08\x0b-\x1f\ufffe\uffff]|_(?=x[0-9a-fA-F]{4}_)")
_ENTITIES = {"&": "&amp;", "<": "&lt;", ">": "&gt;"}
_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", re.ASCII)
_MAY_RUN = re.compile(r"[-=+@\t\r\n\uff1d\uff0b\uff0d\uff20]")
_RUN = re.compile(r"(?:^|(?<=[;\t\n]))(?=[-=+@\t\n\uff1d\uff0b\uff0d\uff20])")


def write_csv(target: Path | TextIO, table: Table) -> None:
    """The rows, the totals, then one row for each part left out, with its sentence in the first column.

    UTF-8 without a mark (everything but names is ASCII), commas, decimal points, lines end in \\n. Numbers are as they
    are; a text that a spreadsheet would take for a formula has an apostrophe before it, as `not_run` says.
    """
    rows: list[Sequence[str]] = [table.columns, *table.texts, table.total_texts]
    rows += [[sentence] + [""] * (len(table.columns) - 1) for sentence in table.left_out]
    rows = [[not_run(cell) for cell in row] for row in rows]
    if isinstance(target, Path):
        with target.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows(rows)
    else:
        csv.writer(target, lineterminator="\n").writerows(rows)


def not_run(cell: str) -> str:
    """The text of a cell, with an apostrophe before what a spreadsheet would run if it began a cell there.

    What begins with = + - @, a tab or a line end is run, also after a semicolon, tab or line end, at which spreadsheets
    of other countries part cells [OWASP, CSV Injection]. Numbers are no formulas.
    """
    if not _MAY_RUN.search(cell) or _NUMBER.fullmatch(cell):
        return cell
    lines = cell.replace("\r\n", "\n").replace("\r", "\n")  # of which csv.writer quotes no \r
    return _RUN.sub("'", lines)


def write_xlsx(path: Path, lists: CutList, summary: Summary, facts: BuildFacts) -> None:
    """A sheet Summary and one sheet for each table: header frozen and filtered, numbers as numbers, the totals below,
    then in red what was left out.

    xlsxwriter writes all but the rows; these are set into its text, since it takes five times as long for them, and
    holds every cell in memory.
    """
    frame = BytesIO()
    with xlsxwriter.Workbook(frame, {"in_memory": True}) as workbook:
        workbook.set_properties({"title": summary.name, "created": CREATED})
        _write_summary(workbook, lists, summary, facts)
        for table in lists.tables:
            _write_frame(workbook, table)
    tables = {f"xl/worksheets/sheet{number}.xml": table for number, table in enumerate(lists.tables, start=2)}
    with ZipFile(frame) as source, ZipFile(path, "w") as target:
        for item in source.infolist():
            text = source.read(item)
            if item.filename in tables and tables[item.filename].rows:
                before, first_row, after = re.split(rb'(<row r="2".*?</row>)', text, maxsplit=1)
                styles = re.findall(r's="(\d+)"', first_row.decode())
                text = before + _rows(tables[item.filename], styles).encode() + after
            target.writestr(item, text)


def _write_frame(workbook: Any, table: Table) -> None:
    """A table with no more than blanks in its first row, which have the formats of all rows."""
    sheet = workbook.add_worksheet(table.title.capitalize())
    head = workbook.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "top"})
    texts = zip(table.columns, *table.texts, table.total_texts, strict=True)
    for column, ((name, *shown), decimals, total) in enumerate(zip(texts, table.decimals, table.totals, strict=True)):
        pattern = {"num_format": _pattern(decimals)}
        sheet.write_string(0, column, name, head)
        sheet.set_column(column, column, min(WIDEST, max(map(len, (name[:14], *shown)))) + 2)
        if table.rows:
            sheet.write_blank(1, column, None, workbook.add_format(pattern))
        _write_cell(sheet, len(table.rows) + 1, column, total, workbook.add_format({"bold": True, "top": 1, **pattern}))
    red = workbook.add_format({"font_color": "red"})
    for number, sentence in enumerate(table.left_out, start=len(table.rows) + 2):
        sheet.write_string(number, 0, sentence, red)
    sheet.freeze_panes(1, 1)
    sheet.autofilter(0, 0, len(table.rows), len(table.columns) - 1)
    sheet.set_landscape()
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(0)


def _rows(table: Table, styles: Sequence[str]) -> str:
    """The rows of a table as a sheet has them, the first one in its second row [ECMA-376, 18.3.1.73]."""
    columns = [
        _cells(xl_col_to_name(number), column, style)
        for number, (column, style) in enumerate(zip(zip(*table.rows, strict=True), styles, strict=True))
    ]
    return "".join(f'<row r="{n}">{"".join(row)}</row>' for n, row in enumerate(zip(*columns, strict=True), start=2))


def _cells(letters: str, column: Sequence[Cell], style: str) -> list[str]:
    """A column, said by type, so that no text is taken for a formula or a number."""
    start = f' s="{style}"'
    text, number = start + ' t="inlineStr"><is><t xml:space="preserve">', start + "><v>"
    return [
        f'<c r="{letters}{n}"'
        + (
            f"{text}{_xml(cell)}</t></is></c>"
            if isinstance(cell, str)
            else f"{start}/>"
            if cell is None
            else f"{number}{cell}</v></c>"
        )
        for n, cell in enumerate(column, start=2)
    ]


def _xml(text: str) -> str:
    """The text of a cell, of which a workbook takes LONGEST letters; controls by number [ECMA-376, 22.9.2.19]."""
    if len(text) > LONGEST:
        text = text[: LONGEST - len(GAP)] + GAP
    return _NOT_IN_XML.sub(lambda found: _ENTITIES.get(found[0]) or f"_x{ord(found[0]):04X}_", text)


def _write_cell(sheet: Any, number: int, column: int, cell: Cell, form: Any) -> None:
    """Said by type, so that no text is taken for a formula or a number."""
    if cell is None:
        sheet.write_blank(number, column, None, form)
    elif isinstance(cell, str):
        sheet.write_string(number, column, cell, form)
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
        ("Unusual, told or allowed", _findings(summary), None),
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
