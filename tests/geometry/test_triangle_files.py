"""STL, GLB and glTF files, made by trimesh: the same surface comes back, and what is damaged is one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from geometry.errors import MeshFileError
from geometry.files import read_mesh
from geometry.mesh import Mesh
from tests.geometry.design_surfaces import sphere_cap


def cap() -> Mesh:
    return sphere_cap(8).triangulated


def as_trimesh(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.combinatorics.corners.reshape(-1, 3), process=False)


def corners(mesh: Mesh) -> set[tuple[tuple[float, ...], ...]]:
    """The triangles as places, from their least one on, to the digits of single precision."""
    triangles = mesh.vertices[mesh.combinatorics.corners.reshape(-1, 3)].round(5) + 0.0
    rings = [[tuple(point) for point in triangle.tolist()] for triangle in triangles]
    return {tuple(ring[ring.index(min(ring)) :] + ring[: ring.index(min(ring))]) for ring in rings}


@pytest.mark.parametrize("suffix", ["stl", "glb", "gltf", "ply"])
def test_the_same_surface_comes_back(tmp_path: Path, suffix: str) -> None:
    given = as_trimesh(cap())
    if suffix in ("glb", "gltf"):  # whose +Y is upwards
        given.vertices = given.vertices[:, [0, 2, 1]] * [1, 1, -1]
    given.export(tmp_path / f"cap.{suffix}")
    file = read_mesh(tmp_path / f"cap.{suffix}")
    assert file.mesh.n_vertices == cap().n_vertices
    assert corners(file.mesh) == corners(cap())
    assert ("turned from +Y upwards" in " ".join(file.mended)) == (suffix in ("glb", "gltf"))


def test_pieces_stand_where_the_scene_has_them(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(as_trimesh(cap()))
    scene.add_geometry(as_trimesh(cap()), transform=trimesh.transformations.translation_matrix([10, 0, 0]))
    scene.export(tmp_path / "two.glb")
    mesh = read_mesh(tmp_path / "two.glb").mesh
    assert mesh.n_vertices == 2 * cap().n_vertices
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(12, abs=1e-5)


@pytest.mark.parametrize("suffix", ["stl", "glb", "gltf"])
@pytest.mark.parametrize("data", [b"solid x\nfacet", b"\x00" * 100, b"glTF\x02\x00\x00\x00", b"{}", b"\xff"])
def test_damaged_files_are_one_sentence(tmp_path: Path, suffix: str, data: bytes) -> None:
    path = tmp_path / f"bad.{suffix}"
    path.write_bytes(data)
    with pytest.raises(MeshFileError, match=r"export (it again|the surface as a mesh)"):
        read_mesh(path)
    (tmp_path / f"empty.{suffix}").write_bytes(b" ")
    with pytest.raises(MeshFileError, match="the file is empty"):
        read_mesh(tmp_path / f"empty.{suffix}")
