"""Every real mesh reads: sizes and planarity as listed beside the files, and what had to be mended."""

from __future__ import annotations

from time import perf_counter

import numpy as np
import pytest

from geometry.files import check_faces, read_mesh
from tests.real_data.meshes import DATA, needs_data

pytestmark = needs_data

BASE_1 = ("face indices started at 1; counted from 0",)
WELDED = ("6500 of 9900 vertices welded to others at most 4.8e-05 of the mean edge length away (tolerance 1e-04)",)

# name, vertices, faces, planarity, boundary loops, Euler characteristic, mended
FILES = [
    ("dos/conical1.obj", 1147, 1080, 3.0e-5, 1, 1, ()),
    ("dos/planarizednormalized_six_quad.obj", 720, 656, 4.7e-5, 2, 0, ()),
    ("dos/botanic-garden-bubble-0.obj", 1121, 1076, 8.6e-3, 1, 1, ()),
    ("libhedra/YasIsland.off", 1085, 976, 1.1e-3, 3, -1, ()),
    ("libhedra/gitter.off", 1341, 1216, 3.9e-5, 5, -3, ()),
    ("libhedra/hexagonalminimal_plusgauss.off", 400, 180, 4.3e-11, 2, 0, BASE_1),
    ("libhedra/catenoid3.off", 3400, 1650, 4.9e-5, 2, 0, WELDED),
    ("libhedra/circular_wo_boundary.off", 1427, 1266, 7.5e-3, 2, 0, BASE_1),
    ("directional/inspired_mesh_quads_Conjugate.off", 1749, 1633, 9.9e-3, 1, 1, ()),
    ("directional/train-station.off", 1753, 3330, 0.0, 2, 0, ()),
    ("directional/botanic-garden-bubble.off", 1121, 2152, 0.0, 1, 1, ()),
    ("directional/dome.off", 5000, 9635, 0.0, 1, 1, ()),
]


@pytest.mark.parametrize(
    ("name", "n_vertices", "n_faces", "planarity", "n_loops", "chi", "mended"), FILES, ids=[row[0] for row in FILES]
)
def test_reading(
    name: str, n_vertices: int, n_faces: int, planarity: float, n_loops: int, chi: int, mended: tuple[str, ...]
) -> None:
    found = read_mesh(DATA / name)
    mesh = found.mesh
    assert (mesh.n_vertices, mesh.n_faces) == (n_vertices, n_faces)
    # given with two digits; triangles are planar up to rounding
    assert mesh.planarity.max() == pytest.approx(planarity, rel=0.05, abs=1e-13)
    assert len(mesh.combinatorics.boundary_loops) == n_loops
    assert mesh.combinatorics.euler_characteristic == chi
    assert mesh.combinatorics.face_components.max() == 0
    assert found.mended == mended
    check_faces(mesh)


def test_every_mesh_file_is_in_the_list() -> None:
    present = {path.relative_to(DATA).as_posix() for path in DATA.rglob("*") if path.suffix in (".obj", ".off", ".ply")}
    assert present == {row[0] for row in FILES}


def test_reading_is_quick() -> None:
    """10 ms on an idle machine; the bound leaves room for a busy one."""
    times = []
    for _ in range(3):
        start = perf_counter()
        read_mesh(DATA / "dos" / "conical1.obj")
        times.append(perf_counter() - start)
    assert min(times) < 0.1


def test_edges_of_the_koebe_polyhedron_touch_the_unit_sphere() -> None:
    mesh = read_mesh(DATA / "libhedra" / "hexagonalminimal_plusgauss.off").mesh
    tails = mesh.vertices[mesh.combinatorics.edges[:, 0]]
    distances = np.linalg.norm(np.cross(tails, mesh.edge_vectors), axis=1) / mesh.edge_lengths
    np.testing.assert_allclose(distances, 1, rtol=0, atol=4e-11)  # listed as 1 +- 3e-11
