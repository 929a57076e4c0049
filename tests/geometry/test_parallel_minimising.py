"""Minimising over P(M) against dense linear algebra in the basis, closed forms and the conditions of a minimum."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, RankError
from geometry.functionals.fairness import laplacian
from geometry.functionals.gauss_image_terms import close_to_vertex_normals, faces_at_unit_distance
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.optimise.functional import LinearFunctional, normal_equations
from geometry.optimise.solution import ConvergenceError, Reason, Solution
from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from geometry.parallel.spectrum import null_dimension

seeds = st.integers(0, 2**32 - 1)


def bent(mesh: Mesh, strength: float = 0.1) -> Mesh:
    """A projective image: its faces are planar, but parallels are gone."""
    away = strength * np.array([1.0, 0.7, 0.4]) / np.linalg.norm(mesh.vertices, axis=1).max()
    return mesh.with_vertices(mesh.vertices / (1 + mesh.vertices @ away)[:, None])


DISC = bent(shapes.rotational_mesh(np.stack([np.linspace(1, 0.5, 6), np.linspace(0, 1.5, 6)], axis=1), 7, closed=False))
HEXAGONS = bent(shapes.hexagonal_paraboloid(3, 4) * 0.2)
TORUS = bent(shapes.torus(np.array([[2.0, -1.0], [3.5, -0.5], [3.0, 1.0], [2.2, 0.8]]), 6))
meshes = st.sampled_from([DISC, HEXAGONS, TORUS])


def close_to(points: FloatArray) -> LinearFunctional:
    return LinearFunctional(csr_array(eye_array(points.size)), points.ravel())


def by_basis(mesh: Mesh, H: Any, g: FloatArray, fixed: dict[int, FloatArray]) -> FloatArray:
    """x H x / 2 - g x is least, in the basis of P(M), by a dense basis of what leaves the fixed vertices."""
    basis = ParallelSpace(mesh).basis
    rows = basis.reshape(len(basis), -1)
    held = basis[:, list(fixed)].reshape(len(basis), -1).T
    wanted = np.array(list(fixed.values())).ravel()
    start = np.linalg.lstsq(held, wanted)[0] if fixed else np.zeros(len(basis))
    free = np.linalg.svd(held)[2][len(wanted) :].T
    reduced = free.T @ (rows @ (H @ rows.T)) @ free
    step = np.linalg.solve(reduced, free.T @ (rows @ (g - H @ (rows.T @ start))))
    return np.asarray(((start + free @ step) @ rows).reshape(-1, 3))


@given(meshes, seeds, st.integers(0, 2), st.booleans())
@settings(max_examples=30)
def test_the_minimum_is_that_in_the_basis(mesh: Mesh, seed: int, n_fixed: int, with_linear: bool) -> None:
    rng = np.random.default_rng(seed)
    terms = [(1.0, laplacian(mesh.combinatorics)), (0.01, close_to(rng.normal(size=mesh.vertices.shape)))]
    linear = 0.1 * rng.normal(size=mesh.vertices.shape) if with_linear else None
    n_fixed = min(n_fixed, 1 if mesh is TORUS else 2)  # all that is parallel to the torus is scaled and moved copies
    ends = rng.permutation([0, mesh.n_vertices - 1])[:n_fixed].tolist()
    fixed = {vertex: mesh.vertices[vertex] + rng.normal(size=3) for vertex in ends}
    found = ParallelSpace(mesh).minimise(terms, linear=linear, fixed=fixed)
    H, g = normal_equations(terms)
    expected = by_basis(mesh, H, g if linear is None else g - linear.ravel() / 2, fixed)
    size = np.abs(expected).max()
    np.testing.assert_allclose(found.vertices, expected, atol=1e-8 * size)  # rounding over the least curvature, 1e-4
    assert parallelity(mesh, found).max() <= 1e-12 * size
    for vertex, position in fixed.items():
        np.testing.assert_allclose(found.vertices[vertex], position, atol=1e-12 * size)


@given(st.sampled_from([DISC, HEXAGONS]), seeds)
@settings(max_examples=15)
def test_fair_members_through_fixed_vertices(mesh: Mesh, seed: int) -> None:
    rng = np.random.default_rng(seed)
    fixed = {v: mesh.vertices[v] + 0.3 * rng.normal(size=3) for v in (0, mesh.n_vertices - 1)}
    L = laplacian(mesh.combinatorics)
    found = ParallelSpace(mesh).minimise([(3.0, L)], fixed=fixed)
    H, g = normal_equations([(1.0, L)])
    expected = by_basis(mesh, H, g, fixed)
    np.testing.assert_allclose(found.vertices, expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("mesh", [DISC, HEXAGONS, TORUS])
def test_the_gauss_image_is_such_a_minimum(mesh: Mesh) -> None:
    terms = [(1.0, faces_at_unit_distance(mesh)), (0.1, close_to_vertex_normals(mesh))]
    found = ParallelSpace(mesh).minimise(terms)
    np.testing.assert_allclose(found.vertices, approximate_pair(mesh).gauss_image.vertices, atol=1e-9)


@pytest.mark.parametrize("mesh", [DISC, HEXAGONS, TORUS])
def test_what_is_left_open_stays_as_it_is_in_the_mesh(mesh: Mesh) -> None:
    # fairness alone: a mesh that has shrunk to a point is the fairest; which point is left open
    far = mesh.with_vertices(mesh.vertices + np.array([5.0, -7.0, 11.0]))
    found = ParallelSpace(far).minimise([(1.0, laplacian(mesh.combinatorics))])
    np.testing.assert_allclose(
        found.vertices, np.broadcast_to(far.vertices.mean(axis=0), (mesh.n_vertices, 3)), atol=1e-5
    )
    about_origin = mesh.with_vertices(mesh.vertices - mesh.vertices.mean(axis=0))
    found = ParallelSpace(about_origin).minimise([(1.0, laplacian(mesh.combinatorics))])
    np.testing.assert_allclose(found.vertices, 0, atol=1e-5)
    # one vertex wanted elsewhere: the nearest element that has it there is M moved, as far as that is the shortest way
    wanted = far.vertices[2] + [0.1, 0.2, 0.3]
    rows = csr_array((np.ones(3), ([0, 1, 2], [6, 7, 8])), shape=(3, 3 * mesh.n_vertices))
    found = ParallelSpace(far).minimise([(1.0, LinearFunctional(rows, wanted))])
    np.testing.assert_allclose(found.vertices[2], wanted, atol=1e-10)
    basis = ParallelSpace(far).basis
    nearest = np.linalg.lstsq(basis[:, 2].T, wanted - far.vertices[2])[0]  # the shortest coefficients
    np.testing.assert_allclose(found.vertices - far.vertices, np.einsum("k,kni->ni", nearest, basis), atol=1e-8)


def test_scaling_and_moving_everything_scales_and_moves_the_minimum() -> None:
    rng = np.random.default_rng(0)
    points = DISC.vertices + 0.2 * rng.normal(size=DISC.vertices.shape)
    shift = np.array([10.0, 20.0, -5.0])
    found = ParallelSpace(DISC).minimise([(1.0, close_to(points))], fixed={3: points[3]})
    moved = DISC.with_vertices(1e3 * DISC.vertices + shift)
    again = ParallelSpace(moved).minimise([(1.0, close_to(1e3 * points + shift))], fixed={3: 1e3 * points[3] + shift})
    np.testing.assert_allclose(again.vertices, 1e3 * found.vertices + shift, atol=1e-8)


# --- bounds of edge factors


def conditions_of_a_minimum(
    mesh: Mesh, found: Mesh, gradient: FloatArray, lower: FloatArray, upper: FloatArray
) -> float:
    """How far the gradient in P(M) is from being held by the bounds that are met: a non-negative least squares fit,
    as a linear programme, over the largest entry of the gradient, which mostly is held by the edges of M."""
    basis = ParallelSpace(mesh).basis
    factors = edge_factors(mesh, found)
    change = np.stack([edge_factors(mesh, mesh.with_vertices(element)) for element in basis])
    held_below, held_above = factors < lower + 1e-7, factors > upper - 1e-7
    pushes = np.concatenate([change[:, held_below], -change[:, held_above]], axis=1)
    along = basis.reshape(len(basis), -1) @ gradient.ravel()
    size = np.abs(gradient).max()
    n, k = pushes.shape
    # least t with |along - pushes y| <= t and y >= 0
    rows = np.block([[-pushes, -np.ones((n, 1))], [pushes, -np.ones((n, 1))]])
    fit = linprog(np.append(np.zeros(k), 1.0), A_ub=rows, b_ub=np.concatenate([-along, along]) / size)
    return float(fit.fun)


@given(meshes, seeds, st.floats(0.0, 0.5), st.floats(1.0, 2.0))
@settings(max_examples=12)
def test_bounds_hold_and_the_minimum_is_one(mesh: Mesh, seed: int, low: float, high: float) -> None:
    rng = np.random.default_rng(seed)
    points = 2.0 * mesh.vertices + 0.5 * rng.normal(size=mesh.vertices.shape)
    terms = [(1.0, close_to(points)), (0.5, laplacian(mesh.combinatorics))]
    found = ParallelSpace(mesh).minimise(terms, factor_bounds=(low, high))
    factors = edge_factors(mesh, found)
    room = 1e-9 * np.abs(found.vertices).max() / mesh.edge_lengths.min()
    assert low - room <= factors.min() <= factors.max() <= high + room
    assert parallelity(mesh, found).max() <= 1e-12 * np.abs(found.vertices).max()
    H, g = normal_equations(terms)
    gradient = H @ found.vertices.ravel() - g
    assert (
        conditions_of_a_minimum(mesh, found, gradient, np.full(mesh.n_edges, low), np.full(mesh.n_edges, high)) < 1e-6
    )


def test_wide_bounds_change_nothing() -> None:
    terms = [(1.0, close_to(np.random.default_rng(0).normal(size=DISC.vertices.shape)))]
    free = ParallelSpace(DISC).minimise(terms, fixed={0: DISC.vertices[0]})
    bounded = ParallelSpace(DISC).minimise(terms, fixed={0: DISC.vertices[0]}, factor_bounds=(-1e3, np.inf))
    np.testing.assert_allclose(bounded.vertices, free.vertices, atol=1e-9)


def test_signs_may_differ_from_edge_to_edge() -> None:
    """As in [Pottmann2007, Fig. 11]: the fairest element of P(S) with the signs of one that is known."""
    parallel = ParallelSpace(DISC)
    known = parallel.elements(1, seed=5)[0] * 20.0
    signs = np.sign(edge_factors(DISC, known))
    assert 5 < (signs < 0).sum() < DISC.n_edges - 5
    bounds = np.where(signs > 0, 0.05, -np.inf), np.where(signs > 0, np.inf, -0.05)
    found = parallel.minimise([(1.0, laplacian(DISC.combinatorics))], factor_bounds=bounds)
    factors = edge_factors(DISC, found)
    np.testing.assert_array_equal(np.sign(factors), signs)
    assert np.abs(factors).min() >= 0.05 - 1e-8
    fairness = [float((laplacian(DISC.combinatorics).residual(m.vertices.ravel()) ** 2).sum()) for m in (found, known)]
    scaled = known * (0.05 / np.abs(edge_factors(DISC, known)).min())  # it too keeps the bounds
    assert fairness[0] < float((laplacian(DISC.combinatorics).residual(scaled.vertices.ravel()) ** 2).sum())


def test_equal_bounds_are_equations() -> None:
    lower = np.full(DISC.n_edges, -np.inf)
    upper = np.full(DISC.n_edges, np.inf)
    lower[[4, 17]] = upper[[4, 17]] = 1.5, -0.25
    found = ParallelSpace(DISC).minimise([(1.0, close_to(DISC.vertices))], factor_bounds=(lower, upper))
    np.testing.assert_allclose(edge_factors(DISC, found)[[4, 17]], [1.5, -0.25], atol=1e-9)


def test_something_linear_within_bounds() -> None:
    """The largest extent along z of a box with edges up to twice as long: a linear programme."""
    box = shapes.box(1, 2, 3)
    found = ParallelSpace(box).minimise(
        linear=-box.vertices * [0, 0, 1], fixed={0: box.vertices[0]}, factor_bounds=(0.5, 2.0)
    )
    factors = edge_factors(box, found)
    np.testing.assert_allclose(factors[np.abs(box.edge_vectors[:, 2]) > 0], 2.0, atol=1e-9)


# --- what is refused


def test_fixed_vertices_that_contradict_each_other_are_named() -> None:
    i, j = DISC.combinatorics.edges[0].tolist()
    turned = DISC.vertices[j] + np.cross(DISC.edge_vectors[0], [0, 0, 0.01])
    with pytest.raises(GeometryError, match=r"the fixed vertices contradict each other.*vertex") as caught:
        ParallelSpace(DISC).minimise([(1.0, close_to(DISC.vertices))], fixed={i: DISC.vertices[i], j: turned})
    assert set(caught.value.elements) == {i, j}


def test_a_minimum_that_is_not_reached_is_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = Solution(np.zeros(1), np.zeros(0), 0.0, 17, Reason.STALLED)
    monkeypatch.setattr("geometry.parallel.minimising.minimise_bounded", lambda *_, **__: stopped)
    with pytest.raises(
        ConvergenceError, match="after 17 steps the solver stopped because no step makes progress"
    ) as caught:
        ParallelSpace(DISC).minimise([(1.0, close_to(DISC.vertices))], factor_bounds=(0.5, 2.0))
    assert caught.value.solution is stopped


@pytest.mark.parametrize("bounds", [None, (0.0, np.inf)])
def test_what_falls_without_end_is_refused(bounds: tuple[float, float] | None) -> None:
    linear = -DISC.vertices  # longer is less
    with pytest.raises(GeometryError, match="has no least value"):
        ParallelSpace(DISC).minimise(linear=linear, factor_bounds=bounds)
    with pytest.raises(GeometryError, match="has no least value"):
        ParallelSpace(DISC).minimise(
            [(1.0, laplacian(DISC.combinatorics))], linear=np.ones(DISC.vertices.shape), factor_bounds=bounds
        )


def test_bounds_that_no_member_keeps_are_refused() -> None:
    fixed = {0: DISC.vertices[0], DISC.n_vertices - 1: DISC.vertices[-1]}
    with pytest.raises(GeometryError, match=r"no mesh parallel to M has .* widen the bounds"):
        ParallelSpace(DISC).minimise([(1.0, close_to(DISC.vertices))], fixed=fixed, factor_bounds=(1.1, 2.0))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({}, "there is no objective"),
        ({"quadratic": [(-1.0, close_to(DISC.vertices))]}, "quadratic term 0 has the weight -1.0"),
        ({"quadratic": [(np.nan, close_to(DISC.vertices))]}, "quadratic term 0 has the weight nan"),
        ({"quadratic": [(1.0, close_to(TORUS.vertices))]}, "has 72 unknowns, .* but the mesh has 126 coordinates"),
        (
            {"quadratic": [(1.0, close_to(np.full((42, 3), np.inf)))]},
            "quadratic term 0 has numbers that are not finite",
        ),
        ({"linear": np.ones(7)}, r"the linear term has shape \(7,\), the mesh needs \(42, 3\) or \(126,\)"),
        ({"linear": np.full((42, 3), np.nan)}, "the linear term is not finite at vertex 0"),
        ({"fixed": {42: np.zeros(3)}}, "fixed names vertex 42, but there are 42 vertices"),
        ({"fixed": {-1: np.zeros(3)}}, "fixed names vertex -1"),
        ({"fixed": {0.5: np.zeros(3)}}, "fixed names vertex 0.5: .* an integer"),
        ({"factor_bounds": 1.0}, "the bounds are 1.0: a lower and an upper one are needed"),
        ({"factor_bounds": (0.0, 1.0, 2.0)}, "a lower and an upper one are needed"),
        ({"fixed": {5: [0.0, np.nan, 1.0]}}, "fixed has .* for vertex 5: .* three finite numbers"),
        ({"fixed": {5: [0.0, 1.0]}}, "fixed has .* for vertex 5: .* three finite numbers"),
        ({"factor_bounds": (np.zeros(3), np.inf)}, r"the lower bounds of the edge factors have shape \(3,\)"),
        ({"factor_bounds": (1.0, 0.5)}, r"factor of edge 0 from vertex \d+ to vertex \d+ are 1.0 and 0.5: no number"),
        ({"factor_bounds": (np.nan, 0.5)}, "edge 0 .* are nan and 0.5"),
        ({"factor_bounds": (np.inf, np.inf)}, "edge 0 .* are inf and inf"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments: dict[str, Any], sentence: str) -> None:
    if arguments and "quadratic" not in arguments and "linear" not in arguments:
        arguments = {"quadratic": [(1.0, close_to(DISC.vertices))], **arguments}
    with pytest.raises(GeometryError, match=sentence):
        ParallelSpace(DISC).minimise(**arguments)


# --- what fixed vertices leave free


@given(st.sampled_from([DISC, HEXAGONS, TORUS]), seeds, st.integers(0, 30))
@settings(max_examples=25)
def test_a_minimum_is_refused_exactly_where_nothing_is_free(mesh: Mesh, seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    space = ParallelSpace(mesh)
    vertices = rng.permutation(mesh.n_vertices)[:count]
    left = space.free_dimension(vertices)
    basis = space.basis[:, vertices].reshape(space.dimension, -1)
    assert left == space.dimension - (np.linalg.matrix_rank(basis, tol=1e-8) if count else 0)
    element = space.elements(1, seed=seed)[0] if space.dimension > 4 else mesh * 0.7
    fixed = {int(vertex): element.vertices[vertex] for vertex in vertices}
    terms = [(1.0, close_to(rng.normal(size=mesh.vertices.shape)))]
    if left:
        found = space.minimise(terms, fixed=fixed)
        assert np.abs(found.vertices - element.vertices).max() > 1e-6
    else:
        with pytest.raises(
            GeometryError, match=f"the {len(fixed)} fixed vertices leave nothing to be minimised"
        ) as caught:
            space.minimise(terms, fixed=fixed)
        assert set(caught.value.elements) == set(fixed)


def test_what_fixed_boundaries_leave() -> None:
    grid = shapes.grid(4, 3)
    space, on_boundary = ParallelSpace(grid), np.flatnonzero(grid.combinatorics.is_boundary_vertex)
    # widths of columns and rows, and translations; corners leave widths of equal sums
    assert [space.free_dimension(fixed) for fixed in ((), [0], [0, 0, 19], on_boundary)] == [10, 7, 5, 0]
    with pytest.raises(GeometryError, match=r"leave nothing to be minimised: .*see `free_dimension`"):
        space.minimise([(1.0, close_to(grid.vertices + 1.0))], fixed={int(v): grid.vertices[v] for v in on_boundary})
    with pytest.raises(GeometryError, match="fixed names vertex 20, but there are 20 vertices"):
        space.free_dimension([3, 20])
    for factor_bounds in (None, (0.5, 2.0)):
        with pytest.raises(GeometryError, match="the 2 fixed vertices leave nothing"):
            ParallelSpace(shapes.octahedron()).minimise(
                [(1.0, close_to(shapes.octahedron().vertices + 1.0))],
                fixed={v: shapes.octahedron().vertices[v] for v in (0, 1)},
                factor_bounds=factor_bounds,
            )


def test_where_rounding_decides_what_is_free() -> None:
    with pytest.raises(RankError, match=r"it is 1 dimensions if those up to 1e-09 are zero, but the next is 2\.0e-08"):
        null_dimension(np.diag([1.0, 2e-8, 1e-12]))
    assert [null_dimension(np.diag([1.0, second, 1e-12])) for second in (1e-6, 1e-10)] == [1, 2]
