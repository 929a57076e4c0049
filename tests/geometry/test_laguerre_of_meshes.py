"""Laguerre transformations take meshes with exact offsets to meshes with them [Pottmann2007, Prop. 3, 4]."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import GeometryError, ParallelityError
from geometry.exact_offsets import conicality, edge_cone_deviation, face_offset_pair
from geometry.gauss import Pair
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.gauss.distances import edge_distances, face_distances, vertex_distances
from geometry.mesh import Mesh, solids
from geometry.parallel.edge_parallelity import parallelity
from geometry.spheres.laguerre import LaguerreTransformation
from geometry.spheres.lorentz import FORM
from geometry.spheres.moebius import MoebiusTransformation
from geometry.spheres.oriented_cones import VertexCones
from tests.geometry.parallel_elements import SIMPLE, SOLIDS, element, opened, solid
from tests.geometry.test_laguerre import planes, transformation
from tests.geometry.test_lorentz import direction, orthogonal, seeds

L = LaguerreTransformation
EXACT = 1e-11  # some hundred operations on numbers below a hundred, boosts of gamma below 2.3
names = st.sampled_from(sorted(SOLIDS))
speeds = st.floats(0, 0.9)


def assert_same(one: Pair, two: Pair, bound: float = 1e-9) -> None:
    for first, second in ((one.mesh, two.mesh), (one.gauss_image, two.gauss_image)):
        size = max(1.0, float(np.abs(first.vertices).max()))
        np.testing.assert_allclose(first.vertices, second.vertices, rtol=0, atol=bound * size)


def pair(name: str, scale: str, seed: int) -> Pair:
    """A random M, parallel to a boosted and opened solid S with its edges, faces or vertices at distance 1."""
    whole = circumscribed(name) if scale == "face" else solid(name, scale)
    velocity = 0.5 * direction(np.random.default_rng(seed)) / vertex_distances(whole).max()
    image = opened(MoebiusTransformation.boost(velocity).map_mesh(whole), seed)
    return Pair(element(image, seed), image)


@cache
def circumscribed(name: str) -> Mesh:
    return face_offset_pair(SOLIDS[name]).gauss_image


def moderate(image: Mesh, seed: int, portion: float) -> LaguerreTransformation:
    """A transformation that takes no vertex of S to infinity."""
    return transformation(seed, portion / float(vertex_distances(image).max()))


@given(names, seeds, st.floats(-3, 3))
def test_elementary_transformations(name: str, seed: int, d: float) -> None:
    rng = np.random.default_rng(seed)
    given = pair(name, "edge", seed)
    m, s = given.mesh, given.gauss_image
    q, t = orthogonal(rng, rng.choice([-1.0, 1.0])), rng.normal(size=3)
    moved = Pair(m.with_vertices(m.vertices @ q.T + t), s.with_vertices(s.vertices @ q.T))
    assert_same(given.laguerre(L.motion(q, t)), moved, 1e-13)
    assert_same(given.laguerre(L.offset(d)), Pair(given.offset_mesh(d), s), 1e-13)
    turned = given.laguerre(L.reversal())
    assert_same(turned, Pair(m, -1 * s), 1e-13)
    np.testing.assert_allclose(turned.mesh.face_normals, -m.face_normals, atol=1e-12)
    assert turned.mesh.combinatorics is turned.gauss_image.combinatorics


@given(names, seeds)
def test_proposition_3_vertex_cones_contain_the_edges(name: str, seed: int) -> None:
    """Prop. 3: the edges of M at m_i lie on a cone of revolution about s_i, the one with apex m_i and pole s_i."""
    given = pair(name, "edge", seed)
    m, s = given.mesh, given.gauss_image
    k = VertexCones(m.vertices, s.vertices)
    ends = m.combinatorics.edges.T
    for vertices in ends:
        sines = np.linalg.norm(np.cross(m.edge_directions, k.axes[vertices]), axis=1)
        np.testing.assert_allclose(sines, np.sin(k.half_angles[vertices]), atol=EXACT)
    assert np.nan_to_num(edge_cone_deviation(m)).max() <= 1e-9  # judged without S, from short edges too


@given(names, seeds, speeds)
def test_proposition_4_edge_offset_meshes_go_to_edge_offset_meshes(name: str, seed: int, portion: float) -> None:
    """Prop. 4, with the vertex cones as the paper takes them: through the images of two spheres that touch them."""
    given = pair(name, "edge", seed)
    m, s = given.mesh, given.gauss_image
    f = moderate(s, seed, portion)
    found = given.laguerre(f)
    moved, image = found.mesh, found.gauss_image
    size = np.abs(moved.vertices).max()
    np.testing.assert_allclose(edge_distances(image), 1, atol=1e-10)
    assert parallelity(image, moved).max() <= EXACT * size
    assert image.planarity.max() <= EXACT
    assert moved.plane_deviations.max() <= EXACT * size
    k = VertexCones(m.vertices, s.vertices)
    again = VertexCones.touching(f.map_spheres(k.spheres(1.0)), f.map_spheres(k.spheres(-1.0)))
    assert_same(found, Pair(moved.with_vertices(again.apices), image.with_vertices(again.poles)))


# Three planes touch a cone, and so do the faces of regular solids. The planes of the truncated tetrahedron, all at the
# same distance, meet in edges without length.
CONES = sorted({*SIMPLE, "octahedron", "icosahedron"} - {"truncated_tetrahedron"})


@given(st.sampled_from(CONES), seeds, speeds)
def test_conical_meshes_go_to_conical_meshes(name: str, seed: int, portion: float) -> None:
    """The planes of the faces of M' are the images of the planes of the faces of M."""
    given = pair(name, "face", seed)
    m, s = given.mesh, given.gauss_image
    f = moderate(s, seed, portion)
    found = given.laguerre(f)
    moved, image = found.mesh, found.gauss_image
    size = np.abs(moved.vertices).max()
    np.testing.assert_allclose(np.abs(face_distances(image)), 1, atol=1e-10)
    assert parallelity(image, moved).max() <= EXACT * size
    assert np.nan_to_num(conicality(moved)).max() <= 1e-7  # of small faces
    c = m.combinatorics
    outer = s.face_normals * np.sign(face_distances(s))[:, None]  # faces of S and of M may be reversed
    first = c.corners[c.face_starts[:-1]]
    images = f.map_planes(np.column_stack([outer, np.einsum("fi,fi->f", outer, m.vertices[first])]))[c.corner_face]
    np.testing.assert_allclose(np.einsum("ci,ci->c", images[:, :3], image.vertices[c.corners]), 1, atol=1e-9)
    heights = np.einsum("ci,ci->c", images[:, :3], moved.vertices[c.corners])
    np.testing.assert_allclose(heights, images[:, 3], atol=EXACT * size)


