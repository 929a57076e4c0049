"""Real meshes go the whole road: every part made, every check passed, every document written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from fabkit import FabkitError, Project, build, design

DATA = Path(__file__).parents[2].parent / "shared" / "data"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the folder of real meshes is not beside the project")

MESHES = [
    "dos/conical1.obj",
    "dos/planarizednormalized_six_quad.obj",
    "libhedra/YasIsland.off",
    "libhedra/gitter.off",
    "libhedra/hexagonalminimal_plusgauss.off",
    "directional/inspired_mesh_quads_Conjugate.off",
]
BOTANIC = DATA / "dos" / "botanic-garden-bubble-0.obj"


@pytest.mark.parametrize("name", MESHES)
def test_it_builds_to_the_end(name: str, tmp_path: Path) -> None:
    built = build(Project(mesh=DATA / name, mean_edge_mm=1500.0, out=tmp_path / "out"))
    mesh, assembly = built.structure.mesh, built.assembly
    assert np.degrees(built.structure.twists.max()) < 1e-6
    assert (len(assembly.beams), len(assembly.panels)) == (mesh.n_edges, mesh.n_faces)
    assert len(assembly.nodes) == mesh.n_vertices
    assert assembly.left_out == ()
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["planarity"]["after"] < 1e-12
    assert len(list((tmp_path / "out" / "parts").iterdir())) == sum(manifest["counts"]["marks"].values())


def test_beams_without_room_are_named_or_left_out(tmp_path: Path) -> None:
    settings = {"mesh": BOTANIC, "mean_edge_mm": 1500.0, "out": tmp_path / "out"}
    with pytest.raises(FabkitError, match=r"beams? cannot be built: beam \d+ from node \d+ to node \d+ has no room"):
        design(Project(**settings))
    built = build(Project(**settings, skip_unbuildable=True))
    left = [part for part in built.assembly.left_out if part.kind == "beam"]
    assert 0 < len(left) < 10
    assert len(built.assembly.beams) + len(left) == built.structure.mesh.n_edges
    assert np.degrees(built.structure.twists.max()) < 1e-6
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    table = (tmp_path / "out" / "beams.csv").read_text(encoding="utf-8")
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    for part in left:
        assert part.reason in table
        assert f"beam {part.element} from node" in report
        assert part.reason in [entry["reason"] for entry in manifest["left_out"]]
