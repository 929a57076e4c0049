"""P(M) of real meshes: dimensions that are known, bases and their time, projections, minima."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geometry.files import read_mesh
from geometry.functionals.fairness import laplacian
from geometry.functionals.gauss_image_terms import close_to_vertex_normals, faces_at_unit_distance
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.mesh import Mesh
from geometry.meshing import planarise
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from tests.real_data.meshes import DATA, needs_data, read

pytestmark = needs_data

DIMENSIONS = {
    # E - 2F + 3 chi, but for the hexagonal Koebe polyhedron, where it is 220
    "libhedra/hexagonalminimal_plusgauss.off": 222,
    "dos/planarizednormalized_six_quad.obj": 64,
    "libhedra/YasIsland.off": 107,
    "dos/conical1.obj": 69,
    "libhedra/gitter.off": 119,
    "dos/botanic-garden-bubble-0.obj": 47,
    "libhedra/catenoid3.off": 1750,
}


@cache
def planar(name: str) -> Mesh:
    """Planarised, about the origin, with edges of mean length 1."""
    mesh = planarise(read(name)).mesh
    return mesh.with_vertices((mesh.vertices - mesh.vertices.mean(axis=0)) / mesh.mean_edge_length)


@pytest.mark.parametrize("name", DIMENSIONS)
def test_dimensions(name: str) -> None:
    found = ParallelSpace(planar(name)).spectrum
    assert found.dimension == DIMENSIONS[name]
    # the hexagonal one owes two of its dimensions to being a Koebe polyhedron, which its file states to 4e-11
    assert found.last_zero < (1e-10 if "hexagonal" in name else 1e-12)
    assert found.first_nonzero > 1e5 * found.last_zero


def test_a_gap_is_found_in_a_file_as_it_is_where_there_is_one() -> None:
    hexagonal = ParallelSpace(read_mesh(DATA / "libhedra/hexagonalminimal_plusgauss.off").mesh)
    assert hexagonal.dimension == 222
    assert hexagonal.expected_dimension == 220
    conical = ParallelSpace(read_mesh(DATA / "dos/conical1.obj").mesh)  # planar to 3e-5
    assert conical.dimension == 69
    assert 3e-5 < conical.spectrum.last_zero < conical.spectrum.first_nonzero / 100


@pytest.mark.parametrize("name", [name for name in DIMENSIONS if "catenoid" not in name])
def test_bases(name: str) -> None:
    mesh = planar(name)
    basis = ParallelSpace(mesh).basis
    rows = basis.reshape(len(basis), -1)
    assert len(rows) == DIMENSIONS[name]
    np.testing.assert_allclose(rows @ rows.T, np.eye(len(rows)), atol=1e-11)
    worst = max(parallelity(mesh, mesh.with_vertices(element)).max() for element in basis)
    assert worst < (1e-11 if "hexagonal" in name else 1e-12)


@pytest.mark.parametrize("name", ["dos/conical1.obj", "libhedra/YasIsland.off", "libhedra/gitter.off"])
def test_projection_and_minima_agree_with_the_basis(name: str) -> None:
    mesh = planar(name)
    parallel = ParallelSpace(mesh)
    rows = parallel.basis.reshape(parallel.dimension, -1)
    rng = np.random.default_rng(0)
    wanted = mesh.with_vertices(mesh.vertices + rng.normal(size=mesh.vertices.shape))
    found = parallel.project(wanted)
    # rounding over the least singular values, 2e-5 for the last
    np.testing.assert_allclose(found.vertices.ravel(), rows.T @ (rows @ wanted.vertices.ravel()), atol=1e-8)
    assert parallelity(mesh, found).max() <= 1e-12 * np.abs(wanted.vertices).max()
    terms = [(1.0, faces_at_unit_distance(mesh)), (0.1, close_to_vertex_normals(mesh))]
    np.testing.assert_allclose(
        parallel.minimise(terms).vertices, approximate_pair(mesh).gauss_image.vertices, atol=1e-7
    )


@pytest.mark.parametrize("name", ["dos/planarizednormalized_six_quad.obj", "libhedra/gitter.off"])
def test_fair_members_of_one_sign(name: str) -> None:
    """The fairest mesh parallel to M with edges between half and twice as long, two vertices of it pulled apart."""
    mesh = planar(name)
    far = int(np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1).argmax())
    apart = mesh.vertices[far] - mesh.vertices[0]
    found = ParallelSpace(mesh).minimise(
        [(1.0, laplacian(mesh.combinatorics))],
        linear=None,
        fixed={0: mesh.vertices[0], far: mesh.vertices[far] + 0.01 * apart},
        factor_bounds=(0.5, 2.0),
    )
    factors = edge_factors(mesh, found)
    assert 0.5 - 1e-6 < factors.min() < factors.max() < 2 + 1e-6
    assert parallelity(mesh, found).max() <= 1e-12 * np.abs(found.vertices).max()
