"""A test for each proposition and numbered equation of [Pottmann2007] that the library implements.

Each writes down what the paper says, literally and slowly, and compares the library with it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, null_space

from geometry.arrays import FloatArray
from geometry.curvature import face_curvatures, steiner_area
from geometry.errors import GeometryError, ParallelityError
from geometry.exact_offsets import (
    circularity,
    conicality,
    edge_cone_deviation,
    edge_offset_pair,
    face_offset_pair,
    vertex_offset_pair,
)
from geometry.functionals.fairness import laplacian
from geometry.gauss import Pair, vertex_distances
from geometry.gauss.axes import node_axes, parallel_from_axes
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.polygons import mixed_areas
from geometry.parallel import ParallelSpace
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.spheres.laguerre import LaguerreTransformation

ROUNDING = 1e-10
"""Bases come from singular value decompositions of matrices with condition numbers up to 1e3; sizes are up to 10."""

seeds = st.integers(0, 2**32 - 1)
distances = st.floats(0.05, 3)


def det(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    return float(np.dot(np.cross(a, b), c))


def unit(vector: FloatArray) -> FloatArray:
    return vector / np.linalg.norm(vector)


def edges(mesh: Mesh) -> list[tuple[int, int]]:
    return [(int(i), int(j)) for i, j in mesh.combinatorics.edges]


def distance_of_line(point: FloatArray, along: FloatArray) -> float:
    """From the origin."""
    return float(np.linalg.norm(np.cross(point, unit(along))))


def equations_2(mesh: Mesh) -> FloatArray:
    """(3E, 3N) the matrix of (m'_i - m'_j) x (m_i - m_j) = 0 in the unknown m'."""
    matrix = np.zeros((3 * mesh.n_edges, 3 * mesh.n_vertices))
    for edge, (i, j) in enumerate(edges(mesh)):
        for k, e_k in enumerate(np.eye(3)):
            product = np.cross(e_k, mesh.vertices[i] - mesh.vertices[j])
            matrix[3 * edge : 3 * edge + 3, 3 * i + k] += product
            matrix[3 * edge : 3 * edge + 3, 3 * j + k] -= product
    return matrix


SKEW = shapes.translation_surface(
    [[0, 0, 0], [1, 0.2, 0.3], [2, 0.1, 0.4], [3, 0.5, 0.2]], [[0, 0, 0], [0.3, 1, -0.2], [0.5, 2, -0.6]]
)
"""Neither circular nor conical, nor with an edge offset."""

DISCS = {
    "grid": shapes.grid(3, 2),
    "translation surface": SKEW,
    "half a barrel": shapes.rotational_mesh([[1.0, 0], [1.3, 1], [1.1, 2]], 4, closed=False),
    "hexagons": shapes.hexagonal_paraboloid(3, 2),
}
KOEBE = {
    name: (1 / mid_radius) * getattr(solids, name)()
    for name, mid_radius in {
        "truncated_octahedron": 3 / 2**0.5,
        "rhombicuboctahedron": (4 + 2 * 2**0.5) ** 0.5,
        "truncated_icosahedron": 3 * (1 + 5**0.5) / 2,
    }.items()
}
MESHES = {**DISCS, **KOEBE, "dome": shapes.dome(6, 3), "double ring": shapes.double_ring()}
SPACES = {name: null_space(equations_2(mesh), rcond=1e-10) for name, mesh in MESHES.items()}

names = st.sampled_from(sorted(MESHES))


def element(name: str, seed: int) -> Mesh:
    """Any mesh of P(M), edges reversed and all; of size 1."""
    rng = np.random.default_rng(seed)
    x = SPACES[name] @ rng.uniform(-1, 1, SPACES[name].shape[1])
    return MESHES[name].with_vertices(x.reshape(-1, 3) / np.abs(x).max())


def shaped(name: str, seed: int, base: Mesh | None = None) -> Mesh:
    """A mesh of P(M) without reversed edges: all edge factors with respect to M are between 0.4 and 1.6."""
    other = element(name, seed)
    return MESHES[name] + other * (0.6 / np.abs(edge_factors(MESHES[name], other)).max())


