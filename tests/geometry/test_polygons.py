"""Meshes as vectors; areas, planes and normals of their faces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.mesh import Mesh, shapes
from geometry.mesh.polygons import best_planes, face_centroids, face_mean_edge_lengths, mixed_areas

EPS = float(np.finfo(float).eps)
SHAPES = [
    shapes.grid(3, 2),
    shapes.dome(8, 3),
    shapes.regular_prism(6),
    shapes.dodecahedron(),
    shapes.icosahedron(),
    shapes.translation_surface([[0, 0, 0], [1, 0, 1], [2, 0, 0]], [[0, 0, 0], [0, 1, -1], [0, 2, 0]]),
]
seeds = st.integers(0, 2**32 - 1)


@st.composite
def meshes(draw: st.DrawFn, noise: float = 0.2) -> Mesh:
    """A shape with its vertices moved at random by `noise`, so that faces are not planar."""
    mesh = draw(st.sampled_from(SHAPES))
    return mesh.with_vertices(mesh.vertices + _random(draw(seeds), mesh.vertices.shape) * noise)


def _random(seed: int, shape: tuple[int, ...]) -> FloatArray:
    return np.random.default_rng(seed).uniform(-1, 1, shape)


@given(meshes(), seeds, st.floats(-10, 10), st.floats(-10, 10))
def test_meshes_are_a_vector_space(a: Mesh, seed: int, s: float, t: float) -> None:
    b = a.with_vertices(_random(seed, a.vertices.shape))
    c = a.with_vertices(_random(seed + 1, a.vertices.shape))
    close = {"rtol": 0, "atol": 1e3 * EPS}  # values up to 10 * (10 + 10), a few roundings each
    np.testing.assert_allclose(((a + b) + c).vertices, (a + (b + c)).vertices, **close)
    np.testing.assert_array_equal((a + b).vertices, (b + a).vertices)
    np.testing.assert_array_equal((a - a).vertices, 0)
    np.testing.assert_array_equal((1 * a).vertices, a.vertices)
    np.testing.assert_allclose((s * (t * a)).vertices, ((s * t) * a).vertices, **close)
    np.testing.assert_allclose(((s + t) * a).vertices, (s * a + t * a).vertices, **close)
    np.testing.assert_allclose((s * (a + b)).vertices, (a * s + b * s).vertices, **close)
    assert (a + b).combinatorics is a.combinatorics


def test_meshes_with_other_faces_do_not_add() -> None:
    with pytest.raises(MeshError, match="equal combinatorics"):
        shapes.cube() + shapes.box(1, 1, 1).reversed()


def test_vertices_are_read_only_and_finite() -> None:
    mesh = shapes.cube()
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 7
    broken = mesh.vertices.copy()
    broken[5, 1] = np.nan
    with pytest.raises(MeshError, match=r"vertex 5 is \[.*nan.*\]: coordinates must be finite"):
        mesh.with_vertices(broken)
    with pytest.raises(MeshError, match=r"shape \(7, 3\), the faces need \(8, 3\)"):
        mesh.with_vertices(mesh.vertices[:7])


@given(meshes(), seeds, st.floats(0.01, 100))
def test_areas_and_normals_move_with_the_mesh(mesh: Mesh, seed: int, scale: float) -> None:
    rotation = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    moved = mesh.with_vertices(scale * mesh.vertices @ rotation.T + 5)
    # positions near 5 with edges near `scale`: cross products lose that many digits
    atol = 1e3 * EPS * (scale**2 + scale * 5)
    np.testing.assert_allclose(moved.vector_areas, scale**2 * mesh.vector_areas @ rotation.T, atol=atol, rtol=0)
    np.testing.assert_allclose(moved.edge_lengths, scale * mesh.edge_lengths, rtol=1e3 * EPS * (1 + 5 / scale))
    assert moved.mean_edge_length == pytest.approx(scale * mesh.mean_edge_length)


@given(meshes(), seeds, st.floats(0.01, 100))
def test_planarity_does_not_depend_on_size_or_place(mesh: Mesh, seed: int, scale: float) -> None:
    rotation = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    moved = mesh.with_vertices(scale * (mesh.vertices @ rotation.T + 5))
    # The best plane of a nearly isotropic face is badly determined; the random faces here keep 8 digits.
    np.testing.assert_allclose(moved.planarity, mesh.planarity, rtol=0, atol=1e-8)


@given(meshes())
def test_reversing_turns_areas_and_normals(mesh: Mesh) -> None:
    turned = mesh.reversed()
    np.testing.assert_allclose(turned.vector_areas, -mesh.vector_areas, rtol=0, atol=100 * EPS)
    np.testing.assert_allclose(turned.planarity, mesh.planarity, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(turned.reversed().vertices, mesh.vertices)
    assert turned.reversed().combinatorics.same_as(mesh.combinatorics)


@given(meshes())
def test_vector_areas_of_closed_meshes_add_up_to_nothing(mesh: Mesh) -> None:
    """And those of open ones to the vector area of their boundary."""
    total = np.zeros(3)
    for loop in mesh.combinatorics.boundary_loops:
        points = mesh.vertices[loop]
        total += np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) / 2
    np.testing.assert_allclose(mesh.vector_areas.sum(axis=0), total, rtol=0, atol=1e3 * EPS)


@given(meshes())
def test_best_planes_are_those_of_a_singular_value_decomposition(mesh: Mesh) -> None:
    normals, deviations = best_planes(mesh.vertices, mesh.combinatorics)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=0, atol=10 * EPS)
    for face in range(mesh.n_faces):
        points = mesh.vertices[mesh.combinatorics.face(face)]
        offsets = points - points.mean(axis=0)
        singular_values = np.linalg.svd(offsets, compute_uv=False)
        residual = np.linalg.norm(offsets @ normals[face])
        assert deviations[face] == pytest.approx(np.abs(offsets @ normals[face]).max(), abs=100 * EPS)
        # eigh works on squares: half the digits for values that are nearly zero
        least = singular_values[2] if len(singular_values) > 2 else 0.0
        assert residual == pytest.approx(least, abs=1e-7)
        assert normals[face] @ mesh.vector_areas[face] >= 0


@given(meshes(noise=0.0))
def test_planar_faces_have_their_area_along_their_normal(mesh: Mesh) -> None:
    np.testing.assert_allclose(mesh.planarity, 0, atol=1e-13)  # shapes promise rounding only
    areas = np.einsum("fk,fk->f", mesh.vector_areas, mesh.face_normals)
    np.testing.assert_allclose(areas, np.linalg.norm(mesh.vector_areas, axis=1), rtol=100 * EPS)


@given(meshes(), seeds, st.floats(-10, 10))
def test_mixed_areas_are_a_symmetric_bilinear_form(p: Mesh, seed: int, t: float) -> None:
    """Whose squares are the signed areas; on any polygons, parallel or not, seen along any normals."""
    c = p.combinatorics
    q, r = (_random(seed + k, p.vertices.shape) for k in (1, 2))
    normals = _random(seed, (p.n_faces, 3))

    def mixed(first: FloatArray, second: FloatArray) -> FloatArray:
        return mixed_areas(first, second, c, normals)

    close = {"rtol": 0, "atol": 1e4 * EPS}  # areas up to 5 times 10, sums over up to 6 corners
    np.testing.assert_allclose(mixed(p.vertices, q), mixed(q, p.vertices), **close)
    np.testing.assert_allclose(mixed(p.vertices, q + t * r), mixed(p.vertices, q) + t * mixed(p.vertices, r), **close)
    np.testing.assert_allclose(mixed(p.vertices + np.array([t, 1, -t]), q + t), mixed(p.vertices, q), **close)
    signed = np.einsum("fk,fk->f", p.vector_areas, normals)
    np.testing.assert_allclose(mixed(p.vertices, p.vertices), signed, **close)


def test_mixed_area_of_rectangles() -> None:
    """Of a x b and c x d, sides along each other: (a d + b c) / 2."""
    c = shapes.grid(1, 1).combinatorics
    corners = shapes.grid(1, 1).vertices
    for up in (1.0, -1.0):
        found = mixed_areas(corners * [2, 3, 0], corners * [5, 7, 0] + 100, c, np.array([[0, 0, up]]))
        np.testing.assert_allclose(found, [up * (2 * 7 + 3 * 5) / 2], rtol=1e3 * EPS)  # 100 takes two digits


def test_planarity_of_a_known_skew_quad() -> None:
    """A unit square with two opposite corners lifted by h and two lowered: distance h over its edge length."""
    h = 0.1
    mesh = Mesh.from_faces([[0, 0, h], [1, 0, -h], [1, 1, h], [0, 1, -h]], [[0, 1, 2, 3]])
    edge = (1 + 4 * h**2) ** 0.5
    assert mesh.planarity[0] == pytest.approx(h / edge, rel=1e-12)
    assert face_mean_edge_lengths(mesh.vertices, mesh.combinatorics)[0] == pytest.approx(edge, rel=1e-15)
    np.testing.assert_allclose(mesh.vector_areas, [[0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose(face_centroids(mesh.vertices, mesh.combinatorics), [[0.5, 0.5, 0]], atol=1e-15)


def test_vertex_normals_of_platonic_solids_are_radial() -> None:
    for mesh in (shapes.tetrahedron(), shapes.cube(), shapes.octahedron(), shapes.dodecahedron()):
        radial = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True)
        np.testing.assert_allclose(mesh.vertex_normals, radial, rtol=0, atol=100 * EPS)


def test_vertex_normals_do_not_see_how_a_planar_face_is_cut() -> None:
    """They are weighted by angles, which add up."""
    cube = shapes.box(1, 2, 3)
    whole, *others = cube.combinatorics.faces
    cut = Mesh.from_faces(cube.vertices, [whole[:3], [*whole[2:], whole[0]], *others])
    np.testing.assert_allclose(cut.vertex_normals, cube.vertex_normals, rtol=0, atol=100 * EPS)


def test_an_unused_vertex_has_no_normal() -> None:
    mesh = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], [[0, 1, 2]])
    np.testing.assert_array_equal(mesh.vertex_normals, [[0, 0, 1]] * 3 + [[0, 0, 0]])
