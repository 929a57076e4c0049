"""The page of `fabkit diff`: which pieces are new, gone or changed, in colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from fabkit.formats.report.html_page import html_page, key_facts, model_html, part_of_page
from fabkit.formats.report.tables import cells_data, table_html
from fabkit.production import Table

__all__ = ["ShownModel", "differences_html"]

COLOURS = {"same": (196, 203, 209), "changed": (224, 130, 20), "new": (42, 157, 92), "gone": (206, 42, 42)}
"""Colours of pieces by what became of them: sRGB, 0 to 255."""


@dataclass(frozen=True)
class ShownModel:
    """A model as a report has it. names: of its pieces. head and arrays: of `model_data`. middle_mm: of the model, at
    the coordinates of the mesh file.

    >>> from fabkit.formats.report import ShownModel
    >>> sorted(ShownModel(("B001 e0",), {}, "", (0.0, 0.0, 0.0)).data)
    ['arrays', 'middle_mm', 'model', 'names']
    """

    names: Sequence[str]
    head: dict[str, Any]
    arrays: str
    middle_mm: Sequence[float]

    @property
    def data(self) -> dict[str, Any]:
        return {"names": self.names, "model": self.head, "arrays": self.arrays, "middle_mm": self.middle_mm}


def differences_html(title: str, table: Table, earlier: ShownModel, later: ShownModel) -> str:
    """The text of the page. table: of `folder_differences`. It asks the network for nothing.

    >>> from fabkit.formats.report import ShownModel, differences_html
    >>> from fabkit.parts import Column
    >>> from fabkit.production import Table
    >>> table = Table("differences", (Column("Change", None, ["new"]), Column("Piece now", None, ["B001 e0"])))
    >>> model = ShownModel(("B001 e0",), {}, "", (0.0, 0.0, 0.0))
    >>> "<dt>New</dt><dd>1</dd>" in differences_html("Changes from a to b", table, model, model)
    True
    """
    changes = table.by_column[0].texts
    counts = {name: changes.count(name) for name in ("new", "gone", "changed")}
    counts["same"] = len(later.names) - counts["new"] - counts["changed"]
    body = part_of_page(
        "differences.html",
        title=escape(title),
        key_facts=key_facts((name.capitalize(), str(count), "") for name, count in counts.items()),
        model=model_html(COLOURS, find="Find a piece"),
        table=table_html(table),
    )
    return html_page(
        title,
        body,
        colours={name: f"rgb{colour}" for name, colour in COLOURS.items()},
        scripts=("differences.js",),
        data={"table": cells_data(table), "colours": COLOURS, "earlier": earlier.data, "later": later.data},
    )
