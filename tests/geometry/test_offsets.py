"""Circular, conical and edge offset meshes are recognised, and others measured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.exact_offsets import circularity, conicality, edge_axis_twist, edge_cone_deviation
from geometry.gauss import Pair
from geometry.gauss.distances import face_distances, vertex_distances
from geometry.mesh import Mesh, shapes
from geometry.parallel.edge_parallelity import parallelity

ROUNDING = 1e-13  # some hundred operations on numbers near 1
seeds = st.integers(0, 2**32 - 1)


def polygon(corners: FloatArray) -> Mesh:
    return Mesh.from_faces(corners, [list(range(len(corners)))])


def pyramid(spokes: FloatArray) -> Mesh:
    """Triangles between an apex at the origin, vertex 0, and neighbours counter-clockwise around it."""
    n = len(spokes)
    return Mesh.from_faces(np.concatenate([np.zeros((1, 3)), spokes]), [[0, 1 + k, 1 + (k + 1) % n] for k in range(n)])


def turned(points: FloatArray, seed: int) -> FloatArray:
    return points @ np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def spread_angles(rng: np.random.Generator, n: int) -> FloatArray:
    """n angles once around, neighbours less than half a turn and not too little apart."""
    return 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, size=n)) / n


# --- circular


@given(seeds, st.integers(3, 9), st.floats(1e-3, 1e3))
@settings(deadline=None)
def test_corners_on_a_circle_are_circular_wherever_they_are(seed: int, n: int, size: float) -> None:
    angles = spread_angles(np.random.default_rng(seed), n)
    corners = np.stack([np.cos(angles) + 2, np.sin(angles) - 3, 0 * angles], axis=1) * size
    assert circularity(polygon(turned(corners, seed)))[0] <= ROUNDING


@given(st.floats(0.2, 5.0))
@settings(deadline=None)
def test_a_rhombus_is_as_little_circular_as_its_diagonals_differ(height: float) -> None:
    rhombus = polygon(np.array([[1.0, 0, 0], [0, height, 0], [-1, 0, 0], [0, -height, 0]]))
    expected = abs(1 - height) / 2 / np.hypot(1, height)
    np.testing.assert_allclose(circularity(rhombus), expected, atol=ROUNDING)


def test_triangles_and_rotational_meshes_are_circular() -> None:
    for mesh in (shapes.icosahedron(), shapes.dome(9, 5), shapes.regular_prism(7), shapes.box(1, 2, 3)):
        assert circularity(mesh).max() <= ROUNDING


# --- conical


@given(seeds, st.integers(3, 7), st.floats(0.1, 1.2))
@settings(deadline=None)
def test_planes_tangent_to_a_cone_are_conical(seed: int, n: int, opening: float) -> None:
    angles = spread_angles(np.random.default_rng(seed), n)
    normals = np.stack([np.cos(angles), np.sin(angles), np.full(n, opening)], axis=1)
    spokes = np.cross(np.roll(normals, 1, axis=0), normals)  # the edge between two neighbouring faces
    spokes *= -np.sign(spokes[:, 2:]) / np.linalg.norm(spokes, axis=1, keepdims=True)
    found = conicality(pyramid(turned(spokes, seed)))
    assert found[0] <= ROUNDING * 100  # normals of slender triangles
    assert np.isnan(found[1:]).all()


@given(seeds)
@settings(deadline=None)
def test_four_faces_are_conical_where_opposite_angles_have_equal_sums(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles = spread_angles(rng, 4)
    spokes = np.stack([np.cos(angles), np.sin(angles), rng.uniform(-1.5, -0.5, size=4)], axis=1)
    spokes /= np.linalg.norm(spokes, axis=1, keepdims=True)
    between = np.arccos(np.sum(spokes * np.roll(spokes, -1, axis=0), axis=1))
    defect = abs(between[0] - between[1] + between[2] - between[3])
    found = float(conicality(pyramid(spokes))[0])
    assert found <= 0.2 * defect + ROUNDING  # at most 0.14 in twenty thousand of these
    assume(defect > 1e-3)
    assert found > 1e-6 * defect  # mostly a tenth, less only where the normals hardly determine a cone


def test_rotational_and_simple_meshes_are_conical_and_parallelograms_are_not() -> None:
    for mesh in (shapes.dome(9, 5), shapes.dodecahedron(), shapes.box(1, 2, 3), shapes.octahedron()):
        assert np.nanmax(conicality(mesh)) <= ROUNDING
    # a flat vertex, a fold: degenerate cones
    assert np.nanmax(conicality(shapes.grid(3, 3))) <= ROUNDING
    fold = shapes.grid(2, 2)
    fold = fold.with_vertices(fold.vertices + np.outer(np.abs(fold.vertices[:, 0] - 1), [0, 0, -0.3]))
    assert np.nanmax(conicality(fold)) <= ROUNDING
    u = np.linspace(-1, 1, 4)
    skew = shapes.translation_surface(
        np.stack([u, 0.5 * u, -(u**2)], axis=1), np.stack([0 * u, u, -0.5 * u**2], axis=1)
    )
    assert np.nanmin(conicality(skew)) > 1e-2


def test_nothing_is_asked_at_the_boundary() -> None:
    grid = shapes.grid(3, 3)
    np.testing.assert_array_equal(np.isnan(conicality(grid)), grid.combinatorics.is_boundary_vertex)


# --- edge offsets


@given(seeds, st.integers(4, 7), st.floats(-2.0, 2.0), st.booleans())
@settings(deadline=None)
def test_edges_on_either_half_of_a_cone_are_recognised(seed: int, n: int, steepness: float, both: bool) -> None:
    rng = np.random.default_rng(seed)
    angles = spread_angles(rng, n)
    spokes = np.stack([np.cos(angles), np.sin(angles), np.full(n, steepness)], axis=1)
    if both:
        spokes[:, 2] *= rng.choice([-1, 1], size=n)
    found = edge_cone_deviation(pyramid(turned(spokes * rng.uniform(0.5, 2, size=(n, 1)), seed)))
    assert found[0] <= ROUNDING
    assert np.isnan(found[1:]).all()  # neighbours have three edges


def test_many_edges_at_a_vertex_take_no_longer() -> None:
    angles = spread_angles(np.random.default_rng(0), 60)  # 2^59 ways to choose halves
    spokes = np.stack([np.cos(angles), np.sin(angles), 0.3 * np.where(np.arange(60) % 3, 1, -1)], axis=1)
    assert edge_cone_deviation(pyramid(spokes))[0] <= ROUNDING
    spokes[7, 2] *= 1.01
    assert edge_cone_deviation(pyramid(spokes))[0] > 1e-3


def test_koebe_polyhedra_have_edge_offsets_and_so_have_meshes_parallel_to_them() -> None:
    for mesh in (shapes.cube(), shapes.dodecahedron(), shapes.icosahedron(), shapes.box(1, 2, 3)):
        assert edge_axis_twist(mesh).max() <= ROUNDING
    assert edge_cone_deviation(shapes.octahedron()).max() <= ROUNDING
    assert edge_cone_deviation(shapes.icosahedron()).max() <= ROUNDING


def test_other_polyhedra_have_none() -> None:
    stretch = (1.0, 1.3, 0.8)
    icosahedron, dodecahedron = shapes.icosahedron(), shapes.dodecahedron()
    assert edge_cone_deviation(icosahedron.with_vertices(icosahedron.vertices * stretch)).max() > 1e-2
    assert edge_axis_twist(dodecahedron.with_vertices(dodecahedron.vertices * stretch)).max() > 1e-2


def test_vertices_with_less_than_three_edges_say_nothing() -> None:
    grid = shapes.grid(2, 1)
    corner = grid.combinatorics.vertex_degrees < 3
    np.testing.assert_array_equal(np.isnan(edge_axis_twist(grid)), corner[grid.combinatorics.edges].any(axis=1))


# --- distances of a Gauss image


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.1, -0.2, 0.3)])
def test_distances_of_a_box(shift: tuple[float, float, float]) -> None:
    mesh = shapes.box(3, 4, 5)
    cube = shapes.cube()
    image = mesh.with_vertices(cube.vertices + shift)
    np.testing.assert_allclose(vertex_distances(image), np.linalg.norm(cube.vertices + shift, axis=1))
    np.testing.assert_allclose(Pair(mesh, image).face_distances, 1 + mesh.face_normals @ shift)
    middles = image.vertices[mesh.combinatorics.edges].mean(axis=1)
    across = middles * (np.abs(mesh.edge_vectors) < 1)
    np.testing.assert_allclose(Pair(mesh, image).edge_distances, np.linalg.norm(across, axis=1))


@given(st.tuples(*[st.floats(-2, 2)] * 3))
@settings(deadline=None)
def test_edges_of_the_image_without_length_have_the_direction_of_the_mesh(point: tuple[float, float, float]) -> None:
    mesh = shapes.box(3, 4, 5)
    image = mesh.with_vertices(np.tile(point, (8, 1)))
    axis = np.abs(mesh.edge_vectors).argmax(axis=1)
    expected = np.linalg.norm(np.where(np.arange(3) == axis[:, None], 0.0, point), axis=1)
    np.testing.assert_allclose(Pair(mesh, image).edge_distances, expected, atol=1e-15)


@given(st.tuples(*[st.floats(-2, 2)] * 3))
def test_translates_of_a_gauss_image(vector: tuple[float, float, float]) -> None:
    mesh = shapes.dodecahedron()
    image = mesh.translated(vector)
    assert image.combinatorics is mesh.combinatorics
    np.testing.assert_allclose(vertex_distances(image), np.linalg.norm(mesh.vertices + vector, axis=1))
    # planes move by the part of the vector across them, and so do lines
    moved = Pair(mesh, image).face_distances - face_distances(mesh)
    np.testing.assert_allclose(moved, mesh.face_normals @ vector, atol=1e-14)
    middles = mesh.vertices[mesh.combinatorics.edges].mean(axis=1) + vector
    across = np.linalg.norm(np.cross(middles, mesh.edge_directions), axis=1)
    np.testing.assert_allclose(Pair(mesh, image).edge_distances, across, atol=1e-14)
    np.testing.assert_allclose(parallelity(mesh, image), 0, atol=1e-14)


def test_only_a_vector_translates() -> None:
    mesh = shapes.cube()
    for wrong in (1.0, [1.0, 2.0], mesh.vertices):
        with pytest.raises(MeshError, match="translated by a vector of 3 numbers"):
            mesh.translated(wrong)
    with pytest.raises(MeshError, match="must be finite"):
        mesh.translated([0.0, np.nan, 0.0])


def test_turned_over_image_has_negative_face_distances() -> None:
    np.testing.assert_allclose(Pair(shapes.cube(), shapes.cube() * -1.0).face_distances, -1.0)
