"""Circle patterns with given radii around holes: symmetric ones in closed form, that they close, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import Combinatorics, koebe
from geometry.arrays import FloatArray, IntArray
from geometry.circle_patterns import CirclePattern, open_circle_pattern
from geometry.errors import GeometryError
from geometry.mesh import shapes, tilings

seeds = st.integers(0, 2**32 - 1)
N, RINGS = 12, 3
ANNULUS = tilings.rotational_quads(N, RINGS)
INNER, OUTER = np.arange(N) * (RINGS + 1), np.arange(N) * (RINGS + 1) + RINGS


def with_holes(n: int, faces: list[int]) -> Combinatorics:
    grid = shapes.grid(n, n)
    return grid.part(np.setdiff1d(np.arange(grid.n_faces), faces)).combinatorics


def off_pattern(pattern: CirclePattern) -> float:
    """How far circles are from touching along edges, from meeting at right angles in corners, and from 2 pi about inner
    vertices."""
    c, z, r = pattern.combinatorics, pattern.centres, pattern.radii
    corners, faces = c.corners, c.n_vertices + c.corner_face
    i, j = c.edges.T
    inside = c.is_used & ~c.is_boundary_vertex
    return max(
        float(np.abs(np.abs(z[i] - z[j]) / (r[i] + r[j]) - 1).max()),
        float(np.abs(np.abs(z[corners] - z[faces]) / np.hypot(r[corners], r[faces]) - 1).max()),
        float(np.abs(pattern.vertex_angles[inside] - 2 * np.pi).max()),
    )


def radii_at(c: Combinatorics, vertices: IntArray, values: FloatArray) -> FloatArray:
    radii = np.full(c.n_vertices, np.nan)
    radii[vertices] = values
    return radii


@given(seeds, st.floats(0.0, 0.5))
@settings(max_examples=20)
def test_radii_around_a_hole_are_met_and_the_pattern_closes(seed: int, spread: float) -> None:
    wanted = np.exp(spread * np.random.default_rng(seed).normal(size=N))
    pattern = open_circle_pattern(ANNULUS, radii=radii_at(ANNULUS, INNER, wanted), outer=int(OUTER[0]))
    assert off_pattern(pattern) <= 1e-10
    ratios = pattern.vertex_radii[INNER] / wanted
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-12)


def test_equal_radii_around_a_hole_give_rings() -> None:
    """Circles of a ring touch: r = R sin(pi / n); those of the next one too: R' - R = r + r'."""
    pattern = open_circle_pattern(ANNULUS, radii=radii_at(ANNULUS, INNER, np.full(N, 7.0)), outer=int(OUTER[0]))
    s = np.sin(np.pi / N)
    rings = pattern.vertex_radii.reshape(N, RINGS + 1)
    np.testing.assert_allclose(rings[:, 1:] / rings[:, :-1], (1 + s) / (1 - s), rtol=1e-12)
    np.testing.assert_allclose(rings[:, -1], 1.0, rtol=1e-12)
    centres = pattern.centres[: ANNULUS.n_vertices].reshape(N, RINGS + 1)
    np.testing.assert_allclose(np.abs(centres - centres.mean()), rings / s, rtol=1e-10)


@given(st.floats(0.05, 0.6), st.floats(0, 2 * np.pi))
@settings(max_examples=20)
def test_of_a_moebius_image_of_rings_the_outer_radii_vary_less(distance: float, direction: float) -> None:
    """z -> 1 / (z - a) takes the rings to an eccentric pattern with the same radii around its hole."""
    rings = open_circle_pattern(ANNULUS, radii=radii_at(ANNULUS, INNER, np.ones(N)), outer=int(OUTER[0]))
    z, r = rings.centres[: ANNULUS.n_vertices], rings.vertex_radii
    z = z - z.mean()
    pole = (1 + distance) ** -1 * 3 * np.abs(z).max() * np.exp(1j * direction)
    image = r / np.abs(np.abs(z - pole) ** 2 - r**2)
    both = radii_at(ANNULUS, np.concatenate([INNER, OUTER]), image[np.concatenate([INNER, OUTER])])
    given_both = open_circle_pattern(ANNULUS, radii=both, outer=int(OUTER[0]))  # these close by themselves
    assert off_pattern(given_both) <= 1e-10
    np.testing.assert_allclose(given_both.vertex_radii / image, given_both.vertex_radii[OUTER[0]] / image[OUTER[0]])
    found = open_circle_pattern(ANNULUS, radii=radii_at(ANNULUS, INNER, image[INNER]), outer=int(OUTER[0]))
    assert off_pattern(found) <= 1e-10
    logs = np.log(np.stack([found.vertex_radii[OUTER], image[OUTER]]))
    spreads = np.square(logs - logs.mean(axis=1, keepdims=True)).sum(axis=1)
    assert spreads[0] <= spreads[1] * 1.01  # least to first order
    np.testing.assert_allclose(logs[0].mean(), 0, atol=1e-9)


@given(seeds)
@settings(max_examples=10)
def test_two_holes_close_together(seed: int) -> None:
    c = with_holes(7, [8, 9, 39, 40])  # each of two quads
    holes = sorted(c.boundary_loops, key=len)[:2]
    wanted = [np.exp(0.2 * np.random.default_rng(seed + k).normal(size=len(hole))) for k, hole in enumerate(holes)]
    radii = radii_at(c, np.concatenate(holes), np.concatenate(wanted))
    pattern = open_circle_pattern(c, radii=radii)
    assert off_pattern(pattern) <= 1e-9
    for hole, values in zip(holes, wanted, strict=True):
        ratios = pattern.vertex_radii[hole] / values
        np.testing.assert_allclose(ratios, ratios[0], rtol=1e-12)


def test_a_koebe_polyhedron_with_given_radii_around_its_hole() -> None:
    wanted = np.where(np.arange(N) < N // 2, 1.0, 1.5)
    S = koebe(ANNULUS, radii=radii_at(ANNULUS, INNER, wanted), outer=int(OUTER[0]), coverage=0.3)
    assert np.abs(np.linalg.norm(S.tangency_points, axis=1) - 1).max() <= 1e-9
    assert S.mesh.planarity.max() <= 1e-9


def test_holes_that_cannot_close_are_refused() -> None:
    wanted = np.where(np.arange(N) < N // 2, 1.0, 1.5)
    both = radii_at(ANNULUS, np.concatenate([INNER, OUTER]), np.concatenate([wanted, np.ones(N)]))
    with pytest.raises(GeometryError, match=r"does not close around a hole.* leave those of the outer boundary free"):
        open_circle_pattern(ANNULUS, radii=both, outer=int(OUTER[0]))
