"""Real meshes are recognised for what their authors say they are."""

from __future__ import annotations

import pytest

from fabkit.commands.inspection import inspect_mesh
from tests.real_data.meshes import DATA, needs_data

pytestmark = needs_data


@pytest.mark.parametrize(
    ("name", "circular", "conical", "edge_offset"),
    [
        ("dos/conical1.obj", "no", "nearly", "no"),
        ("libhedra/hexagonalminimal_plusgauss.off", "no", "yes", "yes"),
        ("libhedra/catenoid3.off", "no", "yes", "nearly"),
        ("libhedra/YasIsland.off", "no", "no", "no"),
    ],
)
def test_offsets_are_recognised(name: str, circular: str, conical: str, edge_offset: str) -> None:
    facts = dict(inspect_mesh(DATA / name).facts())
    assert facts["circular"].split(":")[0] == circular
    assert facts["conical"].split(":")[0] == conical
    assert facts["edge offset"].split(":")[0] == edge_offset


def test_a_triangle_mesh_is_reported_as_unfit() -> None:
    facts = dict(inspect_mesh(DATA / "directional" / "dome.off").facts())
    assert "only scaled copies" in facts["unfit"]
    assert "beam heights" not in facts


def test_what_was_mended_is_reported() -> None:
    facts = list(inspect_mesh(DATA / "libhedra" / "catenoid3.off").facts())
    assert any(name == "mended" and "6500 of 9900 vertices" in fact for name, fact in facts)
