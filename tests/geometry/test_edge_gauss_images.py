"""Koebe polyhedra S are recovered from meshes M parallel to them, whatever edges run the other way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from geometry.exact_offsets import edge_offset_pair
from geometry.gauss import Pair
from geometry.gauss.distances import edge_distances
from geometry.mesh import Mesh, shapes
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from tests.geometry.box_meshes import turning
from tests.geometry.parallel_elements import SIMPLE, boosted, element, opened, solid, tangent_profile

seeds = st.integers(0, 2**32 - 1)
FAR = 1e-8  # what planes of 1e-13 and edges of a hundredth of the mean leave of the far vertices of slim cones


@pytest.mark.parametrize("name", [*SIMPLE, "rhombicuboctahedron"])
@given(seed=seeds)
@settings(max_examples=6)
def test_a_koebe_polyhedron_is_recovered_from_a_mesh_parallel_to_it(name: str, seed: int) -> None:
    image = boosted(solid(name, "edge"), seed)
    mesh = element(image, seed)
    pair = edge_offset_pair(mesh)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-9)
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-11
    sign = np.sign(np.sum(pair.gauss_image.vertices * image.vertices))
    np.testing.assert_allclose(sign * pair.gauss_image.vertices, image.vertices, atol=FAR)


@pytest.mark.parametrize("name", ["dodecahedron", "truncated_icosahedron", "truncated_cube", "rhombicuboctahedron"])
@given(seed=seeds)
@example(seed=3042)  # rounding decides there about what the distances leave free
@settings(max_examples=10)
def test_edges_run_the_other_way_and_boundaries_have_vertices_with_two_edges(name: str, seed: int) -> None:
    image = opened(boosted(solid(name, "edge"), seed), seed)
    mesh = element(image, seed)
    pair = edge_offset_pair(mesh)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-9)
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-11
    assume((edge_factors(mesh, image) < 0).any())
    inner = mesh.combinatorics.vertex_degrees > 2  # edges between two others may touch the circle of a face twice
    sign = np.sign(np.sum((pair.gauss_image.vertices * image.vertices)[inner]))
    np.testing.assert_allclose(sign * pair.gauss_image.vertices[inner], image.vertices[inner], atol=FAR)
    np.testing.assert_array_equal(pair.gauss_image.vertices[~mesh.combinatorics.is_used], 0)


# --- reversed edges in closed form


@given(st.integers(5, 16), st.integers(3, 8), seeds)
@example(16, 3, 0)  # the upper ring has nearly the normals of the one below it
@settings(max_examples=20)
def test_meridians_of_a_waisted_mesh_run_the_other_way_in_its_koebe_polyhedron(n: int, steps: int, seed: int) -> None:
    profile = tangent_profile(n, steps, -0.9)
    profile = profile[(profile[:, 0] > 0.3).cumprod() == 1]
    assume(len(profile) > 3)
    image = shapes.rotational_mesh(profile, n)
    np.testing.assert_allclose(edge_distances(image), 1, atol=1e-13)
    lengths = np.random.default_rng(seed).uniform(0.5, 1.5, size=(len(profile) - 1, 1))
    waisted = np.concatenate([[[6.0, 0.0]], [6.0, 0.0] - np.cumsum(lengths * np.diff(profile, axis=0), axis=0)])
    assume(waisted[:, 0].min() > 0.5)
    mesh = shapes.rotational_mesh(waisted, n)
    pair = edge_offset_pair(mesh)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-12)
    sign = np.sign(np.sum(pair.gauss_image.vertices * image.vertices))
    np.testing.assert_allclose(sign * pair.gauss_image.vertices, image.vertices, atol=1e-10)
    on_meridian = np.diff(mesh.combinatorics.edges // len(profile), axis=1)[:, 0] == 0
    np.testing.assert_array_equal(sign * edge_factors(mesh, pair.gauss_image) < 0, on_meridian)
    assert np.median(np.einsum("ni,ni->n", pair.gauss_image.vertices, mesh.vertex_normals)) > 0  # S is outside


@given(st.integers(3, 9), seeds)
@settings(max_examples=20)
def test_an_end_of_an_edge_is_not_the_other_end_too(n: int, seed: int) -> None:
    """Upright edges of a prism are perpendicular to all others: S may also be flat, with its two rings in one."""
    cosine = np.cos(np.pi / n)
    prism = shapes.regular_prism(n)
    image = prism.with_vertices(prism.vertices * [1.0, 1.0, np.sqrt(1 - cosine**2)])
    mesh = element(image, seed)
    pair = edge_offset_pair(mesh)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-9)
    assert np.linalg.norm(pair.gauss_image.edge_vectors, axis=1).min() > 1e-3


def rings_of_a_cone(n: int, rings: int) -> Mesh:
    """Frusta one above the other: lines down the cone are straight, so that each ring of S has the same two places."""
    radii = np.arange(2.0, 2.0 + rings)
    return shapes.rotational_mesh(np.column_stack([radii, -0.7 * radii]), n)


def open_box() -> Mesh:
    box = shapes.box(1, 1.3, 0.8)
    return Mesh.from_faces(box.vertices, box.combinatorics.faces[1:])


@given(st.one_of(st.just(open_box()), st.builds(rings_of_a_cone, st.integers(5, 12), st.integers(3, 5))), seeds)
@settings(max_examples=60)
def test_of_several_images_rounding_does_not_choose(mesh: Mesh, seed: int) -> None:
    """Copies that are turned and numbered otherwise: the same S, without points for edges."""
    rng = np.random.default_rng(seed)
    turn, number = turning(seed), rng.permutation(mesh.n_vertices)
    positions = np.empty_like(mesh.vertices)
    positions[number] = mesh.vertices @ turn.T
    copy = Mesh.from_faces(positions, [number[list(face)] for face in mesh.combinatorics.faces])
    found, image = edge_offset_pair(copy).gauss_image, edge_offset_pair(mesh).gauss_image
    # rounding, over edges of M of a tenth of the largest or so
    np.testing.assert_allclose(found.vertices[number], image.vertices @ turn.T, atol=1e-12)
    assert np.linalg.norm(image.edge_vectors, axis=1).min() > 1e-3


@given(st.integers(2, 4), st.floats(1.1, 3), seeds)
@settings(max_examples=20)
def test_edges_that_do_not_distinguish_candidates_are_decided_by_others(half: int, ratio: float, seed: int) -> None:
    """A tube with a crown: its lower ring, perpendicular to the upright edges, is as good above as it is below."""
    n = 2 * half
    tube = shapes.regular_prism(n)
    radius = np.sin(np.pi / n)  # of the circles in the sides; their upper edges are tangents, between parallel tangents
    heights = np.concatenate([np.full(n, -radius), radius * np.where(np.arange(n) % 2, ratio, 1 / ratio)])
    positions = np.column_stack([tube.vertices[:, :2], heights])
    image = Mesh.from_faces(positions, tube.combinatorics.faces[:n])
    np.testing.assert_allclose(edge_distances(image), 1, atol=1e-13)
    mesh = element(image, seed)
    pair = edge_offset_pair(mesh)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-9)


@given(seeds, st.integers(0, 29))
@settings(max_examples=20)
def test_neighbours_with_two_edges_get_a_line_from_their_face(seed: int, edge: int) -> None:
    """Of all faces at the ends of an edge only one is kept: neither end says where the edge of S lies."""
    whole = boosted(solid("dodecahedron", "edge"), seed)
    c = whole.combinatorics
    kept = [f for k, f in enumerate(c.faces) if k == c.edge_faces[edge, 0] or not {*f} & {*c.edges[edge].tolist()}]
    image = Mesh.from_faces(whole.vertices, kept)
    assert (image.combinatorics.vertex_degrees[c.edges[edge]] == 2).all()
    mesh = element(image, seed)
    found = edge_offset_pair(mesh).gauss_image
    np.testing.assert_allclose(Pair(mesh, found).edge_distances, 1, atol=1e-9)
    # of the two tangents of the circle in that face, the one on the side of the others
    for factor in (2.0, -2.0):
        found = edge_offset_pair(image * factor).gauss_image
        used = image.combinatorics.is_used
        sign = np.sign(np.sum((found.vertices * image.vertices)[used]))
        np.testing.assert_allclose(sign * found.vertices[used], image.vertices[used], atol=1e-7)
