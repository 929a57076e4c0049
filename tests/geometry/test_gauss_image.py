"""The Gauss image: parallel, near the unit sphere, least among all parallel meshes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError
from geometry.functionals.boundary_normals import extrapolated_normals
from geometry.gauss import Pair
from geometry.gauss.approximate_gauss_image import approximate_pair, refuse_triangle_mesh
from geometry.gauss.distances import vertex_distances
from geometry.mesh import Mesh, shapes
from geometry.parallel.edge_parallelity import parallelity

PARALLEL = 1e-13
seeds = st.integers(0, 2**32 - 1)
weights = st.tuples(st.floats(0, 2), st.floats(0, 2), st.floats(0.01, 2), st.floats(0, 2))


def vault(seed: int = 0, nx: int = 6, ny: int = 5) -> Mesh:
    """Parallelograms over a dome, no two alike, made unlike by a projective map."""
    rng = np.random.default_rng(seed)
    u, v = (np.cumsum(rng.uniform(0.7, 1.3, size=n + 1)) for n in (nx, ny))
    u, v = u - u.mean(), v - v.mean()
    first = np.stack([u, 0.1 * u, -0.06 * u**2], axis=1)
    second = np.stack([0 * v, v, -0.05 * v**2 + 0.003 * v**3], axis=1)
    mesh = shapes.translation_surface(first, second)
    divisor = 1 + 0.02 * mesh.vertices[:, :1] + 0.01 * mesh.vertices[:, 1:2]
    return mesh.with_vertices(mesh.vertices / divisor)


def saddle() -> Mesh:
    u = np.linspace(-2, 2, 7)
    zero = np.zeros(7)
    return shapes.translation_surface(
        np.stack([u, zero, 0.2 * u**2], axis=1), np.stack([0.2 * u, u, -0.15 * u**2], axis=1)
    )


def rotation(seed: int) -> FloatArray:
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return q * np.linalg.det(q)


def objective(mesh: Mesh, image: Mesh, faces: float, edges: float, vertices: float, fairness: float) -> float:
    """The functional of [Pottmann2007, 4.2], face by face and vertex by vertex, and that of the edges."""
    c = mesh.combinatorics
    s, at_vertices = image.vertices, extrapolated_normals(mesh)
    total = 0.0
    for face in range(c.n_faces):
        total += faces * float(mesh.face_normals[face] @ s[c.face(face)[0]] - 1) ** 2
    for edge in range(c.n_edges):
        normals = [mesh.face_normals[face] for face in c.edge_faces[edge] if face >= 0]
        middle = sum(normals, start=np.zeros(3)) / len(normals)
        total += edges * float(middle @ s[c.edges[edge, 0]] / np.linalg.norm(middle) - 1) ** 2
    for vertex in range(c.n_vertices):
        neighbours = c.adjacency[[vertex]].indices
        total += vertices * float(((s[vertex] - at_vertices[vertex]) ** 2).sum())
        total += fairness * float(((s[vertex] - s[neighbours].mean(axis=0)) ** 2).sum())
    return total


MESHES = {
    "vault": vault(),
    "saddle": saddle(),
    "annulus": shapes.dome(11, 5),
    "closed": shapes.regular_prism(6),
    "pentagons": shapes.dodecahedron(),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(given_weights=weights, rounds=st.integers(1, 3))
@settings(deadline=None, max_examples=20)
def test_it_is_parallel(mesh: Mesh, given_weights: tuple[float, float, float, float], rounds: int) -> None:
    faces, edges, vertices, fairness = given_weights
    image = approximate_pair(
        mesh, faces=faces, edges=edges, vertices=vertices, fairness=fairness, rounds=rounds
    ).gauss_image
    assert image.combinatorics is mesh.combinatorics
    assert parallelity(mesh, image).max() <= (PARALLEL if rounds == 1 else 1e-11)  # the bound for these


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(given_weights=weights, seed=seeds)
@settings(deadline=None, max_examples=10)
def test_no_parallel_mesh_does_better(mesh: Mesh, given_weights: tuple[float, float, float, float], seed: int) -> None:
    faces, edges, vertices, fairness = given_weights
    image = approximate_pair(mesh, faces=faces, edges=edges, vertices=vertices, fairness=fairness).gauss_image
    least = objective(mesh, image, *given_weights)
    rng = np.random.default_rng(seed)
    others = [
        mesh,
        image,
        approximate_pair(mesh, vertices=1.0).gauss_image,
        approximate_pair(mesh, fairness=5.0).gauss_image,
    ]
    direction = sum((other * rng.normal() for other in others[1:]), start=others[0] * rng.normal())
    direction = direction.with_vertices(direction.vertices + rng.normal(size=3))
    for step in (1e-2, -1e-2):
        assert objective(mesh, image + direction * step, *given_weights) >= least - 1e-9  # flat to first order


@pytest.mark.parametrize(
    ("mesh", "in_radius"),
    [(shapes.cube(), 1.0), (shapes.dodecahedron(), ((25 + 11 * 5**0.5) / 10) ** 0.5 * 2 / (1 + 5**0.5))],
    ids=["cube", "dodecahedron"],
)
def test_regular_solids_become_the_copy_that_touches_the_sphere(mesh: Mesh, in_radius: float) -> None:
    image = approximate_pair(
        mesh, vertices=1e-7
    ).gauss_image  # all but the faces alone; the vertices pull by the order of their weight
    np.testing.assert_allclose(image.vertices, mesh.vertices / in_radius, atol=1e-6)
    np.testing.assert_allclose(Pair(mesh, image).face_distances, 1.0, atol=1e-6)


@given(st.integers(3, 12), seeds)
@settings(deadline=None, max_examples=20)
def test_a_conical_mesh_has_a_face_offset(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    latitudes = np.cumsum(rng.uniform(0.1, 0.2, size=6))
    profile = np.stack([np.cos(latitudes), np.sin(latitudes)], axis=1) * [3.0, 2.0]
    mesh = shapes.rotational_mesh(profile, n)
    pair = approximate_pair(mesh, vertices=1e-6)
    # the vertices pull by their weight times how far they are from their normals, some 10 on a prism
    np.testing.assert_allclose(pair.face_distances, 1.0, atol=1e-4)


@given(seeds, st.floats(-3, 3), st.tuples(*[st.floats(-20, 20)] * 3))
@settings(deadline=None, max_examples=20)
def test_size_and_place_do_not_matter_and_attitude_turns_with_it(
    seed: int, decades: float, shift: tuple[float, float, float]
) -> None:
    mesh, turn = vault(), rotation(seed)
    moved = mesh.with_vertices((mesh.vertices @ turn + shift) * 10.0**decades)
    # the penalty of 1e7 times rounding
    np.testing.assert_allclose(
        approximate_pair(moved).gauss_image.vertices, approximate_pair(mesh).gauss_image.vertices @ turn, atol=1e-7
    )


def test_the_other_side_has_the_opposite_image() -> None:
    mesh = vault()
    np.testing.assert_allclose(
        approximate_pair(mesh.reversed()).gauss_image.vertices, -approximate_pair(mesh).gauss_image.vertices, atol=1e-8
    )


def test_parts_do_not_influence_each_other() -> None:
    one, other = vault(), shapes.regular_prism(5)
    faces = [face.tolist() for face in one.combinatorics.faces] + [
        [v + one.n_vertices for v in f] for f in other.combinatorics.faces
    ]
    both = approximate_pair(
        Mesh.from_faces(np.concatenate([one.vertices, other.vertices + 20]), faces)
    ).gauss_image.vertices
    np.testing.assert_allclose(both[: one.n_vertices], approximate_pair(one).gauss_image.vertices, atol=1e-7)
    np.testing.assert_allclose(both[one.n_vertices :], approximate_pair(other).gauss_image.vertices, atol=1e-7)


def test_vertices_without_faces_stay_at_the_origin() -> None:
    mesh = vault()
    more = Mesh.from_faces(np.concatenate([mesh.vertices, [[9.0, 9.0, 9.0]]]), mesh.combinatorics.faces)
    image = approximate_pair(more, fairness=0.1).gauss_image
    np.testing.assert_allclose(image.vertices[-1], 0, atol=1e-15)
    np.testing.assert_allclose(
        image.vertices[:-1], approximate_pair(mesh, fairness=0.1).gauss_image.vertices, atol=1e-7
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_finer_dome_is_nearer_to_the_sphere(seed: int) -> None:
    mesh = vault(seed, 12, 10)
    pair = approximate_pair(mesh)
    assert np.ptp(pair.edge_distances) < 0.1
    assert np.abs(pair.vertex_distances - 1).max() < 0.1


def test_some_triangles_are_welcome_and_triangles_only_are_not() -> None:
    roof = Mesh.from_faces(
        np.concatenate([shapes.cube().vertices, [[0.0, 0.0, 2.0]]]),
        [f for f in shapes.cube().combinatorics.faces if set(f) != {1, 3, 5, 7}]
        + [[*pair, 8] for pair in zip((1, 5, 7, 3), (5, 7, 3, 1), strict=True)],
    )
    assert set(roof.combinatorics.face_sizes.tolist()) == {3, 4}
    assert parallelity(roof, approximate_pair(roof).gauss_image).max() <= PARALLEL
    refuse_triangle_mesh(roof)
    with pytest.raises(GeometryError, match="only scaled copies of it"):
        approximate_pair(shapes.icosahedron())


# --- rounds


def deviation(mesh: Mesh, image: Mesh, faces: float, edges: float, vertices: float, fairness: float) -> float:
    """What rounds lower: squared deviations of the distances from 1."""
    total = faces * np.square(Pair(mesh, image).face_distances - 1).sum()
    total += edges * np.square(Pair(mesh, image).edge_distances - 1).sum()
    total += vertices * np.square(vertex_distances(image) - 1).sum()
    c = mesh.combinatorics
    means = c.adjacency @ image.vertices / c.vertex_degrees[:, None]
    return float(total + fairness * np.square(image.vertices - means).sum())


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(given_weights=weights)
@settings(deadline=None, max_examples=5)
def test_rounds_lower_the_deviation_of_the_distances(
    mesh: Mesh, given_weights: tuple[float, float, float, float]
) -> None:
    faces, edges, vertices, fairness = given_weights
    values = []
    for rounds in (1, 2, 4, 60):
        image = approximate_pair(
            mesh, faces=faces, edges=edges, vertices=vertices, fairness=fairness, rounds=rounds
        ).gauss_image
        values.append(deviation(mesh, image, *given_weights))
    assert all(later <= earlier * (1 + 1e-9) + 1e-25 for earlier, later in pairwise(values))
    # at the end, to first order, no parallel mesh is better
    rng = np.random.default_rng(0)
    direction = approximate_pair(mesh, vertices=1.0).gauss_image * rng.normal() + mesh * rng.normal()
    direction = direction.translated(rng.normal(size=3)) * (1 / np.abs(direction.vertices).max())
    there, back = (deviation(mesh, image + direction * step, *given_weights) for step in (1e-5, -1e-5))
    slope = (there - back) / 2e-5
    assert abs(slope) <= 1e-2 * (1 + sum(given_weights))  # after the first round up to 1 for a unit of weight


@pytest.mark.parametrize("mesh", [MESHES["pentagons"], MESHES["closed"], shapes.box(3, 4, 5)])
def test_one_kind_of_distance_comes_to_1_where_it_can(mesh: Mesh) -> None:
    pair = approximate_pair(mesh, faces=0, edges=1, vertices=0, rounds=30)
    np.testing.assert_allclose(pair.edge_distances, 1, atol=1e-12)
    vertices = approximate_pair(mesh, faces=0, vertices=1, rounds=30).gauss_image
    np.testing.assert_allclose(vertex_distances(vertices), 1, atol=1e-12)
    faces = approximate_pair(mesh, vertices=0, rounds=30).gauss_image
    np.testing.assert_allclose(Pair(mesh, faces).face_distances, 1, atol=1e-12)


def test_edges_folded_flat_are_left_out() -> None:
    grid = shapes.grid(2, 2)
    folded = grid.with_vertices(np.abs(grid.vertices - [1.0, 0, 0]))
    image = approximate_pair(folded, edges=1.0).gauss_image
    assert np.isfinite(image.vertices).all()


# --- what cannot be done is said


def test_faces_that_are_not_planar_are_refused() -> None:
    mesh = vault()
    vertices = mesh.vertices.copy()
    vertices[0, 2] += 1e-6 * mesh.mean_edge_length
    with pytest.raises(
        GeometryError, match=r"face 0 is off its plane by .*e-07 of .* allowed 1e-12; planarise"
    ) as raised:
        approximate_pair(mesh.with_vertices(vertices))
    assert raised.value.elements == (0,)
    assert raised.value.bound == 1e-12


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"faces": -1.0}, "the weight faces is -1"),
        ({"fairness": float("nan")}, "the weight fairness is nan"),
        ({"vertices": float("inf")}, "the weight vertices is inf"),
        ({"vertices": 0.0}, "faces alone do not determine the Gauss image at the boundary"),
        ({"faces": 0.0, "vertices": 0.0, "fairness": 1.0}, "nor fairness its position"),
        ({"faces": 0.0, "vertices": 0.0}, "the weight vertices is 0"),
        ({"edges": -1.0}, "the weight edges is -1"),
        ({"vertices": 1e-9, "edges": 2.0, "faces": 0.0}, "at least 1e-08 of the largest weight"),
        ({"rounds": 0}, "the number of rounds is 0"),
        ({"faces": 0.0, "vertices": 0.0, "fairness": 1.0, "rounds": 3}, "the weight vertices is 0"),
    ],
)
def test_weights_that_determine_nothing_are_refused(wrong: dict[str, float], says: str) -> None:
    with pytest.raises(GeometryError, match=says):
        approximate_pair(vault(), **wrong)


def test_an_edge_without_length_is_refused() -> None:
    mesh = shapes.grid(2, 2)
    vertices = mesh.vertices.copy()
    vertices[0] = vertices[1]
    with pytest.raises(MeshError, match="has no length"):
        approximate_pair(mesh.with_vertices(vertices))
