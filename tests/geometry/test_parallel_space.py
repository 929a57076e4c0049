"""P(M) against the paper's own way, a dense decomposition of (2), and against theory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError, ParallelityError, RankError
from geometry.mesh import Mesh, shapes
from geometry.optimise.solution import ConvergenceError
from geometry.parallel import minimising, space, spectrum
from geometry.parallel.closing import Closing
from geometry.parallel.parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace

seeds = st.integers(0, 2**32 - 1)
numbers = st.floats(-3, 3)


def by_equation_2(mesh: Mesh) -> FloatArray:
    """(3N, d) an orthonormal basis of P(M): the null space of (m_i - m_j) x (s_i - s_j) = 0 [Pottmann2007, (2)]."""
    rows = np.zeros((mesh.n_edges, 3, mesh.n_vertices, 3))
    for edge, (i, j) in enumerate(mesh.combinatorics.edges):
        x, y, z = mesh.vertices[i] - mesh.vertices[j]
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / np.linalg.norm([x, y, z])
        rows[edge, :, i], rows[edge, :, j] = cross, -cross
    matrix = rows.reshape(3 * mesh.n_edges, -1)
    matrix = matrix[:, np.repeat(mesh.combinatorics.is_used, 3)]
    _, values, directions = np.linalg.svd(matrix)
    rank = int((values > 1e-9).sum())  # rounding is at 1e-15, the least others of the meshes here at 1e-4
    basis = np.zeros((3 * mesh.n_vertices, matrix.shape[1] - rank))
    basis[np.repeat(mesh.combinatorics.is_used, 3)] = directions[rank:].T
    return basis


def together(*meshes: Mesh) -> Mesh:
    """The disjoint union."""
    starts = np.cumsum([0, *(mesh.n_vertices for mesh in meshes)])
    faces = [
        [int(v + start) for v in f]
        for mesh, start in zip(meshes, starts, strict=False)
        for f in mesh.combinatorics.faces()
    ]
    return Mesh.from_faces(np.concatenate([mesh.vertices for mesh in meshes]), faces)


def without(mesh: Mesh, *faces: int) -> Mesh:
    """With holes; vertices that are left over stay, unused."""
    return Mesh.from_faces(mesh.vertices, [f for k, f in enumerate(mesh.combinatorics.faces()) if k not in faces])


def split(mesh: Mesh, *faces: int) -> Mesh:
    """With faces cut into triangles from their first corner."""
    parts = []
    for k, f in enumerate(mesh.combinatorics.faces()):
        parts += [[f[0], f[n], f[n + 1]] for n in range(1, len(f) - 1)] if k in faces else [f]
    return Mesh.from_faces(mesh.vertices, parts)


def subdivided(mesh: Mesh, *edges: int) -> Mesh:
    """With a vertex of valence 2 more on some edges, on the straight line."""
    pairs = [mesh.combinatorics.edges[edge].tolist() for edge in edges]
    middle = {frozenset(pair): mesh.n_vertices + k for k, pair in enumerate(pairs)}
    faces = []
    for f in mesh.combinatorics.faces():
        following = [*f[1:], f[0]]
        new = [[v, middle.get(frozenset((v, w)))] for v, w in zip(f, following, strict=True)]
        faces.append([v for pair in new for v in pair if v is not None])
    points = [0.3 * mesh.vertices[i] + 0.7 * mesh.vertices[j] for i, j in pairs]
    return Mesh.from_faces(np.concatenate([mesh.vertices, points]), faces)


def voxels(filled: FloatArray) -> Mesh:
    """The boundary of a solid of unit cubes, filled (nx, ny, nz): many coplanar faces."""
    padded = np.pad(np.asarray(filled, dtype=bool), 1)
    quads = []
    for axis in range(3):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for side in (0, 1):
            outside = np.roll(padded, 1 - 2 * side, axis)
            corner = np.argwhere(padded & ~outside) + side * np.eye(3)[axis]
            ring = [0 * u, u, u + v, v] if side else [0 * u, v, u + v, u]
            quads.append(np.stack([corner + step for step in ring], axis=1))
    points, names = np.unique(np.concatenate(quads).reshape(-1, 3), axis=0, return_inverse=True)
    return Mesh.from_faces(points, names.reshape(-1, 4).tolist())


PLATE = np.ones((5, 3, 1))
PLATE[1, 1], PLATE[3, 1] = 0, 0

ANNULUS = shapes.dome(7, 3)
TORUS = shapes.torus(np.array([[2.0, -1.0], [3.5, -0.5], [3.0, 1.0], [2.2, 0.8]]), 5)
MESHES = {
    "disc": shapes.grid(3, 4),
    "annulus": ANNULUS,
    "several boundaries": without(shapes.grid(5, 5), 6, 8, 18),
    "boundaries on the sphere": without(shapes.dodecahedron(), 0, 3, 7),
    "sphere": shapes.regular_prism(7),
    "torus": TORUS,
    "torus with holes": without(TORUS, 0, 7),
    "genus 2": voxels(PLATE),
    "genus 2, coplanar faces few": shapes.double_ring(),
    "hexagons": shapes.hexagonal_paraboloid(3, 3),
    "triangles": split(ANNULUS, *range(ANNULUS.n_faces)),
    "closed triangles": shapes.icosahedron(),
    "triangles among larger faces": split(ANNULUS, 0, 1, 5, 9, 10, 11),
    "more equations than unknowns": split(shapes.grid(4, 4), *range(13)),
    "triangles on a torus": split(TORUS, *range(TORUS.n_faces - 2)),
    "valence 2 at the boundary": subdivided(shapes.grid(2, 2), 0, 3, 7),
    "valence 2 inside": subdivided(shapes.box(1, 2, 3), 0, 5, 6),
    "a triangle without height": Mesh.from_faces(
        [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0.7, 0, 0]], [[0, 1, 2, 3], [1, 0, 4]]
    ),
    "faces that meet in a vertex": without(shapes.grid(2, 2), 1, 2),
    "a hole closed by a vertex": without(shapes.grid(3, 3), 4, 8),
    "parts": together(shapes.box(1, 1, 1), shapes.grid(2, 3), TORUS),
    "unused vertices": together(without(shapes.grid(2, 2), 3), shapes.tetrahedron()),
}
meshes = st.sampled_from(sorted(MESHES)).map(MESHES.__getitem__)


def projected(mesh: Mesh, seed: int) -> Mesh:
    """A projective image: planar faces stay planar, and straight edges straight; what was parallel no longer is."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    reach = np.linalg.norm(mesh.vertices, axis=1).max()
    away = rng.normal(size=3)
    away *= 0.3 / np.linalg.norm(away) / reach
    return mesh.with_vertices(mesh.vertices @ turn / (1 + mesh.vertices @ away)[:, None])


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
    assert found.last_kept < 1e-13  # rounding in mesh and factor
    assert found.first_dropped > 1e-3


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
    assert dense[rank] <= found.last_kept <= 10 * dense[rank]  # a bound, and no useless one


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
    values = np.linalg.svd(Closing(mesh).narrow.toarray(), compute_uv=False)[::-1]
    zeros = int((values < 1e-9).sum())
    monkeypatch.setattr(spectrum, "BLOCK", block)
    found = ParallelSpace(mesh).spectrum
    assert found.dimension == by_equation_2(mesh).shape[1]
    # the first one dropped is a Ritz value: from above, and nearly there
    assert values[zeros] * 0.999 < found.first_dropped < values[zeros] * 1.3


