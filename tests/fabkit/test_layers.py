"""Panels in several layers: what tells them apart in names, tables, drawings and nests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fabkit import Built, Project, design
from fabkit.checking import violations
from fabkit.kinds import PANEL, neighbour_names
from fabkit.parts import Assembly, Frame, Parts
from fabkit.production import panel_drawings, piece_tables, share_equal_parts
from geometry.mesh.shapes import dome

SIZES = {"layers": [{"thickness_mm": 10, "joint_mm": 10}]}


@pytest.fixture(scope="module")
def built() -> Built:
    return design(Project(mesh=dome(4, 1), mean_edge_mm=1500, **SIZES))


@pytest.fixture(scope="module")
def doubled(built: Built) -> Assembly:
    """The assembly with each panel once more, 50 mm higher, as layer 1; but for the first one."""
    panels = list(built.assembly["panels"])
    again = [
        replace(
            part,
            mark=f"{part.mark}a",
            placement=Frame(part.placement.origin + 50 * part.placement.axes[2], part.placement.axes),
            details=replace(part.details, layer=np.int64(1)),
        )
        for part in panels[1:]
    ]
    return built.assembly.with_group(Parts.of(PANEL, [*panels, *again]))


def test_each_panel_has_the_neighbours_of_its_own_layer(doubled: Assembly) -> None:
    panels, n = doubled["panels"], len(doubled["panels"])
    names = neighbour_names(panels, [str(k) for k in range(n)], "left out", "-")
    row, across, layer = panels.details.neighbours.row, panels.details.neighbours.values, panels.details.layer
    assert {"left out"} == {name for k, name in enumerate(names) if layer[row[k]] == 1 and across[k] == 0}
    for k, name in enumerate(names):
        if name.isdigit():
            assert panels.elements[int(name)] == across[k]
            assert layer[int(name)] == layer[row[k]]


def test_equal_panels_of_two_layers_are_one_mark_with_names_of_their_own(doubled: Assembly) -> None:
    shared = share_equal_parts(doubled)
    panels = shared["panels"]
    assert len(set(panels.piece_names)) == len(panels) == 7
    assert "P001 f1.2" in panels.piece_names
    assert [drawing.name for drawing in panel_drawings(shared)] == list(panels.mark_names)
    edges = next(table for table in piece_tables(shared, None) if table.title == "panel_edges")
    own = {row[0]: row[-1] for row in edges.rows if row[-1]}
    assert own["P001 f2.2"].endswith(".2")
    assert not own["P001 f2"].endswith(".2")


def test_a_panel_that_a_layer_has_twice_is_named(doubled: Assembly) -> None:
    panels = doubled["panels"]
    twice = replace(panels, details=replace(panels.details, layer=np.zeros(len(panels), dtype=np.int64)))
    assert [each.finding for each in violations(doubled)] == []
    assert {each.finding for each in violations(doubled.with_group(twice))} == {
        f"face {face} has 2 panels, allowed 1" for face in (1, 2, 3)
    }
