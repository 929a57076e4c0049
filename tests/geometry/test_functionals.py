"""Every functional: Jacobians against differences, zeros on known shapes, units, rigid motions, Newton's steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, IntArray
from geometry.errors import MeshError
from geometry.exact_offsets import circularity, conicality
from geometry.functionals.circular_faces import CircularFaces
from geometry.functionals.closeness import close_to
from geometry.functionals.conical_vertices import ConicalVertices, closed_fans
from geometry.functionals.convex_faces import ConvexFaces
from geometry.functionals.fairness import laplacian, strain
from geometry.functionals.gauss_image_terms import (
    close_to_vertex_normals,
    edge_normals,
    edges_at_unit_distance,
    faces_at_unit_distance,
    vertices_at_unit_distance,
)
from geometry.functionals.parallel_edges import ParallelEdges, parallel_to
from geometry.functionals.planar_faces import PlanarFaces
from geometry.mesh import Combinatorics, Mesh, shapes
from geometry.optimise.functional import Functional, LinearFunctional, StackedFunctional
from geometry.optimise.newton import nearest_feasible
from geometry.optimise.solution import Reason
from tests.geometry.bent_meshes import rotation, shaken, with_midpoints

seeds = st.integers(0, 2**32 - 1)
decades = st.floats(-6, 6)


def vase() -> Mesh:
    """Rotational, of both signs of curvature: planar, circular and conical."""
    heights = np.linspace(0, 5, 8)
    return shapes.rotational_mesh(np.stack([2 + np.sin(heights), heights], axis=1), 10)


def planar_not_more() -> Mesh:
    """Planar quads of all curvatures, neither circular nor conical: a sheared vase."""
    return vase().with_vertices(vase().vertices @ [[1.0, 0.3, 0.1], [0.0, 1.0, 0.4], [0.2, 0.0, 1.0]])


MESHES = {
    "vase": vase(),
    "sheared vase": planar_not_more(),
    "flat": shapes.grid(4, 3),
    "octahedron": shapes.octahedron(),
    "icosahedron": shapes.icosahedron(),
    "dodecahedron": shapes.dodecahedron(),
    "prism": shapes.regular_prism(7),
    "midpoints": with_midpoints(vase(), np.arange(vase().n_edges)),
}

ON_MESHES: dict[str, Callable[[Combinatorics], Functional]] = {
    "planarity": PlanarFaces,
    "circularity": CircularFaces,
    "conicality": ConicalVertices,
    "convexity": lambda c: ConvexFaces(c, np.arange(c.n_faces)),
}


def differences(functional: Functional, x: FloatArray, direction: FloatArray, step: float) -> FloatArray:
    ahead, back = (functional.residual(x + sign * step * direction) for sign in (1, -1))
    return (ahead - back) / (2 * step)


def groups(functional: Functional, combinatorics: Combinatorics) -> IntArray:
    """Where residuals of one face or vertex begin: within, a basis is chosen, which may turn."""
    if isinstance(functional, (PlanarFaces, CircularFaces)):
        sizes = np.sort(combinatorics.face_sizes[combinatorics.face_sizes > 3]) - 3
    elif isinstance(functional, ConicalVertices):
        sizes = np.concatenate([np.full(len(f), f.shape[1] - 3) for f in closed_fans(combinatorics) if f.shape[1] > 3])
    else:
        raise AssertionError(functional)
    return np.concatenate([[0], np.cumsum(sizes)[:-1]])


def norms(values: FloatArray, starts: IntArray) -> FloatArray:
    return np.sqrt(np.add.reduceat(values**2, starts)) if len(values) else values


# --- Jacobians


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize(
    "functional", [lambda mesh: ConvexFaces(mesh.combinatorics, np.arange(mesh.n_faces)), lambda mesh: _angles(mesh)]
)
@given(seed=seeds)
@settings(max_examples=8)
def test_jacobians_that_are_exact_at_planar_faces(
    mesh: Mesh, functional: Callable[[Mesh], Functional], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    affine = np.eye(3) + 0.2 * rng.uniform(-1, 1, size=(3, 3))
    x = (mesh.vertices @ affine).ravel()
    direction = rng.normal(size=x.shape)
    asked = functional(mesh)
    # the step squared, and rounding over the step
    np.testing.assert_allclose(
        asked.jacobian(x) @ direction, differences(asked, x, direction, 1e-6), rtol=1e-6, atol=1e-6
    )


def _angles(mesh: Mesh) -> Functional:
    """Conicality of the vertices with four faces, the others cut off."""
    asked = ConicalVertices(mesh.combinatorics)
    n = sum(len(fans) for fans in closed_fans(mesh.combinatorics) if fans.shape[1] == 4)

    class OfFour:
        def residual(self, x: FloatArray) -> FloatArray:
            return asked.residual(x)[:n]

        def jacobian(self, x: FloatArray) -> FloatArray:
            return asked.jacobian(x)[:n]

    return OfFour()  # type: ignore[return-value]


FEASIBLE = [
    *[(PlanarFaces, name) for name in MESHES],
    *[(CircularFaces, name) for name in ("vase", "flat", "dodecahedron", "prism")],
    *[(ConicalVertices, name) for name in ("vase", "flat", "octahedron", "icosahedron")],
]


@pytest.mark.parametrize(("kind", "name"), FEASIBLE)
@given(seed=seeds)
@settings(max_examples=8)
def test_jacobians_are_exact_where_the_residuals_vanish(
    kind: Callable[[Combinatorics], Functional], name: str, seed: int
) -> None:
    mesh = MESHES[name]
    functional, x = kind(mesh.combinatorics), mesh.vertices.ravel()
    direction = np.random.default_rng(seed).normal(size=x.shape)
    assert np.abs(functional.residual(x)).max(initial=0.0) < 1e-14
    starts, step = groups(functional, mesh.combinatorics), 1e-7
    if functional.residual(x).size == 0:
        return  # triangles only
    predicted = norms(functional.jacobian(x) @ direction, starts)
    for sign in (1, -1):
        found = norms(functional.residual(x + sign * step * direction) / step, starts)
        # second derivatives times the step: of curvature 1 / edge length, times lengths of faces and normals that turn
        np.testing.assert_allclose(predicted, found, atol=1e-4)


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(seed=seeds, amount=st.floats(0.01, 0.2))
@settings(max_examples=8)
def test_planarity_gives_the_gradient_of_the_squared_distances_everywhere(mesh: Mesh, seed: int, amount: float) -> None:
    _check_gradient(PlanarFaces(mesh.combinatorics), shaken(mesh, amount, seed), seed, 1e-6)


@pytest.mark.parametrize("name", ["sheared vase", "midpoints", "dodecahedron", "flat"])
@given(seed=seeds)
@settings(max_examples=8)
def test_circularity_gives_the_gradient_at_planar_faces(name: str, seed: int) -> None:
    affine = np.eye(3) + 0.3 * np.random.default_rng(seed).uniform(-1, 1, size=(3, 3))
    mesh = MESHES[name].with_vertices(MESHES[name].vertices @ affine)
    assert np.abs(CircularFaces(mesh.combinatorics).residual(mesh.vertices.ravel())).max() > 1e-3
    _check_gradient(CircularFaces(mesh.combinatorics), mesh, seed, 1e-6)


@pytest.mark.parametrize("name", ["icosahedron", "octahedron"])
@given(seed=seeds, amount=st.floats(1e-4, 1e-2))
@settings(max_examples=8)
def test_conicality_gives_the_gradient_up_to_the_square_of_the_residual(name: str, seed: int, amount: float) -> None:
    mesh = shaken(MESHES[name], amount, seed)
    _check_gradient(ConicalVertices(mesh.combinatorics), mesh, seed, 1e-7 + 20 * amount**2)


def _check_gradient(functional: Functional, mesh: Mesh, seed: int, tolerance: float) -> None:
    x = mesh.vertices.ravel()
    direction = np.random.default_rng(seed).normal(size=x.shape)
    direction /= np.linalg.norm(direction)
    residual, step = functional.residual(x), 1e-5

    def half_square(x: FloatArray) -> float:
        return float(functional.residual(x) @ functional.residual(x)) / 2

    change = (half_square(x + step * direction) - half_square(x - step * direction)) / (2 * step)
    assert residual @ (functional.jacobian(x) @ direction) == pytest.approx(change, abs=tolerance)


@given(seeds, decades)
def test_the_jacobian_of_parallelity_is_exact_everywhere(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    mesh = vase()
    x = 10.0**scale * np.concatenate([shaken(mesh, 0.2, seed).vertices.ravel(), rng.normal(size=3 * mesh.n_vertices)])
    functional, direction = ParallelEdges(mesh.combinatorics), rng.normal(size=x.shape)
    step = 1e-6 * 10.0**scale
    found = differences(functional, x, direction, step)
    np.testing.assert_allclose(functional.jacobian(x) @ direction, found, rtol=1e-6, atol=1e-5)


LINEAR: dict[str, Callable[[Mesh], LinearFunctional]] = {
    "laplacian": lambda mesh: laplacian(mesh.combinatorics),
    "parallel_to": parallel_to,
    "faces_at_unit_distance": faces_at_unit_distance,
    "edges_at_unit_distance": lambda mesh: edges_at_unit_distance(mesh, edge_normals(mesh)),
    "vertices_at_unit_distance": lambda mesh: vertices_at_unit_distance(mesh, mesh.vertex_normals),
    "close_to_vertex_normals": close_to_vertex_normals,
    "close_to": lambda mesh: close_to(mesh.vertices),
}


@pytest.mark.parametrize("make", LINEAR.values(), ids=LINEAR)
@given(seeds)
@settings(max_examples=5)
def test_linear_functionals_are_their_jacobians(make: Callable[[Mesh], LinearFunctional], seed: int) -> None:
    functional, rng = make(vase()), np.random.default_rng(seed)
    x, direction = rng.normal(size=(2, 3 * vase().n_vertices))
    found = differences(functional, x, direction, 1.0)
    np.testing.assert_allclose(functional.jacobian(x) @ direction, found, atol=1e-13)


# --- zeros


@pytest.mark.parametrize("name", ["vase", "flat", "octahedron", "icosahedron", "dodecahedron", "prism"])
def test_known_shapes_are_planar_circular_and_conical(name: str) -> None:
    mesh = MESHES[name]
    for kind in (PlanarFaces, CircularFaces, ConicalVertices):
        assert np.abs(kind(mesh.combinatorics).residual(mesh.vertices.ravel())).max(initial=0.0) < 1e-14


def test_a_residual_for_each_condition() -> None:
    larger = with_midpoints(shapes.dodecahedron(), np.arange(30))  # 12 faces with 10 corners; valences 3 and 2
    c, x = larger.combinatorics, larger.vertices.ravel()
    assert [len(kind(c).residual(x)) for kind in (PlanarFaces, CircularFaces, ConicalVertices)] == [12 * 7, 12 * 7, 0]
    c, x = shapes.icosahedron().combinatorics, shapes.icosahedron().vertices.ravel()
    assert [len(kind(c).residual(x)) for kind in (PlanarFaces, CircularFaces, ConicalVertices)] == [0, 0, 12 * 2]
    c, x = shapes.grid(4, 3).combinatorics, shapes.grid(4, 3).vertices.ravel()
    assert [len(kind(c).residual(x)) for kind in (PlanarFaces, CircularFaces, ConicalVertices)] == [12, 12, 6]
    for kind in (PlanarFaces, CircularFaces, ConicalVertices):
        assert kind(c).jacobian(x).shape == (len(kind(c).residual(x)), len(x))


@given(seeds, st.integers(4, 9), st.floats(1e-9, 1e-2), st.floats(0.2, 2 * np.pi))
def test_circularity_is_the_distance_from_the_circle(seed: int, k: int, off: float, spread: float) -> None:
    # corners of a regular polygon; one goes out by `off`: least squares leave 1 - 3/k of that, to second order
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi / k * np.arange(k)
    corners = np.stack([np.cos(angles), np.sin(angles), np.zeros(k)], axis=1)
    corners[0] *= 1 + off
    mesh = Mesh.from_faces(corners @ rotation(seed) + rng.normal(size=3), [list(range(k))])
    residual = CircularFaces(mesh.combinatorics).residual(mesh.vertices.ravel())
    assert residual.shape == (k - 3,)
    assert np.linalg.norm(residual) == pytest.approx(off * (1 - 3 / k) ** 0.5, rel=3 * off + 1e-6)
    # and corners anywhere on a circle leave nothing
    angles = np.sort(rng.uniform(0, spread, size=k))
    corners = np.stack([np.cos(angles), np.sin(angles), np.zeros(k)], axis=1)
    on_circle = Mesh.from_faces(corners @ rotation(seed), [list(range(k))])
    assert np.abs(CircularFaces(on_circle.combinatorics).residual(on_circle.vertices.ravel())).max() < 1e-13


@given(seeds, st.integers(4, 8), st.floats(0, 1e-2))
def test_collinear_corners_make_no_false_zeros(seed: int, k: int, bend: float) -> None:
    # three corners nearly on a line, the others anywhere on a circle that the middle one is not on
    rng = np.random.default_rng(seed)
    around = np.sort(rng.uniform(0.8, 5.4, size=k - 3))
    circle = np.stack([np.cos(around), np.sin(around), np.zeros(k - 3)], axis=1)
    line = [[np.cos(0.5), -np.sin(0.5), 0], [np.cos(0.5) + bend, 0, 0], [np.cos(0.5), np.sin(0.5), 0]]
    mesh = Mesh.from_faces(np.concatenate([line, circle]), [list(range(k))])
    residual = CircularFaces(mesh.combinatorics).residual(mesh.vertices.ravel())
    assert np.linalg.norm(residual) > 0.3 * circularity(mesh)[0] > 0
    assert circularity(mesh)[0] > 1e-3 or k > 4
    assert np.linalg.norm(residual) > 1e-3


# --- convexity


def test_convexity_says_which_corner_turns_backwards() -> None:
    dart = Mesh.from_faces([[0, 0, 0], [2, -1, 0], [1, 0, 0], [2, 1, 0], [4, 0, 0]], [[0, 1, 2, 3], [1, 4, 3, 2]])
    turns = ConvexFaces(dart.combinatorics, np.array([0])).residual(dart.vertices.ravel())
    # (-1, 1) then (1, 1): a x b = -2 over the mean length sqrt(2)
    assert turns[2] == pytest.approx(-(2**0.5))
    assert (turns[[0, 1, 3]] > 0).all()
    both = ConvexFaces(dart.combinatorics, np.array([1, 0])).residual(dart.vertices.ravel())
    assert (both[:4] > 0).all()
    np.testing.assert_array_equal(both[4:], turns)
    assert ConvexFaces(dart.combinatorics, np.zeros(0)).jacobian(dart.vertices.ravel()).shape == (0, 15)


@pytest.mark.parametrize("name", MESHES)
def test_faces_of_known_shapes_are_convex(name: str) -> None:
    mesh = MESHES[name]
    turns = ConvexFaces(mesh.combinatorics, np.arange(mesh.n_faces)).residual(mesh.vertices.ravel())
    assert turns.min() > -1e-15
    if name == "midpoints":
        assert np.sort(np.abs(turns))[mesh.combinatorics.n_corners // 2 - 1] < 1e-15  # straight corners
        assert np.sort(np.abs(turns))[mesh.combinatorics.n_corners // 2] > 0.1
    else:
        assert turns.min() > 0.1


@pytest.mark.parametrize("face", [-1, 12])
def test_faces_that_do_not_exist_are_refused(face: int) -> None:
    with pytest.raises(MeshError, match=f"there is no face {face} to keep convex: the faces end at 11"):
        ConvexFaces(shapes.dodecahedron().combinatorics, np.array([3, face]))


# --- parallelity


@given(seeds)
def test_parallelity_is_that_of_parallel_to(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh, other = shaken(vase(), 0.1, seed), rng.normal(size=vase().vertices.shape)
    x = np.concatenate([mesh.vertices.ravel(), other.ravel()])
    both = ParallelEdges(mesh.combinatorics).residual(x).reshape(-1, 3)
    one = parallel_to(mesh).residual(other.ravel()).reshape(-1, 2)
    np.testing.assert_allclose(np.linalg.norm(both, axis=1), np.linalg.norm(one, axis=1), atol=1e-14)
    np.testing.assert_allclose(np.einsum("ei,ei->e", both, mesh.edge_vectors), 0.0, atol=1e-13)
    scaled = np.concatenate([mesh.vertices.ravel(), 3.0 * mesh.vertices.ravel() + 1])
    np.testing.assert_allclose(ParallelEdges(mesh.combinatorics).residual(scaled), 0.0, atol=1e-14)


# --- units and place


@pytest.mark.parametrize(("kind", "power"), [("planarity", 1), ("circularity", 1), ("conicality", 0), ("convexity", 1)])
@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(seed=seeds, scale=decades)
@settings(max_examples=5)
def test_rigid_motions_and_scale(kind: str, power: int, mesh: Mesh, seed: int, scale: float) -> None:
    functional, bent = ON_MESHES[kind](mesh.combinatorics), shaken(mesh, 0.05, seed)
    shift = np.random.default_rng(seed).normal(size=3)
    moved = (bent.vertices @ rotation(seed) + shift) * 10.0**scale
    before, after = functional.residual(bent.vertices.ravel()), functional.residual(moved.ravel())
    if kind != "convexity" and len(before):
        starts = groups(functional, mesh.combinatorics)
        before, after = norms(before, starts), norms(after, starts)
    # rounding of coordinates, magnified where a flat vertex has normals that hardly differ
    np.testing.assert_allclose(after / 10.0 ** (power * scale), before, atol=1e-11)


@given(seeds, decades)
@settings(max_examples=10)
def test_fairness_and_parallelity_do_not_see_place_nor_attitude(seed: int, scale: float) -> None:
    mesh, turn = shaken(vase(), 0.1, seed), rotation(seed)
    moved = mesh.with_vertices((mesh.vertices @ turn + 1.0) * 10.0**scale)
    other = np.random.default_rng(seed).normal(size=mesh.vertices.shape)

    def lengths(functional: LinearFunctional, positions: FloatArray, rows: int) -> FloatArray:
        return np.asarray(np.linalg.norm(functional.residual(positions.ravel()).reshape(-1, rows), axis=1))

    fair = laplacian(mesh.combinatorics)
    np.testing.assert_allclose(
        lengths(fair, moved.vertices, 3) / 10.0**scale, lengths(fair, mesh.vertices, 3), atol=1e-13
    )
    np.testing.assert_allclose(
        lengths(parallel_to(moved), other @ turn, 2), lengths(parallel_to(mesh), other, 2), atol=1e-11
    )
    np.testing.assert_allclose(
        lengths(faces_at_unit_distance(moved), other @ turn, 1),
        lengths(faces_at_unit_distance(mesh), other, 1),
        atol=1e-11,
    )
    for name in ("edges_at_unit_distance", "vertices_at_unit_distance"):
        np.testing.assert_allclose(
            lengths(LINEAR[name](moved), other @ turn, 1), lengths(LINEAR[name](mesh), other, 1), atol=1e-11
        )
    np.testing.assert_allclose(
        lengths(close_to_vertex_normals(moved), other @ turn, 3),
        lengths(close_to_vertex_normals(mesh), other, 3),
        atol=1e-11,
    )


@given(seeds)
@settings(max_examples=10)
def test_strain_is_that_of_the_edges(seed: int) -> None:
    mesh = shaken(vase(), 0.2, seed)
    move = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    i, j = mesh.combinatorics.edges.T
    relative = np.linalg.norm(move[i] - move[j], axis=1) * mesh.mean_edge_length / mesh.edge_lengths
    assert move.ravel() @ (strain(mesh) @ move.ravel()) == pytest.approx(relative @ relative)
    assert strain(mesh) @ np.ones(3 * mesh.n_vertices) == pytest.approx(0, abs=1e-12)


# --- in a solver


@pytest.mark.parametrize("kind", [CircularFaces, ConicalVertices])
@pytest.mark.parametrize("amount", [1e-3, 0.02, 0.05])
def test_newtons_method_makes_meshes_circular_and_conical_quadratically(
    kind: Callable[[Combinatorics], Functional], amount: float
) -> None:
    bent = shaken(vase(), amount, 0)
    start = (bent.vertices / bent.mean_edge_length).ravel()
    constraint = StackedFunctional([PlanarFaces(bent.combinatorics), kind(bent.combinatorics)])
    metric = csr_array(eye_array(len(start)) + 0.3 * strain(bent))
    solution = nearest_feasible(
        constraint, start, metric, tolerance=1e-12, longest_step=0.5, anchored_steps=0, max_steps=7
    )
    assert solution.reason is Reason.CONVERGED
    result = bent.with_vertices(solution.x.reshape(-1, 3))
    assert result.planarity.max() < 1e-12
    deviation = circularity(result) if kind is CircularFaces else conicality(result)
    assert np.nanmax(deviation) < 1e-12
    moves = np.linalg.norm((solution.x - start).reshape(-1, 3), axis=1)
    assert moves.max() < 2 * 3**0.5 * amount  # a mesh as asked for lies within sqrt(3) times the amount
