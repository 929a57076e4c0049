"""The exact meshes are what their docstrings say."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.exact_offsets import circularity, conicality
from geometry.files import check_faces
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.polygons import face_centroids
from geometry.parallel.edge_parallelity import edge_factors, parallelity

GOLDEN = (1 + 5**0.5) / 2
ROUNDING = 1e-14  # sizes are near 1, a few dozen operations


def volume(mesh: Mesh) -> float:
    """Of a closed mesh: a third of the sum of height times area."""
    corners = mesh.vertices[mesh.combinatorics.corners[mesh.combinatorics.face_starts[:-1]]]
    heights = np.einsum("fk,fk->f", mesh.vector_areas, corners)
    return float(heights.sum() / 3)


def mid_radii(mesh: Mesh) -> FloatArray:
    """(E,) distance of each edge's line from the origin."""
    tails = mesh.vertices[mesh.combinatorics.edges[:, 0]]
    return np.linalg.norm(np.cross(tails, mesh.edge_vectors), axis=1) / mesh.edge_lengths


def corner_angles(mesh: Mesh) -> FloatArray:
    c = mesh.combinatorics
    here = mesh.vertices[c.corners]
    ahead, back = mesh.vertices[c.corners[c.next_corner]] - here, mesh.vertices[c.corners[c.previous_corner]] - here
    return np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=1), np.einsum("ck,ck->c", ahead, back))


@pytest.mark.parametrize(
    ("make", "counts", "edge", "mid_radius", "size"),
    [
        (solids.tetrahedron, (4, 6, 4), 8**0.5, 1.0, 8 / 3),
        (solids.cube, (8, 12, 6), 2.0, 2**0.5, 8.0),
        (solids.octahedron, (6, 12, 8), 2**0.5, 0.5**0.5, 4 / 3),
        (solids.icosahedron, (12, 30, 20), 2.0, GOLDEN, 10 / 3 * (3 + 5**0.5)),
        (solids.dodecahedron, (20, 30, 12), 2 / GOLDEN, GOLDEN, (15 + 7 * 5**0.5) / 4 * (2 / GOLDEN) ** 3),
    ],
)
def test_platonic_solids(
    make: Callable[[], Mesh], counts: tuple[int, int, int], edge: float, mid_radius: float, size: float
) -> None:
    mesh = make()
    check_faces(mesh)
    assert (mesh.n_vertices, mesh.n_edges, mesh.n_faces) == counts
    np.testing.assert_allclose(mesh.edge_lengths, edge, rtol=ROUNDING)
    np.testing.assert_allclose(mid_radii(mesh), mid_radius, rtol=ROUNDING)
    assert volume(mesh) == pytest.approx(size, rel=ROUNDING)
    assert mesh.planarity.max() < ROUNDING
    assert getattr(shapes, make.__name__) is make


TRIBONACCI = 1.839286755214161
SNUB = 0.943151259243882
SNUB_CUBE = (2 + 4 * TRIBONACCI - 2 * TRIBONACCI**2) ** 0.5
SNUB_DODECAHEDRON = 6.04373808413276


