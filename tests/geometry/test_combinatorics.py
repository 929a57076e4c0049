"""Faces, edges, stars and boundary loops: identities that hold for every mesh."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import MeshError
from geometry.mesh import Combinatorics, Mesh, shapes

DISCS = [
    shapes.grid(1, 1),
    shapes.grid(4, 3),
    shapes.rotational_mesh([[1, 0], [2, 1], [2, 3]], 5, closed=False),
    shapes.translation_surface([[0, 0, 0], [1, 0, 1], [2, 0, 0]], [[0, 0, 0], [0, 1, -1]]),
]
ANNULI = [shapes.dome(7, 3), shapes.dome(3, 1), shapes.rotational_mesh([[1, 0], [2, 1]], 4)]
SPHERES = [
    shapes.tetrahedron(),
    shapes.cube(),
    shapes.octahedron(),
    shapes.dodecahedron(),
    shapes.icosahedron(),
    shapes.box(1, 2, 3),
    shapes.regular_prism(5),
]
meshes = st.sampled_from(DISCS + ANNULI + SPHERES)


@st.composite
def grids_with_holes(draw: st.DrawFn) -> Combinatorics:
    """Some faces of a grid: any number of components, loops, and vertices at which fans touch."""
    nx, ny = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    whole = shapes.grid(nx, ny)
    kept = draw(st.sets(st.integers(0, nx * ny - 1), min_size=1))
    faces = [face.tolist() for face in whole.combinatorics.faces]
    return Combinatorics.from_faces(whole.n_vertices, [faces[face] for face in sorted(kept)])


combinatorics = st.one_of(meshes.map(lambda mesh: mesh.combinatorics), grids_with_holes())


@pytest.mark.parametrize(
    ("group", "chi", "n_loops"), [(DISCS, 1, 1), (ANNULI, 0, 2), (SPHERES, 2, 0)], ids=["disc", "annulus", "sphere"]
)
def test_euler_characteristic_and_number_of_loops(group: list[Mesh], chi: int, n_loops: int) -> None:
    assert [mesh.combinatorics.euler_characteristic for mesh in group] == [chi] * len(group)
    assert [len(mesh.combinatorics.boundary_loops) for mesh in group] == [n_loops] * len(group)


@given(combinatorics)
def test_corners_go_round_their_faces(c: Combinatorics) -> None:
    assert np.array_equal(c.previous_corner[c.next_corner], np.arange(c.n_corners))
    assert np.array_equal(c.corner_face[c.next_corner], c.corner_face)
    assert np.array_equal(c.corners[c.next_corner], np.concatenate([np.roll(face, -1) for face in c.faces]))
    assert sum(len(faces) for faces, _ in c.faces_by_size()) == c.n_faces
    assert np.array_equal(np.sort(np.concatenate([k.ravel() for _, k in c.faces_by_size()])), np.arange(c.n_corners))


@given(combinatorics)
def test_twin_of_twin_is_the_corner_itself_and_runs_back(c: Combinatorics) -> None:
    inner = np.flatnonzero(c.twin >= 0)
    twins = c.twin[inner]
    assert np.array_equal(c.twin[twins], inner)
    assert np.array_equal(c.corners[twins], c.corners[c.next_corner[inner]])
    assert np.array_equal(c.corners[c.next_corner[twins]], c.corners[inner])
    assert np.array_equal(c.corner_edge[twins], c.corner_edge[inner])


@given(combinatorics)
def test_edges_run_as_their_left_faces(c: Combinatorics) -> None:
    left, right = c.edge_corners.T
    assert np.array_equal(c.corners[left], c.edges[:, 0])
    assert np.array_equal(c.corners[c.next_corner[left]], c.edges[:, 1])
    inner = right >= 0
    assert np.array_equal(c.corners[right[inner]], c.edges[inner, 1])
    assert np.array_equal(c.corner_edge[left], np.arange(c.n_edges))
    assert c.n_corners == 2 * c.n_edges - np.count_nonzero(c.is_boundary_edge)
    assert len(np.unique(np.sort(c.edges, axis=1), axis=0)) == c.n_edges


@given(combinatorics)
def test_boundary_loops_are_the_boundary_edges_once_each(c: Combinatorics) -> None:
    runs = {(int(i), int(j)) for loop in c.boundary_loops for i, j in zip(loop, np.roll(loop, -1), strict=True)}
    assert runs == set(map(tuple, c.edges[c.is_boundary_edge].tolist()))
    assert sum(map(len, c.boundary_loops)) == np.count_nonzero(c.is_boundary_edge)
    assert set(np.flatnonzero(c.is_boundary_vertex)) == {int(v) for loop in c.boundary_loops for v in loop}


def test_a_vertex_where_two_fans_touch_is_in_two_loops() -> None:
    """Two triangles that share the vertex 2 only."""
    c = Combinatorics.from_faces(5, [[0, 1, 2], [2, 3, 4]])
    assert sorted(sorted(loop.tolist()) for loop in c.boundary_loops) == [[0, 1, 2], [2, 3, 4]]
    assert c.vertex_degrees.tolist() == [2, 2, 4, 2, 2]
    assert c.face_components.tolist() == [0, 1]


def test_touching_fans_with_the_hole_between_them() -> None:
    """A 4 x 4 grid without two faces that touch at a corner: the two holes keep to their own loops."""
    faces = [face for number, face in enumerate(shapes.grid(4, 4).combinatorics.faces) if number not in (5, 10)]
    c = Combinatorics.from_faces(25, faces)
    assert sorted(len(loop) for loop in c.boundary_loops) == [8, 16]
    assert c.euler_characteristic == 25 - c.n_edges + 14


@given(combinatorics)
def test_reversed_twice_is_the_same_and_once_turns_every_edge(c: Combinatorics) -> None:
    turned = c.reversed()
    assert turned.reversed().same_as(c)
    assert {tuple(edge[::-1]) for edge in _half_edges(c)} == set(_half_edges(turned))
    assert [sorted(face) for face in turned.faces] == [sorted(face) for face in c.faces]


def _half_edges(c: Combinatorics) -> list[tuple[int, int]]:
    return list(zip(c.corners.tolist(), c.corners[c.next_corner].tolist(), strict=True))


@given(combinatorics)
def test_degrees_and_adjacency_count_the_edges(c: Combinatorics) -> None:
    assert c.vertex_degrees.sum() == 2 * c.n_edges
    assert np.array_equal(np.asarray(c.adjacency.sum(axis=1)).ravel(), c.vertex_degrees)
    assert (c.adjacency != c.adjacency.T).nnz == 0
    assert np.array_equal(np.flatnonzero(c.is_used), np.unique(c.corners))


@given(st.lists(meshes, min_size=1, max_size=3))
def test_components_and_characteristic_of_several_meshes_side_by_side(parts: list[Mesh]) -> None:
    faces: list[list[int]] = []
    n_vertices = 0
    for mesh in parts:
        faces += [[vertex + n_vertices for vertex in face] for face in mesh.combinatorics.faces]
        n_vertices += mesh.n_vertices
    c = Combinatorics.from_faces(n_vertices, faces)
    assert np.bincount(c.face_components).tolist() == [mesh.n_faces for mesh in parts]
    assert c.euler_characteristic == sum(mesh.combinatorics.euler_characteristic for mesh in parts)


@given(mesh=meshes, seed=st.integers(0, 99))
def test_corners_of_faces_and_faces_inside(mesh: Mesh, seed: int) -> None:
    c = mesh.combinatorics
    faces = np.random.default_rng(seed).integers(c.n_faces, size=5)
    corners, owner = c.corners_of(faces)
    np.testing.assert_array_equal(c.corner_face[corners], faces[owner])
    assert [c.corners[corners[owner == k]].tolist() for k in range(5)] == [c.face(face).tolist() for face in faces]
    rim = {int(vertex) for loop in c.boundary_loops for vertex in loop}
    assert c.inner_faces.tolist() == [k for k, face in enumerate(c.faces) if not rim & set(face)]


@given(mesh=meshes, seed=st.integers(0, 99))
def test_a_part_has_the_faces_asked_for_in_their_order_and_no_other_vertices(mesh: Mesh, seed: int) -> None:
    rng = np.random.default_rng(seed)
    faces = rng.permutation(mesh.n_faces)[: rng.integers(1, mesh.n_faces + 1)]
    part = mesh.part(faces)
    assert part.combinatorics.is_used.all()
    for face, its_face in zip(faces, part.combinatorics.faces, strict=True):
        np.testing.assert_array_equal(part.vertices[its_face], mesh.vertices[mesh.combinatorics.face(face)])


def test_same_as_needs_equal_faces() -> None:
    c = shapes.grid(2, 1).combinatorics
    assert c.same_as(Combinatorics.from_faces(c.n_vertices, c.faces))
    assert not c.same_as(c.reversed())
    assert not c.same_as(Combinatorics.from_faces(c.n_vertices + 1, c.faces))


@pytest.mark.parametrize(
    ("faces", "sentence"),
    [
        ([], "the mesh has no faces"),
        ([[0, 1]], "face 0 has 2 corners, at least 3"),
        ([[0, 1, 2], [0, 2, 9]], "face 1 names vertex 9, but there are 6 vertices"),
        ([[0, 1, 2, 1]], "face 0 touches itself: it meets vertex 1 twice"),
        ([[0, 1, 2], [0, 1, 3]], "faces 0 and 1 both run from vertex 0 to vertex 1: neighbours have different orient"),
        ([[0, 1, 2], [1, 0, 3], [0, 1, 4]], "the edge from vertex 0 to vertex 1 belongs to faces 0, 1 and 2, two at"),
        (
            [[0, 1, 4, 3], [1, 2, 5, 4], [2, 3, 0, 5]],  # a strip, its last face turned over
            r"one side only \(it is not orientable\): with all other faces made to agree, faces \d and \d do not",
        ),
    ],
)
def test_what_is_no_manifold_is_refused(faces: list[list[int]], sentence: str) -> None:
    with pytest.raises(MeshError, match=sentence):
        Combinatorics.from_faces(6, faces)
