"""Where meshes meet themselves: against libigl triangle by triangle, and meshes known to be embedded or not."""

from __future__ import annotations

import tracemalloc
from itertools import combinations, permutations

import igl
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.intersections import (
    box_trees,
    face_neighbours,
    flat_faces,
    intersecting_faces,
    is_embedded,
    self_crossing_faces,
)
from geometry.mesh.intersections import meeting_faces as intersections
from tests.geometry.bent_meshes import rotation
from tests.geometry.topologies import MESHES, split, together

seeds = st.integers(0, 2**32 - 1)


def prisms(first: int, second: int, seed: int) -> Mesh:
    """Two prisms of one size, one within the other or through it."""
    rng = np.random.default_rng(seed)
    vertices, faces = [], []
    for k, turn, shift in ((first, np.eye(3), np.zeros(3)), (second, rotation(seed), rng.normal(size=3) / 2)):
        prism = shapes.regular_prism(k)
        faces += [[v + sum(map(len, vertices)) for v in face] for face in prism.combinatorics.faces]
        vertices.append(prism.vertices / np.abs(prism.vertices).max() @ turn + shift)
    return Mesh.from_faces(np.concatenate(vertices), faces)


@given(st.integers(5, 20), st.integers(5, 20), seeds)
def test_points_are_found_in_large_faces_as_in_small_ones(first: int, second: int, seed: int) -> None:
    mesh = prisms(first, second, seed)
    expected = intersecting_faces(mesh)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(intersections, "MANY_CORNERS", 4)
        np.testing.assert_array_equal(intersecting_faces(mesh), expected)


def crowd(seed: int, n_vertices: int, n_faces: int, *, hubs: int, planes: int) -> Mesh:
    """Polygons in random planes through random vertices, a few of which are in most of them; each simple by itself.

    planes: how many the vertices lie in; 0 for triangles in space.
    """
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(n_vertices, 3))
    of_plane = np.arange(n_vertices) % max(planes, 1)
    if planes:
        vertices[:, 2] = 0
        for plane in range(1, planes):
            vertices[of_plane == plane] = vertices[of_plane == plane] @ rotation(seed + plane)
    faces: list[list[int]] = []
    used: set[tuple[int, int]] = set()
    for _ in range(n_faces):
        own = np.flatnonzero(of_plane == rng.integers(max(planes, 1)))
        centres = [vertex for vertex in own[:hubs] if rng.random() < 0.7]
        size = max(rng.integers(3, 7 if planes else 4), len(centres))
        others = rng.choice(own[hubs:], size - len(centres), replace=False)
        face = np.concatenate([np.array(centres, dtype=np.int64), others])
        flat = vertices[face] @ (rotation(seed + int(of_plane[face[0]])).T if of_plane[face[0]] else np.eye(3))
        angles = np.arctan2(*(flat - flat.mean(axis=0))[:, 1::-1].T) if planes else np.arange(3)
        face = face[np.argsort(angles)][:: rng.choice([-1, 1])]
        edges = set(zip(face.tolist(), np.roll(face, -1).tolist(), strict=True))
        if not used & edges:
            used |= edges
            faces.append(face.tolist())
    return Mesh.from_faces(vertices, faces)