# --- 2 Mesh parallelism


@given(names, seeds, seeds, st.floats(-5, 5), st.floats(-5, 5))
def test_parallel_meshes_are_a_linear_space(name: str, one: int, two: int, s: float, t: float) -> None:
    """2.2: linear combinations of meshes parallel to M are parallel to M; its zero is the mesh o in the origin."""
    mesh = MESHES[name]
    blend = s * element(name, one) + t * element(name, two)
    for i, j in edges(mesh):
        crossed = np.cross(blend.vertices[i] - blend.vertices[j], mesh.vertices[i] - mesh.vertices[j])
        assert np.linalg.norm(crossed) <= ROUNDING
    assert parallelity(mesh, blend).max() <= ROUNDING
    assert parallelity(mesh, 0.0 * mesh).max() == 0
    assert parallelity(mesh, mesh.with_vertices(s * mesh.vertices + t)).max() <= ROUNDING  # translated and scaled


@given(names, seeds)
def test_equation_1_edge_factors(name: str, seed: int) -> None:
    """(1): M' is parallel to M if and only if m'_i - m'_j = lambda_ij (m_i - m_j) for all edges."""
    mesh, other = MESHES[name], element(name, seed)
    factors = edge_factors(mesh, other)
    m, m_ = mesh.vertices, other.vertices
    for edge, (i, j) in enumerate(edges(mesh)):
        np.testing.assert_allclose(m_[i] - m_[j], factors[edge] * (m[i] - m[j]), rtol=0, atol=ROUNDING)
    bent = m_.copy()
    bent[0] += np.cross(m[edges(mesh)[0][1]] - m[edges(mesh)[0][0]], [0.1, 0.2, 0.3])
    assert parallelity(mesh, mesh.with_vertices(bent)).max() > 1e-3


