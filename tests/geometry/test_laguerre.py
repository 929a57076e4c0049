"""Laguerre transformations keep contact and tangential distance; meshes with exact offsets go to meshes with them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.edge_offset.laguerre import LaguerreTransformation
from geometry.edge_offset.lorentz import FORM, product
from geometry.edge_offset.moebius import MoebiusTransformation
from geometry.edge_offset.vertex_cones import VertexCones
from geometry.errors import GeometryError, ParallelityError
from geometry.mesh import Mesh, solids
from geometry.meshing import planarise
from geometry.parallel.exact import face_gauss_image
from geometry.parallel.gauss_image import gauss_image
from geometry.parallel.offsets import (
    conicality,
    edge_cone_deviation,
    edge_distances,
    face_distances,
    vertex_distances,
)
from geometry.parallel.parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from tests.geometry.members import SIMPLE, SOLIDS, member, opened, solid
from tests.geometry.test_lorentz import direction, lorentz_matrix, orthogonal, seeds
from tests.real_data.meshes import CONICAL, HEXAGONAL, needs_data, read

L = LaguerreTransformation
EXACT = 1e-11  # some hundred operations on numbers below a hundred, boosts of gamma below 2.3
names = st.sampled_from(sorted(SOLIDS))
speeds = st.floats(0, 0.9)
signs = st.sampled_from([1.0, -1.0])


def transformation(seed: int, speed: float = 0.5) -> LaguerreTransformation:
    """Any: of either determinant, with and without turning over."""
    rng = np.random.default_rng(seed)
    sign, determinant = rng.choice([-1.0, 1.0], size=2)
    return L(sign * lorentz_matrix(rng, speed, determinant=determinant), rng.normal(size=4))


def spheres(seed: int, count: int = 5) -> FloatArray:
    return np.random.default_rng(seed + 1).normal(size=(count, 4)) * 2


def planes(seed: int, count: int = 5) -> FloatArray:
    rng = np.random.default_rng(seed + 2)
    return np.array([np.append(direction(rng), rng.normal()) for _ in range(count)])


def cones(seed: int, count: int = 5) -> VertexCones:
    rng = np.random.default_rng(seed + 3)
    return VertexCones.of_revolution(rng.normal(size=(count, 3)), planes(seed)[:, :3], rng.uniform(1.0, 1.5, count))


def contact(spheres: FloatArray, planes: FloatArray) -> FloatArray:
    """How far spheres are from touching planes, paired."""
    return np.asarray(np.einsum("ki,ki->k", planes[:, :3], spheres[:, :3]) + spheres[:, 3] - planes[:, 3])


def assert_same(one: tuple[Mesh, Mesh], two: tuple[Mesh, Mesh], bound: float = 1e-9) -> None:
    for first, second in zip(one, two, strict=True):
        size = max(1.0, float(np.abs(first.vertices).max()))
        np.testing.assert_allclose(first.vertices, second.vertices, rtol=0, atol=bound * size)


def pair(name: str, scale: str, seed: int) -> tuple[Mesh, Mesh]:
    """A random M, parallel to a boosted and opened solid S with its edges, faces or vertices at distance 1."""
    whole = circumscribed(name) if scale == "face" else solid(name, scale)
    velocity = 0.5 * direction(np.random.default_rng(seed)) / vertex_distances(whole).max()
    image = opened(MoebiusTransformation.boost(velocity).map_mesh(whole), seed)
    return member(image, seed), image


@cache
def circumscribed(name: str) -> Mesh:
    return face_gauss_image(SOLIDS[name])


def moderate(image: Mesh, seed: int, portion: float) -> LaguerreTransformation:
    """A transformation that takes no vertex of S to infinity."""
    return transformation(seed, portion / float(vertex_distances(image).max()))


# --- spheres, planes, cones


@given(seeds, speeds)
def test_tangential_distances_are_kept(seed: int, speed: float) -> None:
    x = spheres(seed)
    y = transformation(seed, speed).map_spheres(x)
    before, after = (product(s[1:] - s[:-1], s[1:] - s[:-1]) for s in (x, y))
    np.testing.assert_allclose(after, before, atol=EXACT * 100)


def test_the_lorentz_product_is_the_squared_tangential_distance() -> None:
    """Two circles of radius 3 and 1 a distance 7 apart: an outer tangent has length sqrt(49 - 4) between them."""
    x, y = np.array([0, 0, 0, 3.0]), np.array([7.0, 0, 0, 1.0])
    assert product(y - x, y - x) == pytest.approx(45)
    assert product(y * [1, 1, 1, -1] - x, y * [1, 1, 1, -1] - x) == pytest.approx(49 - 16)  # an inner one


@given(seeds, speeds)
def test_contact_of_spheres_and_planes_is_kept(seed: int, speed: float) -> None:
    x, p = spheres(seed), planes(seed)
    x[:, 3] -= contact(x, p)
    x[0, 3] += 0.5  # the first one does not touch
    f = transformation(seed, speed)
    images = f.map_planes(p)
    np.testing.assert_allclose(np.linalg.norm(images[:, :3], axis=1), 1, atol=1e-15)
    off = contact(f.map_spheres(x), images)
    np.testing.assert_allclose(off[1:], 0, atol=EXACT)
    assert abs(off[0]) > 1e-3


@given(seeds, speeds)
def test_cones_touch_what_they_touched(seed: int, speed: float) -> None:
    """The cone through the images of two spheres is the image of the cone, and touches the images of its planes."""
    k, f = cones(seed), transformation(seed, speed / 1.2)  # poles are shorter than 1 / sin(1) < 1.2
    image = f.map_cones(k)
    again = VertexCones.touching(f.map_spheres(k.spheres(0.5)), f.map_spheres(k.spheres(-2)))
    np.testing.assert_allclose(again.apices, image.apices, atol=1e-9)
    np.testing.assert_allclose(again.poles, image.poles, atol=1e-9)

    e = np.cross(k.axes, direction(np.random.default_rng(seed)))
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    sines, cosines = np.sin(k.half_angles)[:, None], np.cos(k.half_angles)[:, None]
    normals = sines * k.axes + cosines * e
    touching = f.map_planes(np.column_stack([normals, np.einsum("ki,ki->k", normals, k.apices)]))
    np.testing.assert_allclose(np.einsum("ki,ki->k", touching[:, :3], image.apices), touching[:, 3], atol=EXACT * 10)
    np.testing.assert_allclose(np.einsum("ki,ki->k", touching[:, :3], image.poles), 1, atol=EXACT * 10)


@given(seeds)
def test_cones_from_apex_axis_and_angle_and_from_two_spheres(seed: int) -> None:
    k = cones(seed)
    angles = np.random.default_rng(seed + 3)
    angles.normal(size=(5, 3))
    np.testing.assert_allclose(k.half_angles, angles.uniform(1.0, 1.5, 5), atol=1e-14)
    np.testing.assert_allclose(k.axes, planes(seed)[:, :3], atol=1e-15)
    again = VertexCones.touching(k.spheres(1.0), k.spheres(0.25))
    np.testing.assert_allclose(again.apices, k.apices, atol=1e-13)
    np.testing.assert_allclose(again.poles, k.poles, atol=1e-13)


# --- the group


@given(seeds, seeds, speeds)
def test_composition_and_inverse(one: int, two: int, speed: float) -> None:
    f, g, h = transformation(one, speed), transformation(two, speed), transformation(one + 1, speed)
    x, p = spheres(one), planes(one)
    size = 1e-15 * 1e2 * np.abs(f.matrix).max() * np.abs(g.matrix).max() * 100
    np.testing.assert_allclose((f @ g).map_spheres(x), f.map_spheres(g.map_spheres(x)), atol=size)
    np.testing.assert_allclose((f @ g).map_planes(p), f.map_planes(g.map_planes(p)), atol=size)
    np.testing.assert_allclose(f.inverse().map_spheres(f.map_spheres(x)), x, atol=size * 100)
    np.testing.assert_allclose(f.inverse().map_planes(f.map_planes(p)), p, atol=size * 100)
    np.testing.assert_allclose(((f @ g) @ h).matrix, (f @ (g @ h)).matrix, atol=size * 100)
    np.testing.assert_allclose(((f @ g) @ h).shift, (f @ (g @ h)).shift, atol=size * 100)
    np.testing.assert_array_equal((f @ L.identity()).map_spheres(x), f.map_spheres(x))


@given(names, seeds, st.floats(-3, 3))
def test_elementary_transformations(name: str, seed: int, d: float) -> None:
    rng = np.random.default_rng(seed)
    m, s = pair(name, "edge", seed)
    q, t = orthogonal(rng, rng.choice([-1.0, 1.0])), rng.normal(size=3)
    moved = m.with_vertices(m.vertices @ q.T + t), s.with_vertices(s.vertices @ q.T)
    assert_same(L.motion(q, t).map_mesh(m, s), moved, 1e-13)
    assert_same(L.offset(d).map_mesh(m, s), (m + d * s, s), 1e-13)
    turned = L.turning_over().map_mesh(m, s)
    assert_same(turned, (m, -1 * s), 1e-13)
    np.testing.assert_allclose(turned[0].face_normals, -m.face_normals, atol=1e-12)
    assert turned[0].combinatorics is turned[1].combinatorics


def test_a_boost_leaves_planes_across_it_and_turns_others_away() -> None:
    f = L.boost([0, 0, 0.6])  # gamma = 1.25
    images = f.map_planes([[0, 0, 1, 2.0], [0, 0, -1, 2.0], [1, 0, 0, 2.0]])
    np.testing.assert_allclose(images[:2], [[0, 0, 1, 4.0], [0, 0, -1, 1.0]], atol=1e-15)
    np.testing.assert_allclose(images[2], [0.8, 0, -0.6, 1.6], atol=1e-15)


# --- meshes


@given(names, seeds)
def test_proposition_3_vertex_cones_contain_the_edges(name: str, seed: int) -> None:
    """Prop. 3: the edges of M at m_i lie on a cone of revolution about s_i, the one with apex m_i and pole s_i."""
    m, s = pair(name, "edge", seed)
    k = VertexCones(m.vertices, s.vertices)
    ends = m.combinatorics.edges.T
    for vertices in ends:
        sines = np.linalg.norm(np.cross(m.edge_directions, k.axes[vertices]), axis=1)
        np.testing.assert_allclose(sines, np.sin(k.half_angles[vertices]), atol=EXACT)
    assert np.nan_to_num(edge_cone_deviation(m)).max() <= 1e-9  # judged without S, from short edges too


@given(names, seeds, speeds)
def test_proposition_4_edge_offset_meshes_go_to_edge_offset_meshes(name: str, seed: int, portion: float) -> None:
    """Prop. 4, with the vertex cones as the paper takes them: through the images of two spheres that touch them."""
    m, s = pair(name, "edge", seed)
    f = moderate(s, seed, portion)
    moved, image = f.map_mesh(m, s)
    size = np.abs(moved.vertices).max()
    np.testing.assert_allclose(edge_distances(image, image), 1, atol=1e-10)
    assert parallelity(image, moved).max() <= EXACT * size
    assert image.planarity.max() <= EXACT
    assert moved.plane_deviations.max() <= EXACT * size
    k = VertexCones(m.vertices, s.vertices)
    again = VertexCones.touching(f.map_spheres(k.spheres(1.0)), f.map_spheres(k.spheres(-1.0)))
    assert_same((moved, image), (moved.with_vertices(again.apices), image.with_vertices(again.poles)))


# Three planes touch a cone, and so do the faces of regular solids. The planes of the truncated tetrahedron, all at the
# same distance, meet in edges without length.
CONES = sorted({*SIMPLE, "octahedron", "icosahedron"} - {"truncated_tetrahedron"})


@given(st.sampled_from(CONES), seeds, speeds)
def test_conical_meshes_go_to_conical_meshes(name: str, seed: int, portion: float) -> None:
    """The planes of the faces of M' are the images of the planes of the faces of M."""
    m, s = pair(name, "face", seed)
    f = moderate(s, seed, portion)
    moved, image = f.map_mesh(m, s)
    size = np.abs(moved.vertices).max()
    np.testing.assert_allclose(np.abs(face_distances(image, image)), 1, atol=1e-10)
    assert parallelity(image, moved).max() <= EXACT * size
    assert np.nan_to_num(conicality(moved)).max() <= 1e-7  # of small faces
    c = m.combinatorics
    outer = s.face_normals * np.sign(face_distances(s, s))[:, None]  # faces of S and of M may be reversed
    first = c.corners[c.face_starts[:-1]]
    images = f.map_planes(np.column_stack([outer, np.einsum("fi,fi->f", outer, m.vertices[first])]))[c.corner_face]
    np.testing.assert_allclose(np.einsum("ci,ci->c", images[:, :3], image.vertices[c.corners]), 1, atol=1e-9)
    heights = np.einsum("ci,ci->c", images[:, :3], moved.vertices[c.corners])
    np.testing.assert_allclose(heights, images[:, 3], atol=EXACT * size)


