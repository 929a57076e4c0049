"""Columns of tables: their cells, and the same as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

__all__ = ["Cell", "Column", "texts"]

Cell = str | int | float | None


@dataclass(frozen=True)
class Column:
    """A column of a table: one cell for each row, which is a mark in a cut list.

    decimals: number of decimals shown, None for text. total: the cell below the column, None for an empty one. several:
    whether a cell has several values in one text; such columns are for the report alone, since no program reads them.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.parts import Surroundings
    >>> beams = built.assembly["beams"]
    >>> column = beams.kind.columns(beams, Surroundings(built.assembly))[1]
    >>> column.title, column.cells, column.total
    ('Count', [6, 6, 6, 6, 6], 30)
    """

    title: str
    decimals: int | None
    cells: Sequence[Cell]
    total: Cell = None
    several: bool = False

    @cached_property
    def texts(self) -> list[str]:
        """The cells as text: numbers with the decimals of the column, an empty text for an empty cell."""
        return texts(self.cells, self.decimals)


def texts(cells: Sequence[Cell], decimals: int | None) -> list[str]:
    """Each cell as text, numbers with this many decimals; a number that rounds to zero has no sign.

    >>> from fabkit.parts import texts
    >>> texts([1.26, None, -0.04, "1 to 2"], 1)
    ['1.3', '', '0.0', '1 to 2']
    """
    types = set(map(type, cells))
    if types <= {str}:
        return [*map(str, cells)]
    if decimals is None:
        return ["" if cell is None else str(cell) for cell in cells]
    form, zero = f"%.{decimals}f", f"{0:.{decimals}f}"
    if types <= {int, float}:
        return (f"{form} " * len(cells) % tuple(cells)).replace(f"-{zero} ", f"{zero} ").split()
    found = [cell if isinstance(cell, str) else "" if cell is None else form % cell for cell in cells]
    return [zero if text == "-" + zero else text for text in found]
