"""Conicality: which vertices are conical, curved and flat ones, convex and saddles, with four faces and more."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.exact_offsets import conicality
from geometry.functionals.conical_vertices import ConicalVertices, closed_fans
from geometry.mesh import Mesh, shapes
from tests.geometry.bent_meshes import rotation

seeds = st.integers(0, 2**32 - 1)


def pyramid(directions: FloatArray) -> Mesh:
    """k quads around vertex 0, with its edges along `directions` (k, 3): planar where they are parallelograms."""
    k = len(directions)
    far = directions + np.roll(directions, -1, axis=0)
    faces = [[0, 1 + i, 1 + k + i, 1 + (i + 1) % k] for i in range(k)]
    return Mesh.from_faces(np.concatenate([[np.zeros(3)], directions, far]), faces)


def star(seed: int, k: int, opening: float, *, conical: bool = True) -> Mesh:
    """A vertex with k planar faces tangent to a cone of half angle pi/2 - opening, or nearly so.

    Their normals stand around the axis as they like; edges are where neighbouring planes meet.
    """
    rng = np.random.default_rng(seed)
    azimuths = 2 * np.pi * (np.arange(k) + 0.5 * rng.uniform(size=k)) / k
    openings = opening * (1 + (0 if conical else 0.3) * rng.uniform(-1, 1, size=k))
    normals = np.stack(
        [np.sin(openings) * np.cos(azimuths), np.sin(openings) * np.sin(azimuths), np.cos(openings)], axis=1
    )
    edges = np.cross(normals, np.roll(normals, -1, axis=0))
    edges *= rng.uniform(0.5, 2, size=(k, 1)) / np.linalg.norm(edges, axis=1, keepdims=True)
    return pyramid(edges)


@given(seeds, st.integers(4, 7), st.floats(1e-3, 1.2))
def test_faces_tangent_to_a_cone_are_conical(seed: int, k: int, opening: float) -> None:
    mesh = star(seed, k, opening)
    # edges are good to rounding over the opening
    residual = ConicalVertices(mesh.combinatorics).residual(mesh.vertices.ravel())
    assert residual.shape == (k - 3,)
    assert np.abs(residual).max() < 1e-12 / opening


@given(seeds, st.integers(4, 7), st.floats(1e-2, 1.0))
def test_other_faces_are_not(seed: int, k: int, opening: float) -> None:
    mesh = star(seed, k, opening, conical=False)
    residual = np.linalg.norm(ConicalVertices(mesh.combinatorics).residual(mesh.vertices.ravel()))
    deviation = conicality(mesh)[0]  # in radians of the normals, which are nearer together by the opening
    if k == 4:
        assert residual > 0.3 * deviation / opening
    else:
        assert residual == pytest.approx(deviation, rel=3)
        assert residual > 0.3 * deviation


@given(seeds, st.floats(0.02, 1.0))
def test_saddles_are_conical_by_the_same_angles(seed: int, height: float) -> None:
    # by Newton's method on one edge direction: w_1 + w_3 = w_2 + w_4, then the normals must lie on a circle
    rng = np.random.default_rng(seed)
    azimuths = np.pi / 2 * np.arange(4) + rng.uniform(-0.3, 0.3, size=4)
    heights = height * np.array([1.0, -1, 1, -1]) * rng.uniform(0.5, 1.0, size=4)

    def saddle(last: float) -> Mesh:
        around = np.append(azimuths[:3], last)
        return pyramid(np.stack([np.cos(around), np.sin(around), heights], axis=1))

    functional = ConicalVertices(saddle(0.0).combinatorics)

    def asked(last: float) -> float:
        return float(functional.residual(saddle(last).vertices.ravel())[0])

    first, second = azimuths[3], azimuths[3] + 1e-3
    for _ in range(20):
        if asked(first) == asked(second):
            break
        first, second = second, second - asked(second) * (second - first) / (asked(second) - asked(first))
    mesh = saddle(second)
    assert abs(asked(second)) < 1e-14
    assert conicality(mesh)[0] < 1e-13
    assert conicality(saddle(second + 0.1))[0] > 1e-3 * height


def test_flat_vertices_with_more_faces_are_conical_and_have_tame_derivatives() -> None:
    for k, height in [(5, 0.0), (6, 0.0), (5, 1e-9), (6, 1e-9), (7, 1e-8)]:
        angles = 2 * np.pi / k * np.arange(k) + 0.1 * np.sin(np.arange(k))
        heights = height * np.cos(3 * np.arange(k))
        mesh = pyramid(np.stack([np.cos(angles), np.sin(angles), heights], axis=1) @ rotation(k))
        functional, x = ConicalVertices(mesh.combinatorics), mesh.vertices.ravel()
        assert np.abs(functional.residual(x)).max() < 1e-12
        assert np.isfinite(functional.jacobian(x).toarray()).all()


def test_four_faces_at_a_flat_vertex_ask_for_the_limit_of_curved_ones() -> None:
    edges = np.array([[1.0, 0, 0], [0.3, 1, 0], [-1, 0.2, 0], [0, -1, 0]])
    mesh = pyramid(edges)
    angles = np.arctan2(edges[:, 1], edges[:, 0])
    corners = np.diff(np.append(angles, angles[0] + 2 * np.pi)) % (2 * np.pi)
    found = ConicalVertices(mesh.combinatorics).residual(mesh.vertices.ravel())
    assert abs(found[0]) == pytest.approx(abs(corners @ [1, -1, 1, -1]) / 2)


def test_angles_of_corners_that_turn_backwards_are_more_than_pi() -> None:
    edges, far = np.radians([0.0, 200, 260, 300]), np.radians([100.0, 230, 280, 330])
    around = np.concatenate([edges, far])
    reach = np.repeat([1.0, 3.0], 4)
    vertices = np.stack([reach * np.cos(around), reach * np.sin(around), np.zeros(8)], axis=1)
    faces = [[0, 1 + i, 5 + i, 1 + (i + 1) % 4] for i in range(4)]
    mesh = Mesh.from_faces(np.concatenate([np.zeros((1, 3)), vertices]), faces)
    found = ConicalVertices(mesh.combinatorics).residual(mesh.vertices.ravel())
    assert abs(found[0]) == pytest.approx(np.radians(200 - 60 + 40 - 60) / 2)


def test_fans_run_counter_clockwise_around_inner_vertices() -> None:
    for mesh in (shapes.dome(9, 4), shapes.icosahedron(), shapes.grid(3, 3)):
        c = mesh.combinatorics
        seen = []
        for fans in closed_fans(c):
            vertices = c.corners[fans]
            assert (vertices == vertices[:, :1]).all()
            heads = c.corners[c.next_corner[fans]]
            tails = c.corners[c.previous_corner[fans]]
            np.testing.assert_array_equal(tails, np.roll(heads, -1, axis=1))
            seen += vertices[:, 0].tolist()
        assert sorted(seen) == np.flatnonzero(~c.is_boundary_vertex).tolist()
