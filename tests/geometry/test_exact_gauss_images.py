"""S is recovered from M alone: Proposition 2, on meshes M taken at random from P(S) for a known S."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError
from geometry.exact_offsets import circularity, edge_offset_pair, exact_pairs, face_offset_pair, vertex_offset_pair
from geometry.gauss.distances import vertex_distances
from geometry.mesh import Mesh, shapes
from geometry.parallel.edge_parallelity import parallelity
from tests.geometry.parallel_elements import SIMPLE, SOLIDS, boosted, element, solid

seeds = st.integers(0, 2**32 - 1)
ROUNDING = 1e-10  # what planes of 1e-13 and edges of a hundredth of the mean leave of numbers near 1

# --- the solids


@pytest.mark.parametrize("name", SOLIDS)
def test_each_solid_has_vertex_and_edge_offsets_and_face_offsets_where_it_is_simple_or_platonic(name: str) -> None:
    mesh = SOLIDS[name] * 7.0
    pairs = exact_pairs(mesh, tolerance=1e-13)
    assert set(pairs) == {"vertex", "edge"} | ({"face"} if name in {*SIMPLE, "octahedron", "icosahedron"} else set())
    np.testing.assert_allclose(pairs["edge"].gauss_image.vertices, solid(name, "edge").vertices, atol=1e-13)
    np.testing.assert_allclose(pairs["vertex"].vertex_distances, 1, atol=1e-13)
    # nearest to the normals: no vertex of a solid is more than 8 degrees off
    assert np.einsum("ni,ni->n", pairs["vertex"].gauss_image.vertices, mesh.vertex_normals).min() > 0.99
    if "face" in pairs:
        np.testing.assert_allclose(pairs["face"].face_distances, 1, atol=1e-13)
    for pair in pairs.values():
        assert pair.gauss_image.combinatorics is mesh.combinatorics
        assert parallelity(mesh, pair.gauss_image).max() <= 1e-13


# --- random elements of P(S)


@pytest.mark.parametrize("name", ["dodecahedron", "truncated_icosahedron", "truncated_cube", "regular_prism"])
@given(seed=seeds)
@settings(max_examples=10)
def test_an_inscribed_mesh_is_recovered_where_odd_faces_determine_it(name: str, seed: int) -> None:
    given_image = shapes.regular_prism(5) if name == "regular_prism" else solid(name, "vertex")
    image = boosted(given_image * (1 / vertex_distances(given_image)[0]), seed)
    mesh = element(image, seed)
    found = vertex_offset_pair(mesh).gauss_image
    np.testing.assert_allclose(vertex_distances(found), 1, atol=1e-9)
    assert parallelity(mesh, found).max() <= 1e-11
    if name == "dodecahedron":  # the others leave a circle
        sign = np.sign(np.sum(found.vertices * image.vertices))
        np.testing.assert_allclose(sign * found.vertices, image.vertices, atol=ROUNDING * 100)


@given(seeds)
@settings(max_examples=20)
def test_a_disc_of_circular_quads_has_a_vertex_offset_near_its_normals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = (np.cumsum(rng.uniform(0.1, 0.3, size=n)) for n in (6, 5))
    plane = shapes.translation_surface(np.stack([x, 0 * x, 0 * x], axis=1), np.stack([0 * y, y, 0 * y], axis=1))
    squares = np.sum(plane.vertices**2, axis=1, keepdims=True)
    image = plane.with_vertices((2 * plane.vertices + (squares - 1) * [0.0, 0.0, 1.0]) / (squares + 1))
    assert circularity(image).max() < 1e-13  # stereographic projection: circles stay circles
    mesh = element(image, seed)
    found = vertex_offset_pair(mesh).gauss_image
    np.testing.assert_allclose(vertex_distances(found), 1, atol=1e-9)
    assert parallelity(mesh, found).max() <= 1e-11
    nearness = np.sum(found.vertices * mesh.vertex_normals)
    assert nearness >= abs(np.sum(image.vertices * mesh.vertex_normals)) - 1e-6


@pytest.mark.parametrize("name", SIMPLE)
@given(seed=seeds)
@settings(max_examples=6)
def test_the_faces_of_simple_meshes_have_offsets(name: str, seed: int) -> None:
    image = boosted(solid(name, "edge"), seed)
    mesh = element(image, seed, size=0.1, centre=1.0)
    assume(np.einsum("fi,fi->f", mesh.face_normals, image.face_normals).min() > 0)  # sides are those of M
    pair = face_offset_pair(mesh)
    np.testing.assert_allclose(pair.face_distances, 1, atol=1e-9)
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-11


@given(seeds, st.integers(5, 12))
@settings(max_examples=20)
def test_conical_meshes_of_either_curvature_give_their_face_offset(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    slopes = np.cumsum(rng.uniform(0.1, 0.3, size=6)) - 0.8
    heights = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 0.6, size=6))])
    radii = 2 + np.concatenate([[0.0], np.cumsum(slopes * np.diff(heights))])
    mesh = shapes.rotational_mesh(np.stack([radii, heights], axis=1), n)  # narrowest in its middle
    pair = face_offset_pair(mesh)
    np.testing.assert_allclose(pair.face_distances, 1, atol=1e-12)
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-12
    # the cones of the two rings at a parallel meet where both planes are at distance 1: closed form at inner vertices
    lean = np.arctan(np.cos(np.pi / n) * slopes)  # of the face normals below the horizon
    middle = (lean[1:] + lean[:-1]) / 2
    expected = np.cos(middle) / np.cos((lean[1:] - lean[:-1]) / 2) / np.cos(np.pi / n)
    found_radii = np.linalg.norm(pair.gauss_image.vertices[:, :2], axis=1).reshape(n, 7)[:, 1:-1]
    np.testing.assert_allclose(found_radii, np.tile(expected, (n, 1)), atol=1e-12)


# --- meshes with a choice


def test_where_many_s_are_exact_it_is_near_the_normals() -> None:
    np.testing.assert_allclose(
        edge_offset_pair(shapes.box(1, 2, 3)).gauss_image.vertices, shapes.cube().vertices / 2**0.5
    )
    for found in exact_pairs(shapes.grid(4, 3)).values():
        np.testing.assert_allclose(found.gauss_image.vertices, np.tile([0.0, 0.0, 1.0], (20, 1)), atol=1e-13)


def test_parts_have_each_their_own() -> None:
    one, other = SOLIDS["dodecahedron"], SOLIDS["truncated_cube"] * 0.1
    faces = [face.tolist() for face in one.combinatorics.faces] + [
        [v + one.n_vertices for v in f] for f in other.combinatorics.faces
    ]
    both = Mesh.from_faces(np.concatenate([one.vertices, other.vertices + 5]), faces)
    expected = np.concatenate([solid("dodecahedron", "edge").vertices, solid("truncated_cube", "edge").vertices])
    np.testing.assert_allclose(edge_offset_pair(both).gauss_image.vertices, expected, atol=1e-12)
    assert set(exact_pairs(both)) == {"vertex", "edge", "face"}


@given(seeds, st.floats(-3, 3), st.tuples(*[st.floats(-20, 20)] * 3))
@settings(max_examples=20)
def test_size_and_place_do_not_matter_and_attitude_turns_with_it(
    seed: int, decades: float, shift: tuple[float, float, float]
) -> None:
    mesh = shapes.hexagonal_paraboloid(4, 3)
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn = q * np.linalg.det(q)
    moved = mesh.with_vertices((mesh.vertices @ turn + shift) * 10.0**decades)
    for kind in (vertex_offset_pair, face_offset_pair):
        # the choice near the normals rounds by rounding over LEAST_GAP squared
        np.testing.assert_allclose(kind(moved).gauss_image.vertices, kind(mesh).gauss_image.vertices @ turn, atol=1e-7)


# --- what has none


def parallelograms() -> Mesh:
    """Neither circular nor conical nor parallel to a Koebe polyhedron."""
    u = np.linspace(-1, 1, 5)
    return shapes.translation_surface(
        np.stack([u, 0.5 * u, -0.5 * u**2], axis=1), np.stack([0 * u, u, -0.3 * u**2 + 0.05 * u**3], axis=1)
    )


def test_for_a_mesh_without_any_the_place_is_named() -> None:
    mesh = parallelograms()
    assert exact_pairs(mesh) == {}
    with pytest.raises(
        GeometryError, match=r"no vertex offset: vertex \d+ .* least circular face is \d+.*make_circular"
    ):
        vertex_offset_pair(mesh)
    with pytest.raises(GeometryError, match=r"no edge offset is found: edge \d+ from vertex .* a weight for edges"):
        edge_offset_pair(mesh)
    with pytest.raises(
        GeometryError, match=r"no face offset: face \d+ .* least conical vertex is \d+.*make_conical"
    ) as e:
        face_offset_pair(mesh)
    assert e.value.bound == 1e-9
    assert e.value.value is not None
    assert e.value.value > 1e-3


def test_a_mesh_has_a_vertex_offset_just_if_its_quads_are_circular() -> None:
    mesh = shapes.dome(8, 4)
    assert set(exact_pairs(mesh)) == {"vertex", "face"}
    stretched = mesh.with_vertices(mesh.vertices * [1.0, 1.001, 1.0])  # planar still
    assert circularity(stretched).max() > 1e-5
    assert exact_pairs(stretched) == {}


def test_a_larger_tolerance_takes_what_is_nearly_exact() -> None:
    mesh = shapes.dome(40, 20)
    with pytest.raises(GeometryError, match="no edge offset is found"):
        edge_offset_pair(mesh)
    pair = edge_offset_pair(mesh, tolerance=1e-2)
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-11  # parallel all the same
    assert 1e-5 < np.abs(pair.edge_distances - 1).max() <= 1e-2


def test_faces_that_are_not_planar_and_tolerances_that_are_none_are_refused() -> None:
    mesh = parallelograms()
    vertices = mesh.vertices.copy()
    vertices[7, 2] += 1e-3
    for kind in (vertex_offset_pair, edge_offset_pair, face_offset_pair, exact_pairs):
        with pytest.raises(GeometryError, match=r"is off its plane by .* planarise the mesh first"):
            kind(mesh.with_vertices(vertices))
        for tolerance in (0.0, np.nan):
            with pytest.raises(GeometryError, match="it must be above 0"):
                kind(mesh, tolerance=tolerance)