@given(names, seeds)
def test_equation_2_solution_space(name: str, seed: int) -> None:
    """(2): P(M) is the solution space of (m'_i - m'_j) x (m_i - m_j) = 0 over all edges."""
    mesh, solutions = MESHES[name], SPACES[name]
    space = ParallelSpace(mesh)
    assert space.dimension == solutions.shape[1]
    basis = space.basis.reshape(space.dimension, -1)
    np.testing.assert_allclose(basis.T @ basis, solutions @ solutions.T, rtol=0, atol=ROUNDING)  # the same span
    anything = mesh.with_vertices(np.random.default_rng(seed).uniform(-1, 1, (mesh.n_vertices, 3)))
    nearest = solutions @ (solutions.T @ anything.vertices.ravel())
    np.testing.assert_allclose(space.project(anything).vertices.ravel(), nearest, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", DISCS)
def test_equation_2_degrees_of_freedom(name: str) -> None:
    """After (2): for open meshes we can expect dim P(M) = #edges - 2 #faces + 3."""
    mesh = DISCS[name]
    expected = mesh.n_edges - 2 * mesh.n_faces + 3
    assert SPACES[name].shape[1] == expected
    assert ParallelSpace(mesh).expected_dimension == expected


@pytest.mark.parametrize("name", ["octahedron", "icosahedron"])
def test_parallel_triangle_meshes_are_scaled_copies(name: str) -> None:
    """2.2: two parallel triangle meshes are scaled, and translated, copies of each other."""
    mesh = getattr(solids, name)()
    copies = np.stack([mesh.vertices.ravel(), *np.tile(np.eye(3), (1, mesh.n_vertices))])
    solutions = null_space(equations_2(mesh))
    assert solutions.shape[1] == 4
    np.testing.assert_allclose(solutions @ (solutions.T @ copies.T), copies.T, rtol=0, atol=ROUNDING)
    assert ParallelSpace(mesh).dimension == 4


@given(st.sampled_from(["cube", "dodecahedron", "truncated_octahedron"]), seeds)
def test_parallel_planes_make_parallel_meshes(name: str, seed: int) -> None:
    """2.2: parallel planes of corresponding faces suffice for parallel edges, if no adjacent faces are coplanar."""
    mesh = getattr(solids, name)()
    assert set(mesh.combinatorics.vertex_degrees.tolist()) == {3}
    offsets = np.random.default_rng(seed).uniform(0.5, 1.5, mesh.n_faces)
    vertices = np.empty_like(mesh.vertices)
    for vertex in range(mesh.n_vertices):
        faces = [face for face, corners in enumerate(mesh.combinatorics.faces) if vertex in corners]
        vertices[vertex] = np.linalg.solve(mesh.face_normals[faces], offsets[faces])
    assert parallelity(mesh, mesh.with_vertices(vertices)).max() <= ROUNDING


@given(names, seeds)
def test_proposition_1_parallel_meshes_span_node_axes(name: str, seed: int) -> None:
    """Prop. 1: the lines through corresponding vertices of parallel meshes are node axes, coplanar over each edge."""
    mesh, other = MESHES[name], element(name, seed)
    axes = node_axes(mesh, other)
    for vertex in range(mesh.n_vertices):
        expected = unit(other.vertices[vertex] - mesh.vertices[vertex])
        np.testing.assert_allclose(axes[vertex], expected, rtol=0, atol=ROUNDING)
    for i, j in edges(mesh):
        assert abs(det(unit(mesh.vertices[j] - mesh.vertices[i]), axes[i], axes[j])) <= ROUNDING


@given(st.sampled_from(sorted({**DISCS, **KOEBE})), seeds)
def test_proposition_1_node_axes_make_a_parallel_mesh(name: str, seed: int) -> None:
    """Prop. 1, conversely: a simply connected mesh with node axes has a parallel mesh with its vertices on them."""
    mesh, other = MESHES[name], shaped(name, seed) + translation(MESHES[name], [0, 0, 30])
    axes = np.array([unit(other.vertices[i] - mesh.vertices[i]) for i in range(mesh.n_vertices)])
    distance = float(np.linalg.norm(other.vertices[0] - mesh.vertices[0]))
    found = parallel_from_axes(mesh, axes, start=0, distance=distance)
    np.testing.assert_allclose(found.vertices, other.vertices, rtol=0, atol=1000 * ROUNDING)  # axes are nearly parallel
    i, j = edges(mesh)[-1]
    across = np.cross(axes[i], mesh.vertices[j] - mesh.vertices[i])
    bent = axes.copy()
    bent[i] = unit(axes[i] + 0.01 * unit(across))
    with pytest.raises(ParallelityError, match="not coplanar"):
        parallel_from_axes(mesh, bent)


def translation(mesh: Mesh, by: list[float]) -> Mesh:
    return mesh.with_vertices(np.tile(by, (mesh.n_vertices, 1)))


# --- 3.1 Exact offsets


@given(st.just("dome"), seeds, distances)
def test_proposition_2_vertex_offsets(name: str, seed: int, d: float) -> None:
    """Prop. 2.1: M + dS is a vertex offset of M if and only if the vertices of S are contained in the unit sphere."""
    image = MESHES[name]
    mesh = shaped(name, seed)
    offset = mesh + d * image
    for i in range(mesh.n_vertices):
        assert np.linalg.norm(offset.vertices[i] - mesh.vertices[i]) == pytest.approx(d, rel=ROUNDING)
    recovered = (offset - mesh) * (1 / d)
    np.testing.assert_allclose(vertex_distances(recovered), 1, rtol=0, atol=ROUNDING / d)
    other = mesh + d * mesh
    lengths = np.linalg.norm(other.vertices - mesh.vertices, axis=1) / d
    np.testing.assert_allclose(vertex_distances((other - mesh) * (1 / d)), lengths, rtol=ROUNDING)


@given(st.just("dome"), seeds)
def test_proposition_2_quad_meshes_with_vertex_offsets_are_circular(name: str, seed: int) -> None:
    """Prop. 2.1: a quad mesh has a vertex offset if and only if each face has a circumcircle."""
    mesh = shaped(name, seed)
    for face in mesh.combinatorics.faces:  # opposite angles of a convex quad with a circumcircle add up to pi
        a, b, c, d = mesh.vertices[face]
        assert angle(a, d, b) + angle(c, b, d) == pytest.approx(np.pi, abs=ROUNDING)
    assert circularity(mesh).max() <= ROUNDING
    image = vertex_offset_pair(mesh).gauss_image
    assert parallelity(mesh, image).max() <= ROUNDING
    for vertex in image.vertices:
        assert np.linalg.norm(vertex) == pytest.approx(1, abs=ROUNDING)
    assert circularity(SKEW).max() > 1e-2
    with pytest.raises(GeometryError):
        vertex_offset_pair(SKEW)


def angle(at: FloatArray, first: FloatArray, second: FloatArray) -> float:
    return float(np.arccos(np.clip(np.dot(unit(first - at), unit(second - at)), -1, 1)))


@given(st.sampled_from(sorted(KOEBE)), seeds, distances)
def test_proposition_2_edge_offsets(name: str, seed: int, d: float) -> None:
    """Prop. 2.2: M + dS is an edge offset of M if and only if the edges of S are tangent to the unit sphere."""
    image, mesh = KOEBE[name], shaped(name, seed)
    offset = mesh + d * image
    for i, j in edges(mesh):
        assert distance_of_line(image.vertices[i], image.vertices[j] - image.vertices[i]) == pytest.approx(
            1, rel=ROUNDING
        )
        along = mesh.vertices[j] - mesh.vertices[i]
        assert distance_of_line(offset.vertices[i] - mesh.vertices[i], along) == pytest.approx(d, rel=ROUNDING)
    np.testing.assert_allclose(Pair(mesh, image).edge_distances, 1, rtol=ROUNDING)
    other = element(name, seed)
    lines = [(other.vertices[i], mesh.vertices[j] - mesh.vertices[i]) for i, j in edges(mesh)]
    expected = [distance_of_line(point, along) for point, along in lines]
    np.testing.assert_allclose(Pair(mesh, other).edge_distances, expected, rtol=0, atol=ROUNDING)
    found = edge_offset_pair(mesh).gauss_image
    np.testing.assert_allclose(found.vertices, image.vertices, rtol=0, atol=1000 * ROUNDING)
    with pytest.raises(GeometryError):
        edge_offset_pair(SKEW)


@given(st.sampled_from(["dome", "double ring", "hexagons", "truncated_icosahedron"]), seeds, distances)
def test_proposition_2_face_offsets(name: str, seed: int, d: float) -> None:
    """Prop. 2.3: M + dS is a face offset of M if and only if the faces of S are tangent to the unit sphere."""
    mesh = shaped(name, seed)
    image = face_offset_pair(mesh).gauss_image
    assert parallelity(mesh, image).max() <= ROUNDING
    offset = mesh + d * image
    for face, normal in zip(mesh.combinatorics.faces, mesh.face_normals, strict=True):
        for i in face:
            assert np.dot(normal, image.vertices[i]) == pytest.approx(1, abs=ROUNDING)
            assert np.dot(normal, offset.vertices[i] - mesh.vertices[i]) == pytest.approx(d, abs=ROUNDING)
    np.testing.assert_allclose(Pair(mesh, image).face_distances, 1, rtol=0, atol=ROUNDING)
    other = element(name, seed)
    first = other.vertices[[face[0] for face in mesh.combinatorics.faces]]
    expected = [np.dot(*pair) for pair in zip(mesh.face_normals, first, strict=True)]
    np.testing.assert_allclose(Pair(mesh, other).face_distances, expected, rtol=0, atol=ROUNDING)


@given(st.sampled_from(["dome", "double ring", "hexagons", "truncated_icosahedron"]), seeds)
def test_proposition_2_meshes_with_face_offsets_are_conical(name: str, seed: int) -> None:
    """Prop. 2.3: a mesh has a face offset if and only if the faces at a vertex are tangent to a cone of revolution."""
    mesh = shaped(name, seed)
    image = face_offset_pair(mesh).gauss_image
    c = mesh.combinatorics
    for vertex in np.flatnonzero(~c.is_boundary_vertex):  # the cone's axis is that of the vertex
        faces = [face for face, corners in enumerate(c.faces) if vertex in corners]
        heights = mesh.face_normals[faces] @ unit(image.vertices[vertex])
        np.testing.assert_allclose(heights, heights[0], rtol=0, atol=ROUNDING)
    assert np.nanmax(conicality(mesh), initial=0) <= ROUNDING
    assert np.nanmax(conicality(SKEW)) > 1e-2
    with pytest.raises(GeometryError):
        face_offset_pair(SKEW)


KINDS: list[tuple[Callable[[Mesh], Pair], str]] = [
    (vertex_offset_pair, "dome"),
    (edge_offset_pair, "rhombicuboctahedron"),
    (face_offset_pair, "double ring"),
]


@given(st.sampled_from(KINDS), seeds)
def test_after_proposition_2_offsets_of_parallel_meshes(kind: tuple[Callable[[Mesh], Pair], str], seed: int) -> None:
    """After Prop. 2: if M has an offset at constant distance, every mesh parallel to M has one, with the same S.

    Where M leaves a choice of S, angles and normals decide, which are the same where no edge is reversed.
    """
    found, name = kind
    image = found(MESHES[name]).gauss_image
    of_other = found(shaped(name, seed)).gauss_image
    np.testing.assert_allclose(of_other.vertices, image.vertices, rtol=0, atol=1000 * ROUNDING)


# --- 3.2 Edge offsets


@given(st.sampled_from(sorted(KOEBE)), seeds, distances)
def test_proposition_3_cones_at_the_vertices(name: str, seed: int, d: float) -> None:
    """Prop. 3: if M has an edge offset, the edges at a vertex lie on a cone of revolution about its node axis."""
    mesh = element(name, seed)  # with reversed edges, which lie on the other half of the cone
    offset = mesh + d * KOEBE[name]
    for vertex in range(mesh.n_vertices):
        axis = unit(offset.vertices[vertex] - mesh.vertices[vertex])
        others = [j if i == vertex else i for i, j in edges(mesh) if vertex in (i, j)]
        cosines = [abs(np.dot(axis, unit(mesh.vertices[i] - mesh.vertices[vertex]))) for i in others]
        np.testing.assert_allclose(cosines, cosines[0], rtol=0, atol=1e-6)  # short edges keep fewer digits
    assert np.nanmax(edge_cone_deviation(mesh), initial=0) <= 1e-6


@given(st.sampled_from(sorted(KOEBE)), seeds)
def test_proposition_4_laguerre_transformations(name: str, seed: int) -> None:
    """Prop. 4: x_S -> A x_S + a with A^T J A = J maps the vertex cones of an edge offset mesh to those of another one.

    The cone at m_i touches the spheres (m_i - s_i, 1) and (m_i + s_i, -1), as edges of S are at distance 1; and its
    image touches theirs. Its vertex is the sphere of radius 0 on the line through them.
    """
    rng = np.random.default_rng(seed)
    J = np.diag([1.0, 1, 1, -1])
    A, a = expm(J @ np.triu(skew := rng.uniform(-0.15, 0.15, (4, 4)), 1) - J @ np.triu(skew, 1).T), rng.normal(size=4)
    np.testing.assert_allclose(A.T @ J @ A, J, atol=1e-14)
    mesh, image = shaped(name, seed), KOEBE[name]
    vertices = np.zeros((mesh.n_vertices, 3))
    for i, (m, s) in enumerate(zip(mesh.vertices, image.vertices, strict=True)):
        first, second = A @ [*(m - s), 1] + a, A @ [*(m + s), -1] + a
        vertices[i] = ((first[3] * second - second[3] * first) / (first[3] - second[3]))[:3]
    found = Pair(mesh, image).laguerre(LaguerreTransformation(A, a))
    np.testing.assert_allclose(found.mesh.vertices, vertices, rtol=0, atol=ROUNDING)
    moved = mesh.with_vertices(vertices)
    assert moved.plane_deviations.max() <= ROUNDING  # planar faces again
    for edge, (i, j) in enumerate(edges(moved)):
        s, t = found.gauss_image.vertices[i], unit(vertices[j] - vertices[i])
        assert distance_of_line(s, t) == pytest.approx(1, abs=1e-7), edge  # short edges keep fewer digits


@given(names, seeds)
def test_equation_3_fairness(name: str, seed: int) -> None:
    """(3): f_Laplacian is the sum over the vertices of |m_i - mean of its neighbours|^2."""
    mesh = element(name, seed)
    energy = 0.0
    for vertex, m_i in enumerate(mesh.vertices):
        star = [j if i == vertex else i for i, j in edges(mesh) if vertex in (i, j)]
        energy += np.sum((m_i - sum(mesh.vertices[j] for j in star) / len(star)) ** 2)
    residual = laplacian(mesh.combinatorics).residual(mesh.vertices.ravel())
    assert residual @ residual == pytest.approx(energy, rel=1e-12)


# --- 5 Curvatures


def literal_area(corners: FloatArray, normal: FloatArray) -> float:
    k = len(corners)
    return sum(det(corners[i], corners[(i + 1) % k], normal) for i in range(k)) / 2


def literal_mixed_area(p: FloatArray, q: FloatArray, normal: FloatArray) -> float:
    k = len(p)
    terms = [det(p[i], q[(i + 1) % k], normal) + det(q[i], p[(i + 1) % k], normal) for i in range(k)]
    return sum(terms) / 4


@given(names, seeds, st.floats(-5, 5))
def test_equation_4_mixed_areas(name: str, seed: int, d: float) -> None:
    """(4): area(P + dQ) = area(P) + 2 d area(P, Q) + d^2 area(Q) for parallel polygons P and Q."""
    mesh, other = MESHES[name], element(name, seed)
    mixed = mixed_areas(mesh.vertices, other.vertices, mesh.combinatorics, mesh.face_normals)
    for face, n in enumerate(mesh.face_normals):
        corners = mesh.combinatorics.face(face)
        p, q = mesh.vertices[corners], other.vertices[corners]
        assert mixed[face] == pytest.approx(literal_mixed_area(p, q, n), abs=ROUNDING)
        polynomial = literal_area(p, n) + 2 * d * mixed[face] + d**2 * literal_area(q, n)
        assert literal_area(p + d * q, n) == pytest.approx(polynomial, abs=ROUNDING)


@pytest.mark.parametrize("d", [-0.4, 0.1, 0.5])
def test_equation_5_areas_of_smooth_offsets(d: float) -> None:
    """(5): the area of the offset of a smooth surface is the integral of 1 - 2 d H + d^2 K; (6) tends to it.

    On a zone of the unit sphere, and on a torus, where H and K integrate to -2 pi^2 R and 0.
    """
    zone = 2 * np.pi * (np.sin(np.radians(80)) - np.sin(np.radians(10)))
    spheres = [shapes.dome(8 * n, 4 * n) for n in (1, 2, 4)]
    errors = [steiner_area(Pair(mesh, mesh), d) - zone * (1 + d) ** 2 for mesh in spheres]
    assert abs(errors[2]) < 0.01 * zone
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 4, rtol=0.05)  # error of second order

    R, r = 3.0, 1.0
    errors = []
    for n in (1, 2, 4):
        t = np.linspace(0, 2 * np.pi, 8 * n, endpoint=False)
        mesh = shapes.torus(np.stack([R + r * np.cos(t), r * np.sin(t)], axis=1), 12 * n)
        core = mesh.vertices * [1, 1, 0]
        core *= R / np.linalg.norm(core, axis=1, keepdims=True)
        image = mesh.with_vertices((mesh.vertices - core) / r)
        errors.append(steiner_area(Pair(mesh, image), d) - (4 * np.pi**2 * R * r - 2 * d * (-2 * np.pi**2 * R) + 0))
        assert 4 * np.pi**2 * R * (r + d) == pytest.approx(4 * np.pi**2 * R * r + 4 * np.pi**2 * R * d)
    assert abs(errors[2]) < 0.02 * 4 * np.pi**2 * R * r
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 4, rtol=0.05)


