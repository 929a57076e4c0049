"""P(M): who belongs to it, and its dimension where that is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError, RankError
from geometry.mesh import Mesh, shapes
from geometry.parallel import space
from geometry.parallel.space import ParallelSpace, edge_factors, parallelity

seeds = st.integers(0, 2**32 - 1)
numbers = st.floats(-3, 3)


def together(*meshes: Mesh) -> Mesh:
    """The disjoint union."""
    starts = np.cumsum([0, *(mesh.n_vertices for mesh in meshes)])
    faces = [
        [int(v + start) for v in f]
        for mesh, start in zip(meshes, starts, strict=False)
        for f in mesh.combinatorics.faces()
    ]
    return Mesh.from_faces(np.concatenate([mesh.vertices for mesh in meshes]), faces)


@given(numbers, numbers, numbers, st.tuples(numbers, numbers, numbers))
@settings(deadline=None)
def test_boxes_are_parallel_and_factors_are_ratios_of_lengths(
    x: float, y: float, z: float, shift: tuple[float, float, float]
) -> None:
    box = shapes.box(1, 2, 0.5)
    other = box.with_vertices(box.vertices * (x, y, z) + shift)
    assert parallelity(box, other).max() <= 1e-14  # rounding of sums of numbers up to 6
    axis = np.abs(box.edge_vectors).argmax(axis=1)
    np.testing.assert_allclose(edge_factors(box, other), np.array([x, y, z])[axis], atol=1e-14)


@given(seeds, st.floats(1e-6, 1e-2))
@settings(deadline=None)
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
@settings(deadline=None)
def test_factors_are_linear_and_the_matrix_agrees_with_parallelity(a: float, b: float, seed: int) -> None:
    mesh = shapes.dome(7, 3)
    rng = np.random.default_rng(seed)
    first, second = (mesh.with_vertices(rng.normal(size=mesh.vertices.shape)) for _ in range(2))
    factors = a * edge_factors(mesh, first) + b * edge_factors(mesh, second)
    np.testing.assert_allclose(edge_factors(mesh, first * a + second * b), factors, atol=1e-12)
    rows = (ParallelSpace(mesh).matrix @ first.vertices.ravel()).reshape(-1, 2)
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), parallelity(mesh, first), atol=1e-13)


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
    assert found.last_kept < 1e-13 * 100  # rounding in mesh and factor
    assert found.first_dropped > 1e-3


def test_the_count_is_a_guide() -> None:
    assert ParallelSpace(shapes.grid(3, 4)).expected_dimension == 10  # a disc: E - 2F + 3
    assert ParallelSpace(shapes.regular_prism(9)).expected_dimension == 11
    assert ParallelSpace(shapes.dome(9, 4)).expected_dimension == 9 * 9 - 2 * 36  # an annulus: chi = 0
    assert ParallelSpace(shapes.octahedron()).expected_dimension == 2  # but scaled copies are always there


def test_vertices_without_faces_do_not_count() -> None:
    box = shapes.box(1, 2, 3)
    more = Mesh.from_faces(np.concatenate([box.vertices, [[5.0, 5.0, 5.0]]]), box.combinatorics.faces())
    assert ParallelSpace(more).dimension == 6


def test_block_iteration_and_dense_decomposition_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = shapes.dome(24, 10)
    sparse = ParallelSpace(mesh).spectrum
    dense = np.sort(np.linalg.svd(ParallelSpace(mesh).matrix.toarray(), compute_uv=False))
    assert sparse.dimension == int((dense < 1e-9).sum())
    # the first one dropped is a Ritz value: from above, and nearly there
    assert dense[sparse.dimension] * 0.999 < sparse.first_dropped < dense[sparse.dimension] * 1.2


def test_a_mesh_with_bent_faces_has_no_gap() -> None:
    bent = shapes.grid(6, 6)
    heights = np.random.default_rng(0).uniform(-1e-3, 1e-3, size=bent.n_vertices)
    bent = bent.with_vertices(bent.vertices + np.outer(heights, [0, 0, 1]))
    with pytest.raises(RankError, match=r"no gap .* planarise the mesh first"):
        _ = ParallelSpace(bent).dimension


def test_too_large_a_mesh_is_refused_before_memory_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space, "LARGEST_BASIS", 1000)
    for mesh in (shapes.grid(20, 20), shapes.dodecahedron()):
        with pytest.raises(GeometryError, match="go by `expected_dimension`"):
            _ = ParallelSpace(mesh).dimension


def test_unlike_meshes_and_edges_without_length_are_refused() -> None:
    with pytest.raises(MeshError, match="do not have the same faces"):
        parallelity(shapes.cube(), shapes.octahedron())
    grid = shapes.grid(1, 1)
    with pytest.raises(MeshError, match="has no length, so nothing is parallel to it"):
        edge_factors(grid * 0.0, grid)