@given(names, seeds, speeds)
def test_circular_meshes_go_to_circular_meshes(name: str, seed: int, speed: float) -> None:
    m, s = pair(name, "vertex", seed)
    moved, image = transformation(seed, speed).map_mesh(m, s)
    np.testing.assert_allclose(vertex_distances(image), 1, atol=1e-10)
    assert parallelity(image, moved).max() <= EXACT * 10 * np.abs(moved.vertices).max()


@given(names, st.sampled_from(["edge", "vertex"]), seeds, speeds)
def test_meshes_follow_composition_and_inverse(name: str, scale: str, seed: int, portion: float) -> None:
    m, s = pair(name, scale, seed)
    f = moderate(s, seed, portion)
    there = f.map_mesh(m, s)
    assert_same(f.inverse().map_mesh(*there), (m, s), 1e-8)
    g = moderate(there[1], seed + 1, 0.5)
    assert_same(g.map_mesh(*there), (g @ f).map_mesh(m, s), 1e-8)


@given(names, seeds, speeds, st.floats(-2, 2))
def test_offsets_go_to_offsets_moved_along(name: str, seed: int, portion: float, d: float) -> None:
    """M + d S goes to M' + d (c S' + u), with the last column (u, c) of the matrix: the offset at c d, and a shift."""
    m, s = pair(name, "edge", seed)
    f = moderate(s, seed, portion)
    moved, image = f.map_mesh(m, s)
    offset, same = f.map_mesh(m + d * s, s)
    u, c = f.matrix[:3, 3], f.matrix[3, 3]
    assert_same((offset, same), (moved + d * c * image.translated(u / c), image))


