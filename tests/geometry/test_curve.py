"""The curve through given points: interpolation, corners, and the nearest points against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.surface.curve import Curve

seeds = st.integers(0, 2**32 - 1)


def wave(k: int = 30) -> FloatArray:
    """Points of a smooth space curve, unevenly spaced."""
    s = 5 * np.linspace(0, 1, k) ** 1.3
    return np.stack([s, np.sin(2 * s), np.cos(s)], axis=1)


def circle(k: int) -> FloatArray:
    angles = 2 * np.pi / k * np.arange(k)
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(k)], axis=1)


SQUARE = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
CURVES = {
    "open": Curve.through(wave(), closed=False),
    "closed": Curve.through(circle(12) * [3, 2, 1], closed=True),
    "two points": Curve.through(SQUARE[:2], closed=False),
    "three points": Curve.through(SQUARE[:3] * [1, 0.2, 0], closed=False),
    "square": Curve.through(SQUARE, closed=True),
    "open with corners": Curve.through(np.concatenate([wave(9), wave(9)[-1] + [[0, 0, 1], [0, 0, 2]]]), closed=False),
    "one corner": Curve.through(np.concatenate([circle(16)[:13], [[1.0, -1.0, 0.0]]]), closed=True),
}


def dense(curve: Curve, n: int = 2000) -> FloatArray:
    """n + 1 points on each span, ends included."""
    powers = np.linspace(0, 1, n + 1)[:, None] ** [3, 2, 1, 0]
    return np.einsum("tp,spi->sti", powers, curve.spans).reshape(-1, 3)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
@given(seed=seeds, far=st.floats(-3, 3))
@settings(max_examples=20)
def test_no_point_of_the_curve_is_nearer_than_the_foot(curve: Curve, seed: int, far: float) -> None:
    points = 10.0**far * np.random.default_rng(seed).normal(size=(40, 3))
    feet, tangents = curve.closest(points)
    found = np.linalg.norm(points - feet, axis=1)
    by_force = KDTree(dense(curve)).query(points)[0]
    assert (found <= by_force * (1 + 1e-12)).all()
    # the next sample is half a step of 1/2000 away along spans of lengths up to 2
    np.testing.assert_array_less(by_force - found, 1e-3)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, rtol=1e-12)
    again = curve.closest(feet)[0]
    np.testing.assert_allclose(again, feet, atol=1e-12)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_the_way_to_the_foot_is_across_the_tangent_but_at_ends_and_corners(curve: Curve) -> None:
    points = np.random.default_rng(1).normal(size=(500, 3)) * 2
    feet, tangents = curve.closest(points)
    knots = np.concatenate([curve.spans[:, 3], curve.spans[-1:].sum(axis=1)])
    special = knots[curve.corners] if curve.closed else knots[[0, -1, *curve.corners]]
    smooth = np.ones(500, bool) if len(special) == 0 else KDTree(special).query(feet)[0] > 1e-9
    away = points - feet
    along = np.einsum("ni,ni->n", away, tangents)
    assert smooth.sum() > 50
    # rounding of coordinates up to 10
    np.testing.assert_allclose(along[smooth], 0.0, atol=1e-13)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_spans_meet_and_are_smooth_but_at_corners(curve: Curve) -> None:
    a, b, c, d = curve.spans.swapaxes(0, 1)
    ends, at_ends = a + b + c + d, 3 * a + 2 * b + c
    joints = np.arange(len(a) if curve.closed else len(a) - 1)
    after = (joints + 1) % len(a)
    np.testing.assert_allclose(ends[joints], d[after], atol=1e-13)
    turns = np.linalg.norm(np.cross(_unit(at_ends[joints]), _unit(c[after])), axis=1)
    is_corner = np.isin(after, curve.corners)
    np.testing.assert_allclose(turns[~is_corner], 0.0, atol=1e-12)
    assert (turns[is_corner] > 0.5).all()


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_points_of_the_curve_are_their_own_feet(curve: Curve) -> None:
    points = dense(curve, 97)
    np.testing.assert_allclose(curve.closest(points)[0], points, atol=1e-13)


def test_where_two_parts_are_about_equally_far_the_nearer_one_is_found() -> None:
    turn = np.array([[np.cos(0.1), np.sin(0.1), 0], [-np.sin(0.1), np.cos(0.1), 0], [0, 0, 1]])
    oval = Curve.through(circle(11) @ turn * [3.0, 1.0, 1.0], closed=True)
    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, size=(2000, 3)) * [2.0, 2e-3, 0.0]
    found = np.linalg.norm(points - oval.closest(points)[0], axis=1)
    assert (found <= KDTree(dense(oval)).query(points)[0] * (1 + 1e-12)).all()


def test_the_curve_goes_through_its_points() -> None:
    for points, closed in [(wave(), False), (circle(12), True), (SQUARE, True), (SQUARE, False)]:
        feet, _ = Curve.through(points, closed=closed).closest(points)
        np.testing.assert_allclose(feet, points, atol=1e-14)


def test_corners_are_found() -> None:
    assert Curve.through(SQUARE, closed=True).corners.tolist() == [0, 1, 2, 3]
    assert Curve.through(SQUARE, closed=False).corners.tolist() == [1, 2]
    assert Curve.through(circle(8), closed=True).corners.tolist() == []
    assert Curve.through(circle(7), closed=True).corners.tolist() == list(range(7))
    assert Curve.through(circle(7), closed=True, corner_angle=1.0).corners.tolist() == []
    assert CURVES["one corner"].corners.tolist() == [13]


def test_the_square_is_straight_between_its_corners() -> None:
    points = np.random.default_rng(0).uniform(-1, 3, size=(500, 3))
    feet, _ = CURVES["square"].closest(points)
    along = np.stack([(SQUARE - p, np.roll(SQUARE, -1, axis=0) - SQUARE) for p in points])
    t = np.clip(-np.einsum("nei,nei->ne", along[:, 0], along[:, 1]) / 4, 0, 1)
    away = np.linalg.norm(along[:, 0] + t[..., None] * along[:, 1], axis=2).min(axis=1)
    np.testing.assert_allclose(np.linalg.norm(points - feet, axis=1), away, rtol=1e-14)


def test_beyond_a_corner_the_tangent_is_the_one_more_across() -> None:
    points = np.array([[3.0, 0.0, 0], [2.0, -1.0, 0], [2.5, -0.1, 0]])
    feet, tangents = CURVES["square"].closest(points)
    np.testing.assert_allclose(feet, [[2, 0, 0]] * 3, atol=1e-15)
    np.testing.assert_allclose(tangents, [[0, 1, 0], [1, 0, 0], [0, 1, 0]], atol=1e-15)


@given(seeds)
def test_a_circle_is_met_with_order_four(seed: int) -> None:
    # with the tangents of an arc of angle a, a cubic leaves it by a^4 / 384, and so does a spline as a -> 0
    points = np.random.default_rng(seed).normal(size=(20, 3))
    for k in (16, 64):
        feet, tangents = Curve.through(circle(k), closed=True).closest(points)
        np.testing.assert_allclose(np.linalg.norm(feet, axis=1), 1.0, atol=(2 * np.pi / k) ** 4 / 360)
        around = np.cross([0, 0, 1], feet)
        np.testing.assert_allclose(tangents, around, atol=(2 * np.pi / k) ** 3 / 100)


@given(seeds, st.floats(-6, 6))
def test_units_and_place_do_not_matter(seed: int, decades: float) -> None:
    rng = np.random.default_rng(seed)
    turn, scale, shift = np.linalg.qr(rng.normal(size=(3, 3)))[0], 10.0**decades, rng.normal(size=3)
    points = wave()[rng.integers(0, 30, 20)] + 0.1 * rng.normal(size=(20, 3))
    feet, tangents = CURVES["open"].closest(points)
    moved = Curve.through((wave() @ turn + shift) * scale, closed=False)
    found, along = moved.closest((points @ turn + shift) * scale)
    np.testing.assert_allclose(found / scale, feet @ turn + shift, atol=1e-11)
    np.testing.assert_allclose(along, tangents @ turn, atol=1e-10)


@pytest.mark.parametrize(
    ("points", "closed", "message"),
    [
        (SQUARE[:1], False, "an open curve needs at least 2 points, not 1"),
        (SQUARE[:2], True, "a closed curve needs at least 3 points, not 2"),
        (SQUARE[[0, 1, 1, 2]], False, r"points 1 and 2 of the curve are the same, \[2.0, 0.0, 0.0\]: leave one out"),
        (SQUARE[[0, 1, 2, 0]], True, "points 3 and 0 of the curve are the same"),
        (np.array([[0, 0, 0], [np.nan, 0, 0]]), False, r"point 1 is \[nan, 0.0, 0.0\]: coordinates must be finite"),
        (SQUARE[:, :2], False, r"points have shape \(4, 2\), \(n, 3\) is needed"),
    ],
)
def test_points_that_make_no_curve_are_refused(points: FloatArray, closed: bool, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        Curve.through(points, closed=closed)


def test_points_that_are_no_numbers_have_no_foot() -> None:
    with pytest.raises(GeometryError, match="point 1 is"):
        CURVES["open"].closest(np.array([[0.0, 0, 0], [0, np.inf, 0]]))
    assert CURVES["open"].closest(np.zeros((0, 3)))[0].shape == (0, 3)
