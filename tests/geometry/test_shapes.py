"""The exact meshes are what their docstrings say."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.mesh import Mesh, check_faces, shapes

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
        (shapes.tetrahedron, (4, 6, 4), 8**0.5, 1.0, 8 / 3),
        (shapes.cube, (8, 12, 6), 2.0, 2**0.5, 8.0),
        (shapes.octahedron, (6, 12, 8), 2**0.5, 0.5**0.5, 4 / 3),
        (shapes.icosahedron, (12, 30, 20), 2.0, GOLDEN, 10 / 3 * (3 + 5**0.5)),
        (shapes.dodecahedron, (20, 30, 12), 2 / GOLDEN, GOLDEN, (15 + 7 * 5**0.5) / 4 * (2 / GOLDEN) ** 3),
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
