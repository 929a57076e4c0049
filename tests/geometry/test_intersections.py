"""Where meshes meet themselves: against libigl triangle by triangle, and meshes known to be embedded or not."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.mesh import Mesh, intersections, near_faces, shapes, solids
from geometry.mesh.intersections import intersecting_faces, is_embedded, self_crossing_faces
from tests.geometry.bent_meshes import rotation
from tests.geometry.topologies import MESHES, split, together

seeds = st.integers(0, 2**32 - 1)


def prisms(first: int, second: int, seed: int) -> Mesh:
    """Two prisms of one size, one within the other or through it."""
    rng = np.random.default_rng(seed)
    vertices, faces = [], []
    for k, turn, shift in ((first, np.eye(3), np.zeros(3)), (second, rotation(seed), rng.normal(size=3) / 2)):
        prism = shapes.regular_prism(k)
        faces += [[v + sum(map(len, vertices)) for v in face] for face in prism.combinatorics.faces()]
        vertices.append(prism.vertices / np.abs(prism.vertices).max() @ turn + shift)
    return Mesh.from_faces(np.concatenate(vertices), faces)


@given(st.integers(5, 20), st.integers(5, 20), seeds)
def test_points_are_found_in_large_faces_as_in_small_ones(first: int, second: int, seed: int) -> None:
    mesh = prisms(first, second, seed)
    expected = intersecting_faces(mesh)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(intersections, "LARGE", 4)
        np.testing.assert_array_equal(intersecting_faces(mesh), expected)


FLAT_FACE = "a triangle without height"


def soup(polygons: FloatArray) -> Mesh:
    """Polygons (n, k, 3) without common vertices."""
    n, k = polygons.shape[:2]
    return Mesh.from_faces(polygons.reshape(-1, 3), np.arange(n * k).reshape(n, k).tolist())


def polygon(*corners: tuple[float, float], z: float = 0.0) -> FloatArray:
    return np.insert(np.array(corners, dtype=np.float64), 2, z, axis=1)


@given(seeds)
@settings(max_examples=20)
def test_triangles_meet_where_libigl_says_so(seed: int) -> None:
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(size=(25, 1, 3)) + 0.3 * rng.normal(size=(25, 3, 3))
    expected = [
        [i, j]
        for i in range(25)
        for j in range(i + 1, 25)
        if igl.tri_tri_overlap_test_3d(*triangles[i][:, None], *triangles[j][:, None])
    ]
    assert intersecting_faces(soup(triangles)).tolist() == expected


@pytest.mark.parametrize("name", sorted(set(MESHES) - {FLAT_FACE}))
def test_embedded_meshes_of_every_topology(name: str) -> None:
    assert is_embedded(MESHES[name]) == (name not in ("parts", "unused vertices"))  # these stand in one another


def test_a_face_without_area_is_no_simple_polygon() -> None:
    assert self_crossing_faces(MESHES[FLAT_FACE]).tolist() == [1]


@given(seeds)
@settings(max_examples=20)
def test_faces_of_solids_in_one_another(seed: int) -> None:
    """A face of one meets a face of the other if and only if a piece of it in triangles does."""
    rng = np.random.default_rng(seed)
    first, second = solids.truncated_octahedron(), shapes.dodecahedron()
    turned = second.with_vertices(second.vertices @ rotation(seed).T + rng.normal(size=3))
    both = together(first, turned)
    pieces = split(both, *range(both.n_faces))
    owner = np.repeat(np.arange(both.n_faces), both.combinatorics.face_sizes - 2)
    expected = np.unique(owner[intersecting_faces(pieces)], axis=0)
    np.testing.assert_array_equal(intersecting_faces(both), expected)


def wall(tail: tuple[float, float], head: tuple[float, float], foot: float) -> FloatArray:
    """Upright, from a height up to 2."""
    ends = np.array([tail, head, head, tail])
    return np.insert(ends, 2, [foot, foot, 2.0, 2.0], axis=1)


@given(seeds)
@settings(max_examples=10)
def test_a_face_with_a_bay_wherever_it_lies(seed: int) -> None:
    u_shape = polygon((0, 0), (5, 0), (5, 4), (4, 4), (4, 1), (1, 1), (1, 4), (0, 4))
    # down through the bay, through a leg, standing on a leg, ending above a leg
    walls = [
        wall((2, 2), (3, 3), -1),
        wall((0.5, 2), (1.8, 2), -1),
        wall((0.2, 3), (0.8, 3), 0),
        wall((4, 3), (5, 2), 1),
    ]
    corners = np.concatenate([u_shape, *walls])
    faces = [list(range(8)), *(np.arange(8, 24).reshape(4, 4).tolist())]
    moved = 1e3 * (corners @ rotation(seed).T + np.random.default_rng(seed).normal(size=3))
    for mesh in (
        Mesh.from_faces(corners, faces),
        Mesh.from_faces(moved, faces),
        Mesh.from_faces(moved, faces).reversed(),
    ):
        assert intersecting_faces(mesh).tolist() == [[0, 2], [0, 3]]
        assert not len(self_crossing_faces(mesh))


def test_faces_in_one_plane() -> None:
    square = polygon((0, 0), (2, 0), (2, 2), (0, 2))
    apart, corner, inside, touching = [3.0, 0, 0], [1.5, 1.5, 0], [0.5, 0.5, 0], [0, 2.0, 0]
    squares = np.stack([square, square + apart, square + corner, square / 4 + inside, square + touching])
    expected = [[0, 2], [0, 3], [1, 2], [2, 4]]
    assert intersecting_faces(soup(squares)).tolist() == expected
    turned = squares @ rotation(3).T
    assert intersecting_faces(soup(turned)).tolist() == expected


def test_a_face_folded_back_onto_its_neighbour_overlaps_it() -> None:
    strip = shapes.grid(3, 1)
    folded = strip.vertices.copy()
    folded[6:, 0] = 1.2  # the last of three squares lies under the second one
    assert intersecting_faces(strip.with_vertices(folded)).tolist() == [[1, 2]]
    assert not is_embedded(strip.with_vertices(folded))
    folded[6:, 2] = 0.1  # only creased
    assert is_embedded(strip.with_vertices(folded))


@given(seeds)
def test_faces_as_small_as_rounding_share_no_area(seed: int) -> None:
    mesh = shapes.grid(6, 6)
    rng = np.random.default_rng(seed)
    small = rng.choice(mesh.n_vertices, 25, replace=False)
    crowded = mesh.vertices.copy()
    crowded[small] = [3, 3, 0] + 1e-15 * rng.normal(size=(25, 3))
    meeting = intersecting_faces(mesh.with_vertices(crowded))
    is_small = np.array([set(face) <= set(small.tolist()) for face in mesh.combinatorics.faces()])
    assert not is_small[meeting].all(axis=1).any()


def test_outlines_that_cross_themselves_are_named() -> None:
    mesh = shapes.grid(2, 2)
    vertices = mesh.vertices.copy()
    vertices[[0, 1]] = vertices[[1, 0]]  # face 0 becomes a bow tie
    assert self_crossing_faces(mesh.with_vertices(vertices)).tolist() == [0]
    assert not is_embedded(mesh.with_vertices(vertices))


def test_a_strip_along_a_loop_crosses_itself_once() -> None:
    t = np.linspace(-0.4, np.pi + 0.5, 31)  # a figure of eight comes through the origin at 0 and at pi
    loop = np.stack([np.sin(2 * t), np.sin(t), np.zeros_like(t)], axis=1)
    mesh = shapes.translation_surface(loop, np.array([[0, 0, 0], [0, 0, 1.0], [0, 0, 2.0]]))
    first, second = np.searchsorted(t, [0.0, np.pi]) - 1
    pairs = intersecting_faces(mesh).tolist()
    assert {(i // 2, j // 2) for i, j in pairs} == {(first, second)}
    for row in (0, 1):
        assert [2 * first + row, 2 * second + row] in pairs


def test_a_large_face_is_not_copied_for_each_of_its_neighbours() -> None:
    n = 1000
    prism = shapes.rotational_mesh(np.array([[1.0, 0.0], [1.0, 1.0]]), n)
    faces = [*prism.combinatorics.faces(), list(range(0, 2 * n, 2))[::-1], list(range(1, 2 * n, 2))]
    capped = Mesh.from_faces(prism.vertices @ rotation(0).T, faces)
    tracemalloc.start()
    assert not len(intersecting_faces(capped))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50e6  # as copies, the 1000 neighbours of each cap would take 300 MB


def crumpled_stars(seed: int) -> Mesh:
    """Two stars of triangles and quads with a common rim, turned and crumpled so that many faces cross."""
    rng = np.random.default_rng(seed)
    n = 14
    angles = np.sort(rng.uniform(0, 2 * np.pi, n))
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1) + rng.normal(scale=0.3, size=(n, 3))
    far = 2 * rim + rng.normal(scale=0.3, size=(n, 3))
    vertices = np.concatenate([[[0, 0, 0.5], [0, 0, -0.5]], rim, far]) @ rotation(seed).T
    rings = [((k + 2), (k + 1) % n + 2) for k in range(n)]
    faces = [[0, i, j] for i, j in rings] + [[1, j + n, i + n] for i, j in rings]
    return Mesh.from_faces(vertices, faces + [[j, i, i + n, j + n] for i, j in rings])


@given(seeds)
def test_faces_at_one_vertex_are_found_by_their_directions_as_by_all_pairs(seed: int) -> None:
    mesh = crumpled_stars(seed)
    first, second = np.triu_indices(mesh.n_faces, 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(intersections, "near_faces", lambda mesh, clearance: (first, second))
        expected = intersecting_faces(mesh)
    for many in (2, 1000):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(near_faces, "MANY", many)
            np.testing.assert_array_equal(intersecting_faces(mesh), expected)


def fan(n: int) -> Mesh:
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1)
    return Mesh.from_faces(np.concatenate([[[0, 0, 1.0]], rim]), [[0, k + 1, (k + 1) % n + 1] for k in range(n)])


def tilted_prism(n: int) -> Mesh:
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1)
    ring = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return Mesh.from_faces(np.concatenate([rim, rim + np.array([0, 0, 5])]) @ rotation(3).T, ring)


@pytest.mark.parametrize("make", [fan, tilted_prism])
def test_slender_faces_are_not_compared_all_with_all(make: Callable[[int], Mesh]) -> None:
    """Pairs of all would take a gigabyte; those that are near each other take some kilobytes a face."""
    mesh = make(8000)
    tracemalloc.start()
    try:
        assert is_embedded(mesh)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 100e6
