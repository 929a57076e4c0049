"""What is found in P(M) is the best there, wherever M lies; where rounding decides what that is, it is refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import svd

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, RankError
from geometry.functionals.closeness import close_to
from geometry.functionals.fairness import laplacian
from geometry.functionals.gauss_image_terms import close_to_vertex_normals, faces_at_unit_distance
from geometry.functionals.parallel_edges import parallel_to
from geometry.gauss import approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.meshing import planarise
from geometry.optimise import bounded_quadratic, constrained_quadratic, semidefinite_quadratic
from geometry.optimise.functional import normal_equations
from geometry.optimise.solution import ConvergenceError
from geometry.parallel import ParallelSpace, minimising, parallelity
from geometry.parallel import optimality as optimality_module

from .bent_meshes import shaken, vault, with_midpoints
from .box_meshes import block, ellipsoid, noisy, stairs, tower, turning

seeds = st.integers(0, 2**32 - 1)


def disc(seed: int) -> Mesh:
    return planarise(shaken(vault(), 0.05, seed)).mesh


def annulus(seed: int) -> Mesh:
    return planarise(shaken(shapes.dome(9, 4), 0.05, seed)).mesh


def closed(seed: int) -> Mesh:
    return planarise(shaken(ellipsoid(4, (1.0, 1.3, 1.7)), 0.03, seed)).mesh


def midpoints(seed: int) -> Mesh:
    return planarise(shaken(with_midpoints(vault(), np.arange(0, vault().n_edges, 2)), 0.01, seed)).mesh


KINDS = {"disc": disc, "annulus": annulus, "closed": closed, "midpoints": midpoints}
kinds = st.sampled_from(list(KINDS.values()))


def functional(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Of the Gauss image with the weights of the paper, dense."""
    H, g = normal_equations([(1.0, faces_at_unit_distance(mesh)), (0.1, close_to_vertex_normals(mesh))])
    return H.toarray(), g


def singular_values(mesh: Mesh) -> FloatArray:
    """Ascending, of two conditions an edge."""
    return np.asarray(svd(parallel_to(mesh).matrix.toarray(), compute_uv=False, lapack_driver="gesvd")[::-1])


def by_null_space(mesh: Mesh, zero: float = 1e-10) -> FloatArray:
    """(N, 3) the Gauss image in a dense basis of P(M), where singular values up to `zero` are taken for zero."""
    H, g = functional(mesh)
    _, values, directions = svd(parallel_to(mesh).matrix.toarray(), lapack_driver="gesvd")  # the other may fail
    basis = directions[int((values > zero).sum()) :].T
    return np.asarray((basis @ np.linalg.solve(basis.T @ H @ basis, basis.T @ g)).reshape(-1, 3))


# --- it is the best


@given(kinds, seeds)
@settings(max_examples=25, deadline=None)
def test_the_gauss_image_is_the_best_of_a_dense_basis(kind: Callable[[int], Mesh], seed: int) -> None:
    mesh = kind(seed)
    values = singular_values(mesh)
    least = values[values > 1e-10].min()
    found = approximate_pair(mesh).gauss_image
    # rounding, here up to planarity, over the least singular value, with room; what is less is tested below
    np.testing.assert_allclose(found.vertices, by_null_space(mesh), atol=1e-11 / least)


@given(kinds, seeds)
@settings(max_examples=15, deadline=None)
def test_no_element_of_the_space_makes_it_better(kind: Callable[[int], Mesh], seed: int) -> None:
    mesh = kind(seed)
    H, g = functional(mesh)
    x = approximate_pair(mesh).gauss_image.vertices.ravel()
    least = x @ H @ x / 2 - g @ x
    space = ParallelSpace(mesh)
    for element in space.elements(min(3, space.dimension - 3), seed=seed % 1000):
        for step in (1e-2, -1e-2, 1e-4, -1e-4):
            y = x + step * element.vertices.ravel()
            assert y @ H @ y / 2 - g @ y > least


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (ellipsoid(4, (1.0, 1.3, 1.6)), 15),
        (ellipsoid(5, (1.0, 2.0, 3.0)), 18),
        (shapes.torus(np.array([[2.0, -1.0], [3.5, -0.5], [3.0, 1.0], [2.2, 0.8]]), 9), 12),
    ],
    ids=["ellipsoid", "longer ellipsoid", "torus"],
)
def test_closed_quads_have_more_dimensions_than_are_counted(mesh: Mesh, expected: int) -> None:
    """Their conditions depend on each other; in a mesh with rounded coordinates they contradict each other by that."""
    planar = planarise(mesh).mesh
    space = ParallelSpace(planar)
    assert space.dimension == expected > space.expected_dimension
    np.testing.assert_allclose(approximate_pair(planar).gauss_image.vertices, by_null_space(planar), atol=1e-11)