@pytest.mark.parametrize(
    ("make", "faces", "around", "edge", "mid_radius"),
    [
        (solids.truncated_tetrahedron, {3: 4, 6: 4}, (3, 6, 6), 8**0.5, 3.0),
        (solids.cuboctahedron, {3: 8, 4: 6}, (3, 3, 4, 4), 2**0.5, 1.5**0.5),
        (solids.truncated_cube, {3: 8, 8: 6}, (3, 8, 8), 2 * (2**0.5 - 1), 2**0.5),
        (solids.truncated_octahedron, {4: 6, 6: 8}, (4, 6, 6), 2**0.5, 3 / 2**0.5),
        (solids.rhombicuboctahedron, {3: 8, 4: 18}, (3, 4, 4, 4), 2.0, (4 + 2 * 2**0.5) ** 0.5),
        (solids.truncated_cuboctahedron, {4: 12, 6: 8, 8: 6}, (4, 6, 8), 2.0, (12 + 6 * 2**0.5) ** 0.5),
        (solids.snub_cube, {3: 32, 4: 6}, (3, 3, 3, 3, 4), SNUB_CUBE, SNUB_CUBE / 2 / (2 - TRIBONACCI) ** 0.5),
        (solids.icosidodecahedron, {3: 20, 5: 12}, (3, 3, 5, 5), 2.0, (5 + 2 * 5**0.5) ** 0.5),
        (solids.truncated_dodecahedron, {3: 20, 10: 12}, (3, 10, 10), 2 / GOLDEN, GOLDEN + 2),
        (solids.truncated_icosahedron, {5: 12, 6: 20}, (5, 6, 6), 2.0, 3 * GOLDEN),
        (solids.rhombicosidodecahedron, {3: 20, 4: 30, 5: 12}, (3, 4, 4, 5), 2.0, (10 + 4 * 5**0.5) ** 0.5),
        (
            solids.truncated_icosidodecahedron,
            {4: 30, 6: 20, 10: 12},
            (4, 6, 10),
            2 / GOLDEN,
            (30 + 12 * 5**0.5) ** 0.5 / GOLDEN,
        ),
        (
            solids.snub_dodecahedron,
            {3: 80, 5: 12},
            (3, 3, 3, 3, 5),
            SNUB_DODECAHEDRON,
            SNUB_DODECAHEDRON / 2 / (1 - SNUB) ** 0.5,
        ),
    ],
)
def test_archimedean_solids(
    make: Callable[[], Mesh], faces: dict[int, int], around: tuple[int, ...], edge: float, mid_radius: float
) -> None:
    mesh = make()
    c = mesh.combinatorics
    check_faces(mesh)
    assert dict(zip(*(part.tolist() for part in np.unique(c.face_sizes, return_counts=True)), strict=True)) == faces
    assert (c.euler_characteristic, len(c.boundary_loops)) == (2, 0)
    # the same faces at every vertex
    order = np.lexsort((c.face_sizes[c.corner_face], c.corners))
    np.testing.assert_array_equal(c.face_sizes[c.corner_face][order].reshape(-1, len(around)), [around] * c.n_vertices)
    np.testing.assert_allclose(mesh.edge_lengths, edge, rtol=10 * ROUNDING)  # constants have 15 digits; 1 / (1 - x)
    np.testing.assert_allclose(mid_radii(mesh), mid_radius, rtol=10 * ROUNDING)
    radii = np.linalg.norm(mesh.vertices, axis=1)
    np.testing.assert_allclose(radii, np.hypot(mid_radius, edge / 2), rtol=10 * ROUNDING)
    assert mesh.planarity.max() < ROUNDING
    assert (np.einsum("fk,fk->f", mesh.face_normals, face_centroids(mesh.vertices, c)) > 0).all()


@given(st.integers(3, 12), st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.1, 10))
def test_prisms_and_boxes_have_their_volume(n: int, length: float, width: float, height: float) -> None:
    prism = shapes.regular_prism(n)
    assert volume(prism) == pytest.approx(n * np.sin(2 * np.pi / n), rel=ROUNDING)
    assert set(prism.combinatorics.vertex_degrees.tolist()) == {3}
    box = shapes.box(length, width, height)
    assert volume(box) == pytest.approx(length * width * height, rel=ROUNDING)
    np.testing.assert_allclose(np.ptp(box.vertices, axis=0), [length, width, height], rtol=ROUNDING)


@given(st.integers(1, 6), st.integers(1, 6))
def test_grids_look_up(nx: int, ny: int) -> None:
    mesh = shapes.grid(nx, ny)
    assert (mesh.n_vertices, mesh.n_faces) == ((nx + 1) * (ny + 1), nx * ny)
    np.testing.assert_array_equal(mesh.vector_areas, [[0, 0, 1]] * mesh.n_faces)
    assert mesh.vertices[1 * (ny + 1) + 1].tolist() == [1, 1, 0]


def test_translation_surfaces_are_parallelograms() -> None:
    rng = np.random.default_rng(7)
    first = np.cumsum(rng.uniform([0.5, -0.2, -0.2], [1, 0.2, 0.2], (6, 3)), axis=0)
    second = np.cumsum(rng.uniform([-0.2, 0.5, -0.2], [0.2, 1, 0.2], (5, 3)), axis=0)
    mesh = shapes.translation_surface(first, second)
    a, b, c, d = mesh.vertices[mesh.combinatorics.corners.reshape(-1, 4)].transpose(1, 0, 2)
    np.testing.assert_allclose(a + c, b + d, rtol=0, atol=ROUNDING * 10)
    assert mesh.planarity.max() < ROUNDING * 10
    assert (mesh.vector_areas[:, 2] > 0).all()
    np.testing.assert_array_equal(mesh.vertices[2 * 5 + 3], first[2] + second[3])


