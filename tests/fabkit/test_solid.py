"""Solids and frames: measures against other programs, and what does not depend on place."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from shapely import Polygon

from fabkit.parts import (
    Frame,
    Solid,
    SolidArray,
    Solids,
    Topology,
    prism_topology,
    prism_vertices,
)
from geometry.arrays import FloatArray

CLOSE = 1e-9
"""Relative to the size of the solid: sums of some hundred terms in double precision, with room for flat hulls."""

each = settings(max_examples=50, deadline=None)
seeds = st.integers(0, 2**32 - 1)


def hull_solid(seed: int) -> Solid:
    """The convex hull of random points, in triangles."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(4, 25)), 3)) * rng.uniform(0.2, 3, 3) + rng.uniform(-5, 5, 3)
    hull = ConvexHull(points)
    points, triangles = points[hull.vertices], np.searchsorted(hull.vertices, hull.simplices)
    normals = np.cross(*(points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2)))
    inwards = np.einsum("fk,fk->f", normals, hull.equations[:, :3]) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    starts = np.arange(len(triangles) + 1)
    return Solid(points, Topology(len(points), triangles.ravel(), 3 * starts, starts))


def star_outline(seed: int) -> FloatArray:
    """Some polygon, mostly not convex, counter-clockwise."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 12))
    angles = 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    outline: FloatArray = rng.uniform(0.3, 2, (n, 1)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return outline + rng.uniform(-3, 3, 2)


def drilled_box() -> Solid:
    """4 x 4 x 2 from the origin, with a hole from (1, 1) to (2, 3) all the way up."""
    outer = np.array([[0, 0], [4, 0], [4, 4], [0, 4.0]])
    inner = np.array([[1, 1], [2, 1], [2, 3], [1, 3.0]])
    vertices = np.concatenate([prism_vertices(outline, 0.0, 2.0) for outline in (outer, inner)])
    sides = list(pairwise([0, 1, 2, 3, 0]))
    loops = [[3, 2, 1, 0], [8, 9, 10, 11], [4, 5, 6, 7], [15, 14, 13, 12]]
    loops += [[a, b, b + 4, a + 4] for a, b in sides] + [[b + 8, a + 8, a + 12, b + 12] for a, b in sides]
    starts = 4 * np.arange(len(loops) + 1)
    return Solid(vertices, Topology(16, np.concatenate(loops), starts, np.array([0, 2, *range(4, 13)])))


def random_frame(seed: int) -> Frame:
    rng = np.random.default_rng(seed)
    return Frame(rng.uniform(-10, 10, 3), Rotation.random(rng=rng).as_matrix())


@each
@given(seeds)
def test_measures_of_hulls(seed: int) -> None:
    solid = hull_solid(seed)
    judge = trimesh.Trimesh(solid.vertices, solid.topology.corners.reshape(-1, 3), process=False)
    assert solid.volume_mm3 == pytest.approx(ConvexHull(solid.vertices).volume, rel=CLOSE)
    assert solid.volume_mm3 == pytest.approx(judge.volume, rel=CLOSE)
    np.testing.assert_allclose(solid.centroid, judge.center_mass, atol=1e-7)  # flat hulls cost digits
    np.testing.assert_allclose(solid.normals, np.asarray(judge.face_normals), atol=1e-6)  # and sharp triangles
    assert (
        ConvexHull(solid.vertices).equations[:, :3] @ solid.centroid < -ConvexHull(solid.vertices).equations[:, 3]
    ).all()


@each
@given(seeds, st.floats(-5, 5), st.floats(0.01, 10))
def test_measures_of_prisms(seed: int, bottom: float, height: float) -> None:
    outline = star_outline(seed)
    judge = Polygon(outline)
    assert judge.is_valid
    solid = Solid(prism_vertices(outline, bottom, bottom + height), prism_topology(len(outline)))
    assert solid.volume_mm3 == pytest.approx(judge.area * height, rel=CLOSE)
    expected = [judge.centroid.x, judge.centroid.y, bottom + height / 2]
    np.testing.assert_allclose(solid.centroid, expected, atol=CLOSE * 100)
    np.testing.assert_allclose(solid.normals[:2], [[0, 0, -1], [0, 0, 1]], atol=CLOSE)
    ahead = np.roll(outline, -1, axis=0) - outline
    outward = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1, keepdims=True)
    np.testing.assert_allclose(solid.normals[2:, :2], outward, atol=CLOSE)


def test_measures_of_a_box_with_a_hole() -> None:
    solid = drilled_box()
    assert solid.volume_mm3 == pytest.approx((16 - 2) * 2)
    # area moments: (16 * 2 - 2 * 1.5) / 14 across, (16 * 2 - 2 * 2) / 14 along
    np.testing.assert_allclose(solid.centroid, [29 / 14, 2.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(solid.normals[:2], [[0, 0, -1], [0, 0, 1]], atol=1e-12)
    # the sides of the hole look into it
    np.testing.assert_allclose(solid.normals[6:], [[0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0]], atol=1e-12)
    assert [loop.tolist() for loop in solid.topology.loops(0)] == [[3, 2, 1, 0], [8, 9, 10, 11]]


@each
@given(seeds, seeds, st.floats(0.1, 10))
def test_rigid_motion_and_scale(seed: int, motion: int, scale: float) -> None:
    solid, frame = hull_solid(seed), random_frame(motion)
    moved = Solid(frame.to_world(scale * solid.vertices), solid.topology)
    assert moved.volume_mm3 == pytest.approx(scale**3 * solid.volume_mm3, rel=1e-8)
    np.testing.assert_allclose(moved.centroid, frame.to_world(scale * solid.centroid), atol=1e-6)
    np.testing.assert_allclose(moved.normals, solid.normals @ frame.axes, atol=1e-6)


@each
@given(seeds)
def test_mirrored_is_negative(seed: int) -> None:
    solid = hull_solid(seed)
    mirrored = Solid(solid.vertices * [1, 1, -1], solid.topology)
    assert mirrored.volume_mm3 == pytest.approx(-solid.volume_mm3, rel=CLOSE)
    np.testing.assert_allclose(mirrored.centroid, solid.centroid * [1, 1, -1], atol=1e-7)


def test_far_from_the_origin() -> None:
    """A building 1 km off: 1e-10 of an edge is lost with the coordinates, no more with the measures."""
    near = Solid(random_frame(0).to_world(drilled_box().vertices), drilled_box().topology)
    far = Solid(near.vertices + 1e6, near.topology)
    assert far.volume_mm3 == pytest.approx(near.volume_mm3, rel=CLOSE)
    np.testing.assert_allclose(far.centroid, near.centroid + 1e6, atol=CLOSE)
    np.testing.assert_allclose(far.normals, near.normals, atol=CLOSE)


def test_stacks_are_measured_like_single_solids() -> None:
    outlines = np.array([[[0, 0], [3, 0], [0, 2.0]], [[1, 1], [5, 1], [2, 9.0]]])
    tops = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    vertices = prism_vertices(np.broadcast_to(outlines, (3, 2, 3, 2)), 0.0, tops)
    topology = prism_topology(3)
    assert vertices.shape == (3, 2, 6, 3)
    batch = SolidArray(topology, np.arange(6), vertices.reshape(6, 6, 3))
    solids = Solids.alike(batch.vertices, topology)
    for k, own in enumerate(batch.vertices):
        single = Solid(own, topology)
        assert batch.volumes[k] == solids.volumes[k] == pytest.approx(single.volume_mm3)
        np.testing.assert_allclose(batch.centroids[k], single.centroid, atol=CLOSE)
        np.testing.assert_allclose(solids.centroids[k], single.centroid, atol=CLOSE)
        np.testing.assert_allclose(batch.normals[k], single.normals, atol=CLOSE)


@pytest.mark.parametrize("n", [3, 4, 7])
def test_prism_topology(n: int) -> None:
    t = prism_topology(n)
    assert t is prism_topology(n)
    assert (t.n_vertices, len(t.edges), t.n_faces) == (2 * n, 3 * n, n + 2)
    assert np.bincount(t.edges.ravel()).tolist() == [3] * 2 * n
    assert [len(t.loops(face)) for face in range(t.n_faces)] == [1] * (n + 2)
    assert t.loops(2 + n - 1)[0].tolist() == [n - 1, 0, n, 2 * n - 1]
    assert t.corner_face.tolist() == [0] * n + [1] * n + [2 + k for k in range(n) for _ in range(4)]


def cube_loops() -> list[list[int]]:
    return [loop.tolist() for face in range(6) for loop in prism_topology(4).loops(face)]


def topology(n_vertices: int, loops: list[list[int]]) -> Topology:
    starts = np.cumsum([0, *(len(loop) for loop in loops)])
    return Topology(n_vertices, np.concatenate(loops), starts, np.arange(len(loops) + 1))


def test_closed_cube_is_accepted() -> None:
    assert topology(8, cube_loops()).n_faces == 6


@pytest.mark.parametrize("face", range(6))
def test_open_or_badly_turned_topologies_are_refused(face: int) -> None:
    loops = cube_loops()
    missing = loops[:face] + loops[face + 1 :]
    reversed_face = [*missing, loops[face][::-1]]
    twice = [*loops, loops[face]]
    both_sides = [*loops, loops[face], loops[face][::-1]]
    for broken in (missing, reversed_face, twice, both_sides):
        with pytest.raises(ValueError, match="not a closed solid: each edge must be run along once"):
            topology(8, broken)


def test_vertices_must_match_the_topology() -> None:
    for shape in ((7, 3), (8, 2), (1, 8, 3)):
        with pytest.raises(ValueError, match="vertices have shape"):
            Solid(np.zeros(shape), prism_topology(4))


def test_values_do_not_change() -> None:
    mine = drilled_box().vertices.copy()
    solid = Solid(mine, drilled_box().topology)
    mine[:] = 0
    assert solid.volume_mm3 == pytest.approx(28.0)
    frame = random_frame(0)
    for array in (solid.vertices, solid.centroid, solid.normals, solid.topology.corners, frame.origin, frame.axes):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@each
@given(seeds, seeds, seeds)
def test_frames(a: int, b: int, c: int) -> None:
    outer, inner = random_frame(a), random_frame(b)
    points = np.random.default_rng(c).uniform(-10, 10, (2, 5, 3))
    np.testing.assert_allclose(outer.to_local(outer.to_world(points)), points, atol=1e-12)
    both = outer.place(inner)
    np.testing.assert_allclose(both.to_world(points), outer.to_world(inner.to_world(points)), atol=1e-12)
    np.testing.assert_allclose(both.axes @ both.axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(both.axes) == pytest.approx(1.0)
    # the rows of axes are the frame's x, y, z in world coordinates
    np.testing.assert_allclose(outer.to_world(np.eye(3)) - outer.origin, outer.axes, atol=1e-12)
    np.testing.assert_allclose(outer.to_world(np.zeros(3)), outer.origin)
    np.testing.assert_array_equal(Frame.world().to_world(points), points)
