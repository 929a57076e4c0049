"""Meshes of trimesh, compas and meshio become meshes and come back, in their order, to the last bit."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from geometry import GeometryError, Mesh, MeshError, as_mesh, to_compas, to_meshio, to_trimesh
from geometry.mesh import shapes, solids
from geometry.mesh.triangulation import triangulated

MIXED = solids.rhombicosidodecahedron()  # 20 triangles, 30 squares, 12 pentagons
L_SHAPE = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0], [0, 1, 0]]  # the last corner is straight


def uneven(mesh: Mesh) -> Mesh:
    """With coordinates that use all their bits."""
    return mesh.with_vertices(mesh.vertices * np.pi + 1e3 / 3)


def same(one: Mesh, other: Mesh) -> bool:
    return one.combinatorics.same_as(other.combinatorics) and np.array_equal(one.vertices, other.vertices)


def test_triangles_come_back_from_trimesh_as_they_were() -> None:
    pytest.importorskip("trimesh")
    mesh = uneven(solids.icosahedron())
    assert same(as_mesh(to_trimesh(mesh)), mesh)


def test_larger_faces_become_triangles_of_trimesh_that_know_their_face() -> None:
    pytest.importorskip("trimesh")
    mesh = uneven(MIXED)
    found = to_trimesh(mesh)
    np.testing.assert_array_equal(found.vertices, mesh.vertices)
    faces = found.metadata["face"]
    assert np.bincount(faces).tolist() == (mesh.combinatorics.face_sizes - 2).tolist()
    for triangle, face in zip(found.faces, faces, strict=True):
        assert set(triangle) <= set(mesh.faces[face])
    assert found.is_watertight
    assert found.is_winding_consistent
    areas = np.bincount(faces, found.area_faces)
    np.testing.assert_allclose(areas, np.linalg.norm(mesh.vector_areas, axis=1), rtol=1e-12)  # of coordinates near 300
    assert found.volume > 0


@pytest.mark.parametrize("shift", range(len(L_SHAPE)))
def test_faces_that_are_not_convex_are_covered_once(shift: int) -> None:
    """Wherever the face begins: fans would leave it."""
    mesh = Mesh.from_faces(np.roll(L_SHAPE, shift, axis=0), [range(7), [0, 7, 1]][:1])
    triangles, faces = triangulated(mesh)
    cut = Mesh.from_faces(mesh.vertices, triangles)
    assert faces.tolist() == [0] * 5
    assert cut.vector_areas[:, 2].min() > 0
    np.testing.assert_allclose(cut.vector_areas[:, 2].sum(), 3, rtol=1e-12)


def test_convex_faces_and_others_keep_their_order() -> None:
    points = [*L_SHAPE, [3, 0, 0], [3, 1, 0]]
    mesh = Mesh.from_faces(points, [[1, 7, 8, 2], range(7)])
    triangles, faces = triangulated(mesh)
    assert faces.tolist() == [0, 0, 1, 1, 1, 1, 1]
    assert triangles[:2].tolist() == [[1, 7, 8], [1, 8, 2]]


def test_an_outline_that_crosses_itself_is_named() -> None:
    bow = [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1.5, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0]]
    with pytest.raises(
        MeshError, match="face 1 cannot be cut into triangles, since its outline crosses itself"
    ) as error:
        triangulated(Mesh.from_faces(bow, [[4, 5, 6], [0, 1, 2, 3]]))
    assert error.value.elements == (1,)


def test_meshes_come_back_from_compas_as_they_were() -> None:
    pytest.importorskip("compas")
    mesh = uneven(MIXED)
    assert same(as_mesh(to_compas(mesh)), mesh)


def test_vertices_of_compas_are_numbered_anew_in_their_order() -> None:
    structures = pytest.importorskip("compas.datastructures")
    theirs = structures.Mesh.from_vertices_and_faces(
        [[0, 0, 0], [9, 9, 9], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 2, 3, 4]]
    )
    theirs.delete_vertex(1)
    mesh = as_mesh(theirs)
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2, 3]]


def test_meshes_come_back_from_meshio_with_their_faces_by_size() -> None:
    pytest.importorskip("meshio")
    mesh = uneven(MIXED)
    theirs = to_meshio(mesh)
    assert [(block.type, len(block.data)) for block in theirs.cells] == [
        ("triangle", 20),
        ("quad", 30),
        ("polygon", 12),
    ]
    back, order = as_mesh(theirs), np.concatenate(theirs.cell_data["face"])
    np.testing.assert_array_equal(back.vertices, mesh.vertices)
    assert [face.tolist() for face in back.faces] == [mesh.faces[face].tolist() for face in order]


def test_volumes_of_meshio_are_refused_and_lines_left_out() -> None:
    meshio = pytest.importorskip("meshio")
    points = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    beside = meshio.Mesh(points, [("line", [[0, 1]]), ("triangle", [[0, 1, 2]])])
    assert as_mesh(beside).n_faces == 1
    with pytest.raises(
        MeshError, match="the mesh has cells of type tetra: faces are of type triangle, quad and polygon"
    ):
        as_mesh(meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])]))


@pytest.mark.parametrize(("name", "convert"), [("trimesh", to_trimesh), ("compas", to_compas), ("meshio", to_meshio)])
def test_a_library_that_is_not_installed_is_named(name: str, convert: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, f"{name}.datastructures", None)
    with pytest.raises(GeometryError, match=f"{name} is not installed: install it by pip install {name}"):
        convert(shapes.grid(1, 1))  # type: ignore[operator]
