"""Koebe polyhedra: edges touch the sphere, circles of a kind touch, of both kinds cross at right angles."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components

from geometry.arrays import FloatArray
from geometry.circle_patterns.planar_graphs import refuse_other_than_polyhedra
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron, koebe
from geometry.errors import GeometryError, MeshError
from geometry.gauss.distances import edge_distances
from geometry.mesh import Combinatorics, Mesh, shapes, solids
from geometry.mesh.tilings import dual
from geometry.spheres.moebius import MoebiusTransformation
from geometry.spheres.stereographic import circle_planes, poles
from tests.geometry.random_polyhedra import KINDS, random_polyhedron

ROUNDING = 1e-12
"""A hundred operations on numbers near 1; radii of neighbours differ by a factor of 1000 at most."""

seeds = st.integers(0, 2**32 - 1)
SOLIDS = [name for name in solids.__all__ if name.islower()]


def misfit_up_to_rotation(first: FloatArray, second: FloatArray) -> float:
    """Largest distance after the best rotation, not a reflection, of points (n, 3) about the origin."""
    left, _, right = np.linalg.svd(first.T @ second)
    left[:, 2] *= np.linalg.det(left @ right)
    return float(np.abs(first @ left @ right - second).max())


def assert_koebe(S: KoebePolyhedron, tolerance: float = ROUNDING) -> None:
    """Fig. 9 of the paper, in all its parts."""
    c = S.mesh.combinatorics
    faces, vertices, t = S.face_circles, S.vertex_circles, S.tangency_points
    np.testing.assert_allclose(np.linalg.norm(t, axis=1), 1, atol=tolerance)
    np.testing.assert_allclose(edge_distances(S.mesh), 1, atol=tolerance)
    assert S.mesh.planarity.max() <= 100 * tolerance  # over edge lengths, of which some are small
    f, v = c.corner_face, c.corners
    on_plane = np.einsum("ci,ci->c", S.mesh.vertices[v], faces.normals[f]) - faces.distances[f]
    np.testing.assert_allclose(on_plane, 0, atol=tolerance)
    for circles, ends in ((vertices, c.edges), (faces, c.edge_faces)):
        for end in ends.T:  # every circle passes through the points of its edges
            here = end >= 0
            heights = np.einsum("ei,ei->e", t[here], circles.normals[end[here]]) - circles.distances[end[here]]
            np.testing.assert_allclose(heights, 0, atol=tolerance)
    inner = ~c.is_boundary_edge
    for circles, (i, j) in ((vertices, c.edges.T), (faces, c.edge_faces[inner].T)):
        angles = np.arcsin(circles.radii[i]) + np.arcsin(circles.radii[j])
        between = np.linalg.norm(circles.normals[i] - circles.normals[j], axis=1)
        np.testing.assert_allclose(between, 2 * np.sin(angles / 2), atol=1e-7)  # the arcsine of a great circle
    crossed = np.einsum("ci,ci->c", faces.normals[f], vertices.normals[v])
    np.testing.assert_allclose(crossed, faces.distances[f] * vertices.distances[v], atol=tolerance)  # orthogonal


def assert_convex(S: KoebePolyhedron) -> None:
    normals, distances = S.face_circles.normals, S.face_circles.distances
    assert (S.mesh.vertices @ normals.T - distances).max() <= ROUNDING
    assert (distances > 0).all()


# --- closed


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_over_its_mid_radius_is_found_from_its_combinatorics(name: str) -> None:
    solid = getattr(solids, name)()
    mid_radius = edge_distances(solid).mean()
    found = koebe(solid.combinatorics).mesh
    assert found.combinatorics is solid.combinatorics
    assert misfit_up_to_rotation(found.vertices, solid.vertices / mid_radius) <= ROUNDING
    assert_koebe(koebe(solid.combinatorics))


@pytest.mark.parametrize("name", SOLIDS)
def test_the_dual_has_its_vertices_at_the_poles_of_the_faces(name: str) -> None:
    c = getattr(solids, name)().combinatorics
    S, T = koebe(c), koebe(dual(c))
    poles = S.face_circles.normals / S.face_circles.distances[:, None]
    assert misfit_up_to_rotation(T.mesh.vertices, poles) <= ROUNDING


def test_the_cube_of_another_program() -> None:
    """The README of KoebeRealizations.jl prints the eight vertices, to six digits."""
    x, y, z = 0.316228, 0.707107, 0.948683
    theirs = np.array(
        [[x, -y, z], [-z, -y, x], [-x, -y, -z], [z, -y, -x], [x, y, z], [-z, y, x], [-x, y, -z], [z, y, -x]]
    )
    faces = [[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 5, 6], [3, 2, 6, 7], [0, 3, 7, 4], [7, 6, 5, 4]]
    mesh = Mesh.from_faces(theirs, faces)
    assert (np.einsum("fi,fi->f", mesh.face_normals, mesh.vertices[mesh.combinatorics.corners[::4]]) > 0).all()
    KoebePolyhedron(mesh, tolerance=2e-6)
    assert misfit_up_to_rotation(koebe(mesh.combinatorics).mesh.vertices, theirs) <= 2e-6


@given(seeds, st.integers(4, 60), st.sampled_from(KINDS))
@settings(max_examples=40)
def test_random_polyhedra(seed: int, n: int, kind: str) -> None:
    c = random_polyhedron(np.random.default_rng(seed), n, kind)
    S = koebe(c)
    assert_koebe(S)
    assert_convex(S)
    np.testing.assert_allclose(S.tangency_points.mean(axis=0), 0, atol=ROUNDING)


@given(seeds, st.sampled_from(KINDS), st.floats(0, 0.9))
@settings(max_examples=20)
def test_a_moebius_image_is_normalised_to_the_same_polyhedron(seed: int, kind: str, speed: float) -> None:
    rng = np.random.default_rng(seed)
    S = koebe(random_polyhedron(rng, 20, kind))
    # less than the vertices allow: the plane that goes to infinity has to stay clear of all of them
    farthest = np.linalg.norm(S.mesh.vertices, axis=1).max()
    direction = rng.normal(size=3)
    moved = MoebiusTransformation.boost(speed / farthest * direction / np.linalg.norm(direction)).map_mesh(S.mesh)
    back = KoebePolyhedron(moved).normalised()
    assert misfit_up_to_rotation(back.mesh.vertices, S.mesh.vertices) <= 1e-10  # far vertices are sensitive


@given(seeds, st.integers(4, 30))
@settings(max_examples=20)
def test_numbering_does_not_matter(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    c = random_polyhedron(rng, n, "mixed")
    order = rng.permutation(c.n_vertices)
    faces = [np.roll(order[face], rng.integers(len(face))).tolist() for face in c.faces]
    rng.shuffle(faces)
    other = koebe(Combinatorics.from_faces(c.n_vertices, faces)).mesh.vertices
    assert misfit_up_to_rotation(koebe(c).mesh.vertices, other[order]) <= 1e-10


def test_a_pyramid_with_many_sides() -> None:
    """Its apex and its base have all the neighbours; where their circles are is known."""
    n = 200
    c = Combinatorics.from_faces(n + 1, [[i, (i + 1) % n, n] for i in range(n)] + [list(range(n))[::-1]])
    S = koebe(c)
    assert_koebe(S, 1e-9)  # the apex is far away, normals of long triangles round
    # in the plane, the n circles of a ring cross the circle of the base and touch that of the apex: its radius is
    # (1 + sin a) / cos a times as large, a = pi / n; on the sphere, both are as far from the equator
    expected = np.tan(np.pi / (2 * n))
    np.testing.assert_allclose(S.face_circles.distances[-1], expected, rtol=1e-10)
    np.testing.assert_allclose(S.vertex_circles.distances[-1], expected, rtol=1e-10)


def test_multigrid_and_factor_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    c = random_polyhedron(np.random.default_rng(5), 600, "dual of mixed")
    direct = koebe(c).mesh.vertices
    monkeypatch.setattr("geometry.optimise.grounded_laplacian.MAX_DIRECT_UNKNOWNS", 100)
    assert np.abs(koebe(c).mesh.vertices - direct).max() <= 1e-10


def test_vertex_cones_touch_the_sphere_and_contain_the_edges() -> None:
    S = koebe(solids.truncated_cube().combinatorics)
    cones = S.vertex_cones
    i, _ = S.mesh.combinatorics.edges.T
    axes = S.mesh.vertices[i] / np.linalg.norm(S.mesh.vertices[i], axis=1, keepdims=True)
    inwards = np.abs(np.einsum("ei,ei->e", axes, S.mesh.edge_directions))
    np.testing.assert_allclose(np.arccos(inwards), np.arcsin(1 / np.linalg.norm(cones.poles[i], axis=1)), atol=1e-12)


# --- what is refused


def test_a_vertex_without_face_has_no_circle_inside_the_sphere() -> None:
    mesh = koebe(solids.cube().combinatorics).mesh
    more = Mesh.from_faces([*mesh.vertices, [0, 0, 0]], mesh.combinatorics.faces)
    with pytest.raises(GeometryError, match="pole of cone 8 has length 0"):
        KoebePolyhedron(more).vertex_circles  # noqa: B018


def test_a_mesh_that_misses_the_sphere_is_refused() -> None:
    box = shapes.box(2**0.5, 2**0.5, 1.5)
    with pytest.raises(
        GeometryError, match=r"the line of edge \d+ from vertex \d to vertex \d misses the unit sphere by"
    ):
        KoebePolyhedron(box)
    S = koebe(solids.cube().combinatorics).mesh
    bent = Mesh(S.vertices * (1 + 1e-7 * np.arange(8)[:, None] * (np.arange(8)[:, None] == 3)), S.combinatorics)
    with pytest.raises(GeometryError, match="edge"):
        KoebePolyhedron(bent)
    KoebePolyhedron(bent, tolerance=1e-6)


def test_a_face_that_is_not_planar_is_refused() -> None:
    """Six circles of radius 1 that touch one after the other, but not at six points of a circle."""
    centres = np.array([[-1, 0], [1, 0], [2, 3**0.5], [2, 2 + 3**0.5], [0, 2 + 3**0.5], [0, 3**0.5]])
    assert np.allclose(np.linalg.norm(centres - np.roll(centres, 1, axis=0), axis=1), 2)
    vertices = poles(*circle_planes(centres * 0.2, np.full(6, 0.2)))
    mesh = Mesh.from_faces(vertices, [range(6)])
    np.testing.assert_allclose(edge_distances(mesh), 1, atol=1e-15)
    with pytest.raises(GeometryError, match=r"face 0 is off its plane by .* planarise the mesh first"):
        KoebePolyhedron(mesh)


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1, 2], [2, 1, 0]], "vertex 0 has 2 edges, at least 3"),
        # two tetrahedra with a common edge, whose open sides are closed by a quad: 0 and 1 separate
        (
            [[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 4], [1, 4, 5], [4, 0, 5], [3, 1, 5, 0]],
            "share vertices . and ., which",
        ),
        (
            [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [4, 5, 6], [4, 6, 7], [4, 7, 5], [5, 7, 6]],
            "faces 0 and 4 are not",
        ),
        (
            [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 4, 5], [0, 5, 6], [0, 6, 4], [4, 6, 5]],
            "faces 0 and 4 are not",
        ),
    ],
)
def test_graphs_that_are_not_3_connected(faces: list[list[int]], message: str) -> None:
    n = 1 + max(max(face) for face in faces)
    with pytest.raises(MeshError, match=message):
        koebe(Combinatorics.from_faces(n, faces))


@given(seeds, st.integers(4, 14), st.sampled_from(KINDS), st.integers(1, 3))
@settings(max_examples=60)
def test_what_is_refused_is_not_3_connected(seed: int, n: int, kind: str, n_lost: int) -> None:
    """Against the definition, after a few edges are taken away: connected without any two vertices."""
    rng = np.random.default_rng(seed)
    c = random_polyhedron(rng, n, kind)
    for _ in range(n_lost):
        faces = _without_edge(c, int(rng.integers(c.n_edges)))
        if any(len(set(face)) < len(face) for face in faces):
            return  # a face touches itself, which combinatorics do not hold
        c = Combinatorics.from_faces(c.n_vertices, faces)
    if _is_3_connected(c):
        refuse_other_than_polyhedra(c)
        assert_koebe(koebe(c))
    else:
        with pytest.raises(MeshError, match=r"not 3-connected|at least 3"):
            refuse_other_than_polyhedra(c)


def _is_3_connected(c: Combinatorics) -> bool:
    adjacency = c.adjacency.toarray()
    for pair in combinations(range(c.n_vertices), 2):
        left = np.delete(np.delete(adjacency, pair, axis=0), pair, axis=1)
        if connected_components(left)[0] > 1:
            return False
    return c.n_vertices > 3


def test_polygons_nested_too_deeply() -> None:
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    for v in range(4, 40):
        i, j, k = faces.pop()
        faces += [[i, j, v], [j, k, v], [k, i, v]]
    with pytest.raises(
        GeometryError, match=r"the circle of (vertex|face) \d+ has radius .* is needed to tell its points"
    ):
        koebe(Combinatorics.from_faces(40, faces))


def test_handles_and_unused_vertices() -> None:
    tube = shapes.torus([[3.0, 0.0], [4.0, 0.0], [3.5, 1.0]], 5).combinatorics
    with pytest.raises(MeshError, match=r"= 0, of a part of a sphere it is 2: the mesh has handles") as caught:
        koebe(tube)
    assert (caught.value.value, caught.value.bound) == (0, 2)
    with pytest.raises(MeshError, match="vertex 4 belongs to no face"):
        koebe(Combinatorics.from_faces(5, solids.tetrahedron().combinatorics.faces))


@given(seeds, st.integers(5, 30), st.sampled_from(KINDS))
@settings(max_examples=20)
def test_faces_glued_to_each_other_separate_the_graph(seed: int, n: int, kind: str) -> None:
    """Two polyhedra glued along an edge, which both lose: two faces there share two vertices that are not joined."""
    rng = np.random.default_rng(seed)
    c = random_polyhedron(rng, n, kind)
    edge = int(rng.integers(c.n_edges))
    opened = _without_edge(c, edge)
    i, j = c.edges[edge].tolist()
    shifted = np.arange(c.n_vertices) + c.n_vertices
    shifted[[i, j]] = [i, j]
    mirrored = [[int(shifted[v]) for v in face[::-1]] for face in opened[:-1]]
    ring = opened[-1]
    at_i, at_j = ring.index(i), ring.index(j)
    one, two = _part(ring, at_i, at_j), _part(ring, at_j, at_i)
    across = [[*one, *(int(shifted[v]) for v in one[-2:0:-1])], [*two, *(int(shifted[v]) for v in two[-2:0:-1])]]
    used, corners = np.unique(
        np.concatenate([np.array(face) for face in opened[:-1] + mirrored + across]), return_inverse=True
    )
    starts = np.cumsum([0] + [len(face) for face in opened[:-1] + mirrored + across])
    glued = Combinatorics(len(used), corners, starts)
    assert glued.euler_characteristic == 2
    with pytest.raises(MeshError, match=r"so it is not 3-connected|has 2 edges"):
        koebe(glued)


def _without_edge(c: Combinatorics, edge: int) -> list[list[int]]:
    """Faces but the two at an edge, then these two as one."""
    left, right = c.edge_faces[edge].tolist()
    i, j = c.edges[edge].tolist()
    one, two = c.face(left).tolist(), c.face(right).tolist()
    merged = _part(one, one.index(j), one.index(i))[:-1] + _part(two, two.index(i), two.index(j))[:-1]
    return [face for f, face in enumerate(c.faces) if f not in (left, right)] + [merged]


def _part(ring: list[int], start: int, end: int) -> list[int]:
    """From one place of a ring to another, both included."""
    turned = ring[start:] + ring[:start]
    return turned[: (end - start) % len(ring) + 1]


def test_values_for_a_closed_polyhedron_are_refused() -> None:
    c = solids.cube().combinatorics
    with pytest.raises(GeometryError, match="coverage given for a closed polyhedron"):
        koebe(c, coverage=0.5)
    with pytest.raises(GeometryError, match="radii given for a closed polyhedron"):
        koebe(c, radii=np.ones(8))
