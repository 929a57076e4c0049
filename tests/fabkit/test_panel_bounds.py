"""Panels inside their cells, judged from the node axes alone."""

from __future__ import annotations

from dataclasses import replace

import pytest

from fabkit.checking.panel_bounds import panels_crossing_support_planes
from fabkit.detailing.assembling import detail
from fabkit.rules import DetailingRules, LayerRules
from geometry.gauss import Pair, SupportStructure, approximate_pair
from geometry.mesh import shapes


@pytest.fixture(scope="module")
def structure() -> SupportStructure:
    dome = shapes.dome(12, 3)
    mesh = dome * (1500.0 / dome.mean_edge_length)
    return SupportStructure(approximate_pair(mesh), 120.0)


@pytest.mark.parametrize("joint_mm", [0.0, 10.0])
def test_panels_of_a_dome_fill_their_cells_and_no_more(structure: SupportStructure, joint_mm: float) -> None:
    rules = DetailingRules(layers=(LayerRules(joint_mm=joint_mm),))
    panels = detail(structure, rules, name="dome").assembly["panels"]
    assert len(panels_crossing_support_planes(structure, panels)) == 0
    # half a joint to the side, and a little more since support planes are not quite upright, and a panel is outside
    half = joint_mm / 2
    for shift, outside in ((half * 0.98, 0), (half * 1.05 + 0.01, len(panels))):
        moved = replace(panels, origins=panels.origins - shift * panels.axes[:, 1])
        assert len(panels_crossing_support_planes(structure, moved)) == outside


def test_where_cells_narrow_upwards_the_upper_side_counts(structure: SupportStructure) -> None:
    inside_out = SupportStructure(Pair(structure.mesh.reversed(), structure.gauss_image.reversed() * -1), 120.0)
    panels = detail(inside_out, DetailingRules(), name="bowl").assembly["panels"]
    assert len(panels_crossing_support_planes(inside_out, panels)) == 0
    details = replace(panels.details, thickness_mm=panels.details.thickness_mm + 200.0)
    thicker = replace(panels, details=details)
    assert len(panels_crossing_support_planes(inside_out, thicker)) == len(panels)
