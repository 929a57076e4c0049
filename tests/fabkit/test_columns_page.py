"""docs/columns.md explains every column of the cut lists, in their order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fabkit import Project, design
from fabkit.production import cut_list, mark_table, piece_tables
from geometry.mesh.shapes import dome

PAGE = Path(__file__).parents[2] / "docs" / "columns.md"


TITLES = ["beams", "nodes", "panels", "pieces", "placements", "survey", "node_facets", "panel_edges", "mark_points"]


@pytest.mark.parametrize("title", TITLES)
def test_the_page_explains_the_columns_of_the_tables(title: str) -> None:
    built = design(Project(mesh=dome(4, 1), mean_edge_mm=1500))
    tables = [*cut_list(built.assembly, built.nest).tables, *piece_tables(built.assembly, built.nest)]
    tables.append(mark_table(built.assembly, {}))
    assert [table.title for table in tables] == TITLES
    (table,) = (table for table in tables if table.title == title)
    heading = title.capitalize().replace("_", " ")
    section = PAGE.read_text(encoding="utf-8").split(f"## {heading}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", section, re.MULTILINE)[1:]
    assert tuple(column for column, _ in rows) == table.columns
    assert {column for column, meaning in rows if meaning.startswith("*report*")} == {
        column.title for column in table.by_column if column.several
    }
    assert all(meaning for _, meaning in rows)
