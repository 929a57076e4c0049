"""Tables as CSV, for programs: one value a cell, in the dialect that the project asks for."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from fabkit.parts import Column
from fabkit.production import Table
from fabkit.rules import TableRules

__all__ = ["spreadsheet_safe", "write_csv"]

_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", re.ASCII)
_POSSIBLE_FORMULA = re.compile(r"[-=+@\t\r\n\uff1d\uff0b\uff0d\uff20]")
_FORMULA_START = re.compile(r"(?:^|(?<=[;\t\n]))(?=[-=+@\t\n\uff1d\uff0b\uff0d\uff20])")


def write_csv(target: Path | TextIO, table: Table, rules: TableRules | None = None) -> None:
    """The rows, the totals, then one row for each part left out, with its sentence in the first column.

    UTF-8 (everything but names is ASCII), lines end in \\n; by default commas, decimal points and no byte order mark. A
    stream gets no such mark. Numbers are as they are; a text that a spreadsheet would take for a formula has an
    apostrophe before it, as `spreadsheet_safe` says.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import write_csv
    >>> from fabkit.production import cut_list
    >>> write_csv(Path("beams.csv"), cut_list(built.assembly, built.nest)["beams"])
    >>> Path("beams.csv").read_text().splitlines()[1][:27]
    'B001,6,rhs 120x60x5,S355,22'
    """
    rules = rules or TableRules()
    lines: list[Sequence[str]] = [_written(Column("", None, table.columns), rules)]
    lines += zip(*(_written(column, rules) for column in table.by_column), strict=True)
    if table.totals:
        totals = (Column("", column.decimals, [column.total]) for column in table.by_column)
        lines += zip(*(_written(column, rules) for column in totals), strict=True)
    missing = _written(Column("", None, table.left_out), rules)
    lines += [[sentence] + [""] * (len(table.columns) - 1) for sentence in missing]
    if isinstance(target, Path):
        with target.open("w", encoding="utf-8-sig" if rules.bom else "utf-8", newline="") as stream:
            csv.writer(stream, delimiter=rules.delimiter, lineterminator="\n").writerows(lines)
    else:
        csv.writer(target, delimiter=rules.delimiter, lineterminator="\n").writerows(lines)


def _written(column: Column, rules: TableRules) -> Sequence[str]:
    """The texts of a column, as they are where no text can be a formula, which is known from all of them at once."""
    texts, has_words = column.texts, str in set(map(type, column.cells))
    if rules.decimal == "." and not (has_words and _POSSIBLE_FORMULA.search(" ".join(texts))):
        return texts
    return [
        spreadsheet_safe(text) if isinstance(cell, str) else text.replace(".", rules.decimal)
        for cell, text in zip(column.cells, texts, strict=True)
    ]


def spreadsheet_safe(cell: str) -> str:
    """The text of a cell, with an apostrophe before what a spreadsheet would run if it began a cell there.

    What begins with = + - @, a tab or a line end is run, also after a semicolon, tab or line end, at which spreadsheets
    of other countries part cells [OWASP, CSV Injection]. Numbers are no formulas.
    """
    if not _POSSIBLE_FORMULA.search(cell) or _NUMBER.fullmatch(cell):
        return cell
    lines = cell.replace("\r\n", "\n").replace("\r", "\n")  # of which csv.writer quotes no \r
    return _FORMULA_START.sub("'", lines)