@given(names, seeds, speeds)
def test_the_gauss_image_moves_by_the_moebius_transformation_of_the_inverse_transpose(
    name: str, seed: int, portion: float
) -> None:
    """J A J is the inverse of A^T. So normals of planes and Gauss images move by the same map of the sphere."""
    m, s = pair(name, "edge", seed)
    f = moderate(s, seed, portion)
    moebius = MoebiusTransformation(np.linalg.inv(f.matrix).T)
    np.testing.assert_allclose(f.gauss_map.matrix, moebius.matrix, atol=1e-12)
    np.testing.assert_allclose(f.gauss_map.matrix, np.sign(f.matrix[3, 3]) * FORM @ f.matrix @ FORM, atol=1e-14)
    expected = moebius.map_mesh(s)
    image = f.map_mesh(m, s)[1]
    assert_same((image,) * 2, (expected,) * 2)
    np.testing.assert_array_equal(image.combinatorics.corners, expected.combinatorics.corners)
    normals = planes(seed)
    np.testing.assert_allclose(f.map_planes(normals)[:, :3], moebius.map_points(normals[:, :3]), atol=EXACT)


@given(names, seeds, speeds)
def test_other_parallel_pairs_stay_parallel_and_planar(name: str, seed: int, portion: float) -> None:
    image = SOLIDS[name].translated([0.3, 0.2, 0.1]) * 0.7
    m = member(image, seed)
    moved, away = moderate(image, seed, portion).map_mesh(m, image, tolerance=np.inf)
    assert parallelity(away, moved).max() <= EXACT * 10 * np.abs(moved.vertices).max()


