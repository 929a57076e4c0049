"""Laguerre transformations keep contact and tangential distance of spheres, planes and cones, and are a group."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.spheres.laguerre import LaguerreTransformation
from geometry.spheres.lorentz import product
from geometry.spheres.oriented_cones import VertexCones
from tests.geometry.test_lorentz import direction, lorentz_matrix, seeds

L = LaguerreTransformation
EXACT = 1e-11  # some hundred operations on numbers below a hundred, boosts of gamma below 2.3
speeds = st.floats(0, 0.9)


def transformation(seed: int, speed: float = 0.5) -> LaguerreTransformation:
    """Any: of either determinant, with and without turning over."""
    rng = np.random.default_rng(seed)
    sign, determinant = rng.choice([-1.0, 1.0], size=2)
    return L(sign * lorentz_matrix(rng, speed, determinant=determinant), rng.normal(size=4))


def spheres(seed: int, count: int = 5) -> FloatArray:
    return np.random.default_rng(seed + 1).normal(size=(count, 4)) * 2


def planes(seed: int, count: int = 5) -> FloatArray:
    rng = np.random.default_rng(seed + 2)
    return np.array([np.append(direction(rng), rng.normal()) for _ in range(count)])


def cones(seed: int, count: int = 5) -> VertexCones:
    rng = np.random.default_rng(seed + 3)
    return VertexCones.of_revolution(rng.normal(size=(count, 3)), planes(seed)[:, :3], rng.uniform(1.0, 1.5, count))


def contact(spheres: FloatArray, planes: FloatArray) -> FloatArray:
    """How far spheres are from touching planes, paired."""
    return np.asarray(np.einsum("ki,ki->k", planes[:, :3], spheres[:, :3]) + spheres[:, 3] - planes[:, 3])


# --- spheres, planes, cones


@given(seeds, speeds)
def test_tangential_distances_are_kept(seed: int, speed: float) -> None:
    x = spheres(seed)
    y = transformation(seed, speed).map_spheres(x)
    before, after = (product(s[1:] - s[:-1], s[1:] - s[:-1]) for s in (x, y))
    np.testing.assert_allclose(after, before, atol=EXACT * 100)


def test_the_lorentz_product_is_the_squared_tangential_distance() -> None:
    """Two circles of radius 3 and 1 a distance 7 apart: an outer tangent has length sqrt(49 - 4) between them."""
    x, y = np.array([0, 0, 0, 3.0]), np.array([7.0, 0, 0, 1.0])
    assert product(y - x, y - x) == pytest.approx(45)
    assert product(y * [1, 1, 1, -1] - x, y * [1, 1, 1, -1] - x) == pytest.approx(49 - 16)  # an inner one


@given(seeds, speeds)
def test_contact_of_spheres_and_planes_is_kept(seed: int, speed: float) -> None:
    x, p = spheres(seed), planes(seed)
    x[:, 3] -= contact(x, p)
    x[0, 3] += 0.5  # the first one does not touch
    f = transformation(seed, speed)
    images = f.map_planes(p)
    np.testing.assert_allclose(np.linalg.norm(images[:, :3], axis=1), 1, atol=1e-15)
    off = contact(f.map_spheres(x), images)
    np.testing.assert_allclose(off[1:], 0, atol=EXACT)
    assert abs(off[0]) > 1e-3


@given(seeds, speeds)
def test_cones_touch_what_they_touched(seed: int, speed: float) -> None:
    """The cone through the images of two spheres is the image of the cone, and touches the images of its planes."""
    k, f = cones(seed), transformation(seed, speed / 1.2)  # poles are shorter than 1 / sin(1) < 1.2
    image = f.map_cones(k)
    again = VertexCones.touching(f.map_spheres(k.spheres(0.5)), f.map_spheres(k.spheres(-2)))
    np.testing.assert_allclose(again.apices, image.apices, atol=1e-9)
    np.testing.assert_allclose(again.poles, image.poles, atol=1e-9)

    e = np.cross(k.axes, direction(np.random.default_rng(seed)))
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    sines, cosines = np.sin(k.half_angles)[:, None], np.cos(k.half_angles)[:, None]
    normals = sines * k.axes + cosines * e
    touching = f.map_planes(np.column_stack([normals, np.einsum("ki,ki->k", normals, k.apices)]))
    np.testing.assert_allclose(np.einsum("ki,ki->k", touching[:, :3], image.apices), touching[:, 3], atol=EXACT * 10)
    np.testing.assert_allclose(np.einsum("ki,ki->k", touching[:, :3], image.poles), 1, atol=EXACT * 10)


@given(seeds)
def test_cones_from_apex_axis_and_angle_and_from_two_spheres(seed: int) -> None:
    k = cones(seed)
    angles = np.random.default_rng(seed + 3)
    angles.normal(size=(5, 3))
    np.testing.assert_allclose(k.half_angles, angles.uniform(1.0, 1.5, 5), atol=1e-14)
    np.testing.assert_allclose(k.axes, planes(seed)[:, :3], atol=1e-15)
    again = VertexCones.touching(k.spheres(1.0), k.spheres(0.25))
    np.testing.assert_allclose(again.apices, k.apices, atol=1e-13)
    np.testing.assert_allclose(again.poles, k.poles, atol=1e-13)


# --- the group


@given(seeds, seeds, speeds)
def test_composition_and_inverse(one: int, two: int, speed: float) -> None:
    f, g, h = transformation(one, speed), transformation(two, speed), transformation(one + 1, speed)
    x, p = spheres(one), planes(one)
    size = 1e-11 * np.abs(f.matrix).max() * np.abs(g.matrix).max()
    np.testing.assert_allclose((f @ g).map_spheres(x), f.map_spheres(g.map_spheres(x)), atol=size)
    np.testing.assert_allclose((f @ g).map_planes(p), f.map_planes(g.map_planes(p)), atol=size)
    np.testing.assert_allclose(f.inverse().map_spheres(f.map_spheres(x)), x, atol=100 * size)
    np.testing.assert_allclose(f.inverse().map_planes(f.map_planes(p)), p, atol=100 * size)
    np.testing.assert_allclose(((f @ g) @ h).matrix, (f @ (g @ h)).matrix, atol=100 * size)
    np.testing.assert_allclose(((f @ g) @ h).shift, (f @ (g @ h)).shift, atol=100 * size)
    np.testing.assert_array_equal((f @ L.identity()).map_spheres(x), f.map_spheres(x))


def test_a_boost_leaves_planes_across_it_and_turns_others_away() -> None:
    f = L.boost([0, 0, 0.6])  # gamma = 1.25
    images = f.map_planes([[0, 0, 1, 2.0], [0, 0, -1, 2.0], [1, 0, 0, 2.0]])
    np.testing.assert_allclose(images[:2], [[0, 0, 1, 4.0], [0, 0, -1, 1.0]], atol=1e-15)
    np.testing.assert_allclose(images[2], [0.8, 0, -0.6, 1.6], atol=1e-15)


# --- what is refused


def test_cones_that_are_none_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"pole of cone 1 has length 0\.5"):
        VertexCones(np.zeros((2, 3)), np.array([[0, 0, 1.0], [0, 0.5, 0]]))
    with pytest.raises(GeometryError, match="cylinder"):
        VertexCones.touching([[0, 0, 0, 1.0]], [[3, 0, 0, 1.0]])
    with pytest.raises(GeometryError, match="pole of cone 0"):
        VertexCones.touching([[0, 0, 0, 5.0]], [[1, 0, 0, 1.0]])  # one sphere within the other
    with pytest.raises(GeometryError, match="cone 0 has half-angle 2"):
        VertexCones.of_revolution(np.zeros((1, 3)), [[0, 0, 1.0]], [2.0])


def test_spheres_of_cones_have_one_finite_radius_each() -> None:
    cones = VertexCones(np.zeros((2, 3)), [[0, 0, 2], [0, 3, 0]])
    np.testing.assert_array_equal(cones.spheres(1.0), [[0, 0, -2, 1], [0, -3, 0, 1]])
    np.testing.assert_array_equal(cones.spheres([0, 1]), [[0, 0, 0, 0], [0, -3, 0, 1]])
    for radii in ([1.0, 2.0, 3.0], np.nan, [np.inf, 1.0]):
        with pytest.raises(GeometryError, match="the array of radii has"):
            cones.spheres(radii)


def test_wrong_matrices_and_planes_are_refused() -> None:
    with pytest.raises(GeometryError, match="differs"):
        L(2 * np.eye(4), np.zeros(4))
    with pytest.raises(GeometryError, match="shift"):
        L(np.eye(4), np.zeros(3))
    with pytest.raises(GeometryError, match="normal of plane 0"):
        L.identity().map_planes([[2, 0, 0, 1]])
    with pytest.raises(GeometryError, match="at or beyond the cone"):
        L.boost([0, 1.5, 0])