@given(names, seeds, st.floats(-5, 5))
def test_equation_6_proposition_5_steiner(name: str, seed: int, d: float) -> None:
    """Prop. 5, (6): area(M^d) is the sum over the faces of (1 - 2 d H_F + d^2 K_F) area(F), where area(F) > 0."""
    mesh, image = MESHES[name], element(name, seed)
    curvatures = face_curvatures(Pair(mesh, image))
    assert (curvatures.areas > 0).all()
    total = 0.0
    for face, n in enumerate(mesh.face_normals):
        corners = mesh.combinatorics.face(face)
        assert literal_area(mesh.vertices[corners], n) > 0
        total += literal_area((mesh + d * image).vertices[corners], n)
    terms = (1 - 2 * d * curvatures.mean + d**2 * curvatures.gaussian) * curvatures.areas
    assert terms.sum() == pytest.approx(total, abs=mesh.n_faces * ROUNDING)
    assert steiner_area(Pair(mesh, image), d) == pytest.approx(total, abs=mesh.n_faces * ROUNDING)


@given(names, seeds)
def test_equation_7_curvatures_of_faces(name: str, seed: int) -> None:
    """(7): H_F = -area(F, sigma(F)) / area(F), K_F = area(sigma(F)) / area(F); kappa_1,2 solve x^2 - 2 H x + K = 0.

    They exist if and only if H^2 - K >= 0, which holds where F is strictly convex, as all faces are here.
    """
    mesh, image = MESHES[name], element(name, seed)
    curvatures = face_curvatures(Pair(mesh, image))
    for face, n in enumerate(mesh.face_normals):
        corners = mesh.combinatorics.face(face)
        p, q = mesh.vertices[corners], image.vertices[corners]
        H, K = curvatures.mean[face], curvatures.gaussian[face]
        assert pytest.approx(-literal_mixed_area(p, q, n) / literal_area(p, n), abs=ROUNDING) == H
        assert pytest.approx(literal_area(q, n) / literal_area(p, n), abs=ROUNDING) == K
        assert H**2 - K >= -ROUNDING
        first, second = curvatures.principal[face]
        assert first >= second
        assert (first + second) / 2 == pytest.approx(H, abs=ROUNDING)
        assert first * second == pytest.approx(K, abs=ROUNDING)
    assert len(curvatures.without_principal) == 0