# --- real meshes


@cache
def planar(name: str) -> Mesh:
    return planarise(read(name)).mesh


@needs_data
@pytest.mark.parametrize("seed", range(4))
def test_meshes_parallel_to_the_hexagonal_koebe_polyhedron(seed: int) -> None:
    image = planar(HEXAGONAL)
    m = ParallelSpace(image).elements(1, seed=seed)[0] * 10
    f = moderate(image, seed, 0.5)
    np.testing.assert_allclose(edge_distances(image, image), 1, atol=1e-9)
    moved, there = f.map_mesh(m, image)
    np.testing.assert_allclose(edge_distances(there, there), 1, atol=1e-9)
    assert parallelity(there, moved).max() <= 1e-10
    assert (edge_factors(there, moved) < 0).sum() > 100
    for vertices in there.combinatorics.edges.T:
        sines = np.linalg.norm(np.cross(there.edge_directions, there.vertices[vertices]), axis=1)
        np.testing.assert_allclose(sines, 1, atol=1e-9)


@needs_data
@pytest.mark.parametrize("seed", range(4))
def test_a_real_conical_mesh(seed: int) -> None:
    mesh = planar(CONICAL)
    mesh = mesh.translated(-mesh.vertices.mean(axis=0))
    image = face_gauss_image(mesh, tolerance=1.0)
    off = float(np.abs(face_distances(mesh, image) - 1).max())
    f = moderate(image, seed, 0.3)
    with pytest.raises(GeometryError, match="no exact kind"):
        f.map_mesh(mesh, image)
    moved, there = f.map_mesh(mesh, image, tolerance=2 * off)
    assert parallelity(moved, there).max() <= 1e-10
    assert np.abs(np.abs(face_distances(moved, there)) - 1).max() <= 5 * off

    boost = L.boost(0.1 * direction(np.random.default_rng(seed)))
    small, _ = boost.map_mesh(mesh, image, tolerance=2 * off)
    assert np.nanmax(conicality(small)) <= 2 * np.nanmax(conicality(mesh))  # no face is reversed yet


