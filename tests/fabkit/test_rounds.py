"""Solids with round bars and bores: measures against closed forms and against points counted at random."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.checking.round_edges import round_clearances
from fabkit.parts import (
    BORE,
    SHAFT,
    Measures,
    Section,
    Solid,
    Topology,
    bore_vertices,
    prism_topology,
    prism_vertices,
    profile_topology,
    profile_vertices,
    round_vertices,
    shaft_topology,
)
from geometry.arrays import FloatArray
from tests.fabkit.round_solids import SOLIDS
from tests.fabkit.solids import frame

each = settings(max_examples=40, deadline=None)
seeds = st.integers(0, 2**32 - 1)
slopes = st.floats(-1.5, 1.5)
X = np.array([1.0, 0.0, 0.0])


def drilled_block(radius: float = 4.0, depth: float = 20.0) -> Solid:
    """A block 60 x 60 x 40 with a bore through it along z, and a blind one in each of two sides."""
    square = 30.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    topology = prism_topology(4).bored([(0, 1), (2, None), (3, None)])
    middle, facets = np.array([0.0, 0, 0]), np.array([[0.0, -30, 20], [30.0, 0, 20]])
    bores = [
        bore_vertices(middle, np.array([0, 0, 40.0]), 6.0, X),
        bore_vertices(facets[0], facets[0] + [0, depth, 0], radius, X),
        bore_vertices(facets[1], facets[1] - [depth, 0, 0], radius, np.array([0, 0, 1.0])),
    ]
    return Solid(np.concatenate([prism_vertices(square, 0.0, 40.0), *bores]), topology)


def counted(solid: Solid, inside: np.ndarray, points: FloatArray, box: float) -> None:
    """Volume and centroid, by the random points of a box that are inside: to four standard deviations."""
    share = inside.mean()
    error = np.sqrt(share * (1 - share) / len(points))
    assert solid.volume_mm3 / box == pytest.approx(share, abs=4 * error)
    spread = points[inside].std(axis=0) / np.sqrt(inside.sum())
    np.testing.assert_allclose(solid.centroid, points[inside].mean(axis=0), atol=4 * spread.max())


@each
@given(st.floats(1, 200), st.floats(0.1, 0.95), slopes, slopes, st.floats(0, 2 * np.pi), seeds)
def test_tubes_between_oblique_planes(
    radius: float, share: float, first: float, second: float, turn: float, seed: int
) -> None:
    """Area of the section times the distance of the centres; and a tube leans as a whole does."""
    across, inner = np.array([np.cos(turn), np.sin(turn)]), share * radius
    planes = [np.array([x, *(slope * across)]) for x, slope in ((0.0, first), (10 * radius, second))]
    place = frame(seed % 1000)
    bar = Solid(place.to_world(round_vertices([radius], *planes)), shaft_topology())
    tube = Solid(place.to_world(round_vertices([radius, inner], *planes)), shaft_topology(hollow=True))
    core = Solid(place.to_world(round_vertices([inner], *planes)), shaft_topology())
    assert bar.volume_mm3 == pytest.approx(np.pi * radius**2 * 10 * radius, rel=1e-9)
    assert tube.volume_mm3 == pytest.approx(np.pi * (radius**2 - inner**2) * 10 * radius, rel=1e-9)
    joined = tube.volume_mm3 * tube.centroid + core.volume_mm3 * core.centroid
    np.testing.assert_allclose(joined / bar.volume_mm3, bar.centroid, atol=1e-9 * 1e4)
    for normal, plane, side in zip(bar.normals, planes, (-1, 1), strict=True):
        expected = side * np.array([1, *-plane[1:]]) / np.sqrt(1 + plane[1:] @ plane[1:])
        np.testing.assert_allclose(normal, place.axes.T @ expected, atol=1e-9)
    np.testing.assert_allclose(tube.normals, bar.normals, atol=1e-9)


@pytest.mark.parametrize(("first", "second"), [(0.0, 0.0), (0.8, -0.5), (-1.2, -1.2)])
def test_an_oblique_bar_by_points(first: float, second: float) -> None:
    across = np.array([0.6, 0.8])
    solid = Solid(
        round_vertices([2.0], np.array([0, *(first * across)]), np.array([9.0, *(second * across)])), shaft_topology()
    )
    low, high = np.array([-4.0, -2, -2]), np.array([13.0, 2, 2])
    points = np.random.default_rng(0).uniform(low, high, (400_000, 3))
    lean = points[:, 1:] @ across
    inside = (np.hypot(points[:, 1], points[:, 2]) < 2) & (points[:, 0] > first * lean)
    counted(solid, inside & (points[:, 0] < 9 + second * lean), points, float(np.prod(high - low)))


def test_a_drilled_block_by_points() -> None:
    solid = drilled_block()
    points = np.random.default_rng(1).uniform([-30, -30, 0], [30, 30, 40], (400_000, 3))
    x, y, z = points.T
    bored = (np.hypot(x, y) < 6) | ((np.hypot(x, z - 20) < 4) & (y < -10)) | ((np.hypot(y, z - 20) < 4) & (x > 10))
    counted(solid, ~bored, points, 60 * 60 * 40)
    np.testing.assert_allclose(solid.normals[:2], [[0, 0, -1], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(solid.normals[6:], [[0, -1, 0], [1, 0, 0]], atol=1e-12)  # out of the steel


@each
@given(
    st.sampled_from(["flat 120x12", "rhs 120x60x5", "tee 120x80x10x8", "i 120x80x10x8"]),
    st.tuples(slopes, slopes),
    st.tuples(slopes, slopes),
)
def test_profiles_between_oblique_planes(name: str, first: tuple[float, float], second: tuple[float, float]) -> None:
    """All of a profile is cut at the same planes: its volume is its area times the distance at its centre of area."""
    section = Section.of(name)
    planes = np.array([0.0, *first]), np.array([900.0, *second])
    topology = profile_topology(section.loops)
    assert profile_topology(section.loops) is topology
    solid = Solid(profile_vertices(section.loops, *planes), topology)
    points = np.concatenate(section.loops)
    pieces = [Solid(solid.vertices[vertices], own) for vertices, own in topology.pieces]
    volume = sum(piece.volume_mm3 for piece in pieces) if pieces else solid.volume_mm3
    assert solid.volume_mm3 == pytest.approx(volume, rel=1e-12)
    if name[:3] != "tee":
        assert solid.volume_mm3 == pytest.approx(900 * section.area_mm2, rel=1e-12)
    for normal, plane, side in zip(solid.normals, planes, (-1, 1), strict=False):
        expected = side * np.array([1, *-plane[1:]]) / np.sqrt(1 + plane[1:] @ plane[1:])
        np.testing.assert_allclose(normal, expected, atol=1e-9)
    assert len(points) * 2 == topology.n_vertices


def test_a_wall_with_a_hand_hole() -> None:
    """The hole takes its area times the wall; its sides look into it."""
    section = Section.of("rhs 120x60x5")
    whole = profile_topology(section.loops)
    holed = whole.pierced(
        3, 7, 4
    )  # from the wall at y = +30 to the inside of that wall, which begins at inner corner 1
    bar = profile_vertices(section.loops, np.zeros(3), np.array([900.0, 0, 0]))
    outside = np.array([[300.0, 30, -20], [370.0, 30, -20], [370.0, 30, 20], [300.0, 30, 20]])
    hole = np.concatenate([outside[::-1], outside[::-1] - [0, 5.0, 0]])
    solid, plain = Solid(np.concatenate([bar, hole]), holed), Solid(bar, whole)
    np.testing.assert_allclose(plain.normals[[3, 7]], [[0, 1, 0], [0, -1, 0]], atol=1e-12)
    assert abs(plain.volume_mm3 - solid.volume_mm3) == pytest.approx(70 * 40 * 5)
    assert len(holed.pieces) == 4


def test_what_is_no_solid() -> None:
    cube = prism_topology(4)
    with pytest.raises(ValueError, match="none of them a corner"):
        Topology(8, cube.corners, cube.loop_starts, cube.face_starts, np.array([[0, 1, 2, 3, 0, 1, BORE]]))
    with pytest.raises(ValueError, match=r"shaft .1. or a bore"):
        cube.bored([(0, 7)])
    with pytest.raises(ValueError, match=r"shaft .1. or a bore"):
        cube.bored([(0, 1)], sense=2)
    with pytest.raises(ValueError, match="must lean in one plane"):
        round_vertices([2.0], np.array([0.0, 0.5, 0]), np.array([9.0, 0, 0.5]))
    assert cube.bored([(1, None)], sense=SHAFT).pieces[1][1] is shaft_topology()


def clearance(solid: Solid) -> float:
    return round_clearances(Measures(solid.topology, solid.vertices[None])).item()


@pytest.mark.parametrize("name", SOLIDS)
def test_sound_solids_have_clearances(name: str) -> None:
    assert clearance(SOLIDS[name]) > 0


@each
@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(1, 20), st.floats(-1, 1), seeds)
def test_clearance_of_a_bore_in_a_plate(x: float, y: float, radius: float, slope: float, seed: int) -> None:
    """Judged by shapely: distance of the circle's centre from the edges of a concave outline, and from another bore.
    The upper side is oblique, so that the edge there is an ellipse; seen along the bore it is the same circle."""
    outline = np.array([[-40.0, -40], [40, -40], [40, 40], [0, 10], [-40, 40]])
    corners = prism_vertices(outline, 0.0, 100.0)
    corners[5:, 2] += slope * corners[5:, 0]
    bores = [
        round_vertices([r], np.array([0.0, 0, 0]), np.array([100.0, slope, 0]), at=at)[:, [1, 2, 0]]
        for r, at in ((radius, (x, y)), (5.0, (-20.0, -20.0)))
    ]
    place = frame(seed % 999)
    solid = Solid(place.to_world(np.concatenate([corners, *bores])), prism_topology(5).bored([(0, 1), (0, 1)]))
    plate, centre = shapely.Polygon(outline), shapely.Point(x, y)
    inside = plate.contains(centre)
    from_edges = (1 if inside else -1) * plate.exterior.distance(centre) - radius
    least = min(from_edges, np.hypot(x + 20, y + 20) - 5 - radius, 15.0)
    found = clearance(solid)
    assert np.sign(found) == np.sign(least) or abs(least) < 1e-9
    if inside:
        assert found == pytest.approx(least, abs=1e-9)


def test_a_tube_has_a_wall() -> None:
    shift = np.array([0.0, 0, 6.0])
    pipe = SOLIDS["tube"]
    assert clearance(pipe) == pytest.approx(4.0)
    off = pipe.vertices + np.repeat([0 * shift, shift], 4, axis=0)
    assert clearance(Solid(off, pipe.topology)) == pytest.approx(-2.0)
