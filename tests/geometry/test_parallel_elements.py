"""ElementSampler of P(M): basis, random elements, projection, blending; and what is refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError, ParallelityError
from geometry.mesh import Mesh, shapes
from geometry.optimise.solution import ConvergenceError
from geometry.parallel import space
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from tests.geometry.topologies import ANNULUS, MESHES, by_equation_2, meshes, projected

seeds = st.integers(0, 2**32 - 1)
numbers = st.floats(-3, 3)


@pytest.mark.parametrize("name", MESHES)
def test_the_basis_spans_the_null_space_of_equation_2(name: str) -> None:
    mesh, expected = projected(MESHES[name], 1), by_equation_2(projected(MESHES[name], 1))
    basis = ParallelSpace(mesh).basis
    assert basis.shape == (expected.shape[1], mesh.n_vertices, 3)
    rows = basis.reshape(len(basis), -1)
    np.testing.assert_allclose(rows @ rows.T, np.eye(len(rows)), atol=1e-13)
    np.testing.assert_allclose(expected @ (expected.T @ rows.T), rows.T, atol=1e-10)  # rounding over the least 1e-4
    for element in basis:
        assert parallelity(mesh, mesh.with_vertices(element)).max() <= 1e-13  # rounding
    # translations come first: the same for all vertices of a part
    assert ParallelSpace(mesh).contains(mesh.with_vertices(basis[0]))
    np.testing.assert_allclose(basis[0][mesh.combinatorics.corners[:3], 1:], 0, atol=1e-15)


def test_elements_are_orthonormal_members_and_others_for_another_seed() -> None:
    mesh = projected(shapes.hexagonal_paraboloid(4, 4), 3)
    parallel = ParallelSpace(mesh)
    elements = parallel.elements(5, seed=1)
    rows = np.stack([element.vertices.ravel() for element in elements])
    np.testing.assert_allclose(rows @ rows.T, np.eye(5), atol=1e-13)
    for element in elements:
        assert parallelity(mesh, element).max() <= 1e-13
        np.testing.assert_allclose(element.vertices.mean(axis=0), 0, atol=1e-15)
    again, other = parallel.elements(1, seed=1)[0], parallel.elements(1, seed=2)[0]
    np.testing.assert_array_equal(again.vertices, ParallelSpace(mesh).elements(1, seed=1)[0].vertices)
    assert abs(np.vdot(again.vertices, other.vertices)) < 0.99


def test_larger_meshes_lose_no_digits() -> None:
    profile = np.stack([np.linspace(1, 0.6, 41), np.linspace(0, 1.2, 41)], axis=1)
    mesh = projected(shapes.rotational_mesh(profile, 41, closed=False), 1)
    basis = ParallelSpace(mesh).basis
    assert len(basis) == 83
    # 1e-12 where the orthonormal combinations of random elements are not made to close again
    assert max(parallelity(mesh, mesh.with_vertices(element)).max() for element in basis) <= 1e-14
    assert parallelity(mesh, ParallelSpace(mesh).elements(1)[0]).max() <= 3e-16


def test_more_elements_than_dimensions_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"7 independent elements .* P\(M\) has 6 dimensions"):
        ParallelSpace(shapes.grid(3, 3)).elements(7)
    with pytest.raises(GeometryError, match="must be 1 or more"):
        ParallelSpace(shapes.grid(3, 3)).elements(0)


def test_a_basis_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space, "MAX_BASIS_NUMBERS", 1000)
    with pytest.raises(GeometryError, match="take some `elements`"):
        _ = ParallelSpace(shapes.grid(8, 8)).basis


@given(meshes, seeds, st.floats(-4, 4), st.sampled_from([0.0, 1e6]))
@settings(max_examples=25)
def test_projection_is_orthogonal_to_the_null_space_of_equation_2(
    mesh: Mesh, seed: int, exponent: float, far: float
) -> None:
    mesh = projected(mesh, seed)
    rng = np.random.default_rng(seed)
    size = 10.0**exponent
    given_mesh = mesh.with_vertices(size * (rng.normal(size=mesh.vertices.shape) + far))
    found = ParallelSpace(mesh).project(given_mesh)
    basis = by_equation_2(mesh)
    expected = basis @ (basis.T @ given_mesh.vertices.ravel())
    used = mesh.combinatorics.is_used
    # rounding over the least singular values, 1e-4, and that of coordinates far away
    np.testing.assert_allclose(
        found.vertices[used].ravel(), expected.reshape(-1, 3)[used].ravel(), atol=size * (1e-9 + 1e-15 * far)
    )
    np.testing.assert_allclose(found.vertices[~used], given_mesh.vertices[~used], atol=1e-12 * size * max(1, far))
    near = found.with_vertices(found.vertices - given_mesh.vertices.mean(axis=0))
    assert parallelity(mesh, near).max() <= size * (1e-11 + 1e-15 * far)  # largest numbers are some 5


def test_what_is_not_reached_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space, "ELEMENT_TOLERANCE", 1e-20)
    stranger = ANNULUS.with_vertices(np.random.default_rng(0).normal(size=ANNULUS.vertices.shape))
    with pytest.raises(ConvergenceError, match=r"edge \d+ from vertex \d+ to vertex \d+ is off .* allowed") as caught:
        ParallelSpace(ANNULUS).project(stranger)
    assert caught.value.solution.violation <= 1e-12


def test_members_are_projected_onto_themselves() -> None:
    element = ParallelSpace(ANNULUS).elements(1)[0]
    np.testing.assert_allclose(ParallelSpace(ANNULUS).project(element).vertices, element.vertices, atol=1e-13)


@given(meshes, seeds, st.lists(numbers, min_size=1, max_size=4))
@settings(max_examples=25)
def test_blending_is_linear_in_edge_factors(mesh: Mesh, seed: int, weights: list[float]) -> None:
    mesh = projected(mesh, seed)
    parallel = ParallelSpace(mesh)
    elements = [mesh, *(parallel.elements(1, seed=k)[0] for k in range(len(weights) - 1))]
    blend = parallel.blend(weights, elements)
    assert parallel.contains(blend)
    factors = sum(w * edge_factors(mesh, element) for w, element in zip(weights, elements, strict=True))
    scale = (mesh.edge_lengths.max() / mesh.edge_lengths.min()) * 10
    np.testing.assert_allclose(edge_factors(mesh, blend), factors, atol=1e-13 * scale)


# --- what is refused


def test_a_mesh_that_is_no_member_is_named_with_its_edge() -> None:
    cube, moved = shapes.cube(), shapes.cube().vertices.copy()
    moved[3] += [1e-6, 0, 0]
    stranger = cube.with_vertices(moved)
    assert not ParallelSpace(cube).contains(stranger)
    with pytest.raises(ParallelityError, match=r"edge \d+ from vertex \d+ to vertex \d+ of mesh 1 is off") as caught:
        ParallelSpace(cube).blend([1.0, 2.0], [cube, stranger])
    assert caught.value.value == pytest.approx(1e-6)
    assert 3 in cube.combinatorics.edges[caught.value.elements[0]]


@pytest.mark.parametrize(("weights", "count"), [([1.0], 2), ([], 0)])
def test_weights_and_members_must_match(weights: list[float], count: int) -> None:
    with pytest.raises(GeometryError, match="give one for each mesh"):
        ParallelSpace(shapes.cube()).blend(weights, [shapes.cube()] * count)


def test_weights_must_be_numbers() -> None:
    with pytest.raises(GeometryError, match="the weight of mesh 0 is nan"):
        ParallelSpace(shapes.cube()).blend([np.nan], [shapes.cube()])


@pytest.mark.parametrize(
    "ask",
    [
        lambda bent: bent.basis,
        lambda bent: bent.elements(1),
        lambda bent: bent.project(bent.mesh),
        lambda bent: bent.minimise(linear=np.zeros((16, 3))),
    ],
)
def test_bent_faces_are_refused_by_name(ask: Callable[[ParallelSpace], object]) -> None:
    vertices = shapes.grid(3, 3).vertices.copy()
    vertices[0, 2] = 1e-9
    with pytest.raises(GeometryError, match=r"face 0 is off its plane by 2.5e-10 .* allowed 1e-12; planarise"):
        ask(ParallelSpace(shapes.grid(3, 3).with_vertices(vertices)))


def test_meshes_of_other_combinatorics_and_edges_without_length_are_refused() -> None:
    with pytest.raises(MeshError, match="do not have the same faces"):
        parallelity(shapes.cube(), shapes.octahedron())
    for ask in (ParallelSpace(shapes.cube()).project, ParallelSpace(shapes.cube()).contains):
        with pytest.raises(MeshError, match="do not have the same faces"):
            ask(shapes.octahedron())
    grid = shapes.grid(1, 1)
    with pytest.raises(MeshError, match="has no length, so nothing is parallel to it"):
        edge_factors(grid * 0.0, grid)
    collapsed = shapes.grid(2, 2).vertices.copy()
    collapsed[1] = collapsed[0]
    with pytest.raises(MeshError, match=r"edge \d+ from vertex \d to vertex \d has no length"):
        _ = ParallelSpace(shapes.grid(2, 2).with_vertices(collapsed)).dimension
