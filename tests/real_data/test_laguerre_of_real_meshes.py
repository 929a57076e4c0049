"""Laguerre transformations of real meshes with edge offsets and face offsets."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geometry.errors import GeometryError, ParallelityError
from geometry.exact_offsets import conicality, face_offset_pair
from geometry.gauss import Pair
from geometry.gauss.distances import edge_distances
from geometry.mesh import Mesh
from geometry.meshing import planarise
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from geometry.spheres.laguerre import LaguerreTransformation
from tests.geometry.test_laguerre_of_meshes import moderate
from tests.geometry.test_lorentz import direction
from tests.real_data.meshes import CONICAL, HEXAGONAL, needs_data, read

L = LaguerreTransformation
pytestmark = needs_data


@cache
def planar(name: str) -> Mesh:
    return planarise(read(name)).mesh


@pytest.mark.parametrize("seed", range(4))
def test_meshes_parallel_to_the_hexagonal_koebe_polyhedron(seed: int) -> None:
    image = planar(HEXAGONAL)
    m = ParallelSpace(image).elements(1, seed=seed)[0] * 10
    f = moderate(image, seed, 0.5)
    np.testing.assert_allclose(edge_distances(image), 1, atol=1e-9)
    moved, there = (m.with_vertices(points) for points in f.map_lines(m.vertices, image.vertices))
    if seed == 1:  # an edge of M' nearly vanishes, so that its direction has lost its digits
        with pytest.raises(ParallelityError, match="edge 5 from vertex 10 to vertex 0"):
            Pair(m, image).laguerre(f)
    else:
        found = Pair(m, image).laguerre(f)
        np.testing.assert_array_equal(found.mesh.vertices, moved.vertices)
        np.testing.assert_array_equal(found.gauss_image.vertices, there.vertices)
    np.testing.assert_allclose(edge_distances(there), 1, atol=1e-9)
    assert parallelity(there, moved).max() <= 1e-10
    assert (edge_factors(there, moved) < 0).sum() > 100
    for vertices in there.combinatorics.edges.T:
        sines = np.linalg.norm(np.cross(there.edge_directions, there.vertices[vertices]), axis=1)
        np.testing.assert_allclose(sines, 1, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_a_real_conical_mesh(seed: int) -> None:
    mesh = planar(CONICAL)
    mesh = mesh.translated(-mesh.vertices.mean(axis=0))
    pair = face_offset_pair(mesh, tolerance=1.0)
    off = float(np.abs(pair.face_distances - 1).max())
    f = moderate(pair.gauss_image, seed, 0.3)
    with pytest.raises(GeometryError, match="no exact kind"):
        pair.laguerre(f)
    moved = pair.laguerre(f, tolerance=2 * off)
    assert parallelity(moved.mesh, moved.gauss_image).max() <= 1e-10
    assert np.abs(np.abs(moved.face_distances) - 1).max() <= 5 * off

    boost = L.boost(0.1 * direction(np.random.default_rng(seed)))
    small = pair.laguerre(boost, tolerance=2 * off).mesh
    assert np.nanmax(conicality(small)) <= 2 * np.nanmax(conicality(mesh))  # no face is reversed yet
