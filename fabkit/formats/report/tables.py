"""Tables of the report."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from fabkit.production import Table

__all__ = ["cells_data", "table_html"]

_MAX_COLUMN_LETTERS = 34
"""Largest width of a column of the report, in letters."""


def table_html(table: Table) -> str:
    """A table with its heading and a filter, without its rows, which the page makes of `cells_data`.

    Above the rows stands in red what was left out, below them the totals.
    """
    title, identifier = escape(table.title.capitalize()), f"table-{escape(table.title)}"
    classes = [f' class="{each}"' if each else "" for each in _classes(table)]
    heads = "".join(
        f'<th scope="col"{kind}><button type="button">{escape(name)}</button></th>'
        for name, kind in zip(table.columns, classes, strict=True)
    )
    widths = "".join(f'<col style="width: {width:.1f}ch">' for width in _widths(table))
    foot = _row([escape(text) for text in table.total_texts], classes) if table.totals else ""
    missing = "".join(f"<li>{escape(sentence)}</li>" for sentence in table.left_out)
    noun = "mark" if table.columns[0] == "Mark" else "row"
    count = f"{table.n_rows} {noun}{'' if table.n_rows == 1 else 's'}"
    return (
        f'<div class="table-head"><h3>{title} <span class="unit">{count}</span></h3>'
        f'<input type="search" data-table="{identifier}" placeholder="Filter" aria-label="Filter {title}"></div>\n'
        + (f'<ul class="missing">{missing}</ul>\n' if missing else "")
        + f'<div class="table" id="{identifier}" data-table="{escape(table.title)}" tabindex="0">'
        f"<table><colgroup>{widths}</colgroup><thead><tr>{heads}</tr></thead>\n<tbody></tbody>\n"
        f"<tfoot>{foot}</tfoot></table></div><p class='printed-rows'></p>"
    )


def cells_data(table: Table) -> dict[str, object]:
    """The texts of a table by columns, for the page's scripts."""
    cells = [column.texts for column in table.by_column]
    return {"columns": table.columns, "classes": _classes(table), "cells": cells}


def _classes(table: Table) -> list[str]:
    """Of each column in the style sheet; what has several values, files and empty columns are not printed."""
    apart = [column.several or column.title == "File" or not any(column.texts) for column in table.by_column]
    return [
        ("text" if decimals is None else "") + (" wide" if hidden else "")
        for decimals, hidden in zip(table.decimals, apart, strict=True)
    ]


def _widths(table: Table) -> list[float]:
    """Width of each column in digits: its longest text, up to a limit; headings may run over two or three lines."""
    totals = zip(table.by_column, table.total_texts, strict=True)
    longest = [max(map(len, [*column.texts, total])) for column, total in totals]
    words = [max(map(len, name.split())) for name in table.columns]
    return [max(min(text, _MAX_COLUMN_LETTERS), 1.2 * word) + 2.5 for text, word in zip(longest, words, strict=True)]


def _row(cells: Sequence[str], classes: Sequence[str]) -> str:
    return "<tr>" + "".join(f"<td{kind}>{cell}</td>" for kind, cell in zip(classes, cells, strict=True)) + "</tr>"
