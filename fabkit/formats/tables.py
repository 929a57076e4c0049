"""Cut lists as CSV, for programs, and as one XLSX workbook, for people. The same lists give the same bytes."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import xlsxwriter

from fabkit.parts import Cell
from fabkit.production import CutList, Nest, Summary, Table

__all__ = ["not_run", "write_csv", "write_xlsx"]

#: Written as the time of creation, so that the same lists give the same bytes.
CREATED = datetime(2000, 1, 1)
WIDEST = 48

_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", re.ASCII)
_RUN = re.compile(r"(?:^|(?<=[;\t\n]))(?=[-=+@\t\n\uff1d\uff0b\uff0d\uff20])")


def write_csv(target: Path | TextIO, table: Table) -> None:
    """The rows, the totals, then one row for each part left out, with its sentence in the first column.

    UTF-8 without a mark (everything but names is ASCII), commas, decimal points, lines end in \\n. Numbers are as they
    are; a text that a spreadsheet would take for a formula has an apostrophe before it, as `not_run` says.
    """
    rows = [table.columns, *map(table.text, table.rows), table.text(table.totals)]
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
    lines = cell.replace("\r\n", "\n").replace("\r", "\n")  # of which csv.writer quotes no \r
    return cell if _NUMBER.fullmatch(cell) else _RUN.sub("'", lines)


def write_xlsx(path: Path, lists: CutList, summary: Summary, nest: Nest | None) -> None:
    """A sheet Summary and one sheet for each table: header frozen and filtered, numbers as numbers, the totals below,
    then in red what was left out."""
    with xlsxwriter.Workbook(path, {"in_memory": True}) as workbook:
        workbook.set_properties({"title": summary.name, "created": CREATED})
        _write_summary(workbook, lists, summary, nest)
        for table in lists.tables:
            _write_table(workbook, table)


def _write_table(workbook: Any, table: Table) -> None:
    sheet = workbook.add_worksheet(table.title.capitalize())
    head = workbook.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "top"})
    formats = [workbook.add_format({"num_format": _pattern(decimals)}) for decimals in table.decimals]
    total_formats = [
        workbook.add_format({"bold": True, "top": 1, "num_format": _pattern(decimals)}) for decimals in table.decimals
    ]
    texts = [table.text(table.totals), *map(table.text, table.rows)]
    for column, (name, shown) in enumerate(zip(table.columns, zip(*texts, strict=True), strict=True)):
        sheet.write_string(0, column, name, head)
        sheet.set_column(column, column, min(WIDEST, max(map(len, (name[:14], *shown)))) + 2)
    for number, row in enumerate(table.rows, start=1):
        _write_row(sheet, number, row, formats)
    _write_row(sheet, len(table.rows) + 1, table.totals, total_formats)
    red = workbook.add_format({"font_color": "red"})
    for number, sentence in enumerate(table.left_out, start=len(table.rows) + 2):
        sheet.write_string(number, 0, sentence, red)
    sheet.freeze_panes(1, 1)
    sheet.autofilter(0, 0, len(table.rows), len(table.columns) - 1)
    sheet.set_landscape()
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(0)


def _write_row(sheet: Any, number: int, row: Sequence[Cell], formats: Sequence[Any]) -> None:
    for column, (cell, form) in enumerate(zip(row, formats, strict=True)):
        _write_cell(sheet, number, column, cell, form)


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


def _write_summary(workbook: Any, lists: CutList, summary: Summary, nest: Nest | None) -> None:
    """Headings, facts below them in two columns, and sentences."""
    sheet = workbook.add_worksheet("Summary")
    sheet.set_column(0, 0, 48)
    sheet.set_column(1, 1, 24)
    bold = workbook.add_format({"bold": True})
    left = workbook.add_format({"align": "left"})
    red = workbook.add_format({"font_color": "red"})
    left_out = [sentence for table in lists.tables for sentence in table.left_out]
    blocks: list[tuple[str, Sequence[tuple[str, Cell]], Any]] = [
        (summary.name, _mesh_facts(summary), None),
        ("Parts", _part_facts(lists), None),
        ("Sheets", _sheet_facts(nest), None),
        ("Unusual, told or allowed", _findings(summary), None),
        ("Mended in the mesh file", [(text, None) for text in summary.mended or ["nothing"]], None),
        ("Left out", [(text, None) for text in left_out or ["nothing"]], red if left_out else None),
    ]
    line = 0
    for heading, facts, form in blocks:
        sheet.write_string(line, 0, heading, bold)
        for number, (name, value) in enumerate(facts, start=line + 1):
            sheet.write_string(number, 0, name, form)
            _write_cell(sheet, number, 1, value, left)
        line += len(facts) + 2


def _findings(summary: Summary) -> list[tuple[str, Cell]]:
    facts: list[tuple[str, Cell]] = [(f"{each.name} ({each.level})", each.sentence) for each in summary.fitness]
    return facts or [("nothing", None)]


def _mesh_facts(summary: Summary) -> list[tuple[str, Cell]]:
    lengths, heights, leans = summary.edge_lengths_mm, summary.height_shares, summary.lean_shares_deg
    return [
        ("Mesh file", summary.source),
        ("Millimetres a unit of the file", summary.scale_mm),
        ("Zero of the model is at", summary.placed_at),
        ("Vertices", summary.n_vertices),
        ("Edges", summary.n_edges),
        ("Faces", summary.n_faces),
        ("Boundaries", summary.n_boundaries),
        ("Faces out of plane, as read (mean edges)", f"{summary.planarity_before:.1e}"),
        ("Faces out of plane, as built (mean edges)", f"{summary.planarity_after:.1e}"),
        ("Vertices moved to make faces planar, largest (mm)", round(summary.largest_move_mm, 3)),
        ("Vertices moved, mean (mm)", round(summary.mean_move_mm, 3)),
        ("Edge lengths, least to largest (mm)", f"{lengths.min():.1f} to {lengths.max():.1f}"),
        ("Gauss image", summary.gauss_image_origin),
        ("Parts that share a mark differ by less than (mm)", f"{summary.equal_within_mm:.2g}"),
        ("Heights over nominal, least to largest", f"{heights['least']:.4f} to {heights['largest']:.4f}"),
        ("Heights of 95 % of the beams over nominal", f"{heights['p2_5']:.4f} to {heights['p97_5']:.4f}"),
        (
            "Node axes off the normals, median / 95 % / largest (deg)",
            f"{leans['median']:.2f} / {leans['p95']:.2f} / {leans['largest']:.2f}",
        ),
        ("Twist of the beams, largest (deg)", f"{np.abs(summary.twists_deg).max():.1e}"),
        ("Panels lifted over the mesh faces (mm)", round(summary.lift_mm, 3)),
        ("Lift asked for by", summary.lift_reason),
    ]


def _part_facts(lists: CutList) -> list[tuple[str, Cell]]:
    facts: list[tuple[str, Cell]] = []
    for table in lists.tables:
        total = dict(zip(table.columns, table.totals, strict=True))
        facts.append((table.title.capitalize(), total["Count"]))
        facts.append((f"{table.title.capitalize()}, marks", len(table.rows)))
        facts.append((f"{table.title.capitalize()}, mass (kg)", _rounded(total["Mass (kg)"], 1)))
        if "Area (m2)" in total:
            facts.append((f"{table.title.capitalize()}, area (m2)", _rounded(total["Area (m2)"], 2)))
    return facts


def _sheet_facts(nest: Nest | None) -> list[tuple[str, Cell]]:
    if nest is None:
        return [("Panels were not nested", None)]
    return [
        ("Stock (mm)", f"{nest.sheet.length_mm:g} x {nest.sheet.width_mm:g}"),
        ("Sheets used", nest.n_sheets),
        ("Utilisation (%)", round(100 * nest.utilisation, 1)),
        ("Gap between panels (mm)", nest.gap_mm),
        ("Border of a sheet (mm)", nest.border_mm),
        ("Nested by", nest.engine),
    ]


def _rounded(cell: Cell, decimals: int) -> Cell:
    return round(cell, decimals) if isinstance(cell, float) else cell
