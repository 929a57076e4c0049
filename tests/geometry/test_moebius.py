"""Moebius transformations keep the unit sphere, its circles and angles, planes, lines and Koebe polyhedra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.gauss.distances import edge_distances, face_distances, vertex_distances
from geometry.mesh import solids
from geometry.spheres.lorentz import FORM, boost
from geometry.spheres.moebius import MoebiusTransformation
from geometry.spheres.stereographic import to_plane
from tests.geometry.parallel_elements import SOLIDS, boosted, opened, solid
from tests.geometry.test_lorentz import direction, lorentz_matrix, orthogonal, seeds

ROUNDING = 1e-12  # some hundred operations, times the square of gamma = 2.3 at speed 0.9
signs = st.sampled_from([1.0, -1.0])
speeds = st.floats(0, 0.9)


def transformation(seed: int, speed: float, determinant: float = 1.0) -> MoebiusTransformation:
    return MoebiusTransformation(lorentz_matrix(np.random.default_rng(seed), speed, determinant=determinant))


def on_sphere(seed: int, count: int) -> FloatArray:
    rng = np.random.default_rng(seed + 1)
    return np.array([direction(rng) for _ in range(count)])


def cross_ratio(points: FloatArray) -> complex:
    a, b, c, d = to_plane(points) @ [1, 1j]
    return complex((a - b) * (c - d) / ((a - d) * (c - b)))


@given(seeds, speeds, signs)
def test_the_sphere_stays_and_cross_ratios_on_it(seed: int, speed: float, determinant: float) -> None:
    """A map of the sphere is a Moebius transformation if and only if it keeps the cross-ratios, or conjugates them."""
    f, rng = transformation(seed, speed, determinant), np.random.default_rng(seed)
    points = solids.tetrahedron().vertices @ orthogonal(rng) + rng.uniform(-0.5, 0.5, size=(4, 3))  # well apart
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    images = f.map_points(points)
    np.testing.assert_allclose(np.linalg.norm(images, axis=1), 1, atol=ROUNDING)
    assert f.reverses_orientation == (determinant < 0)
    expected = cross_ratio(points) if determinant > 0 else np.conj(cross_ratio(points))
    assert cross_ratio(images) == pytest.approx(expected, rel=1e-9)  # near the north pole digits are lost


@given(seeds, speeds, signs)
def test_points_on_a_plane_go_to_the_image_of_the_plane(seed: int, speed: float, determinant: float) -> None:
    f, rng = transformation(seed, speed, determinant), np.random.default_rng(seed + 2)
    plane = np.append(direction(rng), rng.uniform(-0.9, 0.9))
    points = rng.uniform(-0.5, 0.5, size=(6, 3))
    sides = points @ plane[:3] - plane[3]
    points[:3] -= sides[:3, None] * plane[:3]
    image = f.map_planes([plane])[0]
    assert np.linalg.norm(image[:3]) == pytest.approx(1, abs=1e-15)
    inside = points[np.linalg.norm(points, axis=1) < 1]
    moved = f.map_points(inside) @ image[:3] - image[3]
    before = inside @ plane[:3] - plane[3]
    np.testing.assert_allclose(moved[np.abs(before) < 1e-15], 0, atol=ROUNDING)
    clear = np.abs(before) > 1e-3
    assert (np.sign(moved[clear]) == np.sign(before[clear])).all()


@given(seeds, speeds, signs)
def test_circles_keep_their_angles(seed: int, speed: float, determinant: float) -> None:
    """cos of the angle of two circles: (n . n' - h h') over sqrt((1 - h^2) (1 - h'^2))."""

    def cosine(planes: FloatArray) -> float:
        n, h = planes[:, :3], planes[:, 3]
        return float((n[0] @ n[1] - h[0] * h[1]) / np.sqrt((1 - h[0] ** 2) * (1 - h[1] ** 2)))

    planes = np.column_stack([on_sphere(seed, 2), np.random.default_rng(seed).uniform(-0.9, 0.9, size=2)])
    images = transformation(seed, speed, determinant).map_planes(planes)
    assert cosine(images) == pytest.approx(cosine(planes), abs=1e-9)  # 1 - h^2 rounds where circles become small


@given(st.sampled_from(sorted(SOLIDS)), seeds, st.floats(0, 0.9), signs)
def test_koebe_polyhedra_stay_koebe_polyhedra(name: str, seed: int, portion: float, determinant: float) -> None:
    image = opened(solid(name, "edge"), seed)
    furthest = float(vertex_distances(image).max())
    f = transformation(seed, portion / furthest, determinant)
    moved = f.map_mesh(image)
    np.testing.assert_allclose(edge_distances(moved), 1, atol=1e-11)
    assert moved.planarity.max() <= 1e-11
    planes = f.map_planes(np.column_stack([image.face_normals, face_distances(image)]))
    np.testing.assert_allclose(moved.face_normals, planes[:, :3], atol=1e-9)  # the outside stays outside
    np.testing.assert_allclose(face_distances(moved), planes[:, 3], atol=1e-9)


@given(seeds)
def test_a_boost_is_the_projective_map_written_out(seed: int) -> None:
    mesh = solids.cube() * 0.5
    rng = np.random.default_rng(seed)
    v = direction(rng) * rng.uniform(0, 0.5)
    expected = boosted(mesh, seed)  # draws the same direction and speed
    np.testing.assert_allclose(MoebiusTransformation.boost(v).map_mesh(mesh).vertices, expected.vertices, atol=1e-14)


@given(seeds, speeds, signs, signs)
def test_group_laws(seed: int, speed: float, one: float, two: float) -> None:
    f, g = transformation(seed, speed, one), transformation(seed + 1, speed, two)
    points = on_sphere(seed, 5) * 0.9
    np.testing.assert_allclose((f @ g).map_points(points), f.map_points(g.map_points(points)), atol=1e-10)
    np.testing.assert_allclose(f.inverse().map_points(f.map_points(points)), points, atol=1e-10)
    np.testing.assert_allclose((f @ MoebiusTransformation.identity()).matrix, f.matrix, atol=1e-15 * f.matrix[3, 3])
    np.testing.assert_allclose(MoebiusTransformation(-f.matrix).matrix, f.matrix, rtol=0)
    planes = np.column_stack([on_sphere(seed, 2), [0.3, -0.5]])
    np.testing.assert_allclose((f @ g).map_planes(planes), f.map_planes(g.map_planes(planes)), atol=1e-10)


def test_turning_over_and_reflections_keep_the_outside_outside() -> None:
    cube = solids.cube()
    for matrix in (-FORM, np.diag([1.0, -1.0, 1.0, 1.0])):
        f = MoebiusTransformation(matrix)
        assert f.reverses_orientation
        assert face_distances(f.map_mesh(cube)).min() == pytest.approx(1)


@pytest.mark.parametrize("speed", [0.6, 1 / np.sqrt(3)])
def test_a_vertex_that_goes_through_infinity_is_named(speed: float) -> None:
    """Vertices of the tetrahedron have distance sqrt(3): those across from a velocity of 1/sqrt(3) go to infinity."""
    mesh = solids.tetrahedron()
    v = -speed * mesh.vertices[2] / np.sqrt(3)
    with pytest.raises(GeometryError, match="vertex 2 goes to infinity") as caught:
        MoebiusTransformation.boost(v).map_mesh(mesh)
    assert caught.value.elements == (2,)
    weight = (1 - speed * np.sqrt(3)) / (1 + speed * np.sqrt(3))
    assert caught.value.value == pytest.approx(weight, abs=1e-15)
    assert caught.value.bound == 1e-9


def test_a_plane_that_goes_to_infinity_is_named() -> None:
    f = MoebiusTransformation.boost([0.5, 0, 0])  # takes the plane x = -2 to infinity
    with pytest.raises(GeometryError, match="plane 1 goes to infinity") as caught:
        f.map_planes([[1, 0, 0, 0.5], [1, 0, 0, -2], [0, 1, 0, 0]])
    assert caught.value.elements == (1,)
    np.testing.assert_allclose(f.map_planes([[1, 0, 0, -0.5]]), [[1, 0, 0, 0]], atol=1e-15)  # -0.5 to the origin


def test_far_points_stay_where_nothing_goes_to_infinity() -> None:
    far = np.array([[1e12, 0, 0], [0, -1e15, 3]])
    np.testing.assert_array_equal(MoebiusTransformation.identity().map_points(far), far)
    planes = np.array([[1.0, 0, 0, 1e12]])
    np.testing.assert_array_equal(MoebiusTransformation.identity().map_planes(planes), planes)


def test_wrong_input_is_refused() -> None:
    f = MoebiusTransformation(boost([0.1, 0.2, 0.3]))
    with pytest.raises(GeometryError, match="normal of plane 0"):
        f.map_planes([[1, 1, 0, 0.5]])
    with pytest.raises(GeometryError, match="shape"):
        f.map_points([0, 0, 0])
    with pytest.raises(GeometryError, match="finite"):
        f.map_points([[0, np.inf, 0]])
    with pytest.raises(GeometryError, match="differs"):
        MoebiusTransformation(np.diag([1, 1, 1, 2]))
