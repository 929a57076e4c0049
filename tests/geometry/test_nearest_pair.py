"""M and S together: parallel but for the last digits becomes parallel and planar."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError
from geometry.functionals.planar_faces import relative_plane_deviations
from geometry.gauss import approximate_pair, edge_distances, nearest_parallel_pair
from geometry.mesh import Mesh, shapes, solids
from geometry.parallel import ParallelSpace, parallelity


def pair(mesh: Mesh, seed: int) -> tuple[Mesh, Mesh]:
    """A random mesh parallel to a Koebe polyhedron, and that."""
    image = mesh * (1 / edge_distances(mesh).mean())
    space = ParallelSpace(image)
    elements = space.elements(min(3, space.dimension - 3), seed=seed)
    return sum((element * (0.2 * (-1) ** k) for k, element in enumerate(elements)), start=image), image


def rounded(mesh: Mesh, digits: int) -> Mesh:
    return mesh.with_vertices(np.round(mesh.vertices, digits))


# Of the second and third, P(M) has 11 and 5 dimensions more than counting says: meshes near them have fewer.
@pytest.mark.parametrize(
    "solid", [solids.truncated_icosahedron(), solids.rhombicosidodecahedron(), solids.rhombicuboctahedron()]
)
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(4, 8))
def test_lost_digits_come_back_within_what_was_lost(solid: Mesh, seed: int, digits: int) -> None:
    exact_mesh, exact_image = pair(solid, seed)
    given_mesh, given_image = rounded(exact_mesh, digits), rounded(exact_image, digits)
    found = nearest_parallel_pair(given_mesh, given_image)
    mesh, image = found.mesh, found.gauss_image
    assert parallelity(mesh, image).max() <= 1e-12
    assert relative_plane_deviations(mesh).max() <= 1e-12
    assert relative_plane_deviations(image).max() <= 1e-12
    # the exact pair is one to be found, and about 9 coordinates a face lost half a unit of the last digit each
    assert np.abs(image.vertices - given_image.vertices).max() < 20 * 10.0**-digits
    assert np.abs(mesh.vertices - given_mesh.vertices).max() < 20 * 10.0**-digits


def test_place_and_size_do_not_matter() -> None:
    mesh, image = (rounded(m, 5) for m in pair(solids.rhombicosidodecahedron(), 1))
    here, there = (
        nearest_parallel_pair(mesh, image),
        nearest_parallel_pair((mesh * 700.0).translated([4e3, 0, 1]), image),
    )
    assert np.abs(here.gauss_image.vertices - there.gauss_image.vertices).max() < 1e-9
    assert np.abs((there.mesh.vertices - [4e3, 0, 1]) / 700 - here.mesh.vertices).max() < 1e-9


def test_an_exact_pair_stays_as_it_is() -> None:
    mesh = shapes.dome(12, 4)
    image = approximate_pair(mesh).gauss_image
    found = nearest_parallel_pair(mesh, image)
    assert found.mesh is mesh
    assert found.gauss_image is image


def test_what_is_not_nearly_parallel_is_refused() -> None:
    mesh = solids.snub_cube()
    image = mesh.with_vertices(np.random.default_rng(2).standard_normal(mesh.vertices.shape))
    with pytest.raises(GeometryError, match=r"edge \d+ from vertex \d+ to vertex \d+ stays .* off the direction"):
        nearest_parallel_pair(mesh, image)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-90, 1e90])
@pytest.mark.parametrize("mesh", [shapes.dome(5, 2), shapes.grid(3, 2)], ids=["dome", "grid"])
def test_an_image_of_no_size_that_can_be_reckoned_with_is_refused(mesh: Mesh, size: float) -> None:
    twist = 0.1 * np.sin(np.arange(3.0 * mesh.n_vertices)).reshape(-1, 3)
    mesh, image = mesh.with_vertices(mesh.vertices + twist), mesh.with_vertices((mesh.vertices + 1.0) * size)
    with pytest.raises(GeometryError, match=r"from the origin on average; this must be between 1e-60 and 1e\+60"):
        nearest_parallel_pair(mesh, image)


def test_an_image_whose_large_faces_are_lines_is_no_trouble() -> None:
    mesh = shapes.regular_prism(30)
    image = mesh.with_vertices(mesh.vertices * [0.0, 0.0, 1.0] + [0.0, 0.0, 0.5])
    twisted = mesh.with_vertices(mesh.vertices + 1e-9 * np.sin(np.arange(3.0 * mesh.n_vertices)).reshape(-1, 3))
    with np.errstate(all="raise", under="ignore"):
        found = nearest_parallel_pair(twisted, image)
    assert parallelity(found.mesh, found.gauss_image).max() <= 1e-12
    assert relative_plane_deviations(found.mesh).max() <= 1e-12
