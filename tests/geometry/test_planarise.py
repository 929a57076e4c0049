"""Planarising: planar by an independent measure, close by, and the same whatever the units and the place."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError
from geometry.functionals.planar_faces import PlanarFaces, relative_plane_deviations
from geometry.mesh import Mesh, shapes
from geometry.meshing import Effort, Guides, planarise
from geometry.optimise.solution import ConvergenceError, Reason
from tests.geometry.bent_meshes import graph, out_of_plane, rotation, shaken, vault, with_midpoints

TOLERANCE = 1e-12
seeds = st.integers(0, 2**32 - 1)


MESHES = {
    "quads": vault(),
    "annulus": shapes.dome(9, 4),
    "closed pentagons": shapes.dodecahedron(),
    "closed prism": shapes.regular_prism(7),
    "4 to 8 corners": with_midpoints(vault(), np.arange(0, vault().n_edges, 2)),
    "8 corners": with_midpoints(vault(), np.arange(vault().n_edges)),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(seed=seeds, amount=st.floats(1e-9, 0.05))
@settings(deadline=None, max_examples=12)
def test_faces_become_planar_and_vertices_move_little(mesh: Mesh, seed: int, amount: float) -> None:
    bent = shaken(mesh, amount, seed)
    result = planarise(bent)
    assert out_of_plane(result.mesh) <= TOLERANCE
    assert result.plane_deviation_before == pytest.approx(out_of_plane(bent), rel=1e-5, abs=1e-14)
    assert result.plane_deviation_after <= TOLERANCE
    # a planar mesh lies within sqrt(3) times the amount; in the strain metric short edges may ask for twice that
    assert result.mean_move <= 2 * 3**0.5 * amount
    assert result.mean_move <= result.largest_move
    np.testing.assert_allclose(
        np.linalg.norm(result.mesh.vertices - bent.vertices, axis=1).max(),
        result.largest_move * bent.mean_edge_length,
        rtol=1e-9,
    )


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_a_planar_mesh_comes_back_as_it_is(mesh: Mesh) -> None:
    result = planarise(mesh)
    assert result.mesh is mesh
    assert (result.iterations, result.largest_move, result.mean_move) == (0, 0.0, 0.0)
    again = planarise(planarise(shaken(mesh, 0.01, 0)).mesh)
    assert again.iterations == 0


@given(seeds, st.floats(-6, 6), st.tuples(*[st.floats(-30, 30)] * 3))
@settings(deadline=None, max_examples=12)
def test_units_place_and_attitude_do_not_matter(seed: int, decades: float, shift: tuple[float, float, float]) -> None:
    bent = shaken(vault(), 0.03, 5)
    turn, scale = rotation(seed), 10.0**decades
    moved = bent.with_vertices((bent.vertices @ turn + shift) * scale)
    expected = (planarise(bent).mesh.vertices @ turn + shift) * scale
    # Newton's steps pass on rounding times the penalty of 1e8
    np.testing.assert_allclose(planarise(moved).mesh.vertices, expected, rtol=0, atol=1e-6 * scale)


@given(seeds)
@settings(deadline=None, max_examples=12)
def test_attitude_and_numbers_do_not_matter_where_steps_are_long(seed: int) -> None:
    """Along these lines there is no mesh of planar quads nearby: the first step is cut short, others are halved."""
    bent = shaken(graph(6, lambda x, y: 0.3 * x * y + 0.1 * x**2 - 0.2 * y**3), 0.02, 1)
    rng, turn = np.random.default_rng(seed), rotation(seed)
    numbers = rng.permutation(bent.n_vertices)
    positions = np.empty_like(bent.vertices)
    positions[numbers] = bent.vertices @ turn
    faces = [numbers[face].tolist() for face in bent.combinatorics.faces]
    copy = Mesh.from_faces(positions, [faces[f] for f in rng.permutation(len(faces))])
    given, found = planarise(bent), planarise(copy)
    assert given.largest_move > 0.4
    # as above; with steps limited in each coordinate it was 1e-3
    np.testing.assert_allclose(found.mesh.vertices[numbers], given.mesh.vertices @ turn, rtol=0, atol=1e-6)


@given(seeds)
@settings(deadline=None, max_examples=12)
def test_parts_do_not_influence_each_other(seed: int) -> None:
    one, other = shaken(vault(), 0.02, seed), shaken(shapes.regular_prism(5), 0.02, seed)
    other = other.with_vertices(other.vertices / other.mean_edge_length * one.mean_edge_length + 10)
    faces = [face.tolist() for face in one.combinatorics.faces] + [
        [v + one.n_vertices for v in f] for f in other.combinatorics.faces
    ]
    both = planarise(Mesh.from_faces(np.concatenate([one.vertices, other.vertices]), faces)).mesh
    # steps may end one earlier or later, which moves vertices by far less than a quadratic step's last bits
    np.testing.assert_allclose(both.vertices[: one.n_vertices], planarise(one).mesh.vertices, atol=1e-5)
    np.testing.assert_allclose(both.vertices[one.n_vertices :], planarise(other).mesh.vertices, atol=1e-5)


def test_triangles_ask_for_nothing() -> None:
    mesh = shaken(shapes.icosahedron(), 0.1, 0)
    assert planarise(mesh).mesh is mesh


@given(seeds, st.integers(4, 8), st.floats(1e-12, 1e-2))
@settings(deadline=None)
def test_residuals_have_the_norm_of_the_distances_even_for_collinear_corners(seed: int, k: int, bend: float) -> None:
    # corners 0, 1, 2 nearly on a line: the volume of a quadruple through them nearly vanishes wherever the others are
    rng = np.random.default_rng(seed)
    around = np.sort(rng.uniform(0.5, 5.5, size=k - 3))
    tail = np.stack([np.cos(around), np.sin(around), np.zeros(k - 3)], axis=1)
    line = np.array([[1.0, -0.5, 0.0], [1.0 + bend, 0.0, 0.0], [1.0, 0.5, 0.0]])
    corners = np.concatenate([line, tail]) + rng.uniform(-0.1, 0.1, size=(k, 1)) * [0, 0, 1]
    mesh = Mesh.from_faces(corners, [list(range(k))])
    values = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    residual = PlanarFaces(mesh.combinatorics).residual(corners.ravel())
    assert residual.shape == (k - 3,)
    assert np.linalg.norm(residual) == pytest.approx(values[2], rel=1e-7, abs=1e-14)


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_the_jacobian_is_exact_at_planar_faces(mesh: Mesh) -> None:
    functional = PlanarFaces(mesh.combinatorics)
    x = mesh.vertices.ravel()
    direction = np.random.default_rng(3).normal(size=x.shape)
    step = 1e-6
    predicted = functional.jacobian(x) @ direction
    found = functional.residual(x + step * direction) / step
    # the basis may turn within a face, so norms are compared; what is left is of the order of the step
    rows = [size - 3 for size in sorted(mesh.combinatorics.face_sizes.tolist()) if size > 3]
    splits = np.cumsum(rows)[:-1]
    for left, right in zip(np.split(predicted, splits), np.split(found, splits), strict=True):
        assert np.linalg.norm(left) == pytest.approx(np.linalg.norm(right), abs=1e-4)


def test_deviations_far_from_the_origin_are_those_of_the_coordinates() -> None:
    # whole numbers in one plane; their mean is not one, and rounds by 1e-4 so far out
    flat = np.array([[0, 0], [3, 0], [4, 2], [2, 5], [0, 3]])
    corners = np.column_stack([flat, flat @ [3, 1]]) + 2.0**40
    assert relative_plane_deviations(Mesh.from_faces(corners, [[0, 1, 2, 3, 4]]))[0] < 1e-14


def test_more_fairness_keeps_edges_more_even() -> None:
    bent = shaken(vault(8, 8), 0.2, 2)

    def unevenness(fairness: float) -> float:
        return float(
            np.abs(np.log(planarise(bent, Guides(fairness=fairness)).mesh.edge_lengths / bent.edge_lengths)).max()
        )

    assert unevenness(10.0) < unevenness(0.1)


def test_holding_on_to_the_start_moves_vertices_less() -> None:
    wavy = graph(20, lambda x, y: 0.3 * np.sin(3 * x + 2 * y) * np.cos(2 * x - y))
    assert (
        planarise(wavy, effort=Effort(anchored_steps=8)).mean_move
        < 0.9 * planarise(wavy, effort=Effort(anchored_steps=0)).mean_move
    )


# --- what cannot be done is said


def test_quads_along_asymptotic_lines_are_refused() -> None:
    # a hypar along its rulings: every face would have to degenerate, and how that shows is a matter of rounding
    with pytest.raises(GeometryError, match=r"folded over while planarising|off its plane"):
        planarise(graph(12, lambda x, y: 0.4 * x * y))


ROUGH = graph(10, lambda x, y: np.random.default_rng(0).uniform(-0.2, 0.2, x.shape))


def test_a_face_that_folds_over_is_named() -> None:
    with pytest.raises(
        GeometryError, match=r"face \d+ folded over while planarising: .* degrees, allowed 90"
    ) as raised:
        planarise(ROUGH)
    assert raised.value.value is not None
    assert raised.value.value <= 0


def test_an_edge_that_folds_over_is_named() -> None:
    with pytest.raises(GeometryError, match=r"edge \d+ from vertex \d+ to vertex \d+ folded over while planarising"):
        planarise(ROUGH, Guides(fairness=1.0), Effort(anchored_steps=2))


def test_too_few_steps_are_reported_with_the_worst_face() -> None:
    bent = shaken(vault(), 0.05, 4)
    with pytest.raises(ConvergenceError, match=r"face \d+ is still off its plane by .* after 1 steps") as raised:
        planarise(bent, effort=Effort(max_steps=1))
    assert raised.value.bound == TOLERANCE
    assert raised.value.value is not None
    assert raised.value.value > TOLERANCE
    assert raised.value.solution.reason is Reason.STEP_LIMIT
    assert raised.value.solution.steps == 1


def test_a_mesh_too_far_from_the_origin_is_refused_unless_more_is_allowed() -> None:
    bent = shaken(vault(), 0.01, 4)
    far = bent.with_vertices(bent.vertices + 1e6 * bent.mean_edge_length)
    with pytest.raises(ConvergenceError, match="the mesh is 1e\\+06 mean edge lengths from the origin"):
        planarise(far)
    assert out_of_plane(planarise(far, effort=Effort(tolerance=1e-9)).mesh) <= 1e-9


def test_a_mesh_about_the_origin_is_not_advised_to_move_there() -> None:
    bent = shaken(vault(40, 30), 0.05, 0)
    with pytest.raises(ConvergenceError, match=r"coordinates are rounded to .* lengths; allow more$") as raised:
        planarise(bent, effort=Effort(tolerance=1e-16))
    assert "origin" not in raised.value.message


@pytest.mark.parametrize("mesh", [ROUGH, graph(12, lambda x, y: 0.4 * x * y)])
def test_advice_names_nothing_that_only_a_library_knows(mesh: Mesh) -> None:
    """The same sentences are read by those who have a command line: they name what to do to the mesh."""
    with pytest.raises(GeometryError, match=r"; lay the mesh along conjugate directions$"):
        planarise(mesh)


@given(seeds, st.floats(1e-6, 0.05))
@settings(deadline=None, max_examples=20)
def test_moves_are_reported_for_each_vertex(seed: int, amount: float) -> None:
    bent = shaken(vault(), amount, seed)
    bent = Mesh.from_faces(np.concatenate([bent.vertices, [[9.0, 9.0, 9.0]]]), bent.combinatorics.faces)
    result = planarise(bent)
    moves = np.linalg.norm(result.mesh.vertices - bent.vertices, axis=1) / bent.mean_edge_length
    np.testing.assert_allclose(result.moves, moves, rtol=0, atol=1e-15 * 1e3)
    assert not result.moves.flags.writeable
    assert result.moves[-1] == 0  # belongs to no face, so shares take no notice of it
    assert result.move_of(1.0) == result.largest_move == result.moves.max()
    assert result.mean_move == pytest.approx(result.moves.mean())
    assert (result.moves[:-1] <= result.move_of(0.95)).mean() >= 0.95 - 1 / bent.n_vertices
    assert result.move_of(0.0) == result.moves[:-1].min()
    with pytest.raises(GeometryError, match=r"the share of the vertices is 1\.5"):
        result.move_of(1.5)


def test_a_shape_that_collapses_is_seen_in_the_moves() -> None:
    """Along asymptotic lines no mesh is planar but flat ones: all vertices move, and nothing else tells."""
    result = planarise(graph(8, lambda x, y: 0.12 * x * y))
    assert result.plane_deviation_after <= TOLERANCE
    assert result.move_of(0.95) > 0.3


@pytest.mark.parametrize("name", ["tolerance", "fairness", "anchored_steps", "max_steps"])
@pytest.mark.parametrize("number", [-1, float("nan"), float("inf")])
def test_numbers_out_of_range_are_refused(name: str, number: float) -> None:
    with pytest.raises(GeometryError, match=f"{name} is {number}: a (finite number is needed|number from 0 upwards)"):
        Guides(fairness=number) if name == "fairness" else Effort(**{name: number})


def test_an_edge_without_length_is_refused() -> None:
    mesh = vault()
    vertices = mesh.vertices.copy()
    vertices[1] = vertices[0]
    with pytest.raises(MeshError, match=r"edge \d+ from vertex [01] to vertex [01] has no length"):
        planarise(mesh.with_vertices(vertices))
