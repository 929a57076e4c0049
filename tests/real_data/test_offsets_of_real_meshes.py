"""Exact Gauss images and node axes of real meshes: how exact their authors' offsets are, recovered from M alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geometry.errors import GeometryError, ParallelityError
from geometry.gauss.approximate_gauss_image import gauss_image
from geometry.gauss.axes import node_axes, parallel_from_axes
from geometry.gauss.distances import edge_distances, face_distances, vertex_distances
from geometry.gauss.exact_gauss_image import edge_gauss_image, exact_gauss_images, face_gauss_image, vertex_gauss_image
from geometry.mesh import Mesh
from geometry.meshing import planarise
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from tests.real_data.meshes import CATENOID, CONICAL, HEXAGONAL, SIX_ARMED, YAS, needs_data, read

pytestmark = needs_data


@cache
def planar(name: str) -> Mesh:
    return planarise(read(name)).mesh


def test_the_hexagonal_koebe_polyhedron_is_its_own_edge_gauss_image() -> None:
    mesh = planar(HEXAGONAL)
    images = exact_gauss_images(mesh)
    assert set(images) == {"edge", "face"}  # vertices of valence 3 are conical
    np.testing.assert_allclose(edge_distances(mesh, images["edge"]), 1, atol=1e-11)
    inner = mesh.combinatorics.vertex_degrees > 2
    # its file states it to 4e-11; two vertices of the boundary lie in the middle of straight edges, free to slide
    np.testing.assert_allclose(images["edge"].vertices[inner], mesh.vertices[inner], atol=1e-7)
    np.testing.assert_allclose(face_distances(mesh, images["face"]), 1, atol=1e-12)
    with pytest.raises(GeometryError, match="no vertex offset"):
        vertex_gauss_image(mesh)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_found_from_a_random_mesh_parallel_to_it(seed: int) -> None:
    image = planar(HEXAGONAL)
    points = np.random.default_rng(seed).normal(size=image.vertices.shape)
    mesh = planarise(ParallelSpace(image).project(image.with_vertices(points))).mesh
    assert 200 < (edge_factors(mesh, image) < 0).sum() < 400  # of 580 edges
    found = edge_gauss_image(mesh)
    np.testing.assert_allclose(edge_distances(mesh, found), 1, atol=1e-10)
    assert parallelity(mesh, found).max() <= 1e-11
    inner = image.combinatorics.vertex_degrees > 2
    sign = np.sign(np.sum(found.vertices * image.vertices))
    np.testing.assert_allclose(sign * found.vertices[inner], image.vertices[inner], atol=1e-6)


def test_heights_of_the_hexagonal_mesh_become_1_in_rounds() -> None:
    mesh = planar(HEXAGONAL)
    one = edge_distances(mesh, gauss_image(mesh, faces=0, edges=1, vertices=1e-6))
    assert 1e-3 < np.abs(one - 1).max() < 4e-3  # directions estimated from the faces
    ten = edge_distances(mesh, gauss_image(mesh, faces=0, edges=1, vertices=0, rounds=12))
    np.testing.assert_allclose(ten, 1, atol=1e-11)


def test_edges_of_the_catenoid_run_the_other_way_in_its_koebe_polyhedron() -> None:
    mesh = planar(CATENOID)
    image = edge_gauss_image(mesh, tolerance=1e-5)  # its file has six digits
    assert np.abs(edge_distances(mesh, image) - 1).max() < 4e-6
    assert parallelity(mesh, image).max() <= 1e-11
    assert (edge_factors(mesh, image) < 0).sum() == mesh.n_faces == 1650  # one direction of three
    with pytest.raises(GeometryError, match="no edge offset is found"):
        edge_gauss_image(mesh)
    # a minimal surface of a Koebe kind is conical, as valence 3 is, and its S is inscribed too
    np.testing.assert_allclose(face_distances(mesh, face_gauss_image(mesh)), 1, atol=1e-12)
    np.testing.assert_allclose(vertex_distances(vertex_gauss_image(mesh, tolerance=1e-6)), 1, atol=1e-6)


def test_faces_of_the_conical_mesh() -> None:
    mesh = planar(CONICAL)
    image = face_gauss_image(mesh, tolerance=2e-5)
    assert 1e-6 < np.abs(face_distances(mesh, image) - 1).max() < 1.2e-5
    with pytest.raises(GeometryError, match=r"no face offset.*least conical vertex is \d+, its faces .*e-06 radians"):
        face_gauss_image(mesh)
    assert set(exact_gauss_images(mesh, tolerance=2e-5)) == {"face"}


@pytest.mark.parametrize("name", [SIX_ARMED, YAS])
def test_other_meshes_have_none(name: str) -> None:
    assert exact_gauss_images(planar(name), tolerance=1e-3) == {}


@pytest.mark.parametrize("name", [CONICAL, SIX_ARMED, YAS, HEXAGONAL])
def test_node_axes_there_and_back(name: str) -> None:
    mesh = planar(name)
    image = gauss_image(mesh)
    axes = node_axes(mesh, mesh + image * mesh.mean_edge_length)
    start = mesh.n_vertices // 2
    distance = float(np.linalg.norm(image.vertices[start]))
    back = parallel_from_axes(mesh, axes, start=start, distance=distance) - mesh
    np.testing.assert_allclose(back.vertices, image.vertices, atol=1e-9)  # carried along up to 60 edges
    with pytest.raises(ParallelityError, match="are not coplanar"):
        parallel_from_axes(mesh, mesh.vertex_normals)
