"""Real meshes go the whole road: every part made, every check passed, every document written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from fabkit import FabkitError, Project, build, design
from tests.fabkit.plain_bars import PLAIN_TABLES
from tests.real_data.meshes import DATA, needs_data

pytestmark = needs_data

# hexagons with edges of 1.5 m fit on no stock sheet
MEAN_EDGE_MM = {
    "dos/conical1.obj": 1500.0,
    "dos/planarizednormalized_six_quad.obj": 1500.0,
    "libhedra/YasIsland.off": 1500.0,
    "libhedra/gitter.off": 1500.0,
    "libhedra/hexagonalminimal_plusgauss.off": 1000.0,
    "directional/inspired_mesh_quads_Conjugate.off": 1500.0,
}
WELDED_LEFT_OUT = {
    "dos/conical1.obj": 0,
    "dos/planarizednormalized_six_quad.obj": 0,
    "libhedra/hexagonalminimal_plusgauss.off": 0,
    "libhedra/YasIsland.off": 4,
}
"""Beams that cannot be welded by the default rules: their angles at the nodes are too small."""

BOTANIC = DATA / "dos" / "botanic-garden-bubble-0.obj"


@pytest.mark.parametrize("name", MEAN_EDGE_MM)
def test_it_builds_to_the_end(name: str, tmp_path: Path) -> None:
    built = build(Project(mesh=DATA / name, mean_edge_mm=MEAN_EDGE_MM[name], out=tmp_path / "out", **PLAIN_TABLES))
    mesh, assembly = built.structure.mesh, built.assembly
    assert np.degrees(built.structure.twists.max()) < 1e-6
    assert (len(assembly["beams"]), len(assembly["panels"])) == (mesh.n_edges, mesh.n_faces)
    assert len(assembly["nodes"]) == mesh.n_vertices
    assert assembly.left_out == ()
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["planarity"]["after"] < 1e-12
    assert len(list((tmp_path / "out" / "parts").iterdir())) == sum(manifest["counts"]["marks"].values())


@pytest.mark.parametrize("name", WELDED_LEFT_OUT)
def test_by_default_nearly_everything_can_be_welded(name: str) -> None:
    settings = {"mesh": DATA / name, "mean_edge_mm": MEAN_EDGE_MM[name], "nesting": {"mode": "off"}}
    left_out = design(Project(**settings, skip_unbuildable=True)).assembly.left_out
    assert [part.kind for part in left_out] == ["beam"] * WELDED_LEFT_OUT[name]
    assert all("cannot be welded" in part.reason for part in left_out)


@pytest.mark.parametrize(
    ("mean_edge_mm", "cannot", "n_beams", "n_panels"),
    [
        pytest.param(
            1000.0,
            r"beams cannot be built: the beam on edge \d+ from vertex \d+ to vertex \d+ is too short",
            2,
            0,
            id="beams",
        ),
        pytest.param(1500.0, r"panel P\d+ on face \d+ does not fit on a sheet within its borders", 0, 9, id="panels"),
    ],
)
def test_what_cannot_be_built_is_named_or_left_out(
    mean_edge_mm: float, cannot: str, n_beams: int, n_panels: int, tmp_path: Path
) -> None:
    """Small, the roof has short edges between sharp angles; large, it has faces that no sheet can cover."""
    settings = {"mesh": BOTANIC, "mean_edge_mm": mean_edge_mm, "out": tmp_path / "out", **PLAIN_TABLES}
    with pytest.raises(FabkitError, match=cannot):
        design(Project(**settings))
    built = build(Project(**settings, skip_unbuildable=True))
    left = built.assembly.left_out
    assert sum(part.kind == "beam" for part in left) == n_beams
    assert sum(part.kind == "panel" for part in left) == n_panels
    assert len(built.assembly["beams"]) + n_beams == built.structure.mesh.n_edges
    assert len(built.assembly["panels"]) + n_panels == built.structure.mesh.n_faces
    assert np.degrees(built.structure.twists.max()) < 1e-6
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    tables = {kind: (tmp_path / "out" / f"{kind}s.csv").read_text(encoding="utf-8") for kind in ("beam", "panel")}
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    for part in left:
        assert part.reason in report
        assert part.reason in tables[part.kind]
        assert part.reason in [entry["reason"] for entry in manifest["left_out"]]
