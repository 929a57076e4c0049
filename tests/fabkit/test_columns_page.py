"""docs/columns.md explains every column of the cut lists, in their order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fabkit import Project, design
from fabkit.production import cut_list
from geometry.mesh.shapes import dome

PAGE = Path(__file__).parents[2] / "docs" / "columns.md"


@pytest.mark.parametrize("group", ["beams", "nodes", "panels"])
def test_the_page_explains_the_columns_of_the_cut_list(group: str) -> None:
    built = design(Project(mesh=dome(4, 1), mean_edge_mm=1500))
    section = PAGE.read_text(encoding="utf-8").split(f"## {group.capitalize()}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", section, re.MULTILINE)[1:]
    assert tuple(column for column, _ in rows) == cut_list(built.assembly, built.nest)[group].columns
    assert all(meaning for _, meaning in rows)
