"""Circle patterns in the plane: given radii and angles are met, kites fill what they should, or are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import Polygon

from geometry.arrays import FloatArray
from geometry.circle_patterns.boundary_values import open_circle_pattern
from geometry.circle_patterns.circle_pattern import CirclePattern
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron, koebe
from geometry.errors import GeometryError, MeshError
from geometry.mesh import Combinatorics, shapes
from geometry.mesh.tilings import (
    hexagon_patch,
    pentagon_patch,
    quad_patch,
    rotational_hexagons,
    rotational_quads,
)
from geometry.optimise.solution import ConvergenceError, Reason
from geometry.spheres.stereographic import circle_planes, line_planes, pairs, plane_circles, poles, to_plane, to_sphere
from tests.geometry.random_polyhedra import random_polyhedron
from tests.geometry.test_koebe import assert_koebe, misfit_up_to_rotation

ROUNDING = 1e-12
seeds = st.integers(0, 2**32 - 1)
DISCS = {
    "quads": quad_patch(5, 4),
    "hexagons": hexagon_patch(4, 3),
    "pentagons": pentagon_patch(3, 4),
    "one triangle": Combinatorics.from_faces(3, [[0, 1, 2]]),
    "part of a solid": shapes.cap(shapes.icosahedron(), -0.9).combinatorics,
}
RINGS = {
    "quads": rotational_quads(7, 3),
    "hexagons": rotational_hexagons(6, 4),
    "pentagons": pentagon_patch(8, 3, closed=True),
}


def on_boundary(c: Combinatorics, values: FloatArray) -> FloatArray:
    return np.where(c.is_boundary_vertex, values, np.nan)


def random_disc(rng: np.random.Generator, n: int, kind: str) -> Combinatorics:
    """A random polyhedron without a vertex and the faces around it."""
    c = random_polyhedron(rng, n, kind)
    vertex = int(rng.integers(c.n_vertices))
    faces = [face for face in c.faces if vertex not in face]
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    return Combinatorics(len(used), corners, np.cumsum([0] + [len(face) for face in faces]))


def assert_pattern(pattern: CirclePattern) -> None:
    """Circles that meet are orthogonal, and neighbours touch; so the kites fill 2 pi inside."""
    c = pattern.combinatorics
    v, f = c.corners, c.n_vertices + c.corner_face
    squares = pattern.radii[v] ** 2 + pattern.radii[f] ** 2
    np.testing.assert_allclose(np.abs(pattern.centres[v] - pattern.centres[f]) ** 2, squares, rtol=1e-10)
    i, j = c.edges.T
    np.testing.assert_allclose(
        np.abs(pattern.centres[i] - pattern.centres[j]), pattern.radii[i] + pattern.radii[j], rtol=1e-10
    )
    np.testing.assert_allclose(pattern.vertex_angles[~c.is_boundary_vertex], 2 * np.pi, atol=ROUNDING)
    along = np.abs(pattern.tangency_points - pattern.centres[i])
    np.testing.assert_allclose(along, pattern.radii[i], rtol=1e-10)
    areas = np.imag(np.conj(pattern.centres[i]) * pattern.centres[j])  # faces run counter-clockwise
    assert np.bincount(c.edge_faces[:, 0], areas).sum() - areas[~c.is_boundary_edge].sum() > 0


# --- the stereographic projection


@given(seeds)
def test_points_there_and_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(20, 2)) * 10 ** rng.uniform(-6, 6, size=(20, 1))
    lifted = to_sphere(points)
    np.testing.assert_allclose(np.linalg.norm(lifted, axis=1), 1, rtol=1e-15)
    np.testing.assert_allclose(to_plane(lifted), points, rtol=1e-14)


@given(seeds)
def test_circles_and_lines_go_to_circles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    centres, radii = rng.normal(size=(20, 2)) * 3, rng.uniform(0.1, 10, size=20)
    normals, heights = circle_planes(centres, radii)
    angles = rng.uniform(0, 2 * np.pi, size=20)
    round_about = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-14)
    on_circles = to_sphere(centres + radii[:, None] * round_about)
    np.testing.assert_allclose(np.einsum("ci,ci->c", normals, on_circles), heights, atol=1e-13)
    assert (np.einsum("ci,ci->c", normals, to_sphere(centres)) > heights).all()
    back, sizes = plane_circles(normals, heights)
    np.testing.assert_allclose(back, centres, atol=1e-9)  # small far circles are flat near the pole
    np.testing.assert_allclose(sizes, radii, rtol=1e-9)
    apices = poles(normals, heights)  # the lines from the apex of the cone to its circle are tangents
    np.testing.assert_allclose(
        np.einsum("ci,ci->c", apices - on_circles, on_circles), 0, atol=1e-10 * np.abs(apices).max()
    )

    normals, heights = line_planes(round_about, radii)
    beside = radii[:, None] * round_about + rng.normal(size=(20, 1)) * round_about[:, ::-1] * [-1, 1]
    np.testing.assert_allclose(np.einsum("ci,ci->c", normals, to_sphere(beside)), heights, atol=1e-14)
    np.testing.assert_allclose(normals[:, 2], heights, atol=1e-15)  # through the north pole
    assert (np.einsum("ci,ci->c", normals, to_sphere(beside + round_about)) > heights).all()


# --- given radii and angles


@given(seeds, st.sampled_from(sorted(DISCS)))
@settings(max_examples=30)
def test_given_radii_are_met(seed: int, name: str) -> None:
    c = DISCS[name]
    radii = on_boundary(c, np.exp(np.random.default_rng(seed).normal(size=c.n_vertices)))
    pattern = open_circle_pattern(c, radii=radii)
    np.testing.assert_array_equal(pattern.vertex_radii[c.is_boundary_vertex], radii[c.is_boundary_vertex])
    assert_pattern(pattern)


@given(seeds, st.sampled_from(sorted(DISCS)))
@settings(max_examples=30)
def test_given_angles_are_met_and_give_the_radii_again(seed: int, name: str) -> None:
    c = DISCS[name]
    rng = np.random.default_rng(seed)
    known = open_circle_pattern(c, radii=on_boundary(c, np.exp(rng.normal(size=c.n_vertices))))
    angles = on_boundary(c, known.vertex_angles)
    found = open_circle_pattern(c, angles=angles)
    np.testing.assert_allclose(found.vertex_angles, known.vertex_angles, atol=1e-11)
    ratios = found.radii / known.radii
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-9)
    sized = rng.random(c.n_vertices) < 0.5  # some of each
    sized[c.boundary_loops[0][0]] = True
    mixed = open_circle_pattern(
        c, radii=np.where(sized, on_boundary(c, known.vertex_radii), np.nan), angles=np.where(sized, np.nan, angles)
    )
    np.testing.assert_allclose(mixed.radii, known.radii, rtol=1e-9)


@given(seeds, st.sampled_from(["triangles", "simple", "mixed"]))
@settings(max_examples=20)
def test_random_discs_with_free_boundaries(seed: int, kind: str) -> None:
    c = random_disc(np.random.default_rng(seed), 30, kind)
    pattern = open_circle_pattern(c)
    np.testing.assert_array_equal(pattern.vertex_radii[c.is_boundary_vertex], 1)
    assert_pattern(pattern)
    assert_koebe(koebe(c, coverage=0.3))


@pytest.mark.parametrize("name", ["quads", "hexagons"])
def test_free_boundaries_of_regular_patches_give_the_regular_tiling(name: str) -> None:
    pattern = open_circle_pattern(DISCS[name])
    np.testing.assert_allclose(pattern.vertex_radii, 1, rtol=1e-12)
    np.testing.assert_allclose(pattern.face_radii, {"quads": 1.0, "hexagons": 3**0.5}[name], rtol=1e-12)


def test_equal_radii_vary_least() -> None:
    """Against waves along the boundary of a random disc."""
    c = random_disc(np.random.default_rng(1), 150, "simple")
    i, j = c.edges.T

    def variation(radii: FloatArray) -> float:
        return float(np.square(np.log(radii[i] / radii[j])).sum())

    least = variation(open_circle_pattern(c).vertex_radii)
    rng = np.random.default_rng(2)
    loop = c.boundary_loops[0]
    turns = 2 * np.pi * np.arange(len(loop)) / len(loop)
    for wave in range(1, 4):  # smooth choices
        radii = np.full(c.n_vertices, np.nan)
        radii[loop] = np.exp(0.3 * np.cos(wave * turns + rng.uniform(0, 2 * np.pi)))
        assert variation(open_circle_pattern(c, radii=radii).vertex_radii) > least


# --- rings


@pytest.mark.parametrize("name", sorted(RINGS))
def test_rings_close(name: str) -> None:
    c = RINGS[name]
    pattern = open_circle_pattern(c)
    assert_pattern(pattern)
    assert_koebe(koebe(c, coverage=1.0))
    outer, hole = sorted(c.boundary_loops, key=len, reverse=True)
    given_radii = np.full(c.n_vertices, np.nan)
    given_radii[outer], given_radii[hole] = 2.0, 5.0
    found = open_circle_pattern(c, radii=given_radii, outer=int(outer[0]))
    np.testing.assert_array_equal(found.vertex_radii[outer], 2)
    np.testing.assert_allclose(found.vertex_radii[hole], found.vertex_radii[hole[0]], rtol=1e-14)
    np.testing.assert_allclose(found.vertex_angles[hole].sum(), (len(hole) + 2) * np.pi, rtol=1e-13)
    angles = on_boundary(c, found.vertex_angles)
    again = open_circle_pattern(c, angles=angles, outer=int(outer[0]))
    np.testing.assert_allclose(again.radii / again.radii[0], found.radii / found.radii[0], rtol=1e-9)


def test_quads_around_an_axis_have_radii_in_a_geometric_sequence() -> None:
    """Known in the plane: the square grid wound up by the exponential function, of circles of ratio q."""
    n, rings = 8, 5
    c = rotational_quads(n, rings)
    radii = np.full(c.n_vertices, np.nan)
    radii[[*range(0, c.n_vertices, rings + 1), *range(rings, c.n_vertices, rings + 1)]] = 1
    found = open_circle_pattern(c, radii=radii, outer=0).vertex_radii.reshape(n, rings + 1)
    np.testing.assert_allclose(found, np.broadcast_to(found[0], found.shape), rtol=1e-12)
    a = np.pi / n  # half the angle of a vertex seen from the axis; r / R = sin a for circles in one ring of n
    ratios = found[0, 1:] / found[0, :-1]
    np.testing.assert_allclose(ratios, (1 - np.sin(a)) / (1 + np.sin(a)), rtol=1e-11)


def test_an_irregular_hole_is_filled_for_the_time_being() -> None:
    c = random_polyhedron(np.random.default_rng(3), 60, "triangles")
    first = int(np.argmax(c.vertex_degrees))
    one_round = c.adjacency + c.adjacency @ c.adjacency
    far = np.flatnonzero((c.adjacency @ one_round)[[first]].toarray()[0] == 0)
    faces = [face for face in c.faces if first not in face and far[0] not in face]
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    ring = Combinatorics(len(used), corners, np.cumsum([0] + [len(face) for face in faces]))
    assert ring.euler_characteristic == 0
    S = koebe(ring, coverage=0.8)
    assert_koebe(S)
    hole = min(ring.boundary_loops, key=len)
    points = S.mesh.vertices[hole]  # of the hole: in a plane, as its face was
    assert np.linalg.svd(points - points.mean(axis=0))[1][2] < 1e-12
    radii = np.full(ring.n_vertices, np.nan)
    radii[np.concatenate(ring.boundary_loops)] = 1
    with pytest.raises(GeometryError, match="the circle pattern does not close around a hole"):
        koebe(ring, radii=radii)


def test_holes_of_any_shape_and_number() -> None:
    """One a square, filled with a face; the other an L, whose inner corner has two edges: filled with triangles."""
    faces = shapes.grid(9, 7).combinatorics.faces
    taken = [7 * i + j for i, j in ((2, 2), (2, 3), (3, 2), (3, 3), (6, 3), (6, 4), (7, 4))]
    kept = [face for k, face in enumerate(faces) if k not in taken]
    used, corners = np.unique(np.concatenate(kept), return_inverse=True)
    c = Combinatorics(len(used), corners, np.arange(0, len(corners) + 1, 4))
    outer = max(c.boundary_loops, key=len)
    radii = np.full(c.n_vertices, np.nan)
    radii[outer] = np.random.default_rng(4).uniform(0.8, 1.2, size=len(outer))
    pattern = open_circle_pattern(c, radii=radii)
    np.testing.assert_array_equal(pattern.vertex_radii[outer], radii[outer])
    assert_pattern(pattern)
    assert_koebe(koebe(c))


# --- on the sphere


@given(st.sampled_from(sorted(DISCS)), st.floats(0.05, 0.9))
@settings(max_examples=20)
def test_the_coverage_says_where_the_centre_is(name: str, coverage: float) -> None:
    S = koebe(DISCS[name], coverage=coverage)
    assert_koebe(S)
    np.testing.assert_allclose(S.tangency_points.mean(axis=0), [0, 0, 1 - coverage], atol=1e-13)
    first = S.mesh.vertices[0]
    assert first[0] > 0
    assert abs(first[1]) < ROUNDING


def test_all_coverages_are_moebius_images_of_each_other() -> None:
    one, two = (koebe(DISCS["pentagons"], coverage=share) for share in (0.2, 0.7))
    assert misfit_up_to_rotation(one.normalised().mesh.vertices, two.normalised().mesh.vertices) <= 1e-11
    np.testing.assert_allclose(one.normalised().tangency_points.mean(axis=0), 0, atol=1e-13)


@given(seeds, st.sampled_from(sorted(DISCS)), st.floats(0.01, 1))
@settings(max_examples=30)
def test_where_nothing_overlaps_all_vertices_are_finite_and_all_faces_seen_from_the_origin(
    seed: int, name: str, coverage: float
) -> None:
    c = DISCS[name]
    radii = on_boundary(c, np.exp(np.random.default_rng(seed).normal(size=c.n_vertices)))
    (loop,) = c.boundary_loops
    assume(Polygon(pairs(open_circle_pattern(c, radii=radii).centres[loop])).is_valid)
    S = koebe(c, radii=radii, coverage=coverage)
    assert (S.vertex_circles.distances > 0).all()
    assert (S.face_circles.distances > -ROUNDING).all()  # 0 where a single face covers all


def test_a_vertex_beyond_infinity_is_refused() -> None:
    c = DISCS["quads"]
    radii = on_boundary(c, np.exp(2 * np.random.default_rng(47).normal(size=c.n_vertices)))
    with pytest.raises(
        GeometryError, match=r"the plane of the circle of vertex 29 .* overlaps itself, ask for radii or"
    ):
        koebe(c, radii=radii, coverage=1.0)


# --- what is refused


def test_values_that_cannot_be() -> None:
    c = DISCS["quads"]  # vertex (i, j) is 5 i + j; 6 is inside
    nothing = np.full(c.n_vertices, np.nan)
    free = open_circle_pattern(c)
    radii, angles = on_boundary(c, free.vertex_radii), on_boundary(c, free.vertex_angles)

    def changed(values: FloatArray, vertex: int, value: float) -> FloatArray:
        other = values.copy()
        other[vertex] = value
        return other

    too_wide = "vertex 0 is given the angle 3.14159: it must be above 0 and less than pi for"
    wrong_sum = r"angles along the outer boundary through vertex .* must be exactly 50\.26548246"
    for refused, message in (
        ({"radii": changed(radii, 6, 1.0)}, "vertex 6 is inside and is given radii"),
        ({"radii": changed(radii, 2, -1.0)}, "vertex 2 is given the radius -1: a number above 0"),
        ({"radii": changed(radii, 2, np.inf)}, "finite numbers are needed"),
        ({"radii": changed(radii, 2, np.nan)}, "vertex 2 is given neither a radius nor an angle"),
        ({"radii": radii[:-1]}, r"radii have shape \(29,\), one for each of 30 vertices"),
        ({"radii": radii, "angles": changed(nothing, 1, 3.0)}, "vertex 1 is given a radius and an angle"),
        ({"angles": changed(angles, 0, np.pi)}, too_wide),
        ({"angles": changed(angles, 1, angles[1] + 1e-3)}, wrong_sum),
        ({"outer": 6}, "vertex 6 is not on the boundary"),
    ):
        with pytest.raises(GeometryError, match=message):
            koebe(c, **refused)
    for share in (0.0, 1.1, np.nan):
        with pytest.raises(GeometryError, match="the coverage is"):
            koebe(c, coverage=share)


@given(seeds)
@settings(max_examples=10)
def test_angles_that_no_pattern_has(seed: int) -> None:
    """The vertices of one face ask for nearly pi at each of their faces, and the face itself for 2 pi."""
    rng = np.random.default_rng(seed)
    c = DISCS["hexagons"]
    boundary = np.flatnonzero(c.is_boundary_vertex)
    n_outside = np.bincount(c.corner_face, c.is_boundary_vertex[c.corners])
    face = int(rng.choice(np.flatnonzero(n_outside >= 4)))
    crowd = np.intersect1d(c.face(face), boundary)
    n_faces = np.bincount(c.corners)
    angles = np.full(c.n_vertices, np.nan)
    angles[crowd] = n_faces[crowd] * np.pi - 0.1
    rest = np.setdiff1d(boundary, crowd)
    left = (len(boundary) - 2) * np.pi - angles[crowd].sum()
    angles[rest] = left * n_faces[rest] / n_faces[rest].sum()
    assume((angles[rest] < np.pi * n_faces[rest]).all() and (angles[rest] > 0).all())
    asked, room = angles[crowd].sum() + 2 * np.pi, np.pi * (n_faces[crowd].sum() + 6 - len(crowd))
    assume(asked > room)
    with pytest.raises(
        GeometryError, match=rf"there is no circle pattern .* face.*{face}.* radians, and must be less than"
    ) as caught:
        open_circle_pattern(c, angles=angles)
    assert caught.value.value >= caught.value.bound


def test_a_neck_too_long_and_thin() -> None:
    with pytest.raises(
        ConvergenceError, match=r"its radii differ by a factor of .*e\+\d\d, and beyond 1e\+14"
    ) as caught:
        koebe(rotational_quads(5, 60))
    assert caught.value.solution.reason is Reason.STALLED


def test_open_meshes_that_touch_themselves() -> None:
    faces = shapes.grid(3, 3).combinatorics.faces
    faces = [face for k, face in enumerate(faces) if k not in (4, 8)]
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    with pytest.raises(MeshError, match="the boundary passes twice through vertex 10"):
        koebe(Combinatorics(len(used), corners, np.arange(0, len(corners) + 1, 4)))


def test_a_koebe_polyhedron_of_one_face() -> None:
    S = koebe(Combinatorics.from_faces(5, [[0, 1, 2, 3, 4]]), coverage=0.1)
    assert isinstance(S, KoebePolyhedron)
    np.testing.assert_allclose(S.face_circles.normals, [[0, 0, 1]], atol=1e-14)
    assert S.vertex_circles.radii.std() < 1e-14