@given(seeds)
def test_equation_8_vanishing_mixed_area_of_quads(seed: int) -> None:
    """(8): area(Q, Q*) = 0 for parallel quads if and only if 13 is parallel to 2*4*, and 24 to 1*3*."""
    rng = np.random.default_rng(seed)
    n = np.array([0.0, 0.0, 1.0])
    q = np.zeros((4, 3))
    q[:, :2] = np.array([[0, 0], [3, 0], [3, 3], [0, 3]]) + rng.uniform(-1, 1, (4, 2))
    mesh, e = Mesh.from_faces(q, [range(4)]), np.roll(q, -1, axis=0) - q
    parallel = null_space(e[:, :2].T).T  # the factors (k, 4) of edges that close

    def quad(factors: FloatArray) -> FloatArray:
        steps = factors[:, None] * e
        return np.cumsum(steps, axis=0) - steps

    first, second = (literal_mixed_area(q, quad(factors), n) for factors in parallel)
    dual = quad(parallel[0] * second - parallel[1] * first)
    other = quad(parallel[0] * first + parallel[1] * second)
    for image, vanishes in [(dual, True), (other, False)]:
        area = literal_mixed_area(q, image, n)
        crossed = [np.cross(q[2] - q[0], image[3] - image[1]), np.cross(q[3] - q[1], image[2] - image[0])]
        assert (abs(area) < ROUNDING) == vanishes
        assert (np.abs(crossed).max() < ROUNDING) == vanishes
        (H,) = face_curvatures(Pair(mesh, mesh.with_vertices(image))).mean
        assert pytest.approx(-area / literal_area(q, n), abs=ROUNDING) == H