def by_all_pairs(mesh: Mesh) -> list[list[int]]:
    """Every two faces one of which has an edge through the other, or that lie in one plane and share area."""
    close = 1e-9 * mesh.mean_edge_length
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    frames = [np.linalg.svd(normal[None])[2] for normal in mesh.face_normals]  # the normal, and two across it
    crossing, flat = set(), set()
    for a, b in permutations(range(mesh.n_faces), 2):
        seen = (mesh.vertices - mesh.vertices[faces[b][0]]) @ frames[b].T
        if np.abs(seen[faces[a], 0]).max() <= close:
            areas = [shapely.Polygon(seen[face, 1:]) for face in (faces[a], faces[b])]
            if all(shapely.is_valid(areas)) and areas[0].intersection(areas[1]).area > 1e-6 * min(
                area.area for area in areas
            ):
                flat.add((min(a, b), max(a, b)))
            continue
        inside = shapely.make_valid(shapely.Polygon(seen[faces[b], 1:]))
        for tail, head in zip(faces[a], [*faces[a][1:], faces[a][0]], strict=True):
            low, high = seen[tail], seen[head]
            is_clear = max(abs(low[0]), abs(high[0])) > close and not {tail, head} & set(faces[b])
            if is_clear and (low[0] > 0) != (high[0] > 0):
                point = low + low[0] / (low[0] - high[0]) * (high - low)
                if inside.contains(shapely.Point(point[1:])):
                    crossing.add((min(a, b), max(a, b)))
    return [list(pair) for pair in combinations(range(mesh.n_faces), 2) if pair in crossing | flat]


@given(seeds, st.integers(0, 4), st.integers(0, 2))
@settings(max_examples=40)
def test_all_that_meet_are_found_without_comparing_all(seed: int, hubs: int, planes: int) -> None:
    """Also where many faces meet in a few vertices, and wherever the mesh lies."""
    mesh = crowd(seed, 30, 14, hubs=hubs, planes=planes)
    expected = by_all_pairs(mesh)
    moved = mesh.vertices @ rotation(seed).T * 10.0 ** np.random.default_rng(seed).integers(-3, 4)
    moved = moved + 100 * np.ptp(moved, axis=0)
    with pytest.MonkeyPatch.context() as patch:
        for module, name in (
            (face_neighbours, "CROWDED_VERTEX_FACES"),
            (flat_faces, "MANY_CORNERS"),
            (intersections, "MANY_CORNERS"),
        ):
            patch.setattr(module, name, 3)
        for module in (box_trees, flat_faces):
            patch.setattr(module, "PAIRS_AT_ONCE", 10)
        assert intersecting_faces(mesh).tolist() == expected
        assert intersecting_faces(mesh.with_vertices(moved)).tolist() == expected
        assert intersecting_faces(mesh.with_vertices(moved).reversed()).tolist() == expected
    assert intersecting_faces(mesh).tolist() == expected


@pytest.mark.parametrize("many", [1, 16])
def test_faces_that_share_two_vertices_and_cross_between_them(many: int) -> None:
    """Two long arms from two corners that both faces have; all other edges are far from where they cross."""
    one = polygon((0, 0), (20, 19), (10, 0), (30, 20), (20, 21))
    other = one * [-1, 1, 1] + [10, 0, 0]
    mesh = Mesh.from_faces([*one, *other[[1, 3, 4]]], [[0, 1, 2, 3, 4], [2, 7, 6, 0, 5]])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(face_neighbours, "CROWDED_VERTEX_FACES", many)
        assert intersecting_faces(mesh).tolist() == [[0, 1]]


FLAT_FACE = "a triangle without height"


def separate_polygons(polygons: FloatArray) -> Mesh:
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
    assert intersecting_faces(separate_polygons(triangles)).tolist() == expected


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
    assert intersecting_faces(separate_polygons(squares)).tolist() == expected
    turned = squares @ rotation(3).T
    assert intersecting_faces(separate_polygons(turned)).tolist() == expected


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
    is_small = np.array([set(face) <= set(small.tolist()) for face in mesh.combinatorics.faces])
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
    faces = [*prism.combinatorics.faces, list(range(0, 2 * n, 2))[::-1], list(range(1, 2 * n, 2))]
    capped = Mesh.from_faces(prism.vertices @ rotation(0).T, faces)
    tracemalloc.start()
    assert not len(intersecting_faces(capped))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50e6  # as copies, the 1000 neighbours of each cap would take 300 MB


def turned_together(*meshes: Mesh) -> Mesh:
    mesh = together(*meshes)
    return mesh.with_vertices(mesh.vertices @ rotation(0).T)