@given(
    st.lists(st.tuples(st.floats(0.5, 5), st.floats(0.2, 2)), min_size=2, max_size=5),
    st.integers(3, 9),
    st.booleans(),
)
def test_rotational_meshes_are_circular_and_conical(profile: list[tuple[float, float]], n: int, closed: bool) -> None:
    points = np.array(profile)
    points[:, 1] = np.cumsum(points[:, 1])
    mesh = shapes.rotational_mesh(points, n, closed=closed)
    c = mesh.combinatorics
    check_faces(mesh)
    assert c.euler_characteristic == (0 if closed else 1)
    assert mesh.planarity.max() < 1e-13  # radii to 5, heights to 10
    angles = corner_angles(mesh)
    quads = angles.reshape(-1, 4)
    np.testing.assert_allclose(quads[:, 0] + quads[:, 2], np.pi, atol=1e-12)  # circular: opposite angles of a face
    for vertex in np.flatnonzero(~c.is_boundary_vertex):  # conical: opposite angles at a vertex
        start = corner = int(np.flatnonzero(c.corners == vertex)[0])
        around = []
        while not around or corner != start:
            around.append(angles[corner])
            corner = int(c.twin[c.previous_corner[corner]])
        assert len(around) == 4
        assert around[0] + around[2] == pytest.approx(around[1] + around[3], abs=1e-12)
    middle = mesh.vertices[c.corners].reshape(-1, 4, 3).mean(axis=1)
    steep = np.einsum("fk,fk->f", mesh.vector_areas * [1, 1, 0], middle)
    assert (steep > 0).all()


def test_open_rotational_meshes_span_half_a_turn() -> None:
    mesh = shapes.rotational_mesh([[1, 0], [2, 1]], 5, closed=False)
    np.testing.assert_allclose(mesh.vertices[[0, 4, 8]], [[1, 0, 0], [0, 1, 0], [-1, 0, 0]], rtol=0, atol=ROUNDING)


def test_domes_are_inscribed_in_the_unit_sphere() -> None:
    mesh = shapes.dome(12, 5)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1, rtol=ROUNDING)
    assert (mesh.n_vertices, mesh.n_faces, mesh.combinatorics.euler_characteristic) == (72, 60, 0)


@pytest.mark.parametrize(("profile", "n", "closed"), [([[0, 0], [1, 1]], 5, True), ([[1, 0], [1, 1]], 2, True)])
def test_rotational_meshes_need_room(profile: list[list[float]], n: int, closed: bool) -> None:
    with pytest.raises(MeshError, match="positive radii and at least 3 meridians"):
        shapes.rotational_mesh(profile, n, closed=closed)


@pytest.mark.parametrize(("m", "n"), [(3, 3), (5, 8), (8, 5)])
def test_tori_have_genus_1_and_their_volume(m: int, n: int) -> None:
    """Pappus, between regular polygons: the area of the profile times the length of the path of its centre."""
    angles = 2 * np.pi / m * np.arange(m)
    mesh = shapes.torus(np.stack([3 + np.cos(angles), np.sin(angles)], axis=1), n)
    check_faces(mesh)
    c = mesh.combinatorics
    assert (c.euler_characteristic, len(c.boundary_loops), set(c.vertex_degrees.tolist())) == (0, 0, {4})
    assert mesh.planarity.max() < ROUNDING
    assert circularity(mesh).max() < ROUNDING
    assert np.nanmax(conicality(mesh)) < 10 * ROUNDING
    # cut at a height, it is what lies between two n-gons of area n sin(2 pi / n) / 2 times their radii squared
    profile = 3 * m * np.sin(2 * np.pi / m) / 2  # moment of the polygon about the axis
    assert volume(mesh) == pytest.approx(n * np.sin(2 * np.pi / n) * profile, rel=10 * ROUNDING)