@given(names, seeds, speeds)
def test_circular_meshes_go_to_circular_meshes(name: str, seed: int, speed: float) -> None:
    found = pair(name, "vertex", seed).laguerre(transformation(seed, speed))
    moved, image = found.mesh, found.gauss_image
    np.testing.assert_allclose(vertex_distances(image), 1, atol=1e-10)
    assert parallelity(image, moved).max() <= EXACT * 10 * np.abs(moved.vertices).max()


@given(names, st.sampled_from(["edge", "vertex"]), seeds, speeds)
def test_meshes_follow_composition_and_inverse(name: str, scale: str, seed: int, portion: float) -> None:
    given = pair(name, scale, seed)
    f = moderate(given.gauss_image, seed, portion)
    there = given.laguerre(f)
    assert_same(there.laguerre(f.inverse()), given, 1e-8)
    g = moderate(there.gauss_image, seed + 1, 0.5)
    assert_same(there.laguerre(g), given.laguerre(g @ f), 1e-8)


@given(names, seeds, speeds, st.floats(-2, 2))
def test_offsets_go_to_offsets_moved_along(name: str, seed: int, portion: float, d: float) -> None:
    """M + d S goes to M' + d (c S' + u), with the last column (u, c) of the matrix: the offset at c d, and a shift."""
    given = pair(name, "edge", seed)
    f = moderate(given.gauss_image, seed, portion)
    moved = given.laguerre(f)
    offset = Pair(given.offset_mesh(d), given.gauss_image).laguerre(f)
    u, c = f.matrix[:3, 3], f.matrix[3, 3]
    image = moved.gauss_image
    assert_same(offset, Pair(moved.mesh + d * c * image.translated(u / c), image))


