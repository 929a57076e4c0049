"""Curvature of triangulated surfaces against formulas; curved triangles; surfaces as triangle meshes."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.errors import GeometryError, MeshError
from geometry.mesh import Mesh
from geometry.surface import Curvature, Surface, refined, smoothed
from tests.geometry.design_surfaces import ball, chart, cylinder, disc, monkey_saddle, torus, triangle_mesh


def test_a_sphere_bends_away_from_its_outer_normal() -> None:
    curvature = Curvature.of(ball(4, (2.0, 2.0, 2.0)).mesh)
    assert np.abs(curvature.principal_curvatures + 0.5).max() < 0.01
    along = np.einsum("ni,nij,nj->n", curvature.normals, curvature.tensors, curvature.normals)
    assert np.abs(along).max() < 1e-4


def test_curvature_of_a_torus_tends_to_the_formula() -> None:
    errors = []
    for n in (60, 120):
        mesh = torus(n, n * 2 // 5).mesh
        radius = np.hypot(*mesh.vertices[:, :2].T)
        exact = np.sort(np.stack([-(radius - 3) / radius, -np.ones(len(radius))], axis=1), axis=1)
        errors.append(np.abs(np.sort(Curvature.of(mesh).principal_curvatures, axis=1) - exact).max())
    print(f"errors {errors}")
    assert errors[1] < 0.05
    assert errors[0] / errors[1] > 3


def test_directions_of_a_cylinder() -> None:
    curvature = Curvature.of(cylinder().mesh)
    inside = np.abs(curvature.mesh.vertices[:, 2] - 1.25) < 0.9
    assert np.abs(np.abs(curvature.principal_directions[inside, 1, 2]) - 1).max() < 1e-6
    assert np.abs(curvature.principal_directions[inside, 0, 2]).max() < 1e-3


def test_asymptotic_directions_have_no_normal_curvature() -> None:
    surface = chart(30, 30, lambda u, v: (2 * u - 1, 2 * v - 1, (2 * u - 1) * (2 * v - 1)))
    curvature = Curvature.of(surface.mesh)
    lines = curvature.asymptotic_directions
    assert np.abs(np.einsum("nai,nij,naj->na", lines, curvature.tensors, lines)).max() < 1e-9
    middle = np.linalg.norm(surface.mesh.vertices, axis=1).argmin()
    assert np.abs(np.sort(np.abs(lines[middle]), axis=1)[:, :2]).max() < 1e-3
    assert np.isnan(Curvature.of(ball(2, (1.0, 1.0, 1.0)).mesh).asymptotic_directions).all()


def test_umbilics_of_an_ellipsoid_and_a_monkey_saddle() -> None:
    surface = ball(4, (3.0, 2.0, 1.2))
    umbilics = Curvature.of(surface.mesh).umbilics
    assert umbilics.indices.tolist() == [0.5] * 4
    centres = surface.mesh.vertices[surface.mesh.combinatorics.corners.reshape(-1, 3)[umbilics.triangles]].mean(axis=1)
    a, b, c = 3.0, 2.0, 1.2
    x, z = a * np.sqrt((a**2 - b**2) / (a**2 - c**2)), c * np.sqrt((b**2 - c**2) / (a**2 - c**2))
    assert np.abs(np.abs(centres) - [x, 0, z]).max() < 0.05
    assert Curvature.of(monkey_saddle(16).mesh).umbilics.indices.tolist() == [-0.5]


def test_too_few_triangles_have_no_curvature() -> None:
    with pytest.raises(MeshError, match="vertex 0 of the surface has 2 others within 3 edges, its curvature needs 5"):
        Curvature.of(triangle_mesh(np.eye(3), np.array([[0, 1, 2]])))
    mesh = ball(1, (1.0, 1.0, 1.0)).mesh  # as STL files hold it: each triangle with vertices of its own
    apart = triangle_mesh(mesh.vertices[mesh.combinatorics.corners], np.arange(3 * mesh.n_faces).reshape(-1, 3))
    with pytest.raises(MeshError, match=r"make them one by geometry\.files\.mend"):
        Curvature.of(apart)


@pytest.mark.parametrize("pieces", [2, 3, 4])
def test_curved_triangles_are_nearer_to_a_sphere(pieces: int) -> None:
    surface = ball(2, (1.0, 1.0, 1.0))
    finer = refined(surface, pieces)
    c = finer.mesh.combinatorics
    assert c.n_faces == pieces**2 * surface.mesh.n_faces
    assert c.euler_characteristic == 2
    flat = 1 - np.linalg.norm(surface.mesh.vertices[surface.mesh.combinatorics.edges].mean(axis=1), axis=1).min()
    assert np.abs(np.linalg.norm(finer.mesh.vertices, axis=1) - 1).max() < 0.15 * flat


def test_refining_a_disc_keeps_its_boundary() -> None:
    surface = disc(4, lambda x, y: 0 * x)
    finer = refined(surface)
    assert finer.mesh.combinatorics.is_boundary_edge.sum() == 3 * surface.mesh.combinatorics.is_boundary_edge.sum()
    assert np.abs(finer.mesh.vertex_normals - [0, 0, 1]).max() < 1e-12


def test_fans_that_meet_in_a_vertex_are_apart_as_triangles() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [9, 9, 9]]
    mesh = Mesh.from_faces(points, [[0, 1, 2], [0, 3, 4]])
    triangulated = Surface(mesh).triangulated
    assert triangulated.n_vertices == 6
    assert np.array_equal(triangulated.vertices[triangulated.combinatorics.corners], mesh.vertices[[0, 1, 2, 0, 3, 4]])


def test_polygons_become_triangles_about_their_centroids() -> None:
    triangulated = Surface(Mesh.from_faces([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2, 3]])).triangulated
    assert triangulated.n_faces == 4
    assert triangulated.combinatorics.is_boundary_vertex.tolist() == [True] * 4 + [False]


def test_smoothing_takes_noise_out_and_tells_the_moves() -> None:
    clean = chart(30, 30, lambda u, v: (2 * u - 1, 2 * v - 1, 0.3 * (2 * u - 1) ** 2)).mesh
    noise = 0.1 * clean.mean_edge_length * np.random.default_rng(1).normal(size=clean.vertices.shape)
    noisy = clean.vertices + noise
    corners = np.flatnonzero((np.abs(clean.vertices[:, :2]) == 1).all(axis=1))
    result = smoothed(Surface(clean.with_vertices(noisy)), 8 * clean.mean_edge_length)
    found = result.surface.mesh.vertices
    assert np.array_equal(result.moves, np.linalg.norm(found - noisy, axis=1))
    middle = np.abs(clean.vertices[:, :2]).max(axis=1) < 0.7
    assert np.abs((found - clean.vertices)[middle, 2]).mean() < 0.4 * np.abs(noise[middle, 2]).mean()
    assert np.abs(found - noisy)[corners].max() < 1e-3 * clean.mean_edge_length
    errors = [
        np.abs(Curvature.of(mesh).tensors - Curvature.of(clean).tensors).mean()
        for mesh in (clean.with_vertices(noisy), result.surface.mesh)
    ]
    assert errors[1] < 0.5 * errors[0]


def test_smoothing_damps_short_waves_only() -> None:
    for periods, kept in ((2, 0.9), (12, 0.15)):
        surface = chart(60, 8, lambda u, v, k=periods: (10 * u, v, 0.01 * np.sin(2 * np.pi * k * u)))
        vertices = smoothed(surface, 10 / 5).surface.mesh.vertices
        left = np.abs(vertices[np.abs(vertices[:, 0] - 5) < 2.5, 2]).max() / 0.01
        print(periods, left)
        assert (left > kept) if periods == 2 else (left < kept)


def test_a_wavelength_is_positive() -> None:
    with pytest.raises(GeometryError, match="the wavelength is 0: a length above 0 is needed"):
        smoothed(cylinder(), 0)
