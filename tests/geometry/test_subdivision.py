"""Subdivision by Catmull and Clark: B-splines on regular quads, limits elsewhere, the boundary, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from geometry import Mesh, MeshError, subdivided
from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.mesh import shapes, solids

seeds = st.integers(0, 2**32 - 1)

OPEN = [shapes.grid(4, 3), shapes.hexagonal_paraboloid(3, 3), shapes.dome(9, 3), shapes.double_ring()]
CLOSED = [solids.cube(), shapes.regular_prism(7), shapes.box(3.0, 2.0, 1.0), solids.dodecahedron()]


def moved(mesh: Mesh, seed: int) -> Mesh:
    return mesh.with_vertices(mesh.vertices + np.random.default_rng(seed).normal(size=mesh.vertices.shape))


def with_phantoms(points: FloatArray) -> FloatArray:
    """One more control point at each end of (n, ...), where the line through the last two continues."""
    return np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])


def spline(points: FloatArray, parameters: FloatArray) -> FloatArray:
    """Uniform cubic B-spline of control points (n, ...), at parameters from 0 to n - 1."""
    padded = with_phantoms(points)
    return np.asarray(BSpline(np.arange(len(padded) + 4) - 3.0, padded, 3)(parameters))


def limits_of_quads(mesh: Mesh) -> FloatArray:
    """(N, 3) where the vertices go at last [HalsteadKassDeRose1993], at the boundary on the cubic B-spline."""
    c, n = mesh.combinatorics, mesh.combinatorics.vertex_degrees[:, None]
    ends, opposite, rim = np.zeros((3, c.n_vertices, 3))
    np.add.at(ends, c.edges, mesh.vertices[c.edges[:, ::-1]])
    np.add.at(opposite, c.corners, mesh.vertices[c.corners[c.next_corner[c.next_corner]]])
    outer = c.edges[c.is_boundary_edge]
    np.add.at(rim, outer, mesh.vertices[outer[:, ::-1]])
    inside = (n**2 * mesh.vertices + 4 * ends + opposite) / (n * (n + 5))
    return np.where(c.is_boundary_vertex[:, None], (4 * mesh.vertices + rim) / 6, inside)


@given(seeds, st.integers(2, 5), st.integers(2, 5), st.integers(1, 3))
def test_regular_quads_converge_to_the_bicubic_b_spline(seed: int, nx: int, ny: int, times: int) -> None:
    heights = np.random.default_rng(seed).normal(size=(nx + 1, ny + 1))
    grid = shapes.grid(nx, ny)
    control = grid.with_vertices(np.column_stack([grid.vertices[:, :2], heights.ravel()]))
    fine = subdivided(control, times, corners=[0, ny, nx * (ny + 1), nx * (ny + 1) + ny])
    limits = limits_of_quads(fine)
    limits[[0, ny, nx * (ny + 1), nx * (ny + 1) + ny]] = control.vertices[[0, ny, nx * (ny + 1), nx * (ny + 1) + ny]]
    # u, v are their own splines: a linear function stays as it is, at the ends through the corners too
    u, v = limits[:, 0], limits[:, 1]
    of_columns = spline(heights, u)  # (n, ny + 1)
    expected = [spline(row, np.array([at]))[0] for row, at in zip(of_columns, v, strict=True)]
    np.testing.assert_allclose(limits[:, 2], expected, atol=1e-12)
    # all parameters of the finer grid are there
    steps = [np.arange(n * 2**times + 1) / 2**times for n in (nx, ny)]
    found = limits[np.lexsort((v.round(9), u.round(9))), :2]
    np.testing.assert_allclose(found, np.stack(np.meshgrid(*steps, indexing="ij"), axis=2).reshape(-1, 2), atol=1e-12)


@given(seeds, st.sampled_from(OPEN + CLOSED))
def test_vertices_keep_the_place_where_they_go_at_last(seed: int, mesh: Mesh) -> None:
    coarse = subdivided(moved(mesh, seed), corners=())  # quads, at extraordinary vertices too
    fine = subdivided(coarse, corners=())
    once, kinks = np.unique(fine.combinatorics.edges[fine.combinatorics.is_boundary_edge], return_counts=True)
    single = ~np.isin(np.arange(coarse.n_vertices), once[kinks > 2])
    found, expected = limits_of_quads(fine)[: coarse.n_vertices], limits_of_quads(coarse)
    np.testing.assert_allclose(found[single], expected[single], atol=1e-12)


@given(seeds, st.sampled_from(OPEN + CLOSED), st.integers(1, 2))
def test_each_corner_of_a_face_becomes_a_quad(seed: int, mesh: Mesh, times: int) -> None:
    mesh = moved(mesh, seed)
    fine = subdivided(mesh, times)
    assert fine.n_faces == mesh.combinatorics.n_corners * 4 ** (times - 1)
    assert set(fine.combinatorics.face_sizes.tolist()) == {4}
    assert fine.combinatorics.euler_characteristic == mesh.combinatorics.euler_characteristic
    assert len(fine.combinatorics.boundary_loops) == len(mesh.combinatorics.boundary_loops)
    # orientation: the new face at a corner turns as the old one does
    flat = shapes.grid(3, 3)
    assert (subdivided(flat, times).face_normals @ flat.face_normals[0] > 0.999).all()


@given(seeds, st.sampled_from(OPEN + CLOSED))
def test_subdivision_goes_along_with_affine_maps(seed: int, mesh: Mesh) -> None:
    rng = np.random.default_rng(seed)
    matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    mapped = subdivided(mesh.with_vertices(mesh.vertices @ matrix + shift), 2, corners=())
    expected = subdivided(mesh, 2, corners=()).vertices @ matrix + shift
    np.testing.assert_allclose(mapped.vertices, expected, atol=1e-12 * np.abs(expected).max())


@given(seeds)
def test_the_boundary_depends_on_the_boundary_alone_and_corners_stay(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = shapes.grid(5, 4)
    rim = grid.combinatorics.is_boundary_vertex
    other = grid.with_vertices(grid.vertices + np.where(rim, 0.0, 1.0)[:, None] * rng.normal(size=(30, 3)))
    fine, changed = subdivided(grid, 2), subdivided(other, 2)
    on_rim = fine.combinatorics.is_boundary_vertex
    np.testing.assert_array_equal(fine.vertices[on_rim], changed.vertices[on_rim])
    assert not np.allclose(fine.vertices, changed.vertices)
    corners = [0, 4, 25, 29]
    np.testing.assert_array_equal(fine.vertices[corners], grid.vertices[corners])
    round_all = subdivided(grid, corners=())
    np.testing.assert_allclose(round_all.vertices[0], [1 / 8, 1 / 8, 0], atol=1e-15)  # (6 v + a + b) / 8
    one = subdivided(grid, 2, corners=[29])
    np.testing.assert_array_equal(one.vertices[29], grid.vertices[29])
    assert np.abs(one.vertices[0] - grid.vertices[0]).max() > 0.1


def test_kinks_of_the_boundary_are_corners_by_themselves() -> None:
    bent = shapes.grid(2, 1)  # the middle of the long sides bent by 30 and by 40 degrees
    for degrees, stays in ((30.0, False), (40.0, True)):
        turn = np.radians(degrees)
        vertices = bent.vertices.copy()
        vertices[4:] = [[1 + np.cos(turn), y, np.sin(turn)] for y in (0.0, 1.0)]
        fine = subdivided(bent.with_vertices(vertices))
        assert np.allclose(fine.vertices[2], [1, 0, 0]) == stays


def test_a_vertex_where_two_pieces_of_the_boundary_meet_stays() -> None:
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-3, 0, 0], [-3, -2, 0], [0, -2, 0], [9, 9, 9]]
    pinched = Mesh.from_faces(vertices, [[0, 1, 2, 3], [0, 4, 5, 6]])
    fine = subdivided(pinched, 2, corners=())
    np.testing.assert_array_equal(fine.vertices[0], [0, 0, 0])
    np.testing.assert_array_equal(fine.vertices[7], [9, 9, 9])  # belongs to no face
    assert not np.allclose(fine.vertices[2], [1, 1, 0])


def test_a_cube_is_as_the_paper_has_it() -> None:
    fine = subdivided(solids.cube())  # corners at (1, 1, 1): F = (1, 1, 1) / 3, R = (2, 2, 2) / 3, so (5, 5, 5) / 9
    np.testing.assert_allclose(np.abs(fine.vertices[:8]), np.full((8, 3), 5 / 9), atol=1e-15)
    np.testing.assert_allclose(np.sort(np.abs(fine.vertices[8:20])), np.tile([0, 0.75, 0.75], (12, 1)), atol=1e-15)
    np.testing.assert_allclose(np.sort(np.abs(fine.vertices[20:])), np.tile([0, 0, 1], (6, 1)), atol=1e-15)


def test_what_is_refused() -> None:
    grid = shapes.grid(3, 3)
    assert subdivided(grid, 0) is grid
    for times in (-1, 1.5):
        with pytest.raises(GeometryError, match=f"subdivided {times} times: a whole number from 0 upwards"):
            subdivided(grid, times)  # type: ignore[arg-type]
    with pytest.raises(GeometryError, match=r"subdivided 12 times the mesh would have 1.5e\+08 faces, at most 5e\+06"):
        subdivided(grid, 12)
    for vertex in (5, 16, -1):
        with pytest.raises(
            MeshError, match=f"vertex {vertex} is to be a corner of the boundary, but it is not on the boundary"
        ):
            subdivided(grid, corners=[0, vertex])
