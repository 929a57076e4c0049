"""Closeness to points, surfaces and curves: who is asked, Jacobians against differences, Newton's steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError
from geometry.functionals.closeness import OnCurve, OnSmoothSurface, OnSurface, close_to
from geometry.mesh import shapes
from geometry.surface.curve import Curve
from geometry.surface.surface import Surface

seeds = st.integers(0, 2**32 - 1)


def differences(functional: OnCurve | OnSurface, x: FloatArray, direction: FloatArray, step: float) -> FloatArray:
    ahead, back = (functional.residual(x + sign * step * direction) for sign in (1, -1))
    return np.asarray((ahead - back) / (2 * step))


def curve() -> Curve:
    s = np.linspace(0, 4, 20)
    return Curve.through(np.stack([s, np.sin(s), 0.3 * s**2], axis=1), closed=False)


@given(seeds, st.sampled_from([0.0, 1e-5, 1e-2]))
def test_the_jacobians_of_closeness_are_exact_up_to_the_distance(seed: int, off: float) -> None:
    rng = np.random.default_rng(seed)
    on_curve = np.repeat(np.einsum("p,spi->si", 0.37 ** np.arange(3.0, -1, -1), curve().spans), 2, axis=0)
    dome = shapes.dome(12, 6)
    on_dome = dome.vertices[dome.combinatorics.corners[dome.combinatorics.face_starts[:-1][:, None] + np.arange(4)]]
    on_dome = np.einsum("fki,k->fi", on_dome, [0.4, 0.3, 0.2, 0.1])
    for base, functional in [
        (on_curve, OnCurve(curve(), np.arange(len(on_curve)), len(on_curve))),
        (on_dome, OnSurface(Surface(dome), np.arange(len(on_dome)), len(on_dome))),
    ]:
        x = (base + off * rng.uniform(-1, 1, size=base.shape)).ravel()
        direction = rng.uniform(-1, 1, size=x.shape)
        found = differences(functional, x, direction, 1e-7)
        # the distance, times how fast normals and tangents turn; the basis across the curve turns with them
        np.testing.assert_allclose(functional.jacobian(x) @ direction, found, atol=1e-7 + 6 * off)


def test_close_to_is_the_way_from_the_points() -> None:
    points = np.arange(12.0).reshape(4, 3)
    np.testing.assert_array_equal(close_to(points).residual(points.ravel() + 2), np.full(12, 2.0))
    with pytest.raises(GeometryError, match=r"point 1 is \[0.0, nan, 0.0\]"):
        close_to(np.array([[0.0, 0, 0], [0, np.nan, 0]]))


def test_only_chosen_vertices_are_asked() -> None:
    dome = shapes.dome(12, 6)
    x = (dome.vertices * 1.1).ravel()
    chosen = np.array([40, 3])
    on_surface, on_curve = OnSurface(Surface(dome), chosen, dome.n_vertices), OnCurve(curve(), chosen, dome.n_vertices)
    assert on_surface.residual(x).shape == (2,)
    assert on_curve.residual(x).shape == (4,)
    for functional, rows in ((on_surface, [0, 1]), (on_curve, [0, 0, 1, 1])):
        matrix = functional.jacobian(x).tocoo()
        assert matrix.shape == (len(rows), 3 * dome.n_vertices)
        assert set(zip(matrix.row.tolist(), (matrix.col // 3).tolist(), strict=True)) <= set(
            zip(range(len(rows)), chosen[rows].tolist(), strict=True)
        )
    assert on_surface.residual(x) == pytest.approx(0.1, rel=0.05)
    feet = curve().closest(x.reshape(-1, 3)[chosen])[0]
    away = np.linalg.norm(x.reshape(-1, 3)[chosen] - feet, axis=1)
    assert (np.linalg.norm(on_curve.residual(x).reshape(2, 2), axis=1) <= away + 1e-14).all()
    for make in (lambda v: OnSurface(Surface(dome), v, 84), lambda v: OnCurve(curve(), v, 84)):
        with pytest.raises(MeshError, match="there is no vertex 84: the vertices end at 83"):
            make(np.array([0, 84]))


@given(seeds)
@settings(max_examples=10)
def test_newtons_steps_lead_to_surface_and_curve_quadratically(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dome = shapes.dome(48, 24)
    for functional, points in [
        (OnSurface(Surface(dome), np.arange(20), 20), dome.vertices[rng.integers(300, 900, 20)]),
        (OnCurve(curve(), np.arange(20), 20), curve().closest(rng.uniform(0.5, 3.5, (20, 3)) * [1, 0.3, 1])[0]),
    ]:
        x = (points + 0.02 * rng.uniform(-1, 1, size=points.shape)).ravel()
        for _ in range(4):
            matrix = functional.jacobian(x).toarray()
            x = x - np.linalg.lstsq(matrix, functional.residual(x))[0]
        # 0.02, then squares; near an edge of the surface one step more
        assert np.abs(functional.residual(x)).max() < 1e-14


def test_distances_from_a_smooth_surface_are_those_along_its_normals() -> None:
    mesh = shapes.dome(9, 5)
    surface = Surface(mesh)
    points = mesh.vertices * 1.1
    functional = OnSmoothSurface(surface, mesh.combinatorics)
    np.testing.assert_allclose(functional.residual(points.ravel()), surface.distances(points)[0], atol=1e-15)
    rows = functional.jacobian(points.ravel()).toarray().reshape(mesh.n_vertices, mesh.n_vertices, 3)
    at = np.arange(mesh.n_vertices)
    np.testing.assert_allclose(rows[at, at], surface.closest(points)[1], atol=1e-15)
    assert np.count_nonzero(rows.any(axis=2)) == mesh.n_vertices


@given(seeds, st.integers(1, 9))
def test_close_to_chosen_vertices_with_weights(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    x, chosen, points, weights = (
        rng.normal(size=30),
        rng.integers(0, 10, count),
        rng.normal(size=(count, 3)),
        rng.random(count),
    )
    term = close_to(points, chosen, n_vertices=10, weights=weights)
    squares = np.square(x.reshape(-1, 3)[chosen] - points).sum(axis=1)
    np.testing.assert_allclose(np.square(term.residual(x)).sum(), weights @ squares, rtol=1e-12)
    assert term.matrix.shape == (3 * count, 30)
    everywhere = rng.normal(size=(10, 3))
    np.testing.assert_array_equal(
        close_to(everywhere, np.arange(10), n_vertices=10).residual(x), close_to(everywhere).residual(x)
    )


def test_what_close_to_refuses() -> None:
    points = np.zeros((2, 3))
    with pytest.raises(GeometryError, match="vertices are chosen: give n_vertices too"):
        close_to(points, [0, 1])
    with pytest.raises(MeshError, match="there is no vertex 7: the vertices end at 4"):
        close_to(points, [0, 7], n_vertices=5)
    with pytest.raises(GeometryError, match="there are 2 points, 3 vertices and 2 weights"):
        close_to(points, [0, 1, 2], n_vertices=5)
    with pytest.raises(GeometryError, match="there are 2 points, 2 vertices and 3 weights"):
        close_to(points, weights=[1, 2, 3])
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(GeometryError, match=f"the weight of point 1 is {wrong}"):
            close_to(points, weights=[1.0, wrong])