@given(names, seeds, speeds)
def test_the_gauss_image_moves_by_the_moebius_transformation_of_the_inverse_transpose(
    name: str, seed: int, portion: float
) -> None:
    """J A J is the inverse of A^T. So normals of planes and Gauss images move by the same map of the sphere."""
    given = pair(name, "edge", seed)
    f = moderate(given.gauss_image, seed, portion)
    moebius = MoebiusTransformation(np.linalg.inv(f.matrix).T)
    np.testing.assert_allclose(f.gauss_map.matrix, moebius.matrix, atol=1e-12)
    np.testing.assert_allclose(f.gauss_map.matrix, np.sign(f.matrix[3, 3]) * FORM @ f.matrix @ FORM, atol=1e-14)
    expected = moebius.map_mesh(given.gauss_image)
    moved = given.laguerre(f)
    image = moved.gauss_image
    assert_same(moved, Pair(moved.mesh, expected))
    np.testing.assert_array_equal(image.combinatorics.corners, expected.combinatorics.corners)
    normals = planes(seed)
    np.testing.assert_allclose(f.map_planes(normals)[:, :3], moebius.map_points(normals[:, :3]), atol=EXACT)


@given(names, seeds, speeds)
def test_other_parallel_pairs_stay_parallel_and_planar(name: str, seed: int, portion: float) -> None:
    image = SOLIDS[name].translated([0.3, 0.2, 0.1]) * 0.7
    m = element(image, seed)
    moved = Pair(m, image).laguerre(moderate(image, seed, portion), tolerance=np.inf)
    assert parallelity(moved.gauss_image, moved.mesh).max() <= EXACT * 10 * np.abs(moved.mesh.vertices).max()


def test_the_cube_becomes_a_frustum() -> None:
    """By hand: the cube of half-edge 1, boosted along z at 0.6, becomes a frustum with the planes of that boost."""
    cube = solids.cube()
    moved = Pair(cube, cube).laguerre(L.boost([0, 0, 0.6]))
    np.testing.assert_allclose(moved.face_distances, 1, atol=1e-14)
    np.testing.assert_allclose(sorted(set(moved.mesh.vertices[:, 2].round(12))), [-0.5, 2.0])


def test_a_vertex_that_goes_through_infinity_is_named() -> None:
    s = solid("cube", "edge")  # vertices at sqrt(3/2) from the origin
    m = element(s, 0)
    direction = s.vertices[5] / np.linalg.norm(s.vertices[5])
    Pair(m, s).laguerre(L.boost(0.8 * direction))
    with pytest.raises(GeometryError, match="vertex 5 goes to infinity") as caught:
        Pair(m, s).laguerre(L.boost(np.sqrt(2 / 3) * direction))
    assert caught.value.elements == (5,)
    assert caught.value.value == pytest.approx(0, abs=1e-15)
    with pytest.raises(GeometryError, match="cone 5 goes to infinity"):
        L.boost(0.9 * direction).map_cones(VertexCones(m.vertices, s.vertices))


def test_meshes_without_exact_offsets_and_not_parallel_are_refused() -> None:
    s = solid("truncated_cube", "edge")
    m = element(s, 1)
    with pytest.raises(GeometryError, match=r"nearest to having all edges .* off, allowed 1e-09") as caught:
        Pair(m, s * 1.01).laguerre(L.identity())
    assert caught.value.value == pytest.approx(0.01)
    pair = approximate_pair(m)
    pair.laguerre(L.identity(), tolerance=np.inf)
    with pytest.raises(GeometryError, match="no exact kind"):
        pair.laguerre(L.identity())
    with pytest.raises(ParallelityError, match="Gauss image"):
        Pair(m, s.with_vertices(s.vertices + np.eye(len(s.vertices), 3))).laguerre(L.identity())