@given(st.integers(3, 9), st.integers(1, 8))
def test_catenoids_have_the_gauss_image_they_promise(n: int, rings: int) -> None:
    mesh = shapes.catenoid(n, rings)
    check_faces(mesh)
    latitudes = np.radians(np.linspace(-60, 60, rings + 1))
    image = shapes.rotational_mesh(np.stack([np.cos(latitudes), -np.sin(latitudes)], axis=1), n)
    assert parallelity(mesh, image).max() < ROUNDING
    factors = edge_factors(mesh, image)
    radii = np.hypot(*mesh.vertices[:, :2].T)
    np.testing.assert_allclose(radii.reshape(n, -1), [1 / np.cos(latitudes)] * n, rtol=ROUNDING)
    around = np.ptp(radii[mesh.combinatorics.edges], axis=1) < ROUNDING
    if rings % 2 == 0:  # else the ring in the middle has two of the same radius, joined by meridians
        assert (factors[around] > 0).all()
        assert (factors[~around] < 0).all()
    heights = mesh.vertices[:, 2].reshape(n, -1)
    np.testing.assert_allclose(heights, -heights[:, ::-1], rtol=0, atol=10 * ROUNDING)


@given(st.integers(1, 5), st.integers(1, 5))
def test_hexagons_touch_the_paraboloid(nx: int, ny: int) -> None:
    mesh = shapes.hexagonal_paraboloid(nx, ny)
    c = mesh.combinatorics
    check_faces(mesh)
    assert (mesh.n_faces, c.euler_characteristic, len(c.boundary_loops)) == (nx * ny, 1, 1)
    assert c.vertex_degrees.max() <= 3
    assert (mesh.vector_areas[:, 2] > 0).all()
    np.testing.assert_allclose(mesh.vertices.max(axis=0)[:2], -mesh.vertices.min(axis=0)[:2], rtol=ROUNDING)
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(z, (x**2 + y**2 - 1) / 2, rtol=0, atol=100 * ROUNDING)
    for face, normal in enumerate(
        mesh.face_normals
    ):  # the plane at height z with the normal (-x, -y, 1) touches at (x, y)
        slope = -normal[:2] / normal[2]
        corners = mesh.vertices[c.face(face)]
        np.testing.assert_allclose(corners[:, :2].mean(axis=0), slope, rtol=0, atol=100 * ROUNDING)
        np.testing.assert_allclose(corners[:, :2] @ slope - slope @ slope / 2, corners[:, 2], atol=1000 * ROUNDING)
        np.testing.assert_allclose(np.linalg.norm(corners[:, :2] - slope, axis=1), 1, rtol=100 * ROUNDING)


def test_double_rings_have_genus_2() -> None:
    mesh = shapes.double_ring()
    c = mesh.combinatorics
    check_faces(mesh)
    assert (mesh.n_vertices, mesh.n_faces, c.euler_characteristic, len(c.boundary_loops)) == (26, 28, -2, 0)
    assert mesh.planarity.max() < ROUNDING
    assert set(c.face_sizes.tolist()) == {4}
    np.testing.assert_allclose(np.abs(mesh.face_normals[:, 2]), 0.5**0.5, rtol=ROUNDING)
    assert np.nanmax(conicality(mesh)) < ROUNDING
    first, second = mesh.face_normals[c.edge_faces].transpose(1, 0, 2)
    assert np.linalg.norm(np.cross(first, second), axis=1).min() > 0.4
    ridges = 4 * 10**0.5 + 2 * 2 + 4
    assert 0.9 * ridges < volume(mesh) / 0.5 < ridges  # bars of section 1/2, which overlap where three meet
    assert np.ptp(mesh.vertices[:, 2]) == 1.0


def test_caps_are_the_faces_above_a_height() -> None:
    solid = solids.rhombicosidodecahedron()
    mesh = shapes.cap(solid, 1.0)
    c = mesh.combinatorics
    assert (c.euler_characteristic, len(c.boundary_loops)) == (1, 1)
    assert set(c.face_sizes.tolist()) == {3, 4, 5}
    assert c.is_used.all()
    high = face_centroids(solid.vertices, solid.combinatorics)[:, 2] > 1
    np.testing.assert_array_equal(mesh.vector_areas, solid.vector_areas[high])
    with pytest.raises(MeshError, match="no faces"):
        shapes.cap(solid, 10.0)
