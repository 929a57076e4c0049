"""The design surface: feet against brute force over all triangles, normals, gradients of the distance, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError
from geometry.mesh import Mesh, shapes
from geometry.surface.surface import Surface

seeds = st.integers(0, 2**32 - 1)


def shaken(mesh: Mesh, amount: float, seed: int) -> Mesh:
    noise = np.random.default_rng(seed).uniform(-amount, amount, size=mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + noise * mesh.mean_edge_length)


def triangles_of(mesh: Mesh) -> FloatArray:
    """(T, 3, 3): triangles as they are, larger faces cut about their centroids."""
    parts = []
    for face in mesh.combinatorics.faces:
        ring = mesh.vertices[face]
        if len(face) == 3:
            parts.append(ring[None])
        else:
            centre = np.broadcast_to(ring.mean(axis=0), ring.shape)
            parts.append(np.stack([ring, np.roll(ring, -1, axis=0), centre], axis=1))
    return np.concatenate(parts)


def distances_by_force(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """(n,) least distance over all triangles, their insides and edges."""
    best = np.full(len(points), np.inf)
    for triangle in triangles:
        a, e, f = triangle[0], triangle[1] - triangle[0], triangle[2] - triangle[0]
        s, t = np.linalg.lstsq(np.stack([e, f], axis=1), (points - a).T)[0]
        feet = a + s[:, None] * e + t[:, None] * f
        inside = (s >= 0) & (t >= 0) & (s + t <= 1)
        best = np.where(inside, np.minimum(best, np.linalg.norm(points - feet, axis=1)), best)
        for start, end in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            s = np.clip((points - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
            best = np.minimum(best, np.linalg.norm(points - start - s[:, None] * (end - start), axis=1))
    return best


MESHES = {
    "triangles": shapes.icosahedron(),
    "pentagons": shapes.dodecahedron(),
    "prism": shapes.regular_prism(7),
    "quads that are not planar": shaken(shapes.dome(8, 3), 0.1, 0),
    "one triangle": Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "collinear corner": Mesh.from_faces([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], [[0, 1, 2, 3, 4]]),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(seed=seeds, far=st.sampled_from([0.01, 1.0, 1e3, 1e8, 1e12]))
@settings(max_examples=15)
def test_feet_are_the_nearest_points(mesh: Mesh, seed: int, far: float) -> None:
    points = far * np.random.default_rng(seed).normal(size=(10, 3))
    feet, normals = Surface(mesh).closest(points)
    size = far + np.abs(mesh.vertices).max()
    np.testing.assert_allclose(
        np.linalg.norm(points - feet, axis=1), distances_by_force(points, triangles_of(mesh)), atol=1e-14 * size
    )
    np.testing.assert_allclose(distances_by_force(feet, triangles_of(mesh)), 0.0, atol=1e-14 * size)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_at_the_vertices_normals_are_those_of_the_vertices(mesh: Mesh) -> None:
    feet, normals = Surface(mesh).closest(mesh.vertices)
    np.testing.assert_allclose(feet, mesh.vertices, atol=1e-14)
    np.testing.assert_allclose(normals, mesh.vertex_normals, atol=1e-12)


@given(seeds)
def test_normals_turn_steadily_where_the_surface_has_edges(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(200, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    step = 1e-6
    surface = Surface(shapes.icosahedron())
    first, second = surface.closest(points)[1], surface.closest(points + step * rng.uniform(-1, 1, points.shape))[1]
    # between two vertices an edge length of 2 apart the normals of the solid turn by 1.11; flat faces would jump by 0.7
    assert np.linalg.norm(first - second, axis=1).max() < 10 * step


def test_normals_of_a_sphere() -> None:
    points = np.random.default_rng(2).normal(size=(500, 3))
    points[:, 2] = np.clip(points[:, 2], 0.3, 2) * np.linalg.norm(points[:, :2], axis=1)  # above its lower boundary
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    surface = Surface(shapes.dome(72, 14))  # every 5 degrees
    points = points[points[:, 2] < np.sin(np.radians(79))]
    feet, normals = surface.closest(points)
    outwards = feet / np.linalg.norm(feet, axis=1, keepdims=True)
    inner = feet[:, 2] < np.sin(np.radians(74))  # at the boundary, vertices have fewer faces, and normals lean
    assert np.linalg.norm(normals - outwards, axis=1)[inner].max() < np.radians(1.0)


# --- distances


@pytest.mark.parametrize("height", [0.0, 1e-6, 1e-3, -1e-3])
def test_gradients_are_those_of_the_distances(height: float) -> None:
    rng = np.random.default_rng(3)
    mesh = shaken(shapes.dome(12, 6), 0.02, 1)
    surface = Surface(mesh)
    inside = np.einsum("tk,tki->ti", rng.dirichlet([2, 2, 2], size=len(triangles_of(mesh))), triangles_of(mesh))
    points = inside + height * surface.closest(inside)[1]
    direction = rng.normal(size=points.shape)
    step = 1e-7
    values, gradients = surface.distances(points)
    change = surface.distances(points + step * direction)[0] - surface.distances(points - step * direction)[0]
    found = np.einsum("ni,ni->n", gradients, direction)
    # rounding over the step, and 3 times the height: how fast normals turn on this coarse, shaken dome
    np.testing.assert_allclose(found, change / (2 * step), atol=1e-8 + 3 * abs(height))
    np.testing.assert_allclose(values, height, atol=1e-15 + 0.1 * abs(height))  # facets lean by up to 25 degrees


def test_beyond_the_boundary_vertices_go_on_gliding() -> None:
    surface = Surface(shapes.grid(3, 3))
    points = np.array([[-2.0, 1.5, 0.0], [-2.0, 1.4, 0.5], [4.0, 5.0, -0.25], [1.2, 3.5, 1.0]])
    values, gradients = surface.distances(points)
    np.testing.assert_allclose(values, points[:, 2], atol=1e-15)
    np.testing.assert_allclose(gradients, [[0, 0, 1]] * 4, atol=1e-15)


@pytest.mark.parametrize("along", [0.0, 0.2, 0.5])
def test_gradients_beyond_a_leaning_boundary(along: float) -> None:
    mesh = shapes.dome(12, 6)
    surface = Surface(mesh)
    start, end = mesh.vertices[0], mesh.vertices[7]  # two neighbours on the lower boundary
    base = (1 - along) * start + along * end
    point = base * [1.005, 1.005, 1] - [0, 0, 0.005]
    foot = surface.closest(point[None])[0][0]
    away, h = float(np.linalg.norm(point - foot)), 1e-7
    assert np.linalg.norm(np.cross(foot - start, end - start)) < 1e-14  # on the edge
    near = point + h * np.concatenate([np.eye(3), -np.eye(3)])
    values = surface.distances(near)[0]
    # exact up to the way to the foot, on a unit sphere; normals lean along the edge by up to 0.25
    np.testing.assert_allclose(
        surface.distances(point[None])[1][0], (values[:3] - values[3:]) / (2 * h), atol=1e-7 + 2 * away
    )


@given(seeds, st.floats(-6, 6))
def test_units_and_place_do_not_matter(seed: int, decades: float) -> None:
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    scale, shift = 10.0**decades, rng.normal(size=3)
    mesh = MESHES["quads that are not planar"]
    points = mesh.vertices + 0.1 * rng.normal(size=mesh.vertices.shape)
    values, gradients = Surface(mesh).distances(points)
    moved = Surface(mesh.with_vertices((mesh.vertices @ turn + shift) * scale))
    found, slopes = moved.distances((points @ turn + shift) * scale)
    np.testing.assert_allclose(found / scale, values, atol=1e-11)
    np.testing.assert_allclose(slopes, gradients @ turn, atol=1e-9)


# --- refusals


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200])
def test_points_that_are_no_numbers_are_refused(value: float) -> None:
    surface = Surface(shapes.cube())
    points = np.array([[0.0, 0, 0], [0, value, 0]])
    for ask in (surface.closest, surface.distances):
        with pytest.raises(GeometryError, match=r"point 1 is \[.*\]: coordinates must be finite numbers") as raised:
            ask(points)
        assert raised.value.elements == (1,)


def test_shapes_of_points() -> None:
    surface = Surface(shapes.cube())
    assert surface.closest(np.zeros((0, 3)))[0].shape == (0, 3)
    assert surface.distances(np.zeros((0, 3)))[0].shape == (0,)
    for points in (np.zeros(3), np.zeros((2, 2))):
        with pytest.raises(GeometryError, match="points have shape"):
            surface.closest(points)


def test_a_triangle_without_area_is_refused() -> None:
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0]]
    with pytest.raises(MeshError, match=r"face 1 has no area: .* more than 1e-09 is needed; remove it") as raised:
        Surface(Mesh.from_faces(vertices, [[0, 1, 2], [0, 3, 1]]))
    assert raised.value.elements == (1,)


def test_a_face_that_its_centroid_does_not_see_is_refused() -> None:
    hook = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [3, 4, 0], [3, 1, 0], [0, 1, 0]]
    with pytest.raises(MeshError, match=r"face 0 cannot be cut into triangles about its centroid"):
        Surface(Mesh.from_faces(hook, [list(range(6))]))


def test_two_layers_back_to_back_are_refused() -> None:
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    with pytest.raises(MeshError, match="the faces at vertex 0 face opposite directions"):
        Surface(Mesh.from_faces(vertices, [[0, 1, 2], [0, 2, 1]]))
