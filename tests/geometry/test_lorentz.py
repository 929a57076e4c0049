"""Lorentz matrices keep the form diag(1, 1, 1, -1); boosts add velocities; drift is taken off, others refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.spheres.lorentz import FORM, boost, deviation, inverse, orthonormalised, product, rotation

ROUNDING = 1e-14  # deviations are over the square of the norm; some dozen operations
REST = np.array([0.0, 0.0, 0.0, 1.0])
seeds = st.integers(0, 2**32 - 1)
speeds = st.floats(0, 0.999)


def direction(rng: np.random.Generator) -> FloatArray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def orthogonal(rng: np.random.Generator, determinant: float = 1.0) -> FloatArray:
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q)) * determinant


def lorentz_matrix(rng: np.random.Generator, speed: float, *, determinant: float = 1.0) -> FloatArray:
    """Any Lorentz matrix that keeps the sign of the last number is such a product."""
    first, second = orthogonal(rng), orthogonal(rng, determinant)
    return rotation(first) @ boost(speed * direction(rng)) @ rotation(second)


@given(seeds, speeds)
def test_a_boost_is_symmetric_keeps_the_form_and_moves_rest_to_its_velocity(seed: int, speed: float) -> None:
    v = speed * direction(np.random.default_rng(seed))
    matrix = boost(v)
    assert deviation(matrix) <= ROUNDING
    np.testing.assert_array_equal(matrix, matrix.T)
    moved = matrix @ REST
    np.testing.assert_allclose(moved[:3] / moved[3], v, atol=1e-15)
    np.testing.assert_allclose(moved[3], 1 / np.sqrt(1 - v @ v), rtol=1e-10)  # 1 - v v rounds at 0.999
    np.testing.assert_array_equal(boost(-v), inverse(matrix))


@given(seeds, st.floats(-0.99, 0.99), st.floats(-0.99, 0.99))
def test_velocities_on_a_line_add_as_einstein_says(seed: int, one: float, two: float) -> None:
    e = direction(np.random.default_rng(seed))
    both = boost(one * e) @ boost(two * e)
    np.testing.assert_allclose(both, boost((one + two) / (1 + one * two) * e), rtol=0, atol=1e-10 * both[3, 3])


@given(seeds, speeds)
def test_light_along_a_boost_is_stretched_and_what_is_across_stays(seed: int, speed: float) -> None:
    rng = np.random.default_rng(seed)
    e = direction(rng)
    matrix = boost(speed * e)
    doppler = np.sqrt((1 + speed) / (1 - speed))
    for sign, factor in ((1, doppler), (-1, 1 / doppler)):
        light = np.append(sign * e, 1.0)
        np.testing.assert_allclose(matrix @ light, factor * light, atol=1e-13 * doppler)
    across = np.append(np.cross(e, rng.normal(size=3)), 0.0)
    np.testing.assert_allclose(matrix @ across, across, atol=1e-13 * doppler)


@given(seeds, speeds, st.sampled_from([1.0, -1.0]))
def test_products_and_inverses_are_lorentz_matrices(seed: int, speed: float, determinant: float) -> None:
    rng = np.random.default_rng(seed)
    matrix = lorentz_matrix(rng, speed, determinant=determinant)
    assert deviation(matrix) <= ROUNDING
    size = np.linalg.norm(matrix, 2) ** 2
    np.testing.assert_allclose(matrix @ inverse(matrix), np.eye(4), atol=ROUNDING * size)
    np.testing.assert_allclose(np.linalg.det(matrix), determinant, atol=ROUNDING * size)
    x, y = rng.normal(size=(2, 5, 4))
    kept = product(x @ matrix.T, y @ matrix.T)
    np.testing.assert_allclose(kept, product(x, y), atol=100 * ROUNDING * size)
    np.testing.assert_allclose(product(x, y), np.diag(x @ FORM @ y.T), atol=1e-14)


@given(seeds, st.floats(0, 0.9), st.sampled_from([1.0, -1.0]), st.sampled_from([1.0, -1.0]))
def test_drift_is_taken_off_and_nothing_else_changed(seed: int, speed: float, sign: float, determinant: float) -> None:
    rng = np.random.default_rng(seed)
    matrix = sign * lorentz_matrix(rng, speed, determinant=determinant)
    drifted = matrix * (1 + 1e-10 * rng.uniform(-1, 1, size=(4, 4)))
    assert deviation(drifted) > 1e-12
    mended = orthonormalised(drifted)
    assert deviation(mended) <= ROUNDING
    size = np.linalg.norm(matrix, 2) ** 3  # what is rotated is boosted twice on the way
    np.testing.assert_allclose(mended, matrix, atol=1e-9 * size)
    np.testing.assert_array_equal(orthonormalised(mended), mended)


def test_thousands_of_steps_stay_in_the_group() -> None:
    step = boost([0.01, 0, 0]) @ rotation([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]])  # a screw: it leads far away
    free = kept = np.eye(4)
    for _ in range(1000):
        free, kept = free @ step, orthonormalised(kept @ step)
    assert kept[3, 3] > 1e4
    assert deviation(kept) <= ROUNDING
    np.testing.assert_allclose(kept, free, atol=1e-9 * kept[3, 3])


@pytest.mark.parametrize("velocity", [[1, 0, 0], [0.6, 0.6, 0.6], [0, -3, 0]])
def test_boosts_at_or_beyond_the_cone_are_refused(velocity: list[float]) -> None:
    with pytest.raises(GeometryError, match="at or beyond the cone") as caught:
        boost(velocity)
    assert caught.value.value == pytest.approx(np.linalg.norm(velocity))
    assert caught.value.bound == 1.0


@pytest.mark.parametrize("velocity", [[np.nan, 0, 0], [0, 0], [[0, 0, 0]]])
def test_a_velocity_is_three_finite_numbers(velocity: list[float]) -> None:
    with pytest.raises(GeometryError, match="velocity"):
        boost(velocity)


@pytest.mark.parametrize(
    "matrix",
    [
        2 * np.eye(4),
        np.zeros((4, 4)),
        np.eye(4) + 1e-6 * np.eye(4)[::-1],
        np.diag([1, 1, 1, 1.001]),
        1e200 * np.eye(4),
        1e-200 * np.eye(4),
    ],
)
@pytest.mark.filterwarnings("error")
def test_other_matrices_are_refused(matrix: FloatArray) -> None:
    with pytest.raises(GeometryError, match=r"A\^T J A differs") as caught:
        orthonormalised(matrix)
    assert caught.value.value is not None
    assert caught.value.bound == 1e-9
    assert caught.value.value > caught.value.bound


def test_what_is_no_rotation_is_refused() -> None:
    with pytest.raises(GeometryError, match="differs"):
        rotation(np.diag([1, 1, 2]))
    with pytest.raises(GeometryError, match="shape"):
        rotation(np.eye(4))