def test_a_space_with_very_many_zeros_is_refused_before_memory_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spectrum, "LARGEST_BLOCK", 1000)
    with pytest.raises(GeometryError, match="go by `expected_dimension`"):
        _ = ParallelSpace(shapes.grid(20, 20)).dimension


# --- members


@pytest.mark.parametrize("name", MESHES)
def test_the_basis_spans_the_null_space_of_equation_2(name: str) -> None:
    mesh, expected = projected(MESHES[name], 1), by_equation_2(projected(MESHES[name], 1))
    basis = ParallelSpace(mesh).basis
    assert basis.shape == (expected.shape[1], mesh.n_vertices, 3)
    rows = basis.reshape(len(basis), -1)
    np.testing.assert_allclose(rows @ rows.T, np.eye(len(rows)), atol=1e-13)
    np.testing.assert_allclose(expected @ (expected.T @ rows.T), rows.T, atol=1e-10)  # rounding over the least 1e-4
    for member in basis:
        assert parallelity(mesh, mesh.with_vertices(member)).max() <= 1e-13  # rounding
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
    # 1e-12 where the orthonormal combinations of random members are not made to close again
    assert max(parallelity(mesh, mesh.with_vertices(member)).max() for member in basis) <= 1e-14
    assert parallelity(mesh, ParallelSpace(mesh).elements(1)[0]).max() <= 3e-16


