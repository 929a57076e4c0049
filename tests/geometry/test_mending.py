"""Whatever real files do to a mesh, mending gives the mesh back; what cannot be mended is refused in a sentence."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.files import check_faces, mend
from geometry.files.face_checks import COINCIDENCE_TOLERANCE
from geometry.mesh import Mesh, shapes

Faces = list[list[int]]

CLOSED = [shapes.cube(), shapes.dodecahedron(), shapes.regular_prism(5)]
OPEN = [shapes.grid(3, 3), shapes.dome(7, 3), shapes.rotational_mesh([[1, 0], [2, 1], [2, 3]], 5, closed=False)]
meshes = st.sampled_from(CLOSED + OPEN)
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def oriented_faces(mesh: Mesh) -> set[tuple[tuple[float, ...], ...]]:
    """Faces as cycles of positions to 6 decimals, from the least corner: equal where two meshes are one."""
    return {_cycle(mesh.vertices[face].round(6) + 0.0) for face in mesh.combinatorics.faces}


def _cycle(points: FloatArray) -> tuple[tuple[float, ...], ...]:
    corners = [tuple(point) for point in points.tolist()]
    start = corners.index(min(corners))
    return tuple(corners[start:] + corners[:start])


def pulled_apart(mesh: Mesh) -> tuple[FloatArray, Faces]:
    """Each face with vertices of its own."""
    c = mesh.combinatorics
    faces = [list(range(a, b)) for a, b in zip(c.face_starts[:-1].tolist(), c.face_starts[1:].tolist(), strict=True)]
    return mesh.vertices[c.corners], faces


def moebius_band(n: int) -> tuple[FloatArray, Faces]:
    angle = np.arange(n) * 2 * np.pi / n
    direction = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    across = np.cos(angle / 2)[:, None] * direction + np.sin(angle / 2)[:, None] * [0, 0, 1]
    vertices = np.concatenate([4 * direction - across, 4 * direction + across])
    faces = [[i, i + 1, n + i + 1, n + i] for i in range(n - 1)]
    return vertices, [*faces, [n - 1, n, 0, 2 * n - 1]]


# --- what is mended


@given(meshes)
def test_a_clean_mesh_comes_back_as_it_is(mesh: Mesh) -> None:
    mended, said = mend(mesh.vertices, mesh.combinatorics.faces)
    assert said == ()
    np.testing.assert_array_equal(mended.vertices, mesh.vertices)
    assert mended.combinatorics.same_as(mesh.combinatorics)


@given(meshes, st.integers(0, 2**32 - 1))
def test_vertices_apart_by_less_than_the_tolerance_are_welded(mesh: Mesh, seed: int) -> None:
    vertices, faces = pulled_apart(mesh)
    reach = COINCIDENCE_TOLERANCE * mesh.edge_lengths.min() / 4  # copies are then less than half the tolerance apart
    shift = np.random.default_rng(seed).uniform(-1, 1, vertices.shape) * reach / 3**0.5
    mended, said = mend(vertices + shift, faces)
    assert (mended.n_vertices, mended.n_edges) == (mesh.n_vertices, mesh.n_edges)
    assert mended.combinatorics.euler_characteristic == mesh.combinatorics.euler_characteristic
    (sentence,) = said
    assert sentence.startswith(
        f"{len(vertices) - mesh.n_vertices} of {len(vertices)} vertices welded to others at most"
    )


@given(meshes)
def test_welding_keeps_the_first_of_equal_vertices(mesh: Mesh) -> None:
    mended, _ = mend(*pulled_apart(mesh))
    assert oriented_faces(mended) == oriented_faces(mesh)
    assert {tuple(v) for v in mended.vertices.tolist()} == {tuple(v) for v in mesh.vertices.tolist()}


def test_vertices_further_apart_than_the_tolerance_stay_apart() -> None:
    gap = 2 * COINCIDENCE_TOLERANCE
    square = np.array(SQUARE, dtype=float)
    vertices = np.concatenate([square, square + np.array([1 + gap, 0, 0])])
    faces = [[0, 1, 2, 3], [4, 5, 6, 7]]
    assert mend(vertices, faces)[0].n_vertices == 8
    assert mend(vertices, faces, coincidence=3 * COINCIDENCE_TOLERANCE)[0].n_vertices == 6


def test_closed_parts_that_touch_are_not_welded() -> None:
    """Two cubes with a common edge: welded, that edge would have four faces."""
    cube = shapes.cube()
    faces = [face.tolist() for face in cube.combinatorics.faces]
    vertices = np.concatenate([cube.vertices, cube.vertices + np.array([2, 2, 0])])
    mesh, said = mend(vertices, faces + [[v + 8 for v in face] for face in faces])
    assert (mesh.n_vertices, said) == (16, ())


@given(meshes, st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_unused_vertices_are_removed(mesh: Mesh, n_unused: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.permutation(mesh.n_vertices + n_unused)[: mesh.n_vertices]
    vertices = np.full((mesh.n_vertices + n_unused, 3), 17.0)
    vertices[places] = mesh.vertices
    mended, said = mend(vertices, [places[face].tolist() for face in mesh.combinatorics.faces])
    assert said == (f"{n_unused} of {len(vertices)} vertices belonged to no face; removed",)
    assert mended.n_vertices == mesh.n_vertices
    assert oriented_faces(mended) == oriented_faces(mesh)


@given(st.sampled_from(CLOSED), st.integers(0, 2**32 - 1))
def test_closed_surfaces_face_outwards_whatever_way_their_faces_ran(mesh: Mesh, seed: int) -> None:
    turn = np.random.default_rng(seed).random(mesh.n_faces) < 0.5
    faces = [face[::-1] if turned else face for face, turned in zip(mesh.combinatorics.faces, turn, strict=True)]
    mended, said = mend(mesh.vertices, faces)
    assert oriented_faces(mended) == oriented_faces(mesh)
    expected = f"{turn.sum()} of {mesh.n_faces} faces reversed to face out of a closed surface"
    assert said == ((expected,) if turn.any() else ())


@given(st.lists(st.sampled_from(OPEN), min_size=1, max_size=3), st.integers(0, 2**32 - 1))
def test_open_components_keep_the_orientation_of_most_of_their_faces(parts: list[Mesh], seed: int) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces, n_turned, expected = [], [], 0, set()
    for number, part in enumerate(parts):
        moved = part.with_vertices(part.vertices + np.array([100 * number, 0, 0]))
        turned = rng.permutation(part.n_faces)[: rng.integers(0, (part.n_faces + 1) // 2)]  # fewer than half
        offset = sum(map(len, vertices))
        for index, face in enumerate(part.combinatorics.faces):
            shifted = [vertex + offset for vertex in face]
            faces.append(shifted[::-1] if index in turned else shifted)
        vertices.append(moved.vertices)
        n_turned += len(turned)
        expected |= oriented_faces(moved)
    mended, said = mend(np.concatenate(vertices), faces)
    assert oriented_faces(mended) == expected
    sentence = f"{n_turned} of {len(faces)} faces reversed to agree with their neighbours"
    assert said == ((sentence,) if n_turned else ())


def test_where_as_many_faces_run_either_way_the_first_decides() -> None:
    grid = shapes.grid(2, 1)
    first, second = grid.combinatorics.faces
    assert mend(grid.vertices, [first, second[::-1]])[0].vector_areas[:, 2].tolist() == [1, 1]
    assert mend(grid.vertices, [first[::-1], second])[0].vector_areas[:, 2].tolist() == [-1, -1]


@given(meshes)
def test_flip_turns_everything_round_at_the_end(mesh: Mesh) -> None:
    mended, said = mend(mesh.vertices, mesh.combinatorics.faces, flip=True)
    assert said == ("all faces reversed, as requested",)
    assert oriented_faces(mended) == oriented_faces(mesh.reversed())


def test_a_closing_corner_is_dropped() -> None:
    mesh, said = mend(SQUARE, [[0, 1, 2, 0], [0, 2, 3]])
    assert [face.tolist() for face in mesh.combinatorics.faces] == [[0, 1, 2], [0, 2, 3]]
    assert said == ("1 of 2 faces named their first vertex again at the end; dropped",)


def test_fans_may_touch_at_a_vertex() -> None:
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0], [2, 2, 0]]
    mesh, said = mend(vertices, [[0, 1, 2], [2, 3, 4]])
    assert (mesh.n_vertices, said) == (5, ())


@pytest.mark.parametrize(
    "polygon",
    [
        [[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]],  # not convex
        [[0, 0], [2, 0], [4, 0], [4, 4], [0, 4]],  # a straight corner
        [[0, 0], [6, 0], [6, 6], [1, 6], [1, 2], [3, 2], [3, 4], [2, 4], [2, 5], [5, 5], [5, 1], [0, 1]],  # a spiral
        [[0, 0], [1, 0], [1, 1e-4], [0, 1e-4]],  # thin, but wider than the coincidence of its mean edge length
    ],
    ids=["hollow", "straight corner", "spiral", "thin"],
)
def test_simple_polygons_of_any_form_are_fine(polygon: list[list[float]]) -> None:
    points = np.insert(np.array(polygon, dtype=float), 2, 0.0, axis=1)
    for shift in range(len(points)):
        check_faces(Mesh.from_faces(np.roll(points, shift, axis=0), [range(len(points))]))


def test_strongly_skew_quads_are_left_to_whoever_asks_for_planarity() -> None:
    mesh = Mesh.from_faces([[0, 0, 1], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2, 3]])
    check_faces(mesh)


# --- what is refused


def refused(vertices: object, faces: Faces) -> str:
    with pytest.raises(MeshError) as caught:
        mend(vertices, faces)
    assert "\n" not in caught.value.message
    return caught.value.message


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200])
def test_coordinates_must_be_finite(value: float) -> None:
    vertices = np.array(SQUARE, dtype=float)
    vertices[2, 1] = value
    assert refused(vertices, [[0, 1, 2, 3]]).startswith("vertex 2 is (1.0, ")


@pytest.mark.parametrize(
    ("faces", "sentence"),
    [
        ([], "there are no faces (vertices: 4): a mesh needs polygons, not points or curves"),
        (
            [[2, 3], [0, 1, 0], []],
            "there are no faces: none of 3 has three separate corners, see faces 0, 1 and 2",
        ),
        ([[0, 1, 2, 4]], "face 0 names vertex 4, but the 4 vertices end at 3"),
        ([[0, 1, -1]], "face 0 names vertex -1, but the 4 vertices end at 3"),
        ([[0, 1, 2], [0, 2, 3, 2]], "face 1 touches itself: two of its corners are vertex 2 or lie on it"),
        ([[0, 1, 2, 3], [2, 0, 3, 1]], "faces 0 and 1 have the same vertices (0, 1, 2, 3): remove one of them"),
        ([[0, 1, 2], [0, 2, 3, 1], [0, 1, 2, 3]], "faces 1 and 2 have the same vertices (0, 2, 3, 1): remove one"),
        ([[0, 1, 3, 2]], "face 0 crosses itself: its edge from vertex 1 to 3 meets its edge from 2 to 0"),
    ],
)
def test_faces_that_cannot_be(faces: Faces, sentence: str) -> None:
    assert refused(SQUARE, faces).startswith(sentence)


def test_zero_length_edges_are_named_by_the_check() -> None:
    vertices = [*SQUARE, [0, COINCIDENCE_TOLERANCE / 2, 0]]
    with pytest.raises(MeshError) as caught:
        check_faces(Mesh.from_faces(vertices, [[0, 1, 2, 3, 4]]))
    said = caught.value.message
    assert said.startswith("face 0: its edge from vertex 4 to vertex 0 is 6.3e-05 of the mean edge length long, more ")
    assert refused([[1, 1, 1]] * 3, [[0, 1, 2]]).startswith("there are no faces: none of 1 has three separate corners")


def test_corners_of_a_face_that_fall_together_are_an_error() -> None:
    """A slit polygon: corners 1 and 4 lie at one point without being neighbours."""
    vertices = [[0, 0, 0], [2, 0, 0], [3, 1, 0], [3, -1, 0], [2, 0, 0], [0, 2, 0]]
    assert refused(vertices, [[0, 1, 2, 3, 4, 5]]).startswith(
        "face 0 touches itself: two of its corners are vertex 1 or"
    )


def test_edges_of_three_faces_are_named() -> None:
    vertices = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]]
    said = refused(vertices, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert said.startswith("the edge from vertex 0 to vertex 1 belongs to faces 0, 1 and 2, two at most are allowed")


def test_numbers_in_sentences_are_those_of_the_input_after_welding() -> None:
    """Three sheets pulled apart, with unused vertices in between: the edge is named by its first copies."""
    ends = [[0, 0, 0], [0, 0, 1]]
    vertices = [[9, 9, 9], *ends, [1, 0, 0], [8, 8, 8], *ends, [0, 1, 0], *ends, [-1, -1, 0]]
    said = refused(vertices, [[1, 2, 3], [5, 6, 7], [8, 9, 10]])
    assert said.startswith("the edge from vertex 1 to vertex 2 belongs to faces 0, 1 and 2")


@pytest.mark.parametrize(
    "polygon",
    [
        [[0, 0], [2, 0], [1, 0], [1, 2]],  # along an edge
        [[0, 0], [2, 0], [2, 2], [5, 5], [1, 1], [0, 2]],  # outwards, over a corner
        [[0, 0], [1, 0], [3, 0]],  # no area
        [[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]],  # a corner on another edge
    ],
    ids=["spike", "spike out", "no area", "pinched"],
)
def test_folded_faces_are_refused_wherever_they_begin(polygon: list[list[float]]) -> None:
    points = np.insert(np.array(polygon, dtype=float), 2, 0.0, axis=1)
    for shift in range(len(points)):
        with pytest.raises(MeshError, match="face 0 folds back on itself") as caught:
            check_faces(Mesh.from_faces(np.roll(points, shift, axis=0), [range(len(points))]))
        assert caught.value.elements == (0,)
        assert caught.value.value == pytest.approx(0, abs=1e-15)


def test_a_spike_is_named() -> None:
    said = refused([[0, 0, 0], [2, 0, 0], [1, 0, 0], [1, 2, 0]], [[0, 1, 2, 3]])
    assert said.startswith("face 0 folds back on itself: its vertex 2 lies 0 of the face's mean edge length from its")
    assert "edge from 0 to 1, more than 1e-06 is needed; remove the spike" in said


@given(st.integers(0, 2**32 - 1), st.integers(5, 9))
def test_crossings_are_found_wherever_the_polygon_begins_and_lies(seed: int, n: int) -> None:
    """A regular n-gon with two corners next to each other exchanged, turned anywhere in space, among good faces."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(n) / n
    points = np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    order = list(range(n))
    order[0], order[1] = order[1], order[0]
    shift = int(rng.integers(n))
    good = Mesh.from_faces(np.concatenate([points, points + 5]), [range(n), range(n, 2 * n)])
    check_faces(good)
    bad = [list(range(n)), [n + order[(i + shift) % n] for i in range(n)]]
    with pytest.raises(MeshError, match="face 1 crosses itself") as caught:
        check_faces(Mesh.from_faces(good.vertices, bad))
    assert caught.value.elements == (1,)