# --- what is refused


def test_a_vertex_that_goes_through_infinity_is_named() -> None:
    s = solid("cube", "edge")  # vertices at sqrt(3/2) from the origin
    m = member(s, 0)
    direction = s.vertices[5] / np.linalg.norm(s.vertices[5])
    L.boost(0.8 * direction).map_mesh(m, s)
    with pytest.raises(GeometryError, match="vertex 5 goes to infinity") as caught:
        L.boost(np.sqrt(2 / 3) * direction).map_mesh(m, s)
    assert caught.value.elements == (5,)
    assert caught.value.value == pytest.approx(0, abs=1e-15)
    with pytest.raises(GeometryError, match="cone 5 goes to infinity"):
        L.boost(0.9 * direction).map_cones(VertexCones(m.vertices, s.vertices))


def test_meshes_without_exact_offsets_and_not_parallel_are_refused() -> None:
    s = solid("truncated_cube", "edge")
    m = member(s, 1)
    with pytest.raises(GeometryError, match=r"nearest to having all edges .* off, allowed 1e-09") as caught:
        L.identity().map_mesh(m, s * 1.01)
    assert caught.value.value == pytest.approx(0.01)
    approximate = gauss_image(m)
    L.identity().map_mesh(m, approximate, tolerance=np.inf)
    with pytest.raises(GeometryError, match="no exact kind"):
        L.identity().map_mesh(m, approximate)
    with pytest.raises(ParallelityError, match="Gauss image"):
        L.identity().map_mesh(m, s.with_vertices(s.vertices + np.eye(len(s.vertices), 3)))


def test_cones_that_are_none_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"pole of cone 1 has length 0\.5"):
        VertexCones(np.zeros((2, 3)), np.array([[0, 0, 1.0], [0, 0.5, 0]]))
    with pytest.raises(GeometryError, match="cylinder"):
        VertexCones.touching([[0, 0, 0, 1.0]], [[3, 0, 0, 1.0]])
    with pytest.raises(GeometryError, match="pole of cone 0"):
        VertexCones.touching([[0, 0, 0, 5.0]], [[1, 0, 0, 1.0]])  # one sphere within the other
    with pytest.raises(GeometryError, match="cone 0 has half-angle 2"):
        VertexCones.of_revolution(np.zeros((1, 3)), [[0, 0, 1.0]], [2.0])


def test_wrong_matrices_and_planes_are_refused() -> None:
    with pytest.raises(GeometryError, match="differs"):
        L(2 * np.eye(4), np.zeros(4))
    with pytest.raises(GeometryError, match="shift"):
        L(np.eye(4), np.zeros(3))
    with pytest.raises(GeometryError, match="normal of plane 0"):
        L.identity().map_planes([[2, 0, 0, 1]])
    with pytest.raises(GeometryError, match="at or beyond the cone"):
        L.boost([0, 1.5, 0])


def test_the_cube_with_boxes_around_it() -> None:
    """By hand: the cube of half-edge 1, boosted along z at 0.6, becomes a frustum with the planes of that boost."""
    cube = solids.cube()
    moved, image = L.boost([0, 0, 0.6]).map_mesh(cube, cube)
    np.testing.assert_allclose(face_distances(image, image), 1, atol=1e-14)
    np.testing.assert_allclose(sorted(set(moved.vertices[:, 2].round(12))), [-0.5, 2.0])