# --- wherever it lies


@given(kinds, seeds, st.floats(1, 4), seeds)
@settings(max_examples=25, deadline=None)
def test_far_away_it_is_the_same_or_refused(kind: Callable[[int], Mesh], seed: int, decades: float, where: int) -> None:
    """Planarised there, coordinates are rounded by 1e-16 times the distance, and so are edges."""
    mesh = kind(seed)
    direction = np.random.default_rng(where).normal(size=3)
    shift = 10**decades * mesh.mean_edge_length * direction / np.linalg.norm(direction)
    far = planarise(mesh.translated(shift)).mesh
    image = approximate_pair(mesh).gauss_image.vertices
    values = singular_values(mesh)
    bound = 1e3 * 10**decades * 1e-16 / values[values > 1e-10].min()
    assume(bound < 1e-4)
    np.testing.assert_allclose(approximate_pair(far).gauss_image.vertices, image, atol=bound)
    back = far.translated(-shift)
    np.testing.assert_allclose(approximate_pair(back).gauss_image.vertices, image, atol=bound)


@given(seeds, st.floats(1, 3))  # from 4 on, rounding alone may be more than the parallelity that is promised
@settings(max_examples=15, deadline=None)
def test_far_away_projections_and_minima_are_the_same(seed: int, decades: float) -> None:
    mesh = disc(seed % 100)
    rng = np.random.default_rng(seed)
    shift = 10**decades * mesh.mean_edge_length * rng.normal(size=3)
    far = planarise(mesh.translated(shift)).mesh.translated(-shift)  # as rounded as it came
    target = mesh.with_vertices(mesh.vertices + 0.1 * rng.normal(size=mesh.vertices.shape))
    near_space, far_space = ParallelSpace(mesh), ParallelSpace(far)
    bound = 1e-12 * 10**decades  # 1e-16 times the distance over singular values of 1e-2, and room
    np.testing.assert_allclose(far_space.project(target).vertices, near_space.project(target).vertices, atol=bound)
    fair = [(1.0, laplacian(mesh.combinatorics))]
    fixed = {0: target.vertices[0], mesh.n_vertices - 1: target.vertices[-1]}
    found = [space.minimise(fair, fixed=fixed).vertices for space in (near_space, far_space)]
    np.testing.assert_allclose(found[1], found[0], atol=10 * bound)
    terms = [(1.0, close_to(target.vertices))]
    kept = [space.minimise(terms, factor_bounds=(0.9, 1.1)).vertices for space in (near_space, far_space)]
    np.testing.assert_allclose(kept[1], kept[0], atol=max(10 * bound, 1e-7))  # interior points, where no polish helps


