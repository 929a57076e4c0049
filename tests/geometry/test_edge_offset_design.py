"""Edge offset meshes designed in P(S): signs, lengths, what is held, and what has no solution."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray, IntArray
from geometry.edge_offset.contradictory_signs import conflicting_edges
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron
from geometry.edge_offset.koebe_polyhedra import koebe as koebe_of
from geometry.edge_offset.signed_meshes import alternating_signs, edge_offset_mesh, guided_signs, saddle_signs
from geometry.errors import GeometryError
from geometry.exact_offsets import edge_offset_pair
from geometry.functionals.fairness import laplacian
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.intersections.meeting_faces import is_embedded
from geometry.mesh.tilings import pentagon_patch
from geometry.meshing import planarise
from geometry.parallel import ParallelSpace, edge_factors, parallelity
from geometry.spheres.stereographic import circle_planes, poles
from tests.geometry.tiling_polyhedra import KINDS, tiling_polyhedron
from tests.real_data.meshes import HEXAGONAL, needs_data, read

SOUTH = [0, 0, -1]
QUADS = tiling_polyhedron("quads")
PENTAGONS = tiling_polyhedron("pentagons", turn=np.pi / 4)
HEXAGONS = tiling_polyhedron("hexagons", reach=2.2)
seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from([QUADS, PENTAGONS, HEXAGONS])
AT_LEAST_1 = (1.0, np.inf)


def plan_signs(koebe: Mesh) -> IntArray:
    """Edges nearer to the x direction of the tiling keep their orientation."""
    return saddle_signs(koebe, [1, 0, 0], pole=SOUTH)


def fairness(mesh: Mesh) -> float:
    return float(np.square(laplacian(mesh.combinatorics).residual(mesh.vertices.ravel())).sum())


def offset_distances(mesh: Mesh, koebe: Mesh, d: float) -> FloatArray:
    """(E,) distances of the edge lines of M and M + d S, from the two meshes alone."""
    offset = mesh + d * koebe
    along = mesh.edge_vectors / mesh.edge_lengths[:, None]
    between = offset.vertices[mesh.combinatorics.edges[:, 0]] - mesh.vertices[mesh.combinatorics.edges[:, 0]]
    return np.linalg.norm(np.cross(along, between), axis=1)


@pytest.mark.parametrize("kind", KINDS)
def test_the_polyhedra_of_these_tests_are_koebe_polyhedra(kind: str) -> None:
    koebe = tiling_polyhedron(kind)
    KoebePolyhedron(koebe, tolerance=1e-12)
    assert set(koebe.combinatorics.face_sizes) == {KINDS[kind]}
    assert (koebe.face_normals[:, 2] > 0).all()
    assert is_embedded(koebe)


# --- results


@pytest.mark.parametrize("koebe", [QUADS, PENTAGONS], ids=["quads", "pentagons"])
def test_meshes_of_negative_curvature(koebe: Mesh) -> None:
    """[Pottmann2007, Fig. 11], and the like with quads: embedded, and curved negatively in each face."""
    signs = plan_signs(koebe)
    mesh = edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    assert is_embedded(mesh)
    assert (np.einsum("fi,fi->f", mesh.vector_areas, koebe.face_normals) < 0).all()
    factors = edge_factors(koebe, mesh)
    np.testing.assert_array_equal(np.sign(factors), signs)
    assert mesh.edge_lengths.min() == pytest.approx(1, abs=1e-8)
    size = np.abs(mesh.vertices).max()
    assert parallelity(koebe, mesh).max() <= 1e-12 * size
    np.testing.assert_allclose(offset_distances(mesh, koebe, 0.2), 0.2, atol=1e-12 * size)
    np.testing.assert_allclose(mesh.vertices.mean(axis=0), 0, atol=1e-12 * size)


@given(kinds, seeds)
@settings(max_examples=12)
def test_signs_of_a_parallel_mesh_have_a_solution_and_the_fairest_is_found(koebe: Mesh, seed: int) -> None:
    wanted = koebe.vertices * np.random.default_rng(seed).uniform(-1, 1, 3)
    element = ParallelSpace(koebe).project(koebe.with_vertices(wanted))
    lengths = element.edge_lengths
    signs = guided_signs(koebe, element)
    assert (signs != 0).all()
    assert not len(conflicting_edges(koebe, signs))
    mesh = edge_offset_mesh(koebe, signs=signs, lengths=(lengths / 2, np.inf))
    size = np.abs(mesh.vertices).max()
    assert (signs * edge_factors(koebe, mesh) * koebe.edge_lengths - lengths / 2).min() >= -1e-9 * size
    # convex: no other mesh that is allowed is fairer, nor are those on the way to it
    for share in (1e-3, 0.5, 1.0):
        assert fairness(mesh * (1 - share) + element * share) >= fairness(mesh) * (1 - 1e-9)


@given(kinds, st.floats(0.01, 100))
@settings(max_examples=10)
def test_larger_lengths_scale_the_mesh(koebe: Mesh, scale: float) -> None:
    mesh = edge_offset_mesh(koebe, signs=plan_signs(koebe), lengths=AT_LEAST_1)
    scaled = edge_offset_mesh(koebe, signs=plan_signs(koebe), lengths=(scale, np.inf))
    np.testing.assert_allclose(scaled.vertices, scale * mesh.vertices, atol=1e-6 * scale)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_lengths_of_any_unit_do(scale: float) -> None:
    fairest = edge_offset_mesh(HEXAGONS, signs=1, lengths=AT_LEAST_1)
    scaled = edge_offset_mesh(HEXAGONS, signs=1, lengths=(scale, np.inf))
    np.testing.assert_allclose(scaled.vertices, scale * fairest.vertices, atol=1e-6 * scale)


@pytest.mark.parametrize("most", [1e3, 1e6, 1e9, 1e15])
def test_a_largest_length_far_away_is_none(most: float) -> None:
    fairest = edge_offset_mesh(HEXAGONS, signs=1, lengths=AT_LEAST_1)
    mesh = edge_offset_mesh(HEXAGONS, signs=1, lengths=(1.0, most))
    np.testing.assert_allclose(mesh.vertices, fairest.vertices, atol=1e-9)


def test_a_largest_length_is_kept() -> None:
    koebe = tiling_polyhedron("hexagons", turn=np.pi / 12)
    signs = plan_signs(koebe)
    free = edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    most = 0.95 * free.edge_lengths.max()
    mesh = edge_offset_mesh(koebe, signs=signs, lengths=(1.0, most))
    assert mesh.edge_lengths.max() == pytest.approx(most, rel=1e-8)
    assert mesh.edge_lengths[signs != 0].min() >= 1 - 1e-8  # others may be shorter
    assert fairness(mesh) > fairness(free)
    with pytest.raises(GeometryError, match="widen the bounds"):  # the signs alone have a solution
        edge_offset_mesh(koebe, signs=signs, lengths=(1.0, 1.01))


def test_a_symmetric_patch_gets_a_symmetric_mesh() -> None:
    patch = koebe_of(pentagon_patch(12, 12), coverage=0.4).mesh
    lengths = np.sort(edge_offset_mesh(patch, signs=1, lengths=AT_LEAST_1).edge_lengths)
    # 4 edges of each kind in a patch that turns into itself by quarters; the mean edge is 1.2, a mark needs ten digits
    assert (np.diff(lengths) > 1e-10).sum() < patch.n_edges / 4


@pytest.mark.parametrize("koebe", [QUADS, PENTAGONS], ids=["quads", "pentagons"])
def test_target_lengths_make_edges_even(koebe: Mesh) -> None:
    signs = plan_signs(koebe)
    fair = edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    misses = []
    for evenness in (0.1, 1.0, 100.0):
        mesh = edge_offset_mesh(koebe, signs=signs, lengths=(0.3, np.inf), length=1.0, evenness=evenness)
        np.testing.assert_array_equal(np.sign(edge_factors(koebe, mesh)), signs)
        off = np.square(mesh.edge_lengths - 1).sum()
        # least of all multiples of itself, and of what leads to another mesh with these signs
        for other in (mesh * 1.01, mesh * 0.99, mesh * 0.99 + fair * 0.01):
            if (other.edge_lengths >= 0.3).all():
                more = evenness * (np.square(other.edge_lengths - 1).sum() - off) + fairness(other) - fairness(mesh)
                assert more >= 0
        misses.append(off)
    assert misses[0] > misses[1] > misses[2]
    doubled = edge_offset_mesh(koebe, signs=signs, lengths=(0.6, np.inf), length=2.0, evenness=evenness)
    np.testing.assert_allclose(doubled.vertices, 2 * mesh.vertices, atol=1e-6)


def test_fixed_and_target_positions() -> None:
    element = edge_offset_mesh(QUADS, signs=plan_signs(QUADS), lengths=AT_LEAST_1).translated([5, 6, 7])
    lifted = element.translated([0, 0, 1])
    targets = dict(enumerate(lifted.vertices))
    near = edge_offset_mesh(QUADS, near=targets, closeness=1e8)
    np.testing.assert_allclose(near.vertices, lifted.vertices, atol=1e-5)
    held = {v: element.vertices[v] for v in (0, QUADS.n_vertices - 1)}
    mesh = edge_offset_mesh(QUADS, fixed=held)
    for vertex, position in held.items():
        np.testing.assert_allclose(mesh.vertices[vertex], position, atol=1e-10)
    assert fairness(mesh) < fairness(element)
    signed = edge_offset_mesh(QUADS, signs=plan_signs(QUADS), fixed=held)
    assert (plan_signs(QUADS) * edge_factors(QUADS, signed)).min() >= -1e-9
    assert fairness(mesh) <= fairness(signed) <= fairness(element)


# --- signs


def test_alternating_signs_of_quads() -> None:
    signs = alternating_signs(QUADS.combinatorics)
    np.testing.assert_array_equal(signs, plan_signs(QUADS) * signs[0] * plan_signs(QUADS)[0])
    np.testing.assert_array_equal(alternating_signs(QUADS.combinatorics, first=-1), -signs)
    catenoid = shapes.catenoid(8, 3)  # its meridians reverse [Pottmann2007, Fig. 17]
    is_ring = np.abs(catenoid.edge_vectors[:, 2]) < 1e-9
    signs = alternating_signs(catenoid.combinatorics)
    np.testing.assert_array_equal(signs, np.where(is_ring == is_ring[0], 1, -1))
    assert not alternating_signs(HEXAGONS.combinatorics).any()


def test_alternating_signs_that_contradict_themselves() -> None:
    with pytest.raises(GeometryError, match="odd valence") as caught:
        alternating_signs(solids.cube().combinatorics)
    assert len(caught.value.elements) == 12
    alternating_signs(shapes.torus(np.array([[2.0, -1], [3.5, -0.5], [3, 1], [2.2, 0.8]]), 5).combinatorics)


def test_saddle_signs_of_meridians() -> None:
    koebe = rotational_koebe()
    is_ring = np.abs(koebe.edge_vectors[:, 2]) < 1e-9
    signs = saddle_signs(koebe, [0, 0, 1])
    np.testing.assert_array_equal(signs, np.where(is_ring, -1, 1))
    np.testing.assert_array_equal(signs, signs[0] * alternating_signs(koebe.combinatorics))
    around = np.cross([0, 0, 1.0], koebe.vertices[koebe.combinatorics.edges].mean(axis=1))
    np.testing.assert_array_equal(saddle_signs(koebe, around), -signs)
    mesh = edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    assert is_embedded(mesh)
    np.testing.assert_array_equal(guided_signs(koebe, mesh), signs)
    radii = np.linalg.norm(mesh.vertices[:, :2], axis=1).reshape(12, -1)
    np.testing.assert_allclose(radii, np.broadcast_to(radii[0], radii.shape), rtol=1e-6)  # as symmetric as S
    assert radii[0].argmin() in (2, 3)  # a waist, as of a catenoid


def rotational_koebe() -> Mesh:
    """12 meridians, 5 rings of quads: rings of equal circles that touch, in geometric progression, on the sphere."""
    half = np.pi / 12
    ratio = (1 + np.sin(half)) / (1 - np.sin(half))  # |c| + r over |c| - r, where circles about vertices touch
    radii = ratio ** np.arange(-2.5, 3)
    turn = 2 * half * np.arange(12)[:, None]
    plan = radii[None, :, None] * np.stack([np.cos(turn), np.sin(turn)], axis=2)
    lifted = poles(*circle_planes(plan, np.sin(half) * np.broadcast_to(radii, (12, 6)))).reshape(-1, 3)
    faces = [
        [6 * i + j, 6 * ((i + 1) % 12) + j, 6 * ((i + 1) % 12) + j + 1, 6 * i + j + 1]
        for i in range(12)
        for j in range(5)
    ]
    return Mesh.from_faces(lifted, faces)


def test_a_direction_between_two_edges_says_nothing() -> None:
    square = tiling_polyhedron("quads", reach=0.1)
    np.testing.assert_array_equal(np.abs(saddle_signs(square, [1, 0, 0], pole=SOUTH)), 1)
    np.testing.assert_array_equal(saddle_signs(square, [1, 1, 0], pole=SOUTH), 0)
    np.testing.assert_array_equal(saddle_signs(square, np.zeros((4, 3))), 0)


def test_the_pole_carries_directions_to_the_sphere() -> None:
    """Edges of the tiling are straight; turned with it, the signs stay."""
    for turn in (0.2, 1.0, 2.5):
        koebe = tiling_polyhedron("quads", turn=turn)
        direction = [np.cos(turn), np.sin(turn), 0]
        np.testing.assert_array_equal(saddle_signs(koebe, direction, pole=SOUTH), plan_signs(QUADS))
        assert (saddle_signs(koebe, direction) != plan_signs(QUADS)).any()


def test_at_the_pole_itself_there_is_no_direction() -> None:
    pole = KoebePolyhedron(QUADS).tangency_points[5]
    signs = saddle_signs(QUADS, np.cross(pole, [0, 0, 1]), pole=pole)
    assert signs[5] == 0
    assert np.count_nonzero(signs) > QUADS.n_edges / 2


def test_a_guide_across_or_without_edges_says_nothing() -> None:
    square = shapes.cube()
    np.testing.assert_array_equal(guided_signs(square, square * 0.0), 0)
    np.testing.assert_array_equal(guided_signs(square, square * -2.0), -1)


# --- what has no solution


def test_faces_that_cannot_close_are_named() -> None:
    koebe = solids.cube() * (1 / 2**0.5)
    signs = np.ones(12, dtype=int)
    face = koebe.combinatorics.corner_edge[:4]
    signs[face[:2]] = -1  # two neighbouring sides of face 0
    with pytest.raises(GeometryError, match=r"face 0 cannot close, as its edges -0, -1, \+2, \+3 then all") as caught:
        edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    assert 0 in caught.value.elements
    signs[face[1]] = 0  # free to run as it must: the neighbour of a reversed side
    signs[face] = 0
    edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)


def test_signs_that_do_not_fit_together_are_named() -> None:
    koebe = tiling_polyhedron("pentagons")
    signs = saddle_signs(koebe, [1, 0, 0]).copy()
    with pytest.raises(GeometryError, match="the signs have no solution: each face could close") as caught:
        edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    edges = list(caught.value.elements)
    np.testing.assert_array_equal(conflicting_edges(koebe, signs), edges)
    signs[edges] = 0
    mesh = edge_offset_mesh(koebe, signs=signs, lengths=AT_LEAST_1)
    signed = signs != 0
    np.testing.assert_array_equal(np.sign(edge_factors(koebe, mesh))[signed], signs[signed])
    assert not len(conflicting_edges(koebe, signs))


@pytest.mark.parametrize("signs", [0, 1, plan_signs(QUADS)], ids=["free", "all kept", "some reversed"])
def test_what_shrinks_to_a_point_is_refused(signs: IntArray) -> None:
    with pytest.raises(GeometryError, match="shrunk to a point"):
        edge_offset_mesh(QUADS, signs=signs)
    with pytest.raises(GeometryError, match="shrunk to a point"):
        edge_offset_mesh(QUADS, signs=signs, length=1.0, evenness=0.0)
    with pytest.raises(GeometryError, match="shrunk to a point"):
        edge_offset_mesh(QUADS, signs=signs, fixed={0: [0, 0, 0]})
    with pytest.raises(GeometryError, match="shrunk to a point"):
        edge_offset_mesh(QUADS, signs=signs, fixed={0: [1, 2, 3], 1: [1, 2, 3]})


def test_bad_input_is_named() -> None:
    with pytest.raises(GeometryError, match="the mesh is not a Koebe polyhedron") as caught:
        edge_offset_mesh(QUADS * 1.1, signs=1, lengths=AT_LEAST_1)
    assert caught.value.value == pytest.approx(0.1)
    with pytest.raises(GeometryError, match=r"the signs have shape \(3,\), there are"):
        edge_offset_mesh(QUADS, signs=[1, 1, -1])
    signs = np.ones(QUADS.n_edges)
    signs[7] = 2
    with pytest.raises(GeometryError, match=r"edge 7 .* has the sign 2.0"):
        edge_offset_mesh(QUADS, signs=signs)
    with pytest.raises(GeometryError, match=r"at least -1\.0 long"):
        edge_offset_mesh(QUADS, signs=1, lengths=(-1.0, 2.0))
    with pytest.raises(GeometryError, match="no number is between them"):
        edge_offset_mesh(QUADS, signs=1, lengths=(3.0, 2.0))
    lengths = np.ones(QUADS.n_edges)
    for wrong in (np.nan, np.inf, 0.0, -1.0):
        lengths[7] = wrong
        with pytest.raises(GeometryError, match=r"edge 7 .* a finite number above 0 is needed"):
            edge_offset_mesh(QUADS, signs=1, length=lengths)
    edge_offset_mesh(QUADS, signs=np.where(np.arange(QUADS.n_edges) == 7, 0, 1), length=lengths)  # nobody asks edge 7
    with pytest.raises(GeometryError, match=r"\(3,\) or"):
        saddle_signs(QUADS, np.ones((4, 3)))
    with pytest.raises(GeometryError, match="the direction has nan at"):
        saddle_signs(QUADS, [1, np.nan, 0])
    with pytest.raises(GeometryError, match="first sign is 2"):
        alternating_signs(QUADS.combinatorics, first=2)
    with pytest.raises(GeometryError, match="a point of the unit sphere"):
        saddle_signs(QUADS, [1, 0, 0], pole=[0, 0, 2])


def test_fixed_vertices_that_contradict_the_signs_are_not_blamed_on_the_signs() -> None:
    i, j = QUADS.combinatorics.edges[0].tolist()
    fixed = {i: QUADS.vertices[j], j: QUADS.vertices[i]}  # edge 0 reversed
    with pytest.raises(GeometryError, match="free some vertices, or widen the bounds"):
        edge_offset_mesh(QUADS, signs=1, fixed=fixed)


@needs_data
def test_a_mesh_parallel_to_the_hexagonal_koebe_polyhedron() -> None:
    koebe = edge_offset_pair(planarise(read(HEXAGONAL)).mesh).gauss_image
    element = ParallelSpace(koebe).project(koebe.with_vertices(koebe.vertices * [1, 1, -1]))
    signs = guided_signs(koebe, element)
    assert 100 < (signs < 0).sum() < 480
    mesh = edge_offset_mesh(koebe, signs=signs, lengths=(element.edge_lengths / 2, np.inf))
    np.testing.assert_array_equal(np.sign(edge_factors(koebe, mesh)), signs)
    size = np.abs(mesh.vertices).max()
    np.testing.assert_allclose(offset_distances(mesh, koebe, 0.1), 0.1, atol=1e-10 * size)  # S: 3e-11 in its file
