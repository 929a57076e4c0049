"""All lists as one XLSX workbook, for people: it prints on pages that can be read.

The same lists give the same bytes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import xlsxwriter

from fabkit.formats.legend_table import legend
from fabkit.parts import Cell, Kind
from fabkit.production import WORKBOOK, BuildFacts, Fact, Summary, Table
from fabkit.rules import TitleBlock

__all__ = ["write_xlsx"]

CREATED = datetime(2000, 1, 1)
"""Time of creation written into workbooks, so that the same lists give the same bytes."""
FONT, FONT_POINTS = "Arial", 9
"""Font of all cells and its size in points; Arial, since programs without it have one of the same widths. Nine, since a
sheet as wide as below is printed at 8/9 of its size."""
PORTRAIT_PIXELS, LANDSCAPE_PIXELS, LARGE_PIXELS = 800, 1170, 1680
"""Widths in pixels (96 per inch) of sheets that are printed at 8 points or more: on A4 upright, A4 across, A3
across; the printed widths less borders of 1 cm, times 9/8."""
EM_PIXELS = 12.6
"""Height in pixels of that font, 12, and a twentieth more, by which LibreOffice makes columns narrower than Excel."""
CELL_PIXELS, INDENT_PIXELS = 12, 9
"""Widths in pixels of the space beside a text, and of that before the text in columns of text."""
BOLD_WIDTH = 1.1
"""Width of bold letters over that of others."""
WIDEST_TEXT_PIXELS, UPRIGHT_TEXT_PIXELS, NARROWEST_TEXT_PIXELS = 560, 400, 100
"""Largest width in pixels of a column of text, whose cells then have several lines; the same where the sheet then fits
A4 upright, and where it would else be too wide."""
LINE_POINTS = 12.5
"""Height in points of a line of text in a cell."""
MAX_HEADER_LETTERS = 55
"""Largest number of letters of the project and of the issue in the head of a page: a head has at most 255, and a
sign & counts twice."""

LONGEST_CELL, CUT_OFF = 32767, " ..."
"""Largest number of letters of a cell of a workbook; end of a text that was longer."""

_WIDTHS = {
    letter: width
    for letters, width in (
        ("ijl' !,./:;I[\\]ft|", 0.28),
        ("()-r`\u00b0", 0.34),
        ("cksvxyz*J", 0.5),
        ('0123456789abdeghnopqu"#$?_{}^L\u00e4\u00f6\u00fc\u00e9\u00e8\u00df', 0.56),
        ("ABEKPSVXYFTZ&+<=>~\u00c4", 0.67),
        ("CDHNRUw\u00dc", 0.73),
        ("GOQ\u00d6", 0.78),
        ("mM", 0.84),
    )
    for letter in letters
}
"""Widths of the letters of that font over its height, rounded up; all others are taken as squares."""
_DIGITS = str.maketrans("123456789", "000000000")


def write_xlsx(
    path: Path,
    tables: Sequence[Table],
    summary: Summary,
    facts: BuildFacts,
    title_block: TitleBlock | None = None,
    *,
    apart: Sequence[str] = (),
    kinds: Sequence[Kind[Any]] = (),
) -> None:
    """The sheets Legend and Summary, and one for each table that is not apart: header frozen and filtered, numbers as
    numbers, the totals below, then in red what was left out. apart: titles of tables that are CSV files only; the
    summary lists them too. kinds: of the parts that there are, for the legend, by default
    beams, nodes and panels.

    Each sheet prints as wide as its paper, at 8 points or more, with the heading on each page, and above and below it
    the project, revision and date, the units, and the page. Empty columns and that of files are hidden.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import write_xlsx
    >>> from fabkit.production import cut_list
    >>> write_xlsx(Path("list.xlsx"), cut_list(built.assembly, built.nest).tables, built.summary, built.facts)
    >>> Path("list.xlsx").read_bytes()[:2]
    b'PK'
    """
    issued = title_block or TitleBlock()
    data = BytesIO()  # so that a full disk is told as it is of all other files
    with xlsxwriter.Workbook(data, {"in_memory": True}) as workbook:
        workbook.set_properties(
            {"title": summary.name, "author": issued.author, "company": issued.organisation, "created": CREATED}
        )
        workbook.formats[0].set_font_name(FONT)
        workbook.formats[0].set_font_size(FONT_POINTS)
        contents: list[tuple[str, Cell, str]] = [
            (each.file, each.n_rows, "rows; not in this workbook" if each.title in apart else "rows") for each in tables
        ]
        _write_table(workbook, legend(summary.site, kinds), summary.name, issued)
        _write_summary(workbook, tables, contents, summary, facts, issued)
        for table in tables:
            if table.title not in apart:
                _write_table(workbook, table, summary.name, issued)
    path.write_bytes(data.getvalue())


def _sheet_name(table: Table) -> str:
    return table.title.capitalize().replace("_", " ")


def _format(workbook: Any, **properties: Any) -> Any:
    return workbook.add_format({"font_name": FONT, "font_size": FONT_POINTS, "valign": "top", **properties})


def _set_page(sheet: Any, title: str, project: str, issued: TitleBlock, pixels: float) -> None:
    """Paper, borders, head and foot of the printed pages of a sheet of this width."""
    if pixels > PORTRAIT_PIXELS:
        sheet.set_landscape()
    sheet.set_paper(8 if pixels > LANDSCAPE_PIXELS else 9)  # A3, A4
    sheet.set_margins(left=0.39, right=0.39, top=0.75, bottom=0.6)
    sheet.fit_to_pages(1, 0)
    left, right = _in_header(project), _in_header(issued.issue)
    sheet.set_header(f"&L{left}&C{title}&R{right}")
    sheet.set_footer(f"&L{_in_header(issued.organisation)}&Cmm, degrees, kg&RPage &P of &N")


def _in_header(text: str) -> str:
    """A sign & begins a code there, and a blank keeps digits from being taken for the size of a font."""
    plain = "".join(letter if letter.isprintable() else " " for letter in text)
    short = plain if len(plain) <= MAX_HEADER_LETTERS else plain[: MAX_HEADER_LETTERS - len(CUT_OFF)] + CUT_OFF
    return short.replace("&", "&&")


def _write_table(workbook: Any, table: Table, project: str, issued: TitleBlock) -> None:
    title = _sheet_name(table)
    sheet, widths = workbook.add_worksheet(title), _widths(table)
    sheet.set_default_row(LINE_POINTS)
    patterns = [_pattern(decimals) for decimals in table.decimals]
    heads = [
        _format(workbook, bold=True, bottom=1, **{**pattern, "text_wrap": True, "valign": "bottom"})
        for pattern in patterns
    ]
    formats = [_format(workbook, bottom=1, bottom_color="#d0d0d0", **pattern) for pattern in patterns]
    total_formats = [_format(workbook, bold=True, top=1, **pattern) for pattern in patterns]
    for column, (name, width, head) in enumerate(zip(table.columns, widths, heads, strict=True)):
        sheet.write_string(0, column, name, head)
        sheet.set_column_pixels(column, column, width, None, {"hidden": width == 0})
    rooms = [
        width + (0 if decimals is None else INDENT_PIXELS)
        for width, decimals in zip(widths, table.decimals, strict=True)
    ]
    shown_heads = [each for each, width in zip(zip(table.columns, rooms, strict=True), widths, strict=True) if width]
    sheet.set_row(0, LINE_POINTS * max(_lines(*each, bold=True) for each in shown_heads))
    for number, row in enumerate(table.rows, start=1):
        _write_row(sheet, number, row, formats)
    lines = np.ones(table.n_rows, dtype=np.int64)
    for each, width in zip(table.by_column, widths, strict=True):
        texts = [cell for cell in each.cells if isinstance(cell, str)]
        taken = {shape: _lines(shape, width) for shape in _shapes(texts)}
        if max(taken.values(), default=1) > 1:
            lines = np.maximum(lines, [taken.get(_shape(str(cell)), 1) for cell in each.cells])
    for number in (np.flatnonzero(lines > 1) + 1).tolist():
        sheet.set_row(number, LINE_POINTS * int(lines[number - 1]))
    if table.totals:
        _write_row(sheet, table.n_rows + 1, table.totals, total_formats)
    red = _format(workbook, font_color="red", text_wrap=True)
    for number, sentence in enumerate(table.left_out, start=table.n_rows + 2):
        _merge(sheet, number, 0, len(widths) - 1, sentence, red)
        sheet.set_row(number, LINE_POINTS * _lines(sentence, sum(widths)))
    sheet.freeze_panes(1, 1)
    sheet.autofilter(0, 0, table.n_rows, len(table.columns) - 1)
    sheet.repeat_rows(0)
    _set_page(sheet, title, project, issued, sum(widths))


def _widths(table: Table) -> list[int]:
    """Width of each column in pixels: its longest text and the longest word of its heading. 0 of a column that is
    hidden: one without any text, and that of files, which have the names of the marks. Where the sheet would be wider
    than A4 upright, A4 across, and then A3 across, its texts take several lines."""
    columns, totals = [column.texts for column in table.by_column], table.total_texts
    beside = [INDENT_PIXELS if decimals is None else 0 for decimals in table.decimals]
    heads = [max(_pixels(word, bold=True) for word in name.split()) for name in table.columns]
    hide = [
        name == "File" or (bool(texts) and not any(texts) and not total)
        for name, texts, total in zip(table.columns, columns, totals, strict=True)
    ]
    natural = [
        max(head, _pixels(total, bold=True), *map(_pixels, _shapes(texts)))
        for head, total, texts in zip(heads, totals, columns, strict=True)
    ]
    for paper, least in (
        (PORTRAIT_PIXELS, UPRIGHT_TEXT_PIXELS),
        (LANDSCAPE_PIXELS, NARROWEST_TEXT_PIXELS),
        (LARGE_PIXELS, NARROWEST_TEXT_PIXELS),
    ):
        for limit in range(WIDEST_TEXT_PIXELS, least - 1, -20):
            widths = [
                0 if hidden else math.ceil(extra + (max(min(width, limit), head) if extra else width))
                for width, head, extra, hidden in zip(natural, heads, beside, hide, strict=True)
            ]
            if sum(widths) <= paper:
                return widths
    return widths


def _shape(text: str) -> str:
    """A text of the same width that many share: all digits are as wide as 0."""
    return text.translate(_DIGITS)


def _shapes(texts: Sequence[str]) -> set[str]:
    return set(_shape("\0".join(texts)).split("\0"))


def _pixels(text: str, bold: bool = False) -> float:
    letters = EM_PIXELS * sum(_WIDTHS.get(letter, 1.0) for letter in text)
    return (BOLD_WIDTH if bold else 1.0) * letters + CELL_PIXELS


def _lines(text: str, width: float, bold: bool = False) -> int:
    """Number of lines that a text takes in a cell of this width, with room for words that do not end there."""
    room, lines, blank = width - CELL_PIXELS / 2 - INDENT_PIXELS, 0, _pixels(" ") - CELL_PIXELS
    if _pixels(text, bold) - CELL_PIXELS <= room and "\n" not in text:
        return 1
    for paragraph in text.split("\n"):
        used, lines = 0.0, lines + 1
        for word in paragraph.split(" "):
            length = _pixels(word, bold) - CELL_PIXELS
            if used and used + blank + length > room:
                used, lines = 0.0, lines + 1
            lines += max(0, math.ceil(length / room) - 1)
            used += (blank if used else 0.0) + min(length, room)
    return lines


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


def _merge(sheet: Any, number: int, first: int, last: int, text: str, form: Any) -> None:
    """One cell of several columns; the text is written apart, since merging would make a formula of "=1+1"."""
    sheet.merge_range(number, first, number, last, "", form)
    sheet.write_string(number, first, _cut(text), form)


def _pattern(decimals: int | None) -> dict[str, Any]:
    if decimals is None:
        return {"num_format": "@", "text_wrap": True, "align": "left", "indent": 1}
    return {"num_format": "0." + "0" * decimals if decimals else "0", "align": "right"}


SUMMARY_PIXELS = (325, 165, 310)
"""Widths in pixels of the columns of the summary: names, values, notes."""


def _write_summary(
    workbook: Any,
    tables: Sequence[Table],
    contents: Sequence[tuple[str, Cell, str]],
    summary: Summary,
    facts: BuildFacts,
    issued: TitleBlock,
) -> None:
    """Headings, below them facts in two columns, notes in a third one, and sentences."""
    sheet = workbook.add_worksheet("Summary")
    sheet.set_default_row(LINE_POINTS)
    for column, width in enumerate(SUMMARY_PIXELS):
        sheet.set_column_pixels(column, column, width)
    bold = _format(workbook, bold=True)
    wrapped = _format(workbook, align="left", text_wrap=True)
    red = _format(workbook, font_color="red", text_wrap=True)
    left_out = [sentence for table in tables for sentence in table.left_out]
    blocks: list[tuple[str, Sequence[tuple[str, Cell, str]], Any]] = [
        (summary.name, [*_issue(issued), *_shown(facts.mesh)], wrapped),
        ("Parts", _shown(facts.parts), wrapped),
        ("Sheets", _shown(facts.sheets), wrapped),
        ("Lists", contents, wrapped),
        ("Findings, noted or accepted", _findings(summary), wrapped),
        ("Mended in the mesh file", [(text, None, "") for text in summary.mended or ["nothing"]], wrapped),
        ("Left out", [(text, None, "") for text in left_out or ["nothing"]], red if left_out else wrapped),
    ]
    line = 0
    for heading, rows, form in blocks:
        sheet.write_string(line, 0, _cut(heading), bold)
        for number, row in enumerate(rows, start=line + 1):
            _write_fact(sheet, number, row, form)
        line += len(rows) + 2
    _set_page(sheet, "Summary", summary.name, issued, sum(SUMMARY_PIXELS))


def _write_fact(sheet: Any, number: int, row: tuple[str, Cell, str], form: Any) -> None:
    """A name, a value and a note; a text without a note runs over the columns to its right."""
    name, value, note = row
    first, second, third = SUMMARY_PIXELS
    texts = [(name, first), (str(value), second), (note, third)]
    if value is None and not note:
        _merge(sheet, number, 0, 2, name, form)
        texts = [(name, sum(SUMMARY_PIXELS))]
    elif isinstance(value, str) and not note:
        sheet.write_string(number, 0, name, form)
        _merge(sheet, number, 1, 2, value, form)
        texts = [(name, first), (value, second + third)]
    else:
        for column, cell in enumerate((name, value, note or None)):
            _write_cell(sheet, number, column, cell, form)
    sheet.set_row(number, LINE_POINTS * max(_lines(*each) for each in texts))


def _issue(issued: TitleBlock) -> list[tuple[str, Cell, str]]:
    return [(key.capitalize(), value, "") for key, value in vars(issued).items() if value]


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
