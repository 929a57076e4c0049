"""A pair of a mesh and its Gauss image: parallel by construction, and what it answers by definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError, ParallelityError
from geometry.gauss import PARALLEL_TOLERANCE, Pair, approximate_pair, edge_distances, points_inwards
from geometry.mesh import Mesh, shapes, solids
from geometry.spheres import LaguerreTransformation as L
from tests.geometry.parallel_elements import SOLIDS, element, opened, solid
from tests.geometry.test_lorentz import orthogonal, seeds

names = st.sampled_from(sorted(SOLIDS))
vectors = st.tuples(*[st.floats(-5, 5)] * 3).map(np.array)


def random_pair(name: str, seed: int) -> Pair:
    """A random M in P(S) of an opened solid S that touches the sphere with its edges."""
    S = opened(solid(name, "edge"), seed)
    return Pair(element(S, seed), S)


@given(names, seeds)
def test_measures_are_those_of_edges_one_by_one(name: str, seed: int) -> None:
    pair = random_pair(name, seed)
    M, S, c = pair.mesh, pair.gauss_image, pair.mesh.combinatorics
    for edge, (i, j) in enumerate(c.edges.tolist()):
        along = (M.vertices[j] - M.vertices[i]) / np.linalg.norm(M.vertices[j] - M.vertices[i])
        foot = S.vertices[i] - np.dot(S.vertices[i], along) * along
        np.testing.assert_allclose(pair.edge_feet[edge], foot, rtol=0, atol=1e-11)
        assert pair.edge_distances[edge] == pytest.approx(np.linalg.norm(foot), abs=1e-11)
        factor = np.dot(S.vertices[j] - S.vertices[i], along) / np.linalg.norm(M.vertices[j] - M.vertices[i])
        assert pair.edge_factors[edge] == pytest.approx(factor, rel=1e-11)
        assert pair.reversed_edges[edge] == (factor < 0)
    np.testing.assert_array_equal(pair.vertex_distances, np.linalg.norm(S.vertices, axis=1))
    first = S.vertices[c.corners[c.face_starts[:-1]]]
    np.testing.assert_allclose(pair.face_distances, np.einsum("fk,fk->f", first, M.face_normals), rtol=0, atol=1e-11)
    np.testing.assert_allclose(pair.edge_distances, edge_distances(S), rtol=0, atol=1e-11)


@given(names, seeds)
def test_vertices_are_mixed_where_edges_around_run_both_ways(name: str, seed: int) -> None:
    pair = random_pair(name, seed)
    expected = []
    for vertex in range(pair.mesh.n_vertices):
        around = (pair.mesh.combinatorics.edges == vertex).any(axis=1)
        if pair.reversed_edges[around].any() and not pair.reversed_edges[around].all():
            expected.append(vertex)
    assert pair.mixed_vertices.tolist() == expected


@given(names, seeds, st.floats(-3, 3))
def test_offset_meshes_form_pairs_with_the_same_gauss_image(name: str, seed: int, d: float) -> None:
    """Distances of the edges of M and M + d S are d times those of S [Pottmann2007, Prop. 2]."""
    pair = random_pair(name, seed)
    offset = pair.offset_mesh(d)
    np.testing.assert_allclose(offset.vertices, pair.mesh.vertices + d * pair.gauss_image.vertices)
    apart = edge_distances(offset - pair.mesh, pair.mesh.edge_directions)
    np.testing.assert_allclose(apart, abs(d) * pair.edge_distances, rtol=0, atol=1e-11)


@given(names, seeds, vectors)
def test_moving_m_changes_nothing_but_its_place_and_moving_s_tilts_the_axes(
    name: str, seed: int, vector: np.ndarray
) -> None:
    pair = random_pair(name, seed)
    moved = pair.translated(vector)
    np.testing.assert_array_equal(moved.mesh.vertices, pair.mesh.vertices + vector)
    assert moved.gauss_image is pair.gauss_image
    np.testing.assert_allclose(moved.edge_distances, pair.edge_distances, rtol=0, atol=1e-10)
    np.testing.assert_allclose(moved.edge_factors, pair.edge_factors, rtol=1e-10)
    tilted = pair.tilted(vector)
    assert tilted.mesh is pair.mesh
    np.testing.assert_array_equal(tilted.gauss_image.vertices, pair.gauss_image.vertices + vector)
    np.testing.assert_allclose(tilted.edge_factors, pair.edge_factors, rtol=1e-10)
    normals = pair.mesh.face_normals
    np.testing.assert_allclose(tilted.face_distances - pair.face_distances, normals @ vector, rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", sorted(SOLIDS))
def test_outwards_is_the_side_to_which_s_points(name: str) -> None:
    pair = Pair(SOLIDS[name] * 3.0, solid(name, "edge"))
    for other, is_inwards in (
        (pair, False),
        (pair.reversed(), True),
        (Pair(pair.mesh, -1 * pair.gauss_image), True),
        (Pair(pair.mesh.reversed(), -1 * pair.gauss_image.reversed()), False),
    ):
        assert other.is_inwards == is_inwards == points_inwards(other.mesh, other.gauss_image)
        outwards = other.outwards()
        assert not outwards.is_inwards
        np.testing.assert_array_equal(outwards.gauss_image.vertices, other.gauss_image.vertices)
        assert (outwards is other) != is_inwards


@given(names, seeds, st.floats(-2, 2), vectors)
def test_laguerre_transformations_act_as_a_group_on_pairs(name: str, seed: int, d: float, vector: np.ndarray) -> None:
    pair, turn = random_pair(name, seed), orthogonal(np.random.default_rng(seed), 1.0)
    moved = pair.laguerre(L.motion(turn, vector)).laguerre(L.offset(d))
    at_once = pair.laguerre(L.offset(d) @ L.motion(turn, vector))
    np.testing.assert_allclose(moved.mesh.vertices, at_once.mesh.vertices, rtol=0, atol=1e-11)
    np.testing.assert_allclose(moved.gauss_image.vertices, pair.gauss_image.vertices @ turn.T, rtol=0, atol=1e-12)
    np.testing.assert_allclose(moved.edge_distances, pair.edge_distances, rtol=0, atol=1e-9)


@given(names, seeds)
def test_parts_keep_measures_and_share_combinatorics(name: str, seed: int) -> None:
    pair = random_pair(name, seed)
    faces = np.flatnonzero(np.random.default_rng(seed).random(pair.mesh.n_faces) < 0.6)
    if not len(faces):
        return
    part = pair.part(faces)
    assert part.gauss_image.combinatorics is part.mesh.combinatorics
    np.testing.assert_allclose(part.face_distances, pair.face_distances[faces], rtol=0, atol=1e-12)


@given(names, seeds, st.floats(-12, -2))
def test_it_is_parallel_to_its_tolerance_or_not_made(name: str, seed: int, decade: float) -> None:
    """A vertex of S that is moved across an edge of M by more than the tolerance is refused, by less is not."""
    pair = random_pair(name, seed)
    M, S = pair.mesh, pair.gauss_image
    _, j = M.combinatorics.edges[0]
    across = np.cross(M.edge_directions[0], [0.3, -0.5, 0.8])
    vertices = S.vertices.copy()
    vertices[j] += 10**decade * across / np.linalg.norm(across)
    if 10**decade > 1.01 * PARALLEL_TOLERANCE:
        with pytest.raises(
            ParallelityError, match="of the Gauss image is off the direction of its mesh edge"
        ) as caught:
            Pair(M, S.with_vertices(vertices))
        assert caught.value.bound == PARALLEL_TOLERANCE
    elif 10**decade < 0.99 * PARALLEL_TOLERANCE:
        moved = Pair(M, S.with_vertices(vertices))
        of_mesh, of_gauss_image = moved.moves_from(M, S)
        assert not of_mesh.any()
        assert np.flatnonzero(of_gauss_image).tolist() == [j]


def test_other_faces_and_edges_without_length_are_refused() -> None:
    cube = shapes.cube()
    with pytest.raises(MeshError, match="do not have the same faces"):
        Pair(cube, shapes.octahedron())
    with pytest.raises(MeshError, match="has no length"):
        Pair(cube * 0.0, cube)
    assert Pair(cube, cube * 0.0).edge_distances.max() == 0  # edges of S may have none


def test_equal_combinatorics_become_the_same_object() -> None:
    one, other = solids.cube(), solids.cube()
    assert one.combinatorics is not other.combinatorics
    pair = Pair(one, other)
    assert pair.gauss_image.combinatorics is pair.mesh.combinatorics is one.combinatorics
    np.testing.assert_array_equal(pair.gauss_image.vertices, other.vertices)


def test_moves_of_m_are_counted_in_its_edges_and_those_of_s_in_radii() -> None:
    cube = shapes.cube()  # of edge length 2
    of_mesh, of_gauss_image = Pair(cube.translated([1, 0, 0]), cube).moves_from(cube, cube.translated([0, 0, 3]))
    np.testing.assert_allclose(of_mesh, 0.5)
    np.testing.assert_allclose(of_gauss_image, 3.0)


def test_leans_are_those_of_its_axes() -> None:
    grid = shapes.grid(3, 2)
    pair = Pair(grid, grid.with_vertices(np.tile([0.0, 0.0, 1.0], (12, 1))))
    np.testing.assert_allclose(pair.leans, 0, atol=1e-15)
    np.testing.assert_allclose(pair.tilted([1.0, 0.0, 0.0]).leans, np.pi / 4, rtol=0, atol=1e-15)


def test_an_approximate_gauss_image_has_no_laguerre_image_of_its_kind() -> None:
    pair = approximate_pair(skew())
    with pytest.raises(GeometryError, match="no exact kind"):
        pair.laguerre(L.boost([0.1, 0.0, 0.0]))
    assert isinstance(pair.laguerre(L.boost([0.1, 0.0, 0.0]), tolerance=np.inf), Pair)


def skew() -> Mesh:
    u = np.linspace(-1, 1, 5)
    return shapes.translation_surface(
        np.stack([u, 0.5 * u, -0.5 * u**2], axis=1), np.stack([0 * u, u, -0.3 * u**2 + 0.05 * u**3], axis=1)
    )