def test_more_elements_than_dimensions_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"7 independent elements .* P\(M\) has 6 dimensions"):
        ParallelSpace(shapes.grid(3, 3)).elements(7)
    with pytest.raises(GeometryError, match="must be 1 or more"):
        ParallelSpace(shapes.grid(3, 3)).elements(0)


def test_a_basis_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space, "LARGEST_BASIS", 1000)
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
    monkeypatch.setattr(minimising, "PARALLEL", 1e-20)
    stranger = ANNULUS.with_vertices(np.random.default_rng(0).normal(size=ANNULUS.vertices.shape))
    with pytest.raises(ConvergenceError, match=r"edge \d+ from vertex \d+ to vertex \d+ is off .* allowed") as caught:
        ParallelSpace(ANNULUS).project(stranger)
    assert caught.value.solution.violation <= 1e-12


def test_members_are_projected_onto_themselves() -> None:
    member = ParallelSpace(ANNULUS).elements(1)[0]
    np.testing.assert_allclose(ParallelSpace(ANNULUS).project(member).vertices, member.vertices, atol=1e-13)


@given(meshes, seeds, st.lists(numbers, min_size=1, max_size=4))
@settings(max_examples=25)
def test_blending_is_linear_in_edge_factors(mesh: Mesh, seed: int, weights: list[float]) -> None:
    mesh = projected(mesh, seed)
    parallel = ParallelSpace(mesh)
    members = [mesh, *(parallel.elements(1, seed=k)[0] for k in range(len(weights) - 1))]
    blend = parallel.blend(weights, members)
    assert parallel.contains(blend)
    factors = sum(w * edge_factors(mesh, member) for w, member in zip(weights, members, strict=True))
    scale = (mesh.edge_lengths.max() / mesh.edge_lengths.min()) * 10
    np.testing.assert_allclose(edge_factors(mesh, blend), factors, atol=1e-13 * scale)


# --- what is refused


def test_a_mesh_that_is_no_member_is_named_with_its_edge() -> None:
    cube, moved = shapes.cube(), shapes.cube().vertices.copy()
    moved[3] += [1e-6, 0, 0]
    stranger = cube.with_vertices(moved)
    assert not ParallelSpace(cube).contains(stranger)
    with pytest.raises(ParallelityError, match=r"edge \d+ from vertex \d+ to vertex \d+ of member 1 is off") as caught:
        ParallelSpace(cube).blend([1.0, 2.0], [cube, stranger])
    assert caught.value.value == pytest.approx(1e-6)
    assert 3 in cube.combinatorics.edges[caught.value.elements[0]]


@pytest.mark.parametrize(("weights", "count"), [([1.0], 2), ([], 0)])
def test_weights_and_members_must_match(weights: list[float], count: int) -> None:
    with pytest.raises(GeometryError, match="one each is needed"):
        ParallelSpace(shapes.cube()).blend(weights, [shapes.cube()] * count)


def test_weights_must_be_numbers() -> None:
    with pytest.raises(GeometryError, match="the weight of member 0 is nan"):
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
    with pytest.raises(GeometryError, match=r"face 0 leaves its plane by 2.5e-10 .* allowed 1e-12; planarise"):
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
