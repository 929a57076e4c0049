"""Hexagonal meshes that touch a surface: against support functions in closed form, and what is said where it fails."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.edge_offset.tangent_hexagons import TangentMesh, mesh_with_planes, tangent_mesh
from geometry.errors import GeometryError
from geometry.files import read_mesh
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.intersections.meeting_faces import intersecting_faces, self_crossing_faces
from geometry.parallel import edge_factors, parallelity
from geometry.surface import Surface
from tests.geometry.bent_meshes import rotation
from tests.geometry.tiling_polyhedra import tiling_polyhedron
from tests.geometry.topologies import split, together, without
from tests.real_data.meshes import DATA, needs_data

PATCH = tiling_polyhedron("hexagons", scale=0.2, turn=0.1)
FLAT_PATCH = tiling_polyhedron("hexagons", scale=0.06)
CLOSED = [shapes.dodecahedron(), solids.truncated_icosahedron(), solids.cube(), solids.truncated_octahedron()]
seeds = st.integers(0, 2**32 - 1)
polyhedra = st.sampled_from([*CLOSED, PATCH, FLAT_PATCH])
AXES = np.array([1.4, 1.0, 0.8])
"""Of an ellipsoid, whose support function is |A n|."""


def corner_heights(mesh: Mesh, koebe: Mesh) -> FloatArray:
    """(C,) of the corners of M over the origin, along the normals of their faces in S."""
    c = mesh.combinatorics
    return np.einsum("ci,ci->c", mesh.vertices[c.corners], koebe.face_normals[c.corner_face])


def offset_deviation(mesh: Mesh, koebe: Mesh) -> float:
    """How far the edge lines of M + S are from distance 1 from those of M, by M and M + S alone."""
    offset, tails = mesh + koebe, mesh.combinatorics.edges[:, 0]
    along = offset.edge_vectors / offset.edge_lengths[:, None]
    across = np.cross(along, offset.vertices[tails] - mesh.vertices[tails])
    return float(np.abs(np.linalg.norm(across, axis=1) - 1).max())


def globe(n: int, axes: FloatArray = AXES) -> Surface:
    """A closed ellipsoid of 6 n^2 quads: those on the sides of a cube, at equal angles from its centre."""
    grid = shapes.grid(n, n)
    x, y = np.tan(np.pi / 4 * (2 * grid.vertices[:, :2] / n - 1)).T
    side = np.stack([x, y, np.ones_like(x)], axis=1)
    turns = [np.eye(3)[[k, (k + 1) % 3, (k + 2) % 3]].T for k in range(3)]
    mirror = np.diag([-1.0, 1.0, -1.0])
    sides = np.concatenate([side @ turn.T for turn in (*turns, *(turn @ mirror for turn in turns))])
    _, first, vertex = np.unique(np.rint(1e6 * sides), axis=0, return_index=True, return_inverse=True)
    faces = np.concatenate([np.array(grid.combinatorics.faces) + k * grid.n_vertices for k in range(6)])
    points = sides[first] / np.linalg.norm(sides[first], axis=1, keepdims=True)
    return Surface(Mesh.from_faces(points * axes, vertex.ravel()[faces].tolist()))


def barrel(n: int) -> Surface:
    """The ellipsoid of 2 n meridians about the x axis and n - 2 rings, open at its poles: even quads."""
    t = np.pi * np.arange(1, n) / n
    ball = shapes.rotational_mesh(np.stack([np.sin(t), -np.cos(t)], axis=1), 2 * n)
    return Surface(ball.with_vertices(ball.vertices[:, [2, 0, 1]] * AXES))


def ring(n: int) -> Surface:
    """A torus of radii 2 and 1; its support function is 2 r + 1 outside and 1 - 2 r inside, r = |(n_x, n_y)|."""
    t = 2 * np.pi * np.arange(n) / n
    return Surface(shapes.torus(np.stack([2 + np.cos(t), np.sin(t)], axis=1), 2 * n))


def saddle(n: int = 40) -> Surface:
    """z = (x^2 - y^2) / 4 over [-1, 1] x [-1, 1]; h(n) = (n_x^2 - n_y^2) / -n_z."""
    flat = shapes.grid(n, n)
    x, y = (flat.vertices[:, :2] * 2 / n - 1).T
    return Surface(flat.with_vertices(np.stack([x, y, (x**2 - y**2) / 4], axis=1)))


def check(found: TangentMesh, koebe: Mesh) -> None:
    """What holds of every result: parallel, planes through the points of touch, edge offsets, and a true report."""
    mesh, size = found.mesh, np.abs(found.mesh.vertices).max()
    c = mesh.combinatorics
    assert parallelity(koebe, mesh).max() <= 1e-12 * size
    heights = np.einsum("fi,fi->f", found.touching, koebe.face_normals)[c.corner_face]
    touched = ~np.isin(c.corner_face, found.missing)
    np.testing.assert_allclose(corner_heights(mesh, koebe)[touched], heights[touched], atol=2e-12 * size)
    assert np.isnan(found.touching[found.missing]).all()
    np.testing.assert_array_equal(np.flatnonzero(edge_factors(koebe, mesh) < 0), found.reversed_edges)
    np.testing.assert_array_equal(self_crossing_faces(mesh), found.self_crossing_faces)
    np.testing.assert_array_equal(intersecting_faces(mesh), found.intersecting_faces)
    assert found.is_embedded == (not len(found.self_crossing_faces) and not len(found.intersecting_faces))


# --- planes at given heights


@given(polyhedra, seeds)
@settings(max_examples=25)
def test_planes_are_where_they_are_wanted(koebe: Mesh, seed: int) -> None:
    heights = np.random.default_rng(seed).uniform(0.5, 2, koebe.n_faces)
    mesh = mesh_with_planes(koebe, heights)
    size = np.abs(mesh.vertices).max()
    wanted = heights[koebe.combinatorics.corner_face]
    np.testing.assert_allclose(corner_heights(mesh, koebe), wanted, atol=1e-12 * size)
    assert parallelity(koebe, mesh).max() <= 1e-12 * size
    inner = np.flatnonzero(~koebe.combinatorics.is_boundary_vertex)
    corners = koebe.combinatorics.corners
    for vertex in inner[:: max(1, len(inner) // 10)]:  # three planes meet in one point
        faces = koebe.combinatorics.corner_face[corners == vertex]
        expected = np.linalg.solve(koebe.face_normals[faces], heights[faces])
        np.testing.assert_allclose(mesh.vertices[vertex], expected, atol=1e-11 * size)


@given(polyhedra, st.floats(-3, 3), seeds)
@settings(max_examples=25)
def test_planes_of_s_scaled_and_moved_give_s_scaled_and_moved(koebe: Mesh, scale: float, seed: int) -> None:
    image = (koebe * scale).translated(np.random.default_rng(seed).normal(size=3))
    c = koebe.combinatorics
    heights = corner_heights(image, koebe)[c.face_starts[:-1]]
    mesh = mesh_with_planes(koebe, heights)
    np.testing.assert_allclose(mesh.vertices, image.vertices, atol=1e-7)  # boundary too


@given(seeds)
@settings(max_examples=10)
def test_the_mesh_is_linear_in_the_heights(seed: int) -> None:
    first, second = np.random.default_rng(seed).normal(size=(2, PATCH.n_faces))
    both = mesh_with_planes(PATCH, first) + 3 * mesh_with_planes(PATCH, second)
    np.testing.assert_allclose(mesh_with_planes(PATCH, first + 3 * second).vertices, both.vertices, atol=1e-8)


def test_free_planes_go_on_as_the_others() -> None:
    heights = 2.5 * corner_heights(PATCH, PATCH)[PATCH.combinatorics.face_starts[:-1]]
    heights[[0, 3, 12]] = np.nan
    np.testing.assert_allclose(mesh_with_planes(PATCH, heights).vertices, 2.5 * PATCH.vertices, atol=1e-9)


# --- surfaces


def test_an_ellipsoid_is_touched_as_its_support_function_says() -> None:
    koebe = tiling_polyhedron("hexagons", scale=0.15, turn=0.1)
    n = koebe.face_normals
    exact = np.linalg.norm(n * AXES, axis=1)
    points = n * AXES**2 / exact[:, None]
    heights_off, points_off = [], []
    for count in (12, 24, 48):
        found = tangent_mesh(koebe, barrel(count))
        check(found, koebe)
        assert not len(found.missing)
        assert found.is_embedded
        assert not len(found.reversed_edges)
        assert offset_deviation(found.mesh, koebe) <= 1e-11
        heights_off.append(np.abs(np.einsum("fi,fi->f", found.touching, n) - exact).max())
        points_off.append(np.linalg.norm(found.touching - points, axis=1).max())
    assert heights_off[2] < 1e-4
    assert heights_off[0] > 4**3 * heights_off[2]  # third order
    assert points_off[0] > 4**2 * points_off[2]  # second order


@given(st.sampled_from(CLOSED[:2]), seeds)
@settings(max_examples=10)
def test_a_closed_polyhedron_around_a_ball(solid: Mesh, seed: int) -> None:
    koebe = solid.with_vertices(solid.vertices @ rotation(seed).T)
    found = tangent_mesh(koebe, globe(20, np.full(3, 2.0)))
    check(found, koebe)
    assert found.is_embedded
    np.testing.assert_allclose(np.linalg.norm(found.touching, axis=1), 2, atol=1e-3)
    n, m = koebe.n_faces, koebe.n_edges
    assert found.report == f"{n} of {n} faces touch the surface; 0 of {m} edges run against those of S"


@pytest.mark.parametrize("curvature", [1, -1])
def test_the_two_sides_of_a_torus(curvature: int) -> None:
    koebe = PATCH.with_vertices(PATCH.vertices[:, [2, 0, 1]])  # about the x axis: away from where it is flat
    found = tangent_mesh(koebe, ring(60), curvature=curvature)
    check(found, koebe)
    n = koebe.face_normals
    across = np.linalg.norm(n[:, :2], axis=1)
    np.testing.assert_allclose(np.einsum("fi,fi->f", found.touching, n), 1 + curvature * 2 * across, atol=1e-4)
    sides = np.einsum("fi,fi->f", found.touching[:, :2], n[:, :2])
    assert (np.sign(sides) == curvature).all()
    assert (len(found.reversed_edges) > 0.3 * koebe.n_edges) == (curvature < 0)


def test_without_a_sign_one_part_of_the_torus_is_kept_to() -> None:
    """Each normal stands twice on a torus; neighbours on different sides would be torn apart."""
    koebe = PATCH.with_vertices(PATCH.vertices[:, [2, 0, 1]])
    found = tangent_mesh(koebe, ring(30))
    sides = np.einsum("fi,fi->f", found.touching[:, :2], koebe.face_normals[:, :2])
    assert len(set(np.sign(sides))) == 1


def test_several_points_of_one_part_are_chosen_by_neighbours() -> None:
    """A helicoid has each normal once a turn, and is curved negatively throughout: one part."""
    turns, across = 3, 12
    flat = shapes.grid(turns * 60, across)
    v, u = (flat.vertices[:, :2] * [2 * np.pi / 60, 2.4 / across] - [0, 1.2]).T
    helicoid = flat.with_vertices(np.stack([u * np.cos(v), u * np.sin(v), v], axis=1))
    koebe = FLAT_PATCH.with_vertices(FLAT_PATCH.vertices[:, [2, 0, 1]])
    found = tangent_mesh(koebe, Surface(helicoid))
    check(found, koebe)
    assert not len(found.missing)
    assert np.ptp(found.touching[:, 2]) < np.pi / 2  # a turn rises by 2 pi


def test_the_part_with_most_normals_is_taken() -> None:
    """A piece of a ball, with the normals of the first half of the faces, between two whole ones."""
    ball = globe(16, np.ones(3)).mesh
    towards = ball.vertices @ PATCH.face_normals[0]
    piece = Mesh.from_faces(ball.vertices, [f for f in ball.combinatorics.faces if towards[f].min() > 0.5])
    ball = ball.translated([5, 0, 0])
    for parts in ([piece, ball, ball], [ball, piece, ball], [ball, ball, piece]):
        found = tangent_mesh(PATCH, Surface(without_unused(together(*parts))))
        check(found, PATCH)
        assert found.touching[:, 0].min() > 3.9


def without_unused(mesh: Mesh) -> Mesh:
    """Without the vertices that belong to no face, which have no normal."""
    used, numbers = np.unique(mesh.combinatorics.corners, return_inverse=True)
    faces = np.split(numbers, mesh.combinatorics.face_starts[1:-1])
    return Mesh.from_faces(mesh.vertices[used], [face.tolist() for face in faces])


def test_a_saddle_has_reversed_edges() -> None:
    found = tangent_mesh(FLAT_PATCH, saddle())
    check(found, FLAT_PATCH)
    assert not len(found.missing)
    n = FLAT_PATCH.face_normals
    np.testing.assert_allclose(
        np.einsum("fi,fi->f", found.touching, n), -(n[:, 0] ** 2 - n[:, 1] ** 2) / n[:, 2], atol=1e-5
    )
    inner = np.flatnonzero(~FLAT_PATCH.combinatorics.is_boundary_edge)
    share = np.isin(inner, found.reversed_edges).mean()
    assert 0.25 < share < 0.75
    assert len(found.reversed_faces) == FLAT_PATCH.n_faces  # no fold: the outline continues as the inside
    assert found.is_embedded
    assert offset_deviation(found.mesh, FLAT_PATCH) <= 1e-11
    assert f"{len(found.reversed_edges)} of {FLAT_PATCH.n_edges} edges run against" in found.report


def test_triangles_and_quads_of_a_surface_say_the_same() -> None:
    quads = globe(30).mesh
    triangles = split(quads, *range(quads.n_faces))
    first, second = (tangent_mesh(PATCH, Surface(mesh)) for mesh in (quads, triangles))
    np.testing.assert_allclose(first.mesh.vertices, second.mesh.vertices, atol=1e-2)


# --- where it fails


def test_faces_without_a_point_to_touch_are_named() -> None:
    ball = globe(24, np.ones(3)).mesh
    upper = [face for face in ball.combinatorics.faces if ball.vertices[face, 2].min() > 0.6]
    found = tangent_mesh(PATCH, Surface(Mesh.from_faces(ball.vertices, upper)))
    check(found, PATCH)
    rim = np.radians(3)  # the normals at the boundary of a surface are off by part of a quad
    low = np.arccos(PATCH.face_normals[:, 2])
    assert set(np.flatnonzero(low > np.arccos(0.6) + rim)) <= set(found.missing.tolist())
    assert set(found.missing.tolist()) <= set(np.flatnonzero(low > np.arccos(0.7) - rim))
    assert f"the normals of faces {found.missing[0]}, {found.missing[1]}" in found.report


def test_a_mesh_that_intersects_itself_says_where() -> None:
    koebe = solids.truncated_icosahedron()
    found = tangent_mesh(koebe, ring(40), curvature=-1)
    check(found, koebe)
    assert 0 < len(found.reversed_faces) < koebe.n_faces
    fewer = found.reversed_faces
    if 2 * len(fewer) > koebe.n_faces:
        fewer = np.setdiff1d(np.arange(koebe.n_faces), fewer)
    assert f"it folds over at faces {fewer[0]}, {fewer[1]}" in found.report
    heights = np.ones(koebe.n_faces)
    heights[0] = 3.0  # its plane is beyond where its neighbours meet
    mesh = mesh_with_planes(koebe, heights)
    assert len(intersecting_faces(mesh)) or len(self_crossing_faces(mesh))
    spiky = tangent_mesh(koebe, globe(30, np.array([6.0, 1, 1])))
    check(spiky, koebe)
    assert not spiky.is_embedded
    assert "intersect" in spiky.report or "cross themselves" in spiky.report


def test_bad_input_is_named() -> None:
    with pytest.raises(GeometryError, match="vertex 0 has 4 faces, whose planes cannot move freely") as caught:
        tangent_mesh(solids.cuboctahedron(), globe(10))
    assert len(caught.value.elements) == 12
    with pytest.raises(GeometryError, match="vertex 0 has 4 faces"):
        mesh_with_planes(solids.cuboctahedron(), np.ones(14))
    with pytest.raises(GeometryError, match="the curvature is 2, its sign is needed"):
        tangent_mesh(PATCH, globe(10), curvature=2)
    with pytest.raises(GeometryError, match="no point with the normal of a face and curvature of the sign -1"):
        tangent_mesh(PATCH, globe(10), curvature=-1)
    with pytest.raises(GeometryError, match="from the other side"):
        tangent_mesh(FLAT_PATCH, Surface(saddle().mesh.reversed()))
    with pytest.raises(GeometryError, match=r"have shape \(3,\), there are"):
        mesh_with_planes(PATCH, np.ones(3))
    heights = np.ones(PATCH.n_faces)
    heights[5] = np.inf
    with pytest.raises(GeometryError, match="the height of face 5 is infinite"):
        mesh_with_planes(PATCH, heights)
    with pytest.raises(GeometryError, match="give one at least"):
        mesh_with_planes(PATCH, np.full(PATCH.n_faces, np.nan))


def test_heights_that_contradict_each_other() -> None:
    """A band of six triangles, three at each vertex: parallel ones are larger, smaller or moved, nothing else."""
    octahedron = shapes.octahedron()
    opposite = int((octahedron.face_normals @ octahedron.face_normals[0]).argmin())
    band = without(octahedron, 0, opposite)
    heights = corner_heights(band, band)[band.combinatorics.face_starts[:-1]]
    np.testing.assert_allclose(mesh_with_planes(band, 3 * heights).vertices, 3 * band.vertices, atol=1e-9)
    heights[4] *= 1.5
    with pytest.raises(GeometryError, match="the heights contradict each other: face ") as caught:
        mesh_with_planes(band, heights)
    assert caught.value.value is not None
    assert caught.value.value > 0.01
    heights[[0, 1]] = np.nan  # scale and position are left to fit the other four
    mesh_with_planes(band, heights)


def test_an_open_polyhedron_takes_any_heights() -> None:
    koebe = without(solids.truncated_icosahedron(), 0)
    heights = np.random.default_rng(0).uniform(1, 1.1, koebe.n_faces)
    found = corner_heights(mesh_with_planes(koebe, heights), koebe)
    np.testing.assert_allclose(found, heights[koebe.combinatorics.corner_face], atol=1e-11)


# --- real surfaces


@needs_data
@pytest.mark.parametrize("name", ["directional/dome.off", "directional/train-station.off"])
def test_roofs(name: str) -> None:
    roof = read_mesh(DATA / name).mesh
    size = np.ptp(roof.vertices, axis=0).max()
    roof = roof.with_vertices((roof.vertices - roof.vertices.mean(axis=0)) / size)
    up = roof if roof.vector_areas[:, 2].sum() > 0 else roof.reversed()
    koebe = tiling_polyhedron("hexagons", scale=0.03)
    found = tangent_mesh(koebe, Surface(up))
    check(found, koebe)
    assert len(found.missing) < koebe.n_faces / 2