def tube(n: int, radius: float) -> Mesh:
    return shapes.rotational_mesh(np.array([[radius, 0.0], [radius, 1.0]]), n)


def fan(n: int, height: float) -> Mesh:
    circle = tube(n, 1.0).vertices[::2]
    return Mesh.from_faces([*circle, [0, 0, height]], [[k, (k + 1) % n, n] for k in range(n)])


def triangles_at_one_point(n: int) -> Mesh:
    directions, sides = np.random.default_rng(0).normal(size=(2, n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    vertices = np.concatenate([directions, directions + 0.1 / n * sides, [[0, 0, 0]]])
    return Mesh.from_faces(vertices, [[k, n + k, 2 * n] for k in range(n)])


def folds(n: int) -> Mesh:
    x = np.arange(n + 1) / n
    profile = np.stack([x, 0 * x, np.arange(n + 1) % 2 / n], axis=1)
    return shapes.translation_surface(profile, np.array([[0, 0, 0], [0, 1.0, 0]]))


def plate_in_a_ring(n: int, width: float) -> Mesh:
    """One face with n corners, and a face of its plane at each of its edges."""
    circle = tube(n, 1.0).vertices[::2]
    ring = [[k, n + k, n + (k + 1) % n, (k + 1) % n] for k in range(n)]
    return Mesh.from_faces([*circle, *((1 + width) * circle)], [list(range(n)), *ring])


MANY_FACES = {
    "one tube in another": lambda n: turned_together(tube(n, 1.0), tube(n, 0.9)),
    "a tube beside another": lambda n: turned_together(tube(n, 1.0), tube(n, 1.0).translated([2.01, 0, 0])),
    "a flat fan": lambda n: turned_together(fan(2 * n, 0.0)),
    "a cone in a cone": lambda n: turned_together(fan(n, 0.5), fan(n, 0.5).translated([0, 0, 0.1])),
    "triangles at one point": triangles_at_one_point,
    "folds": lambda n: turned_together(folds(2 * n)),
    "a large face among small ones": lambda n: turned_together(plate_in_a_ring(2 * n, 1e-3)),
    "a large face among slender ones": lambda n: turned_together(plate_in_a_ring(2 * n, 1.0)),
    "squares": lambda n: turned_together(shapes.grid(40, n // 20)),
}


@pytest.mark.parametrize("name", MANY_FACES)
def test_no_two_of_very_many_are_compared_without_need(name: str) -> None:
    mesh = MANY_FACES[name](2000)
    tracemalloc.start()
    meeting = intersecting_faces(mesh)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert not len(meeting)
    assert peak < 40e6  # every face with every other, as a byte each, would be 16 MB; as two numbers 256 MB


@given(seeds)
@settings(max_examples=10)
def test_a_corner_on_an_edge_only_touches(seed: int) -> None:
    """Two triangles a plane on one side or both sides of a line, one with a corner between those of the other."""
    rng = np.random.default_rng(seed)
    n = 50
    tail, head = rng.normal(size=(2, n, 2))
    across = (head - tail)[:, ::-1] * [-1, 1]
    tips = [tail + rng.normal(size=(n, 1)) * (head - tail) + side * across for side in rng.uniform(0.2, 1, (2, n, 1))]
    between = tail + rng.uniform(0.1, 0.9, size=(n, 1)) * (head - tail)
    for other, expected in ((tips[1] - 2 * across, []), (tips[1], [[2 * k, 2 * k + 1] for k in range(n)])):
        flat = np.stack([tail, head, between, tips[0], other], axis=1)
        vertices = np.concatenate([flat, np.broadcast_to(np.arange(n)[:, None, None], (n, 5, 1))], axis=2)
        faces = [[5 * k + corner for corner in face] for k in range(n) for face in ([0, 1, 3], [2, 0, 4])]
        assert intersecting_faces(Mesh.from_faces(vertices.reshape(-1, 3), faces)).tolist() == expected
