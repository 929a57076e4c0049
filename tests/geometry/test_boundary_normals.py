"""Normals at the boundary: as good as inside, so that mean curvatures converge there with the default Gauss image."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geometry.arrays import FloatArray
from geometry.curvature import face_curvatures
from geometry.errors import GeometryError
from geometry.functionals.boundary_normals import extrapolated_normals
from geometry.gauss import approximate_pair
from geometry.mesh import Combinatorics, Mesh, shapes, solids

seeds = st.integers(0, 2**32 - 1)


def of_revolution(radii: FloatArray, heights: FloatArray, slopes: FloatArray, n: int) -> tuple[Mesh, FloatArray]:
    """A patch over half a turn, n by n quads in the lines of curvature, and the normals (n + 1)^2 of the surface;
    slopes (n + 1, 2): the normals of the profile."""
    mesh = shapes.rotational_mesh(np.stack([radii, heights], axis=1), n + 1, closed=False)
    angles = np.pi / n * np.arange(n + 1)[:, None]
    x, y = np.cos(angles) * slopes[:, 0], np.sin(angles) * slopes[:, 0]
    return mesh, np.stack([x, y, np.broadcast_to(slopes[:, 1], x.shape)], axis=2).reshape(-1, 3)


def patch(name: str, n: int) -> tuple[Mesh, FloatArray, FloatArray]:
    """Mesh, normals, and the mean curvature of the surface in the middle of each face."""
    t = np.linspace(-1, 1, n + 1) if name in ("torus", "catenoid") else np.linspace(-0.5, 1, n + 1)
    middle = (t[1:] + t[:-1]) / 2
    if name == "catenoid":
        slopes = np.stack([1 / np.cosh(t), -np.tanh(t)], axis=1)
        return *of_revolution(np.cosh(t), t, slopes, n), np.zeros(n * n)
    circle = np.stack([np.cos(t), np.sin(t)], axis=1)
    if name == "torus":
        curvatures = -(1 + np.cos(middle) / (3 + np.cos(middle))) / 2
        return *of_revolution(3 + circle[:, 0], circle[:, 1], circle, n), np.tile(curvatures, n)
    a = {"sphere": 1.0, "ellipsoid": 1.5}[name]
    slopes = circle * [1, a]
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    w = np.hypot(a * np.sin(middle), np.cos(middle))  # speed along the meridian
    curvatures = -(a / w**3 + 1 / (a * w)) / 2
    return *of_revolution(a * circle[:, 0], circle[:, 1], slopes, n), np.tile(curvatures, n)


def rim(mesh: Mesh) -> FloatArray:
    """The faces that are not inside."""
    return np.setdiff1d(np.arange(mesh.n_faces), mesh.combinatorics.inner_faces)


def curvature_errors(name: str, n: int, *, known: bool = False) -> tuple[float, float]:
    """Of H at the rim and inside, with estimated normals or the known ones."""
    mesh, normals, curvatures = patch(name, n)
    pair = approximate_pair(mesh, normals=normals) if known else approximate_pair(mesh)
    errors = np.abs(face_curvatures(pair).mean - curvatures)
    return float(errors[rim(mesh)].max()), float(errors[mesh.combinatorics.inner_faces].max())


@pytest.mark.parametrize("name", ["torus", "sphere", "catenoid", "ellipsoid"])
def test_mean_curvatures_converge_at_the_boundary(name: str) -> None:
    """To second order, and as well as with the normals of the surface itself; one-sided normals leave 0.2 to 0.6."""
    errors = np.array([curvature_errors(name, n) for n in (20, 40, 80)])
    assert (np.log2(errors[:-1] / errors[1:]) > 1.5).all()
    assert errors[-1].max() < 1e-3
    known = np.array([curvature_errors(name, n, known=True) for n in (20, 40, 80)])
    assert (errors <= 3 * known).all()  # of the same order, with another constant


@pytest.mark.parametrize("name", ["torus", "sphere", "catenoid", "ellipsoid"])
def test_normals_converge_to_second_order_everywhere(name: str) -> None:
    errors = []
    for n in (20, 40, 80):
        mesh, normals, _ = patch(name, n)
        errors.append(float(np.linalg.norm(extrapolated_normals(mesh) - normals, axis=1).max()))
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > 1.7).all()


@given(seeds, st.floats(-3, 3))
def test_they_turn_with_the_mesh_and_nothing_else_changes_them(seed: int, decades: float) -> None:
    """Size, place, side and numbering; several pieces, each as it is alone."""
    rng = np.random.default_rng(seed)
    mesh = patch("torus", 4)[0]
    mesh = mesh.with_vertices(mesh.vertices + rng.uniform(-0.05, 0.05, mesh.vertices.shape))
    normals = extrapolated_normals(mesh)
    turn = Rotation.random(rng=rng).as_matrix()
    moved = mesh.with_vertices((mesh.vertices @ turn.T + rng.uniform(-9, 9, 3)) * 10**decades)
    np.testing.assert_allclose(extrapolated_normals(moved), normals @ turn.T, rtol=0, atol=1e-12)  # some ten edges away
    np.testing.assert_allclose(extrapolated_normals(mesh.reversed()), -normals, rtol=0, atol=1e-13)
    order = rng.permutation(mesh.n_vertices)
    faces = [[int(order[v]) for v in face] for face in mesh.combinatorics.faces]
    renumbered = Mesh.from_faces(mesh.vertices[np.argsort(order)], [faces[k] for k in rng.permutation(len(faces))])
    np.testing.assert_allclose(extrapolated_normals(renumbered)[order], normals, rtol=0, atol=1e-13)
    both = Mesh.from_faces(
        np.concatenate([mesh.vertices, mesh.vertices + 20]),
        [*mesh.combinatorics.faces, *[[v + mesh.n_vertices for v in face] for face in mesh.combinatorics.faces]],
    )
    np.testing.assert_allclose(extrapolated_normals(both), np.tile(normals, (2, 1)), rtol=0, atol=1e-13)


@given(st.sampled_from(solids.__all__))
def test_closed_meshes_keep_theirs(name: str) -> None:
    solid = getattr(solids, name)()
    assert extrapolated_normals(solid) is solid.vertex_normals


@given(st.sampled_from(solids.__all__), seeds)
def test_inside_nothing_changes_and_the_rim_of_a_convex_mesh_is_nearer_to_the_whole(name: str, seed: int) -> None:
    """A solid without one face: its rim has the normals of the solid more nearly than the faces left over say."""
    solid = getattr(solids, name)()
    faces = np.delete(np.arange(solid.n_faces), seed % solid.n_faces)
    mesh = solid.part(faces)
    inside = ~mesh.combinatorics.is_boundary_vertex
    found = extrapolated_normals(mesh)
    np.testing.assert_array_equal(found[inside], mesh.vertex_normals[inside])
    off, before = (
        np.linalg.norm(n - solid.vertex_normals, axis=1)[~inside].max() for n in (found, mesh.vertex_normals)
    )
    assert off < before


def test_single_faces_rows_and_unused_vertices_have_normals() -> None:
    flat = Mesh(np.eye(4, 3) * 9 + [0, 0, 5], Combinatorics.from_faces(4, [[0, 1, 2]]))
    found = extrapolated_normals(flat)
    np.testing.assert_allclose(found[:3], np.tile(flat.face_normals, (3, 1)), atol=1e-15)
    assert not found[3].any()
    angles = np.linspace(0, 1, 6)
    arc = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    row = shapes.translation_surface(arc, [[0, 0, 0], [0, 0, 1]])
    off = np.arccos(np.clip(np.einsum("ni,ni->n", extrapolated_normals(row), row.vertices * [1, 1, 0]), -1, 1))
    assert off.max() < 0.05  # a turn of 0.2 a face leaves 0.1 at the ends, if they take that of the last face


def test_sharp_folds_are_not_gone_on_with() -> None:
    """An accordion, whose faces are steeper than 70 degrees: at its sides normals would turn right round."""
    profile = np.stack([np.arange(6.0), np.zeros(6), 3 * (np.arange(6.0) % 2)], axis=1)
    mesh = shapes.translation_surface(profile, [[0, 0, 0], [0, 1, 0], [0, 2, 0]])
    cosines = np.einsum("ni,ni->n", extrapolated_normals(mesh), mesh.vertex_normals)
    assert cosines.min() > 0.5


def test_rough_faces_are_not_followed() -> None:
    """Noise of a tenth of an edge on a plane: the rim is less than twice as rough as the mean of its faces."""
    rng = np.random.default_rng(0)
    grid = shapes.grid(30, 30)
    rough = grid.with_vertices(grid.vertices + [0, 0, 0.1] * rng.normal(size=grid.vertices.shape))
    at_rim = grid.combinatorics.is_boundary_vertex
    found, before = (
        np.sqrt(np.square(n[at_rim, :2]).mean()) for n in (extrapolated_normals(rough), rough.vertex_normals)
    )
    assert found < 2 * before


def test_normals_given_are_checked() -> None:
    mesh = patch("torus", 3)[0]
    with pytest.raises(GeometryError, match="normals have shape"):
        approximate_pair(mesh, normals=np.zeros((2, 3)))
    with pytest.raises(GeometryError, match="finite"):
        approximate_pair(mesh, normals=np.full((mesh.n_vertices, 3), np.nan))
