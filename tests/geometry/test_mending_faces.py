"""Corners, faces and pieces that are written too often: mended and reported, or all contradictions named at once."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.files import mend, read_mesh_pair
from geometry.files.clusters import clusters_within
from geometry.files.face_checks import COINCIDENCE_TOLERANCE, check_duplicates
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import Mesh, shapes

Faces = list[list[int]]

MESHES = [shapes.cube(), shapes.dodecahedron(), shapes.grid(3, 3), shapes.dome(7, 3), shapes.regular_prism(5)]
meshes = st.sampled_from(MESHES)
seeds = st.integers(0, 2**32 - 1)


def refused(vertices: object, faces: Faces) -> MeshError:
    with pytest.raises(MeshError) as caught:
        mend(vertices, faces)
    assert "\n" not in caught.value.message
    return caught.value


def assert_mended_to(mesh: Mesh, vertices: object, faces: Faces) -> tuple[str, ...]:
    """The mesh itself, to the last bit."""
    found, said = mend(vertices, faces)
    np.testing.assert_array_equal(found.vertices, mesh.vertices)
    assert found.combinatorics.same_as(mesh.combinatorics)
    return said


# --- corners


@given(meshes, seeds)
def test_corners_named_several_times_in_a_row_count_once(mesh: Mesh, seed: int) -> None:
    rng = np.random.default_rng(seed)
    faces, doubled = [], []
    for number, face in enumerate(mesh.combinatorics.faces):
        counts = rng.integers(1, 4, len(face)) if rng.random() < 0.5 else np.ones(len(face), dtype=int)
        faces.append(np.repeat(face, counts).tolist())
        doubled += [number] if counts.max() > 1 else []
    said = assert_mended_to(mesh, mesh.vertices, faces)
    assert len(said) == bool(doubled)
    if doubled:
        assert said[0].startswith(f"{len(doubled)} of {mesh.n_faces} faces named a vertex twice in a row")
        assert f"face{'s' * (len(doubled) > 1)} {doubled[0]}" in said[0]


@given(meshes, seeds, st.floats(0, 0.4))
def test_corners_of_their_own_at_one_place_count_once(mesh: Mesh, seed: int, share: float) -> None:
    """An edge has a second vertex at one end, in one of its faces, or in both."""
    rng = np.random.default_rng(seed)
    shortest = COINCIDENCE_TOLERANCE * float(mesh.edge_lengths.min())
    edge = int(rng.integers(mesh.n_edges))
    tail, head = mesh.combinatorics.edges[edge].tolist()
    step = rng.normal(size=3)
    extra = mesh.vertices[tail] + step / np.linalg.norm(step) * share * shortest
    faces = []
    for face in mesh.combinatorics.faces:
        for before, after, between in ((tail, head, [tail, mesh.n_vertices]), (head, tail, [head, mesh.n_vertices])):
            place = next((k for k in range(len(face)) if [face[k], face[(k + 1) % len(face)]] == [before, after]), None)
            if place is not None:
                face = [*face[:place], *between, *face[place + 1 :]]
        faces.append(face)
    said = assert_mended_to(mesh, [*mesh.vertices, extra], faces)
    assert said[0].startswith(f"1 of {mesh.n_vertices + 1} vertices welded to others")
    assert "faces had corners at one place, where once is enough" in said[1]


def test_an_edge_without_length_between_two_faces_is_closed() -> None:
    """In a row of quads: two triangles are left there."""
    mesh = shapes.grid(3, 1)
    vertices = mesh.vertices.copy()
    (first, second), *_ = mesh.combinatorics.edges[~mesh.combinatorics.is_boundary_edge].tolist()
    vertices[second] = vertices[first]
    found, said = mend(vertices, mesh.combinatorics.faces)
    assert sorted(found.combinatorics.face_sizes.tolist()) == [3, 3, 4]
    assert len(said) == 2


def test_a_chain_of_short_edges_is_no_copy_of_a_vertex() -> None:
    """A tenth of the side of a square in steps below the tolerance: each is short, all of them are not."""
    steps = np.linspace(0, 0.1, 1501)  # a step is 2/3 of the tolerance
    side = np.stack([steps, np.zeros_like(steps), np.zeros_like(steps)], axis=1)
    grid = shapes.grid(100, 100).translated([0, 400.0, 0])  # so that the mean edge is one of the large ones
    n = len(side) + 3
    vertices = np.concatenate([side, [[1, 0, 0], [1, 1, 0], [0, 1, 0]], grid.vertices])
    faces = [list(range(n)), *[[v + n for v in face] for face in grid.combinatorics.faces]]
    error = refused(vertices, faces)
    assert "but joined by steps of at most" in error.message
    assert len(error.elements) > 1_000


@pytest.mark.parametrize("face", [[0, 1, 2, 3, 1], [0, 1, 0, 2, 3], [3, 0, 1, 2, 1]])
def test_a_vertex_twice_but_not_in_a_row_is_refused_and_all_such_faces_are_named(face: list[int]) -> None:
    square = shapes.grid(1, 1).vertices
    vertices = np.concatenate([square + np.array([3 * k, 0, 0]) for k in range(13)])
    faces = [[v + 4 * k for v in face] for k in range(13)]
    faces[5] = [20, 21, 23, 22]
    error = refused(vertices, faces)
    assert error.message.startswith("face 0 touches itself")
    assert "; likewise faces 1, 2, 3, 4, 6, 7, 8, 9, 10, 11 and 1 more" in error.message
    assert error.elements == (0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12)


# --- faces


@given(meshes, seeds)
def test_faces_with_fewer_than_three_corners_are_dropped(mesh: Mesh, seed: int) -> None:
    """And numbers in sentences are still those of the file."""
    rng = np.random.default_rng(seed)
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    thin = [[], [0], [1, 2], [3, 3, 3], [2, 1, 2]]
    added = sorted(rng.integers(0, len(faces) + 1, 3).tolist(), reverse=True)
    for place in added:
        faces.insert(place, thin[rng.integers(len(thin))])
    said = assert_mended_to(mesh, mesh.vertices, faces)
    assert any(sentence.startswith(f"3 of {len(faces)} faces had fewer than three corners") for sentence in said)
    numbers = [number for number, face in enumerate(faces) if len(set(face)) < 3]
    assert any(
        sentence.endswith(
            f"dropped: faces {numbers[0]}, {numbers[1]} and {numbers[2]} (vertices and faces counted from 0)"
        )
        for sentence in said
    )
    crossed = shapes.grid(1, 1).combinatorics.faces[0]
    crossed = [mesh.n_vertices + v for v in (crossed[0], crossed[2], crossed[1], crossed[3])]
    error = refused(np.concatenate([mesh.vertices, shapes.grid(1, 1).vertices + 50]), [*faces, crossed])
    assert error.message.startswith(f"face {len(faces)} crosses itself")
    assert error.elements == (len(faces),)


@given(meshes, seeds)
def test_faces_written_again_are_dropped_whichever_way_they_run(mesh: Mesh, seed: int) -> None:
    rng = np.random.default_rng(seed)
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    again = rng.integers(0, len(faces), int(rng.integers(1, 2 * len(faces)))).tolist()
    for face in again:
        k = int(rng.integers(len(faces[face])))
        ring = faces[face][k:] + faces[face][:k]
        faces.append(ring[::-1] if rng.random() < 0.5 else ring)
    said = assert_mended_to(mesh, mesh.vertices, faces)
    assert len(said) == 1
    assert said[0].startswith(f"{len(again)} of {len(faces)} faces were written before; dropped: face")


@given(meshes, seeds)
def test_a_mesh_written_twice_with_vertices_of_its_own_counts_once(mesh: Mesh, seed: int) -> None:
    shift = np.random.default_rng(seed).uniform(-0.3, 0.3, mesh.vertices.shape)
    shift *= COINCIDENCE_TOLERANCE * float(mesh.edge_lengths.min())
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    twice = [*faces, *[[v + mesh.n_vertices for v in face[::-1]] for face in faces]]
    said = assert_mended_to(mesh, np.concatenate([mesh.vertices, mesh.vertices + shift]), twice)
    assert said[0].startswith(f"{mesh.n_faces} of {2 * mesh.n_faces} faces were written before; dropped: faces ")
    assert said[1] == f"{mesh.n_vertices} of {2 * mesh.n_vertices} vertices belonged to no face; removed"


def test_boxes_side_by_side_keep_the_walls_that_they_share() -> None:
    cube = shapes.cube()
    width = float(np.ptp(cube.vertices[:, 0]))
    faces = [face.tolist() for face in cube.combinatorics.faces]
    vertices = np.concatenate([cube.vertices, cube.vertices + np.array([width, 0, 0])])
    found, said = mend(vertices, faces + [[v + 8 for v in face] for face in faces])
    assert (found.n_faces, said) == (12, ())


@pytest.mark.parametrize("index", [0.5, np.nan, np.inf, 2 + 1e-9])
def test_indices_that_are_not_whole_are_no_vertices(index: float) -> None:
    square = shapes.grid(1, 1).vertices
    for make in (mend, Mesh.from_faces):
        with pytest.raises(MeshError, match=r"face 1 names vertex .*: vertices have whole numbers") as caught:
            make(square, [[0, 2, 3], [0, 1, index]])
        assert caught.value.elements == (1,)
    assert mend(square, [np.array([0.0, 2.0, 3.0])])[0].n_faces == 1


# --- what contradicts


def triangulated(face: list[int], rng: np.random.Generator) -> Faces:
    """Cut along diagonals, at random; the face is convex."""
    if len(face) == 3:
        return [face]
    i, j = sorted(rng.choice(len(face), 2, replace=False).tolist())
    if j - i < 2 or j - i > len(face) - 2:
        return triangulated(face, rng)
    return triangulated(face[i : j + 1], rng) + triangulated(face[j:] + face[: i + 1], rng)


@given(st.sampled_from([mesh for mesh in MESHES if mesh.combinatorics.face_sizes.max() > 3]), seeds)
def test_faces_and_their_triangles_are_all_listed(mesh: Mesh, seed: int) -> None:
    rng = np.random.default_rng(seed)
    turned = mesh.vertices @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    large = [number for number, face in enumerate(faces) if len(face) > 3]
    chosen = sorted(rng.choice(large, int(rng.integers(1, len(large) + 1)), replace=False).tolist())
    expected = set(chosen)
    for number in chosen:
        pieces = triangulated(faces[number], rng)
        expected |= set(range(len(faces), len(faces) + len(pieces)))
        faces += [piece[:: rng.choice([1, -1])] for piece in pieces]
    error = refused(turned, faces)
    assert set(error.elements) == expected
    n_pieces = len(expected) - len(chosen)
    assert error.message.startswith(f"{n_pieces} of {len(faces)} faces lie on others that have all their vertices: ")
    assert f" on {chosen[0]}" in error.message


def test_a_triangle_in_the_notch_of_a_face_lies_beside_it() -> None:
    corners = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]]
    mesh, said = mend(corners, [[0, 1, 2, 3, 4, 5], [2, 4, 3]])
    assert (mesh.n_faces, said) == (2, ())


def test_all_pairs_of_other_rings_of_the_same_vertices_are_listed() -> None:
    grid = shapes.grid(4, 3)
    faces = [face.tolist() for face in grid.combinatorics.faces]
    raw = RawPolygons.from_faces(grid.vertices, faces + [[a, c, b, d] for a, b, c, d in faces])
    with pytest.raises(MeshError) as caught:
        check_duplicates(raw)
    assert caught.value.elements == tuple(range(24))
    assert "; likewise faces 1 and 13, 2 and 14, 3 and 15" in caught.value.message


def test_all_edges_of_three_faces_are_counted() -> None:
    """A fence along a row of inner edges of a grid."""
    grid = shapes.grid(4, 2)
    row = np.flatnonzero(np.isclose(grid.vertices[:, 1], 1)).tolist()
    lifted = grid.vertices[row] + [0, 0, 1]
    fence = [[row[k], row[k + 1], grid.n_vertices + k + 1, grid.n_vertices + k] for k in range(4)]
    error = refused(
        np.concatenate([grid.vertices, lifted]), [face.tolist() for face in grid.combinatorics.faces] + fence
    )
    first, *others = [f"{b} to {a}" for a, b in pairwise(row)]
    assert error.message.startswith(f"the edge from vertex {first.replace('to', 'to vertex')} belongs to faces ")
    assert f"; likewise the edges {others[0]}, {others[1]} and {others[2]} (vert" in error.message
    assert error.elements == tuple(range(12))


def test_all_crossed_and_all_folded_faces_are_listed() -> None:
    vertices = np.concatenate([shapes.grid(1, 1).vertices + np.array([3 * k, 0, 0]) for k in range(5)])
    crossed = [[0, 1, 2, 3], [4, 5, 7, 6], [8, 9, 10, 11], [12, 13, 15, 14], [16, 17, 19, 18]]
    error = refused(vertices, crossed)
    assert error.elements == (0, 2)
    assert "; likewise face 2 " in error.message
    vertices[[6, 14]] = (vertices[[4, 12]] + vertices[[5, 13]]) / 2
    error = refused(vertices, [[4, 5, 6], [0, 1, 3, 2], [12, 13, 14]])
    assert error.message.startswith("face 0 folds back on itself")
    assert error.elements == (0, 2)


# --- pairs


@given(seeds)
def test_a_pair_goes_through_the_same_mending(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    """Doubled corners, thin faces, copies: in either file, of which only the first is reported."""
    rng = np.random.default_rng(seed)
    folder = tmp_path_factory.getbasetemp()
    mesh = shapes.grid(3, 2)
    image = mesh.vertices @ rng.normal(size=(3, 3))
    for name, vertices in (("M.obj", mesh.vertices), ("S.obj", image)):
        faces = [face.tolist() for face in mesh.combinatorics.faces]
        faces = [[face[0], *face] if rng.random() < 0.5 else face for face in faces]
        faces += [faces[rng.integers(6)][::-1], [1, 2], [4, 4, 4]][: rng.integers(4)]
        rows = ["v " + " ".join(map(repr, row)) for row in vertices.tolist()]
        rows += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
        (folder / name).write_text("\n".join(rows))
    file, found = read_mesh_pair(folder / "M.obj", folder / "S.obj")
    np.testing.assert_array_equal(file.mesh.vertices, mesh.vertices)
    np.testing.assert_array_equal(found.vertices, image)
    assert file.mesh.combinatorics.same_as(mesh.combinatorics)


def test_copies_in_place_are_none_where_the_other_mesh_tells_them_apart(tmp_path: Path) -> None:
    """Two closed pieces at one place whose images differ, as of a surface that covers itself twice."""
    cube = shapes.cube()
    faces = [face.tolist() for face in cube.combinatorics.faces] + [
        [v + 8 for v in face] for face in cube.combinatorics.faces
    ]
    for name, moved in (("M.obj", 0.0), ("S.obj", 5.0)):
        rows = [f"v {x} {y} {z}" for x, y, z in [*cube.vertices, *(cube.vertices + moved)]]
        (tmp_path / name).write_text("\n".join([*rows, *("f " + " ".join(str(v + 1) for v in f) for f in faces)]))
    file, image = read_mesh_pair(tmp_path / "M.obj", tmp_path / "S.obj")
    assert (file.mesh.n_faces, file.mended) == (12, ())
    assert image.vertices.max() == pytest.approx(cube.vertices.max() + 5.0)


# --- many at one place


def clusters_pair_by_pair(points: FloatArray, reach: float) -> FloatArray:
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= reach
    for _ in range(len(points).bit_length()):
        near = near.astype(int) @ near > 0
    return near.argmax(axis=1)


@given(seeds, st.integers(1, 60), st.sampled_from([0.0, 0.02, 0.1, 0.3]), st.sampled_from([0, 1, 2]))
def test_clusters_are_what_steps_within_reach_join(seed: int, n: int, reach: float, digits: int) -> None:
    """Also where many points coincide, nearly coincide or lie in one cell with points beyond the reach of others."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(1, n + 1)), 3)).round(digits)[rng.integers(0, 1, n)]
    points = points + rng.normal(size=(n, 3)) * rng.choice([0.0, 1e-3, 0.05, 0.5])
    found = clusters_within(points, reach)
    expected = clusters_pair_by_pair(points, reach)
    np.testing.assert_array_equal(found[:, None] == found[None], expected[:, None] == expected[None])


@pytest.mark.parametrize("jitter", [0.0, 0.3 * COINCIDENCE_TOLERANCE])
def test_a_point_shared_by_very_many_triangles_is_welded(jitter: float) -> None:
    """Each triangle has a tip of its own: there are 50 million pairs of these."""
    n = 10_000
    angles = np.linspace(0, 2 * np.pi, n + 1)[:-1]
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1)
    tips = np.random.default_rng(1).normal(size=(n, 3)).clip(-1, 1) * jitter / 6
    number = np.arange(n)
    faces = np.stack([number, (number + 1) % n, n + number], axis=1)
    found, _ = mend(np.concatenate([rim, tips]), faces.tolist(), coincidence=COINCIDENCE_TOLERANCE)
    assert (found.n_vertices, found.n_faces) == (n + 1, n)
    assert found.combinatorics.vertex_degrees.max() == n
