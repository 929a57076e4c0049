"""Two files of one combinatorics: mended alike, whatever their formats, or refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import MeshError, MeshFileError
from geometry.files import read_mesh, read_mesh_pair, write_mesh
from geometry.mesh import Mesh, shapes, solids

Faces = list[list[int]]


def write(path: Path, vertices: np.ndarray, faces: Faces) -> Path:
    """OBJ counted from 1 or OFF counted from 0; faces may run as they like."""
    rows = [" ".join(map(repr, row)) for row in vertices.tolist()]
    if path.suffix == ".off":
        lines = ["OFF", f"{len(rows)} {len(faces)} 0", *rows, *(f"{len(f)} {' '.join(map(str, f))}" for f in faces)]
    else:
        lines = [*(f"v {row}" for row in rows), *("f " + " ".join(str(v + 1) for v in face) for face in faces)]
    path.write_text("\n".join(lines) + "\n")
    return path


def split(mesh: Mesh) -> tuple[np.ndarray, Faces]:
    """Every face with vertices of its own, as programs without shared vertices write it."""
    c = mesh.combinatorics
    return mesh.vertices[c.corners], [list(range(a, b)) for a, b in zip(c.face_starts, c.face_starts[1:], strict=False)]


def image_of(mesh: Mesh) -> Mesh:
    """Positions by which each vertex is known again; edges have length."""
    return mesh.with_vertices(mesh.vertices @ np.array([[0.1, 0.2, 0], [0, 0.3, 0.1], [0.1, 0, 0.4]]))


@settings(max_examples=25, deadline=None)
@given(st.randoms(use_true_random=False), st.sampled_from([".obj", ".off"]), st.booleans())
def test_vertices_correspond_whatever_the_faces_of_the_second_look_like(
    tmp_path_factory: pytest.TempPathFactory, random: Random, suffix: str, gaps: bool
) -> None:
    folder = tmp_path_factory.mktemp("pair")
    mesh = shapes.hexagonal_paraboloid(3, 3)
    vertices, faces = split(mesh) if gaps else (mesh.vertices, [face.tolist() for face in mesh.faces])
    images, _ = split(image_of(mesh)) if gaps else (image_of(mesh).vertices, [])
    shuffled = [face[k:] + face[:k] for face in faces for k in [random.randrange(len(face))]]
    shuffled = [face[::-1] if random.random() < 0.5 else face for face in shuffled]
    random.shuffle(shuffled)
    file, image = read_mesh_pair(
        write(folder / "M.obj", vertices, faces), write(folder / f"S{suffix}", images, shuffled)
    )
    alone = read_mesh(folder / "M.obj")
    np.testing.assert_array_equal(file.mesh.vertices, alone.mesh.vertices)
    assert file.mesh.combinatorics.same_as(alone.mesh.combinatorics)
    assert file.mended == alone.mended
    assert image.combinatorics is file.mesh.combinatorics
    np.testing.assert_array_equal(image.vertices, image_of(file.mesh).vertices)


def test_the_second_is_not_judged_and_turns_with_the_first(tmp_path: Path) -> None:
    """An overfolded image with an edge of no length; the first has an unused vertex and faces that run inwards."""
    cube = solids.cube()
    vertices = np.vstack([cube.vertices, [9.0, 9.0, 9.0]])
    faces = [face[::-1] for face in cube.combinatorics.faces]
    images = vertices * [1, 1, -1]
    images[0] = images[faces[0][1]]
    write(tmp_path / "M.obj", vertices, faces)
    write(tmp_path / "S.obj", images, faces)
    file, image = read_mesh_pair(tmp_path / "M.obj", tmp_path / "S.obj")
    assert file.mesh.combinatorics.same_as(cube.combinatorics)
    np.testing.assert_array_equal(image.vertices, images[:-1])
    assert len(file.mended) == 2


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        pytest.param(
            lambda v, f: (v, f[:-1]),
            "first has 16 vertices and 9 faces, the second 16 vertices and 8",
            id="a face less",
        ),
        pytest.param(
            lambda v, f: (v[:-1], [[min(i, 14) for i in g] for g in f[:-1]] + [[0, 1, 2]]),
            "15 vertices",
            id="a vertex less",
        ),
        pytest.param(
            lambda v, f: (v, [[f[0][1], f[0][0], *f[0][2:]], *f[1:]]),
            r"face 1 of the first, with the vertices 1, 5, 6, 2, is not in the second",
            id="corners in another order",
        ),
        pytest.param(
            lambda v, f: (v, [*f[:-1], f[-1][:3]]),
            "face 9 of the first, with the vertices 11, 15, 16, 12",
            id="a triangle",
        ),
        pytest.param(lambda v, f: (np.where(v == v[3], np.nan, v), f), r"S\.obj: .*finite", id="NaN"),
    ],
)
def test_other_faces_are_refused(
    tmp_path: Path, change: Callable[[np.ndarray, Faces], tuple[np.ndarray, Faces]], sentence: str
) -> None:
    mesh = shapes.grid(3, 3)
    write(tmp_path / "M.obj", mesh.vertices, mesh.combinatorics.faces)
    write(tmp_path / "S.obj", *change(mesh.vertices, mesh.combinatorics.faces))
    with pytest.raises(MeshError, match=sentence):
        read_mesh_pair(tmp_path / "M.obj", tmp_path / "S.obj")


def test_vertices_that_become_one_must_be_one_in_both(tmp_path: Path) -> None:
    vertices, faces = split(shapes.grid(2, 1))
    write(tmp_path / "M.obj", vertices, faces)
    images = vertices.copy()
    images[4, 2] += 0.25
    write(tmp_path / "S.obj", images, faces)
    with pytest.raises(MeshError, match=r"vertices \d and 5 coincide .* in the other mesh they are 0\.25 apart"):
        read_mesh_pair(tmp_path / "M.obj", tmp_path / "S.obj")
    with pytest.raises(MeshFileError, match=r"none\.obj: there is no such file"):
        read_mesh_pair(tmp_path / "M.obj", tmp_path / "none.obj")
    write_mesh(tmp_path / "S.ply", shapes.grid(2, 1))  # the same, welded before: numbers no longer correspond
    with pytest.raises(MeshError, match="the first has 8 vertices and 2 faces, the second 6 vertices and 2 faces"):
        read_mesh_pair(tmp_path / "M.obj", tmp_path / "S.ply")
