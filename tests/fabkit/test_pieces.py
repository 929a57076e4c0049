"""Polygons are cut into triangles that cover them once, and outlines with many corners into compact ones."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fabkit.checking.clash import clashing_pairs
from fabkit.checking.convex import is_splittable
from fabkit.checking.convex_pieces import triangles
from fabkit.parts import SolidArray, prism_topology, prism_vertices
from geometry.arrays import FloatArray


def star(n: int, seed: int, roughness: float) -> FloatArray:
    """(n, 2) star-shaped about the origin, 1000 across; roughness 0: regular, 0.9: needles to the middle."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * (np.arange(n) + 0.3 * rng.uniform(-1, 1, n) * (roughness > 0)) / n
    return 1000 * (1 - roughness * rng.random(n))[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def comb(n: int) -> FloatArray:
    """(2n + 2, 2) n teeth on a spine: cut across, it falls into as many pieces."""
    teeth = [[k, 10.0 * (k % 2) + 1.0] for k in range(2 * n - 1, -1, -1)]
    return np.array([[0.0, 0.0], [2.0 * n - 1, 0.0], *teeth])


counts, seeds, roughnesses = st.integers(3, 300), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-6, 0.1, 0.9])


@given(counts, seeds, roughnesses)
def test_triangles_cover_each_polygon_once(n: int, seed: int, roughness: float) -> None:
    outlines = np.array([star(n, seed, roughness), 0.5 * star(n, seed + 1, roughness) + [300.0, -200.0]])
    corners, owner = triangles(outlines)
    for k, outline in enumerate(outlines):
        found, polygon = shapely.polygons(corners[owner == k]), shapely.Polygon(outline)
        # 1e-6 mm2: the largest distance that rounding moves a cut (1e-12 mm), times what the cuts are long together
        assert shapely.area(found).sum() == pytest.approx(polygon.area, abs=1e-6)
        assert polygon.buffer(1e-9).contains(shapely.union_all(found).buffer(-1e-9))


@pytest.mark.parametrize("outline", [star(3000, 0, 0.0), star(3000, 1, 0.3), comb(1500)])
def test_large_outlines_become_compact_triangles_in_proportion(outline: FloatArray) -> None:
    """As a fan or in one Delaunay triangulation, a third of these boxes would meet a point, not some."""
    corners, _ = triangles(outline[None])
    assert len(corners) < 4 * len(outline)
    low, high = corners.min(axis=1), corners.max(axis=1)
    points = np.random.default_rng(0).permutation(outline)[:100]
    over = ((low <= points[:, None]) & (points[:, None] <= high)).all(axis=2).sum(axis=1)
    assert over.max() < 100  # a piece has some 30 triangles, and a corner may lie in the boxes of three pieces


@given(st.integers(20, 300), seeds, roughnesses, st.floats(-1100, 1100), st.floats(-1100, 1100))
def test_a_large_plate_clashes_with_what_reaches_into_its_outline(n, seed, roughness, x, y) -> None:
    """Anywhere in space; whether two prisms at one level share volume is seen in the plan."""
    rng = np.random.default_rng(seed)
    outline, square = star(n, seed, roughness), np.array([[x, y], [x + 30, y], [x + 30, y + 30], [x, y + 30]])
    shared = shapely.intersection(shapely.Polygon(outline), shapely.Polygon(square))
    turn, move = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-1e4, 1e4, 3)
    batches = [
        SolidArray(prism_topology(len(plan)), np.array([k]), (prism_vertices(plan, 0.0, height) @ turn + move)[None])
        for k, (plan, height) in enumerate([(outline, 8.0), (square, 20.0)])
    ]
    assert all(is_splittable(batch).all() for batch in batches)
    pairs, depths = clashing_pairs(batches, depth_mm=1e-6)
    if shared.area == 0.0:
        assert len(pairs) == 0
    elif shared.buffer(-1e-4).area > 0.0:  # a circle of that radius fits in: deeper than what only touches
        assert pairs.tolist() == [[0, 1]]
        assert depths[0] > 1e-6


@pytest.mark.parametrize("lean", [0.0, 0.5])
def test_cut_pieces_keep_the_leaning_ends_of_a_prism(lean: float) -> None:
    """An oblique prism over 100 corners with its upper end cut askew: a box just over that end does not touch it, one
    that reaches a hundredth of a millimetre into it does."""
    n = 100
    vertices = prism_vertices(star(n, 0, 0.2), 0.0, 1000.0)
    vertices[n:, 2] += 0.3 * vertices[n:, 0] - 0.2 * vertices[n:, 1]
    vertices[n:, 0] += lean * vertices[n:, 2]
    vertices[:n, 0] += lean * vertices[:n, 2]
    normal = np.cross(vertices[n + 30] - vertices[n], vertices[n + 60] - vertices[n])
    normal /= np.linalg.norm(normal)
    axes = np.stack([np.cross(normal, [1.0, 0, 0]), np.cross(normal, np.cross(normal, [1.0, 0, 0])), normal])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    middle = vertices[n:].mean(axis=0)
    square = np.array([[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]])
    for above, expected in ((1e-4, 0), (-1e-2, 1)):
        box = prism_vertices(square, above, 50.0) @ axes + middle
        plate = SolidArray(prism_topology(n), np.array([0]), vertices[None])
        assert len(clashing_pairs([plate, SolidArray(prism_topology(4), np.array([1]), box[None])])[0]) == expected


@given(st.integers(3, 40), st.integers(1, 8), seeds)
def test_corners_on_straight_sides_leave_nothing_without_direction(n: int, between: int, seed: int) -> None:
    """Somewhere in space rounding moves them off their sides, so that there are triangles as high as rounding."""
    rng = np.random.default_rng(seed)
    outline, share = star(n, seed, 0.3), np.arange(between + 1)[:, None] / (between + 1)
    sides = np.roll(outline, -1, axis=0) - outline
    plan = (outline[:, None] + share * sides[:, None]).reshape(-1, 2)
    turn, move = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-1e4, 1e4, 3)
    solid = prism_vertices(plan, 0.0, 8.0) @ turn + move
    batches = [
        SolidArray(prism_topology(len(plan)), np.array([k]), (solid + k * 8.0 * turn[2])[None]) for k in range(2)
    ]
    with np.errstate(all="raise"):
        assert len(clashing_pairs(batches, depth_mm=1e-6)[0]) == 0


def test_a_plate_with_thousands_of_corners_takes_memory_in_proportion() -> None:
    n = 3000
    plate = SolidArray(prism_topology(n), np.array([0]), prism_vertices(star(n, 0, 0.0), 0.0, 8.0)[None])
    around = 1010 * star(n, 0, 0.0)[::10, None] / 1000 + [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    boxes = SolidArray(prism_topology(4), np.arange(1, len(around) + 1), prism_vertices(around, 0.0, 8.0))
    tracemalloc.start()
    assert is_splittable(plate).all()
    assert len(clashing_pairs([plate, boxes])[0]) == 0
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # 10 MB are measured; each face with each corner would be over 144 MB
    assert peak < 30e6
