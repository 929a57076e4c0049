"""What fabrication asks of real meshes: masses, what cannot be joined, lift and tops of nodes, bolts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fabkit import Project, design
from fabkit.built import Built
from fabkit.errors import DetailingError
from tests.real_data.meshes import CONICAL, DATA, SIX_ARMED, YAS, needs_data

pytestmark = needs_data

SEAT_MM = 12.0


def designed(mesh: str, kind: str, section: str = "rhs 120x60x5", **settings: Any) -> Built:
    tables: Any = {"beams": {"section": section}, "connection": {"kind": kind}, "nodes": {"top": "trimmed"}}
    return design(
        Project(mesh=DATA / mesh, mean_edge_mm=1500.0, nesting={"mode": "off"}, **tables, **settings)  # type: ignore[arg-type]
    )


def test_welded_hollow_sections_weigh_a_quarter_of_solid_bars() -> None:
    built = designed(CONICAL, "welded")
    edges = built.structure.mesh.edge_lengths.sum()
    assert built.assembly["beams"].masses_kg.sum() / 1000 == pytest.approx(41.5, rel=0.01)
    assert edges * 50 * 120 * 1e-9 * 7850 / 1000 == pytest.approx(157, rel=0.05)  # not cut back; 151 t cut back
    assert built.assembly.left_out == ()
    assert built.summary.underside_mm == pytest.approx(5 + SEAT_MM, abs=1)


def test_what_cannot_be_welded_is_named_and_trimmed_nodes_lift_no_panel() -> None:
    with pytest.raises(DetailingError, match=r"^4 beams cannot be built: .* at vertex 52.* at vertex 53"):
        designed(YAS, "welded")
    built = designed(YAS, "welded", skip_unbuildable=True)
    assert [(part.kind, part.element) for part in built.assembly.left_out] == [
        ("beam", edge) for edge in (1009, 1010, 1355, 1497)
    ]
    assert built.summary.underside_mm == pytest.approx(26 + SEAT_MM, abs=1)
    assert built.assembly["nodes"].details.uncovered_percent.values.max() <= 21


def test_each_end_is_bolted() -> None:
    built = designed(SIX_ARMED, "bolted")
    counts = {group.kind.group: len(group) for group in built.assembly.groups}
    ends = 2 * built.structure.mesh.n_edges
    assert [counts[name] for name in ("end plates", "bolts", "dowels")] == [ends] * 3
    ends_at = np.bincount(built.assembly["bolts"].details.nodes, minlength=built.structure.mesh.n_vertices)
    assert (ends_at == np.bincount(built.structure.mesh.combinatorics.edges.ravel())).all()


@pytest.mark.parametrize("mesh", [SIX_ARMED, YAS])
def test_tees_stand_on_hubs(mesh: str) -> None:
    built = designed(mesh, "hub", section="tee 120x80x10x8", skip_unbuildable=mesh == YAS)
    assert sorted(part.element for part in built.assembly.left_out) == ([1355, 1497] if mesh == YAS else [])
    assert len(built.assembly["caps"]) == 2 * len(built.assembly["nodes"])