def test_rounding_beyond_the_promised_parallelity_is_put_down_to_the_faces(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = disc(0)
    noise = 1e-13 * mesh.mean_edge_length * np.random.default_rng(0).choice([-1.0, 1.0], mesh.vertices.shape)
    coarse = ParallelSpace(mesh.with_vertices(mesh.vertices + noise))
    monkeypatch.setattr(minimising, "ELEMENT_TOLERANCE", 1e-15)  # as if more were promised than the faces leave
    with pytest.raises(ConvergenceError, match=r"faces of M are off their planes by .* planarise the mesh further"):
        coarse.minimise([(1.0, close_to(np.sin(5 * mesh.vertices)))])


# --- boxes: conditions that nearly depend on each other


@given(st.sampled_from([tower(3), tower(4), stairs(4, 3), block(3)]), st.floats(1, 14), seeds)
@settings(max_examples=40, deadline=None)
def test_boxes_with_noise_build_or_are_refused_correctly(mesh: Mesh, digits: float, seed: int) -> None:
    planar = planarise(noisy(mesh, 10**-digits, seed)).mesh
    turn = turning(seed)
    try:
        found = approximate_pair(planar).gauss_image
        turned = approximate_pair(planar.with_vertices(planar.vertices @ turn)).gauss_image
    except (RankError, ConvergenceError) as error:
        refused: GeometryError = error
    else:
        assert parallelity(planar, found).max() <= 1e-11
        np.testing.assert_allclose(turned.vertices, found.vertices @ turn, atol=1e-3)  # refusals begin at some 1e-4
        return
    assert "nearly depend on each other, with singular values of about" in refused.message
    values = singular_values(planar)
    assert values[values > 1e-14].min() < 1e-6  # none but such as rounding matters to
    assert refused.value is not None
    assert refused.bound is not None
    assert refused.value > refused.bound
    assert refused.elements


def test_boxes_whose_noise_is_seen_are_built() -> None:
    """A tower with noise of 1e-4 has singular values of 1e-5 and, of vertices with edges in two lines only, 1e-10."""
    planar = planarise(noisy(tower(4), 1e-4, 0)).mesh
    values = singular_values(planar)
    least = values[values > 1e-14].min()
    assert least < 1e-5
    np.testing.assert_allclose(
        approximate_pair(planar).gauss_image.vertices, by_null_space(planar, 1e-9), atol=1e-13 / least
    )


def test_boxes_take_care_where_the_usual_penalty_stalls(monkeypatch: pytest.MonkeyPatch) -> None:
    meshes = [planarise(noisy(tower(5), 1e-6, seed)).mesh for seed in range(4)]
    for seed, mesh in enumerate(meshes):
        turn = turning(seed)
        turned = approximate_pair(mesh.with_vertices(mesh.vertices @ turn)).gauss_image
        # singular values down to some 1e-9
        np.testing.assert_allclose(turned.vertices, approximate_pair(mesh).gauss_image.vertices @ turn, atol=1e-4)
    monkeypatch.setattr(optimality_module, "replace", lambda quadratic, careful: quadratic)
    stalled = []
    for mesh in meshes:
        try:
            approximate_pair(mesh)
        except GeometryError as error:
            stalled.append(error)
    assert stalled


def test_a_refusal_names_the_edges_and_the_singular_values() -> None:
    planar = planarise(noisy(block(4), 1e-12, 0)).mesh
    with pytest.raises(RankError) as refused:
        approximate_pair(planar)
    message = refused.value.message
    assert "rounding decides about the Gauss image: equations of P(M) nearly depend on each other" in message
    assert "unite faces there that are nearly in one plane" in message
    assert "origin" not in message  # it lies there
    assert len(refused.value.elements) == 3
    reported = float(message.split("singular values of about ")[1].split(",")[0])
    values = singular_values(planar)
    assert values[values > 1e-14].min() / 10 < reported < 1e-11  # noise of 1e-12 makes them
    for edge in refused.value.elements:  # edges between faces in one plane
        left, right = planar.combinatorics.edge_faces[edge]
        assert planar.face_normals[left] @ planar.face_normals[right] > 1 - 1e-9


def test_no_gap_in_a_planar_mesh_is_not_put_down_to_its_faces() -> None:
    planar = planarise(noisy(tower(4), 1e-6, 0)).mesh
    with pytest.raises(RankError, match=r"no gap .* put faces that are nearly in one plane exactly in it$"):
        _ = ParallelSpace(planar).dimension


@pytest.mark.parametrize("weight", [1e-4, 1e-6, 1e-8])
def test_small_weights_decide_what_larger_ones_leave_free(weight: float) -> None:
    mesh, turn = planarise(shaken(shapes.dome(12, 6), 0.02, 3)).mesh, turning(0)
    found = approximate_pair(mesh, vertices=weight).gauss_image
    turned = approximate_pair(mesh.with_vertices(mesh.vertices @ turn), vertices=weight).gauss_image
    # rounding over the weight, up to 8e-14 with the versions of SciPy tried; one refinement only leaves 1e-4 with the
    # least weight
    np.testing.assert_allclose(turned.vertices, found.vertices @ turn, atol=1e-13 / weight)


# --- the checks are seen to fire


def test_asking_for_more_than_rounding_leaves_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """That is how S came out far from the minimum, and parallel to rounding."""
    places = [np.array([1.0, 0.5, 0.0]) * distance for distance in (0, 1e2, 1e3, 4e3)]
    meshes = [planarise(ellipsoid(8, (1.0, 2.0, 3.0)).translated(place)).mesh for place in places]
    images = [approximate_pair(mesh).gauss_image.vertices for mesh in meshes]
    for name, value in (
        ("ROUNDING_MULTIPLE", 0.0),
        ("CAREFUL_ROUNDING_MULTIPLE", 0.0),
        ("OPTIMUM_ACCURACY", 1e-15),
        ("CAREFUL_OPTIMUM_ACCURACY", 1e-15),
    ):
        monkeypatch.setattr(optimality_module, name, value)
    refused = []
    for mesh, image in zip(meshes, images, strict=True):
        try:
            np.testing.assert_allclose(approximate_pair(mesh).gauss_image.vertices, image, atol=1e-9)
        except RankError as error:
            refused.append(error.message)
    assert refused
    assert all(
        "rounding decides about the Gauss image: equations of P(M) nearly depend" in reported for reported in refused
    )


def test_a_solver_that_stops_early_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = disc(0)
    for name in ("OPTIMUM_ACCURACY", "CAREFUL_OPTIMUM_ACCURACY"):
        monkeypatch.setattr(optimality_module, name, 1e-3)
    monkeypatch.setattr(constrained_quadratic, "CAREFUL_PENALTY", 1e4)
    monkeypatch.setattr(constrained_quadratic, "MAX_REFINEMENTS", 0)
    with pytest.raises(
        ConvergenceError, match=r"off the direction of its mesh edge by .* in the Gauss image, allowed 1e-12"
    ):
        approximate_pair(mesh)


def test_a_minimum_that_is_none_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = disc(0)
    terms = [(1.0, close_to(np.sin(5 * mesh.vertices)))]
    for module, name in ((semidefinite_quadratic, "GRADIENT_TOLERANCE"), (semidefinite_quadratic, "CYCLE_REDUCTION")):
        monkeypatch.setattr(module, name, 1e-2)
    monkeypatch.setattr(semidefinite_quadratic, "SEMIDEFINITE_REGULARISATION", 10.0)
    with pytest.raises(GeometryError, match=r"is not at its least value: .* of the gradient remains"):
        ParallelSpace(mesh).minimise(terms)


def test_bounds_that_do_not_hold_the_minimum_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Interior points that end early are off by what bounds and their multipliers make of it."""
    mesh = disc(0)
    terms = [(1.0, close_to(np.sin(5 * mesh.vertices)))]
    ParallelSpace(mesh).minimise(terms, factor_bounds=(0.5, 1.5))
    monkeypatch.setattr(bounded_quadratic, "INTERIOR_POINT_ACCURACY", 1e-2)
    monkeypatch.setattr(bounded_quadratic._Problem, "polished", lambda self, interior: interior)
    with pytest.raises(GeometryError, match=r"rounding decides|is not at its least value|its length is outside"):
        ParallelSpace(mesh).minimise(terms, factor_bounds=(0.5, 1.5))


def test_constraints_that_nearly_depend_on_each_other_take_care() -> None:
    """Hundreds of small singular values: the usual penalty stalls, the careful one does not."""
    rng = np.random.default_rng(0)
    n, m = 200, 100
    left, right = (np.linalg.qr(rng.normal(size=(k, k)))[0] for k in (m, n))
    A = left @ np.diag(np.geomspace(1, 1e-7, m)) @ right[:m]
    H, g = constrained_quadratic.csr_array(np.eye(n)), rng.normal(size=n)
    sparse = constrained_quadratic.csr_array(A)
    usual = constrained_quadratic.ConstrainedQuadratic(H, sparse).minimise(g, np.zeros(m), tolerance=1e-14)
    careful = constrained_quadratic.ConstrainedQuadratic(H, sparse, careful=True).minimise(
        g, np.zeros(m), tolerance=1e-14
    )
    expected = right[m:].T @ (right[m:] @ g)
    assert np.abs(usual.x - expected).max() > 1e-3
    np.testing.assert_allclose(careful.x, expected, atol=1e-6)  # 1e-14 over 1e-7, and room
    np.testing.assert_allclose(careful.x - g + A.T @ careful.multipliers, 0, atol=1e-8)