@given(st.integers(3, 9), st.integers(0, 2**32 - 1))
def test_surfaces_with_one_side_are_refused_and_an_edge_is_named(n: int, seed: int) -> None:
    vertices, faces = moebius_band(n)
    rng = np.random.default_rng(seed)
    faces = [face[::-1] if rng.random() < 0.5 else face for face in faces]
    grid = shapes.grid(1, 1)  # a good component first
    shifted = [[v + 4 for v in face] for face in faces]
    said = refused(np.concatenate([grid.vertices - 50, vertices]), [*grid.combinatorics.faces, *shifted])
    assert said.startswith("the surface has one side only (it is not orientable)")
    words = said.split()
    i, j = (
        int(words[k].rstrip(";")) for k in (words.index("vertex") + 1, words.index("to", words.index("vertex")) + 2)
    )
    assert sum({i, j} <= set(face) for face in shifted) == 2  # an inner edge of the band


def test_check_faces_sees_what_combinatorics_cannot() -> None:
    with pytest.raises(MeshError, match="have the same vertices"):
        check_faces(Mesh.from_faces(SQUARE, [[0, 1, 2, 3], [3, 2, 1, 0]]))
    with pytest.raises(MeshError, match="edge from vertex 1 to vertex 2 is 0 of"):
        check_faces(Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    for mesh in CLOSED + OPEN:
        check_faces(mesh)


@pytest.mark.parametrize("exponent", [-61, -160, -300, -323])
@pytest.mark.parametrize("moved", [0.0, 5.0])
def test_a_mesh_too_small_to_reckon_with_is_refused(exponent: int, moved: float) -> None:
    faces = [face.tolist() for face in shapes.dodecahedron().combinatorics.faces]
    vertices = shapes.dodecahedron().vertices * 10.0**exponent / 4
    with pytest.raises(MeshError, match=r"extent of the mesh is .* at least 1e-60 is needed|no faces"):
        mend(vertices + moved, faces)  # moved, all is one point
    sound, mended = mend(shapes.dodecahedron().vertices * 1e-59, faces)
    assert mended == ()
    np.testing.assert_allclose(sound.edge_lengths, sound.mean_edge_length, rtol=1e-14)
