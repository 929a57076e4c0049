"""Exact Gauss images and node axes of real meshes: how exact their authors' offsets are, recovered from M alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geometry.errors import GeometryError, ParallelityError
from geometry.exact_offsets import edge_offset_pair, exact_pairs, face_offset_pair, vertex_offset_pair
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.gauss.axes import node_axes, parallel_from_axes
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
    pairs = exact_pairs(mesh)
    assert set(pairs) == {"edge", "face"}  # vertices of valence 3 are conical
    np.testing.assert_allclose(pairs["edge"].edge_distances, 1, atol=1e-11)
    inner = mesh.combinatorics.vertex_degrees > 2
    # its file states it to 4e-11; two vertices of the boundary lie in the middle of straight edges, free to slide
    np.testing.assert_allclose(pairs["edge"].gauss_image.vertices[inner], mesh.vertices[inner], atol=1e-7)
    np.testing.assert_allclose(pairs["face"].face_distances, 1, atol=1e-12)
    with pytest.raises(GeometryError, match="no vertex offset"):
        vertex_offset_pair(mesh)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_found_from_a_random_mesh_parallel_to_it(seed: int) -> None:
    image = planar(HEXAGONAL)
    points = np.random.default_rng(seed).normal(size=image.vertices.shape)
    mesh = planarise(ParallelSpace(image).project(image.with_vertices(points))).mesh
    assert 200 < (edge_factors(mesh, image) < 0).sum() < 400  # of 580 edges
    pair = edge_offset_pair(mesh)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-10)
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-11
    inner = image.combinatorics.vertex_degrees > 2
    sign = np.sign(np.sum(pair.gauss_image.vertices * image.vertices))
    np.testing.assert_allclose(sign * pair.gauss_image.vertices[inner], image.vertices[inner], atol=1e-6)


def test_heights_of_the_hexagonal_mesh_become_1_in_rounds() -> None:
    mesh = planar(HEXAGONAL)
    one = approximate_pair(mesh, faces=0, edges=1, vertices=1e-6).edge_distances
    assert 1e-3 < np.abs(one - 1).max() < 4e-3  # directions estimated from the faces
    ten = approximate_pair(mesh, faces=0, edges=1, vertices=0, rounds=12).edge_distances
    np.testing.assert_allclose(ten, 1, atol=1e-11)


def test_edges_of_the_catenoid_run_the_other_way_in_its_koebe_polyhedron() -> None:
    mesh = planar(CATENOID)
    pair = edge_offset_pair(mesh, tolerance=1e-5)  # its file has six digits
    assert np.abs(pair.edge_distances - 1).max() < 4e-6
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-11
    assert (edge_factors(mesh, pair.gauss_image) < 0).sum() == mesh.n_faces == 1650  # one direction of three
    with pytest.raises(GeometryError, match="no edge offset is found"):
        edge_offset_pair(mesh)
    # a minimal surface of a Koebe kind is conical, as valence 3 is, and its S is inscribed too
    np.testing.assert_allclose(face_offset_pair(mesh).face_distances, 1, atol=1e-12)
    np.testing.assert_allclose(vertex_offset_pair(mesh, tolerance=1e-6).vertex_distances, 1, atol=1e-6)


def test_faces_of_the_conical_mesh() -> None:
    mesh = planar(CONICAL)
    pair = face_offset_pair(mesh, tolerance=2e-5)
    assert 1e-6 < np.abs(pair.face_distances - 1).max() < 1.2e-5
    with pytest.raises(GeometryError, match=r"no face offset.*least conical vertex is \d+, its faces .*e-06 radians"):
        face_offset_pair(mesh)
    assert set(exact_pairs(mesh, tolerance=2e-5)) == {"face"}


@pytest.mark.parametrize("name", [SIX_ARMED, YAS])
def test_other_meshes_have_none(name: str) -> None:
    assert exact_pairs(planar(name), tolerance=1e-3) == {}


@pytest.mark.parametrize("name", [CONICAL, SIX_ARMED, YAS, HEXAGONAL])
def test_node_axes_there_and_back(name: str) -> None:
    mesh = planar(name)
    image = approximate_pair(mesh).gauss_image
    axes = node_axes(mesh, mesh + image * mesh.mean_edge_length)
    start = mesh.n_vertices // 2
    distance = float(np.linalg.norm(image.vertices[start]))
    back = parallel_from_axes(mesh, axes, start=start, distance=distance) - mesh
    np.testing.assert_allclose(back.vertices, image.vertices, atol=1e-9)  # carried along up to 60 edges
    with pytest.raises(ParallelityError, match="are not coplanar"):
        parallel_from_axes(mesh, mesh.vertex_normals)
