"""The dimension of P(M) and parallelity, against the paper's own way, a dense decomposition of (2), and theory."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError, RankError
from geometry.mesh import Mesh, shapes, solids
from geometry.parallel import spectrum
from geometry.parallel.edge_closure import EdgeClosure
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from tests.geometry.topologies import ANNULUS, MESHES, by_equation_2, meshes, projected, together

seeds = st.integers(0, 2**32 - 1)
numbers = st.floats(-3, 3)


# --- parallelity and edge factors


@given(numbers, numbers, numbers, st.tuples(numbers, numbers, numbers))
def test_boxes_are_parallel_and_factors_are_ratios_of_lengths(
    x: float, y: float, z: float, shift: tuple[float, float, float]
) -> None:
    box = shapes.box(1, 2, 0.5)
    other = box.with_vertices(box.vertices * (x, y, z) + shift)
    assert parallelity(box, other).max() <= 1e-14  # rounding of sums of numbers up to 6
    axis = np.abs(box.edge_vectors).argmax(axis=1)
    np.testing.assert_allclose(edge_factors(box, other), np.array([x, y, z])[axis], atol=1e-14)


@given(seeds, st.floats(1e-6, 1e-2))
def test_parallelity_is_the_distance_off_the_direction(seed: int, amount: float) -> None:
    cube = shapes.cube()
    moved = cube.vertices.copy()
    vertex = int(np.random.default_rng(seed).integers(8))
    moved[vertex, 2] += amount  # across the edges along x and y, along the one along z
    found = parallelity(cube, cube.with_vertices(moved))
    touched = (cube.combinatorics.edges == vertex).any(axis=1) & (np.abs(cube.edge_vectors[:, 2]) < 1)
    assert touched.sum() == 2
    np.testing.assert_allclose(found, amount * touched, atol=1e-15)


@given(numbers, numbers, seeds)
def test_factors_are_linear_and_the_matrix_agrees_with_parallelity(a: float, b: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (ANNULUS.with_vertices(rng.normal(size=ANNULUS.vertices.shape)) for _ in range(2))
    factors = a * edge_factors(ANNULUS, first) + b * edge_factors(ANNULUS, second)
    np.testing.assert_allclose(edge_factors(ANNULUS, first * a + second * b), factors, atol=1e-12)
    rows = (ParallelSpace(ANNULUS).matrix @ first.vertices.ravel()).reshape(-1, 2)
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), parallelity(ANNULUS, first), atol=1e-13)


# --- dimension


@pytest.mark.parametrize(
    ("mesh", "dimension"),
    [
        # in the plane: widths of columns and rows, and translations
        (shapes.grid(1, 1), 2 + 3),
        (shapes.grid(3, 4), 7 + 3),
        (shapes.grid(20, 20), 40 + 3),
        # simple polyhedra: each face plane moves freely
        (shapes.box(1, 2, 3), 6),
        (shapes.regular_prism(5), 7),
        (shapes.regular_prism(9), 11),
        (shapes.dodecahedron(), 12),
        # triangle meshes: scaled copies
        (shapes.tetrahedron(), 4),
        (shapes.octahedron(), 4),
        (shapes.icosahedron(), 4),
        # parts are independent
        (together(shapes.box(1, 1, 1), shapes.grid(2, 3)), 6 + 8),
    ],
    ids=lambda value: str(value) if isinstance(value, int) else f"{value.n_faces} faces",
)
def test_known_dimensions(mesh: Mesh, dimension: int) -> None:
    found = ParallelSpace(mesh).spectrum
    assert found.dimension == dimension
    assert found.last_zero < 1e-13  # rounding in mesh and factor
    assert found.first_nonzero > 1e-3


@pytest.mark.parametrize("name", MESHES)
def test_dimension_is_that_of_equation_2(name: str) -> None:
    assert ParallelSpace(MESHES[name]).dimension == by_equation_2(MESHES[name]).shape[1]


@given(meshes, seeds)
@settings(max_examples=25)
def test_dimension_of_projective_images_is_that_of_equation_2(mesh: Mesh, seed: int) -> None:
    image = projected(mesh, seed)
    assert ParallelSpace(image).dimension == by_equation_2(image).shape[1]


def test_the_count_is_a_guide() -> None:
    assert ParallelSpace(shapes.grid(3, 4)).expected_dimension == 10  # a disc: E - 2F + 3
    assert ParallelSpace(shapes.regular_prism(9)).expected_dimension == 11
    assert ParallelSpace(shapes.dome(9, 4)).expected_dimension == 9 * 9 - 2 * 36  # an annulus: chi = 0
    assert ParallelSpace(shapes.octahedron()).expected_dimension == 2  # but scaled copies are always there


def test_bent_faces_have_no_gap() -> None:
    bent = shapes.grid(6, 6)
    heights = np.random.default_rng(0).uniform(-1e-2, 1e-2, size=bent.n_vertices)
    bent = bent.with_vertices(bent.vertices + np.outer(heights, [0, 0, 1]))
    with pytest.raises(RankError, match=r"no gap .* planarise the mesh first") as caught:
        _ = ParallelSpace(bent).dimension
    assert caught.value.value is not None
    assert caught.value.bound is not None
    assert caught.value.value < caught.value.bound


@given(st.floats(1e-6, 1e-4))
def test_bending_is_seen_in_the_last_singular_value_kept(height: float) -> None:
    bent = shapes.grid(3, 3).vertices.copy()
    bent[5, 2] += height
    found = ParallelSpace(shapes.grid(3, 3).with_vertices(bent)).spectrum
    assert found.dimension == 9
    dense = np.linalg.svd(closing_in_space(shapes.grid(3, 3).with_vertices(bent)), compute_uv=False)
    rank = 24 - 6  # edges, less widths of columns and rows
    assert dense[rank] <= found.last_zero <= 10 * dense[rank]  # a bound, and no useless one


def closing_in_space(mesh: Mesh) -> FloatArray:
    """(3F, E) the sums of edges around faces, with lengths in the directions of M as unknowns."""
    c = mesh.combinatorics
    rows = np.zeros((c.n_faces, 3, c.n_edges))
    for corner in range(c.n_corners):
        edge = c.corner_edge[corner]
        rows[c.corner_face[corner], :, edge] = mesh.edge_directions[edge] * (1 if c.runs_along_edge[corner] else -1)
    return rows.reshape(-1, c.n_edges)


@pytest.mark.parametrize("block", [1, 4, 8])
def test_inverse_iteration_and_dense_decomposition_agree(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = shapes.dome(24, 10)
    values = np.linalg.svd(EdgeClosure(mesh).narrow.toarray(), compute_uv=False)[::-1]
    zeros = int((values < 1e-9).sum())
    monkeypatch.setattr(spectrum, "FIRST_BLOCK_VECTORS", block)
    found = ParallelSpace(mesh).spectrum
    assert found.dimension == by_equation_2(mesh).shape[1]
    # the first one dropped is a Ritz value: from above, and nearly there
    assert values[zeros] * 0.999 < found.first_nonzero < values[zeros] * 1.3


def test_a_space_with_very_many_zeros_is_refused_before_memory_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spectrum, "MAX_BLOCK_NUMBERS", 1000)
    with pytest.raises(GeometryError, match="go by `expected_dimension`"):
        _ = ParallelSpace(shapes.grid(20, 20)).dimension


@pytest.mark.filterwarnings("error")
def test_a_mesh_that_is_a_point_is_refused() -> None:
    point = 0.0 * solids.cube()
    with pytest.raises(MeshError, match=r"edge \d+ .* has no length"):
        ParallelSpace(point).project(solids.cube())
    with pytest.raises(MeshError, match=r"edge \d+ .* has no length"):
        ParallelSpace(point).elements(1)
