"""Functionals of M and S together: Jacobians against differences, zeros and values on known pairs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.curvature import face_curvatures
from geometry.functionals import (
    CloseToNormals,
    ConstantCurvature,
    EdgesAtUnitDistance,
    EdgeStretch,
    FaceNormalCosines,
    FacesAtUnitDistance,
    InsideBalls,
    InsideCones,
    UprightFaces,
    UprightVertices,
    VerticesAtUnitDistance,
    close_to,
)
from geometry.gauss import approximate_pair
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.polygons import vector_areas
from geometry.optimise import Blocks, Functional, Hinge
from tests.geometry.bent_meshes import shaken, vault, with_midpoints

seeds = st.integers(0, 2**32 - 1)

MESHES = {
    "vault": vault(),
    "dome": shapes.dome(7, 3),
    "hexagons": shapes.hexagonal_paraboloid(4, 3),
    "mixed": with_midpoints(shapes.dome(7, 3), np.array([0, 5, 6])),
}


def both(of_one: Callable[[Mesh], Functional], block: str) -> Callable[[Mesh], Functional]:
    """As a functional of M and S."""
    return lambda mesh: Blocks({"M": mesh.vertices.shape, "S": mesh.vertices.shape}).of(of_one(mesh), block)


def normals(positions: FloatArray) -> FloatArray:
    """Of Phi, a sphere about (1, 2, -30): so large that differences over `NORMAL_TURN_STEP` are exact to 2e-6."""
    away = positions - [1.0, 2.0, -30.0]
    return away / np.linalg.norm(away, axis=1, keepdims=True)


FUNCTIONALS: dict[str, Callable[[Mesh], Functional]] = {
    "edge distances": lambda mesh: EdgesAtUnitDistance(mesh.combinatorics),
    "vertex distances": both(lambda mesh: VerticesAtUnitDistance(mesh.combinatorics), "S"),
    "face distances": lambda mesh: FacesAtUnitDistance(mesh.combinatorics),
    "face axes": lambda mesh: UprightFaces(mesh.combinatorics, 0.9),
    "vertex axes": lambda mesh: UprightVertices(mesh.combinatorics, np.arange(1, mesh.n_vertices), 1.1),
    "mean curvature": lambda mesh: ConstantCurvature(mesh.combinatorics, 0.7, np.linspace(1, 2, mesh.n_faces)),
    "gaussian curvature": lambda mesh: ConstantCurvature(
        mesh.combinatorics, -0.7, np.linspace(1, 2, mesh.n_faces), mixed=False
    ),
    "normals": lambda mesh: CloseToNormals(mesh.combinatorics, normals),
    "cones": lambda mesh: InsideCones(mesh.combinatorics, normals, 0.3),
    "balls": both(lambda mesh: InsideBalls(close_to(mesh.vertices), 3, 0.2), "M"),
    "stretch": both(lambda mesh: EdgeStretch(mesh.combinatorics, mesh.edge_lengths), "M"),
    "turns": lambda mesh: FaceNormalCosines(mesh.combinatorics, mesh.face_normals),
    "hinge": lambda mesh: Hinge(FaceNormalCosines(mesh.combinatorics, mesh.face_normals), 0.985),
    "two-sided hinge": lambda mesh: Hinge(FaceNormalCosines(mesh.combinatorics, mesh.face_normals), 0.9, 0.985),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("functional", FUNCTIONALS.values(), ids=FUNCTIONALS)
@given(seed=seeds)
@settings(max_examples=4)
def test_jacobians_are_derivatives_everywhere(mesh: Mesh, functional: Callable[[Mesh], Functional], seed: int) -> None:
    """Where M is not planar and S not parallel to it too."""
    asked = functional(mesh)
    bent, image = shaken(mesh, 0.1, seed), shaken(mesh * 0.3, 0.3, seed + 1)
    x = np.concatenate([bent.vertices, image.vertices]).ravel()
    direction = np.random.default_rng(seed).normal(size=x.shape)
    step = 1e-6
    differences = (asked.residual(x + step * direction) - asked.residual(x - step * direction)) / (2 * step)
    jacobian = asked.jacobian(x)
    assert jacobian.shape == (len(differences), len(x))
    np.testing.assert_allclose(jacobian @ direction, differences, rtol=1e-5, atol=1e-5 * np.abs(differences).max())


def test_distances_are_those_of_the_pair() -> None:
    pair = approximate_pair(vault())
    mesh, image = pair.mesh, pair.gauss_image
    x = np.concatenate([mesh.vertices, image.vertices]).ravel()
    c = mesh.combinatorics
    np.testing.assert_allclose(EdgesAtUnitDistance(c).residual(x), pair.edge_distances - 1, atol=1e-12)
    np.testing.assert_allclose(FacesAtUnitDistance(c).residual(x), pair.face_distances - 1, atol=1e-12)


def test_an_exact_pair_has_zeros() -> None:
    image = solids.cube()
    x = np.concatenate([image.vertices * 7 + [1, 2, 3], image.vertices]).ravel()
    c = image.combinatorics
    assert np.abs(FacesAtUnitDistance(c).residual(x)).max() < 1e-14
    assert np.abs(EdgesAtUnitDistance(c).residual(x) - (np.sqrt(2) - 1)).max() < 1e-14
    assert np.abs(VerticesAtUnitDistance(c).residual(image.vertices.ravel()) - (np.sqrt(3) - 1)).max() < 1e-14
    assert np.abs(UprightFaces(c).residual(x)).max() < 1e-14
    assert np.abs(UprightVertices(c, np.arange(8), np.sqrt(3)).residual(x)).max() < 1e-14


def test_axes_are_compared_with_the_mean_of_the_faces() -> None:
    mesh = vault()
    some = np.array([12, 5])
    x = np.concatenate([mesh.vertices, 0 * mesh.vertices]).ravel()
    c = mesh.combinatorics
    for vertex, found in zip(some, UprightVertices(c, some, 2.0).residual(x).reshape(-1, 3), strict=True):
        around = mesh.face_normals[[vertex in face for face in c.faces]].sum(axis=0)
        np.testing.assert_allclose(found, -2 * around / np.linalg.norm(around), atol=1e-12)


@pytest.mark.parametrize("radius", [0.5, 3.0])
def test_spheres_have_the_curvatures_of_spheres(radius: float) -> None:
    image = shapes.dome(9, 4)
    mesh = (radius * image).translated([5.0, -2.0, 1.0])
    x = np.concatenate([mesh.vertices, image.vertices]).ravel()
    sizes = np.ones(mesh.n_faces)
    mean = ConstantCurvature(mesh.combinatorics, -1 / radius, sizes).residual(x)
    gaussian = ConstantCurvature(mesh.combinatorics, -1 / radius**2, sizes, mixed=False).residual(x)
    assert max(np.abs(mean).max(), np.abs(gaussian).max()) < 1e-13


def test_curvature_residuals_are_those_of_faces() -> None:
    pair = approximate_pair(vault())
    mesh, image = pair.mesh, pair.gauss_image
    x = np.concatenate([mesh.vertices, image.vertices]).ravel()
    areas = np.linalg.norm(vector_areas(mesh.vertices, mesh.combinatorics), axis=1)
    known = face_curvatures(pair)
    found = ConstantCurvature(mesh.combinatorics, 0.3, areas).residual(x)
    np.testing.assert_allclose(found, 0.3 - known.mean, atol=1e-12)
    found = ConstantCurvature(mesh.combinatorics, -0.3, areas, mixed=False).residual(x)
    np.testing.assert_allclose(found, known.gaussian - 0.3, atol=1e-12)


def test_a_vector_is_inside_a_cone_up_to_its_angle() -> None:
    c = solids.cube().combinatorics
    up = np.tile([0.0, 0.0, 1.0], (8, 1))
    leans = np.radians([0, 5, 14, 15, 16, 30, 90, 170])
    image = 2 * np.stack([np.sin(leans), 0 * leans, np.cos(leans)], axis=1)
    cones = InsideCones(c, lambda _: up, np.radians(15.0))
    found = cones.residual(np.concatenate([np.zeros(24), image.ravel()]))
    np.testing.assert_allclose(found, 2 * np.sin(np.radians(15.0) - leans), atol=1e-12)


def test_a_hinge_is_silent_above_its_bound() -> None:
    mesh = vault()
    x = np.concatenate([mesh.vertices, mesh.vertices]).ravel()
    turns = FaceNormalCosines(mesh.combinatorics, mesh.face_normals)
    assert not Hinge(turns, 0.9).residual(x).any()
    assert not Hinge(turns, 0.9).jacobian(x).toarray().any()
    np.testing.assert_allclose(Hinge(turns, 1.5).residual(x), -0.5)
    np.testing.assert_allclose(Hinge(turns, 0.0, 0.75).residual(x), 0.25)
