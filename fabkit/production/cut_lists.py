"""Cut lists as data: one table for each kind of part, one row for each mark."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fabkit.kinds import PANEL
from fabkit.parts import Assembly, Cell, Column, Parts, Surroundings, texts
from fabkit.production.nesting.nests import Nest

__all__ = ["CutList", "Table", "cut_list", "table_file"]


@dataclass(frozen=True)
class Table:
    """Columns of equally many cells, one at least. title: words in small letters.

    left_out: sentences about the parts that are left out.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import cut_list
    >>> table = cut_list(built.assembly, built.nest)["nodes"]
    >>> table.columns[:3], [row[:3] for row in table.texts]
    (('Mark', 'Count', 'Valence'), [('N001', '6', '3'), ('N002', '6', '4'), ('N003', '6', '3')])
    """

    title: str
    by_column: tuple[Column, ...]
    left_out: tuple[str, ...] = ()

    @property
    def file(self) -> str:
        """The name of its CSV file, as `table_file` gives it."""
        return table_file(self.title)

    @property
    def columns(self) -> tuple[str, ...]:
        """Their names, with units."""
        return tuple(column.title for column in self.by_column)

    @property
    def decimals(self) -> tuple[int | None, ...]:
        return tuple(column.decimals for column in self.by_column)

    @property
    def n_rows(self) -> int:
        return len(self.by_column[0].cells)

    @cached_property
    def rows(self) -> tuple[tuple[Cell, ...], ...]:
        return tuple(zip(*(column.cells for column in self.by_column), strict=True))

    @cached_property
    def texts(self) -> tuple[tuple[str, ...], ...]:
        """The rows as text: numbers with the decimals of their column, an empty text for an empty cell."""
        return tuple(zip(*(column.texts for column in self.by_column), strict=True))

    @property
    def totals(self) -> tuple[Cell, ...]:
        """One cell for each column, None where there is nothing to add up; empty for a table without totals."""
        totals = tuple(column.total for column in self.by_column)
        return totals if any(total is not None for total in totals) else ()

    @property
    def total_texts(self) -> tuple[str, ...]:
        """The totals as text, empty texts for a table without totals."""
        return tuple(texts([column.total], column.decimals)[0] for column in self.by_column)

    def of_single_values(self) -> Table:
        """The table without the columns that have several values in one cell, as files for programs need it."""
        return replace(self, by_column=tuple(column for column in self.by_column if not column.several))


def table_file(title: str) -> str:
    """The name of the CSV file of the table with this title, which may have blanks.

    >>> from fabkit.production import table_file
    >>> table_file("base plates")
    'base_plates.csv'
    """
    return f"{title.replace(' ', '_')}.csv"


@dataclass(frozen=True)
class CutList:
    """One table for each kind of part; together their counts are the number of parts.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import cut_list
    >>> [table.title for table in cut_list(built.assembly, built.nest).tables]
    ['beams', 'nodes', 'panels']
    """

    tables: tuple[Table, ...]

    def __getitem__(self, title: str) -> Table:
        """The table of a group by its name. Raises KeyError where there is none."""
        return {table.title: table for table in self.tables}[title]


def cut_list(assembly: Assembly, nest: Nest | None, *, panel_file: str = "panels/{}.dxf") -> CutList:
    """One table for each group of parts, one row for each mark, in the order of the first parts of the marks.

    Equal parts share a row. Values that depend on the place of a part (its neighbours, its dihedral angles) are then
    given for all of them: a range of numbers, or one text for each place. The files listed are those of the mark: its
    STEP file, and for panels its DXF file, whose path is panel_file with the mark in place of {}.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import cut_list
    >>> beams = cut_list(built.assembly, built.nest)["beams"]
    >>> beams.columns[:4], beams.texts[0][:4]
    (('Mark', 'Count', 'Section', 'Material'), ('B001', '6', 'rhs 120x60x5', 'S355'))
    """
    sheets = {PANEL.group: np.array([place.sheet + 1 for place in nest.placements], dtype=np.int64)} if nest else {}
    around = Surroundings(assembly, sheets, panel_file)
    return CutList(tuple(_table(group, around) for group in assembly.groups))


def _table(parts: Parts[Any], around: Surroundings) -> Table:
    return Table(
        parts.kind.group,
        (*parts.kind.columns(parts, around), *_hidden(parts)),
        tuple(f"left out: {left.reason}" for left in around.assembly.left_out if left.kind == parts.kind.name),
    )


def _hidden(parts: Parts[Any]) -> list[Column]:
    """For each mark, how far at most its pieces differ: in their corners, and at the far ends of the beams on them."""
    largest = np.zeros((len(parts.mark_names), 2))
    np.maximum.at(largest, parts.mark, parts.hidden_mm)
    titles = ["Hidden difference (mm)", "Hidden at far ends (mm)"][: 1 if parts.kind.directions is None else 2]
    return [Column(title, 3, largest[:, k].tolist()) for k, title in enumerate(titles)]
