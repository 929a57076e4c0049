"""Pairs joined along their boundaries: pieces of one mesh, and pieces of constant mean curvature found differently."""

from __future__ import annotations

import tracemalloc
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray, IntArray
from geometry.curvature import constant_mean_of_revolution, face_curvatures
from geometry.edge_offset import BandTiling, rotational_koebe
from geometry.errors import GeometryError, MeshError
from geometry.functionals import relative_plane_deviations
from geometry.gauss import Pair, approximate_pair, join_pairs
from geometry.mesh import shapes, solids
from geometry.mesh.polygons import face_centroids
from geometry.optimised_pairs import PairTargets, optimise_pair
from geometry.parallel import parallelity
from tests.geometry.bent_meshes import rotation

AROUND = 16
EXACT = 1e-9  # of the size of the pieces: some thousand times the rounding of rotations and their singular values


@cache
def barrel() -> Pair:
    """Six rows around an elliptic barrel that widens upwards, so that no other place fits as well."""
    z = np.linspace(-0.6, 0.8, 7)
    mesh = shapes.rotational_mesh(np.stack([np.sqrt(1.2 - z**2) + 0.2 * z, z], axis=1), AROUND)
    return approximate_pair(mesh.with_vertices(mesh.vertices * [1.0, 1.4, 1.0]))


def rows(pair: Pair, low: int, high: int) -> Pair:
    heights = face_centroids(pair.mesh.vertices, pair.mesh.combinatorics)[:, 2]
    levels = np.unique(heights.round(6))
    return pair.part(np.flatnonzero((heights > levels[low] - 1e-3) & (heights < levels[high - 1] + 1e-3)))


def placed(pair: Pair, seed: int, size: float = 1.0) -> Pair:
    turn, shift = rotation(seed), np.random.default_rng(seed).normal(size=3) * 5
    mesh = pair.mesh.with_vertices(size * pair.mesh.vertices @ turn.T + shift)
    return Pair(mesh, mesh.with_vertices(pair.gauss_image.vertices @ turn.T))


def sorted_rows(points: FloatArray) -> FloatArray:
    return np.asarray(points[np.lexsort(points.round(6).T)])


def assert_same(found: Pair, known: Pair) -> None:
    """But for the numbers of vertices."""
    both = [np.concatenate([pair.mesh.vertices, pair.gauss_image.vertices], axis=1) for pair in (found, known)]
    assert found.mesh.n_faces == known.mesh.n_faces
    np.testing.assert_allclose(sorted_rows(both[0]), sorted_rows(both[1]), atol=EXACT)


@given(seed=st.integers(0, 2**32 - 1), decade=st.floats(-2, 2))
@settings(max_examples=8)
def test_the_parts_of_a_mesh_are_put_together_wherever_they_are(seed: int, decade: float) -> None:
    pair = barrel()
    low, middle, high = rows(pair, 0, 2), rows(pair, 2, 3), rows(pair, 3, 6)
    found = join_pairs([low, placed(middle, seed), placed(high, seed + 1)])
    assert_same(found.pair, pair)
    assert found.gaps.max() < EXACT
    scaled = join_pairs([middle, placed(high, seed, 10.0**decade), placed(low, seed + 1, 10.0**-decade)], scaled=True)
    assert_same(scaled.pair, pair)


def test_the_record_says_which_faces_and_vertices_are_whose() -> None:
    pieces = [rows(barrel(), 0, 2), rows(barrel(), 2, 6)]
    found = join_pairs(pieces)
    np.testing.assert_array_equal(found.pieces, np.repeat([0, 1], [2 * AROUND, 4 * AROUND]))
    for number, piece in enumerate(pieces):
        part = found.pair.part(np.flatnonzero(found.pieces == number))
        assert_same(part, piece)
        np.testing.assert_allclose(found.pair.mesh.vertices[found.numbers[number]], piece.mesh.vertices, atol=EXACT)
        assert len(found.vertices_of([number])) == piece.mesh.n_vertices
    assert len(found.vertices_of([0, 1])) == found.pair.mesh.n_vertices


def test_a_piece_is_joined_to_all_loops_that_match() -> None:
    pair = barrel()
    heights = face_centroids(pair.mesh.vertices, pair.mesh.combinatorics)[:, 2]
    middle = np.abs(heights - np.median(heights)) < 0.2
    ends, between = pair.part(np.flatnonzero(~middle)), pair.part(np.flatnonzero(middle))
    found = join_pairs([ends, between.translated([1.0, 2.0, 3.0])])
    assert_same(found.pair, pair)
    assert found.gaps.shape == (2, 2)


def test_where_several_places_fit_a_piece_stays_as_near_as_possible() -> None:
    tube = Pair(shapes.dome(12, 4), shapes.dome(12, 4))
    low, high = rows(tube, 0, 2), rows(tube, 2, 4)
    found = join_pairs([low, high])
    np.testing.assert_allclose(found.pair.mesh.vertices[found.numbers[1]], high.mesh.vertices, atol=EXACT)


# --- boundaries that do not match exactly


def widened(pair: Pair, by: float) -> Pair:
    return Pair(pair.mesh * (1 + by), pair.gauss_image)


def test_a_gap_is_closed_by_small_moves_of_both() -> None:
    low, high = rows(barrel(), 0, 3), widened(rows(barrel(), 3, 6), 0.01)
    found = join_pairs([low, high])
    assert 1e-3 < found.gaps[0, 0] < 0.05
    assert parallelity(found.pair.mesh, found.pair.gauss_image).max() < 1e-12
    assert relative_plane_deviations(found.pair.mesh).max() < 1e-12
    moves = np.linalg.norm(found.pair.mesh.vertices[found.numbers[0]] - low.mesh.vertices, axis=1)
    assert 1e-4 < moves.max() / low.mesh.mean_edge_length < 0.05


@pytest.mark.parametrize("kept", [0, 1])
def test_a_kept_piece_keeps_its_shape_to_the_last_digit(kept: int) -> None:
    pieces = [rows(barrel(), 0, 3), widened(rows(barrel(), 3, 6), 0.01)]
    found = join_pairs(pieces, kept=[kept])
    part = found.pair.part(np.flatnonzero(found.pieces == kept))
    np.testing.assert_allclose(part.mesh.edge_lengths, pieces[kept].mesh.edge_lengths, rtol=1e-13)
    np.testing.assert_allclose(part.edge_distances, pieces[kept].edge_distances, rtol=1e-13)
    assert parallelity(found.pair.mesh, found.pair.gauss_image).max() < 1e-12
    if kept == 0:
        assert np.array_equal(found.pair.mesh.vertices[found.numbers[0]], pieces[0].mesh.vertices)


def test_pieces_that_do_not_match_are_refused_with_numbers() -> None:
    low, high = rows(barrel(), 0, 3), rows(barrel(), 3, 6)
    with pytest.raises(MeshError, match=r"it is 0\.\d+ mean edge lengths off that of piece 0, .* radii, allowed"):
        join_pairs([low, widened(high, 0.3)])
    with pytest.raises(MeshError, match=r"piece 1 fits nowhere: .*, allowed 0.05; give pieces"):
        join_pairs([low, high.tilted([0.0, 0.0, 0.3])])
    with pytest.raises(MeshError, match=r"piece 1 fits nowhere: .* Gauss image"):
        join_pairs([low, Pair(high.mesh, high.gauss_image * -1.0)])
    dome = Pair(shapes.dome(12, 4), shapes.dome(12, 4))
    with pytest.raises(MeshError, match=r"boundary loops have \[12, 12\] vertices, .* before it \[16, 16\]"):
        join_pairs([low, dome])
    with pytest.raises(MeshError, match=r"piece 1 fits nowhere: its boundary loops have \[\] vertices"):
        join_pairs([low, Pair(solids.cube(), solids.cube())])
    with pytest.raises(MeshError, match=r"pieces 0 and 1 are both to be kept, but .* apart"):
        join_pairs([low, widened(high, 0.01)], kept=[0, 1])
    with pytest.raises(GeometryError, match="1 pieces are given: at least 2"):
        join_pairs([low])
    with pytest.raises(GeometryError, match="piece 5 is to be kept, but there are 2"):
        join_pairs([low, high], kept=[5])


def test_boundaries_may_have_many_vertices() -> None:
    """All pairs of vertices would take 130 MB an array."""
    z = np.linspace(-0.2, 0.2, 3)
    mesh = shapes.rotational_mesh(np.stack([np.sqrt(1 - z**2), z], axis=1), 4000)
    low, high = rows(Pair(mesh, mesh), 0, 1), rows(Pair(mesh, mesh), 1, 2)
    tracemalloc.start()
    found = join_pairs([low, high.translated([1.0, 2.0, 3.0])])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.pair.mesh.n_vertices == 12000
    assert peak < 60e6


# --- pieces of constant mean curvature


def bulge(around: int = 24, rows: int = 3, radius: float = 0.8) -> Pair:
    image = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, around, rows, level_ends=True)
    return constant_mean_of_revolution(image, -1.0, radius=radius)


def ring_of_quads(around: int, below: Pair) -> Pair:
    """A row of quads with mean curvature -1 that continues a mesh of revolution at its end."""
    end = below.mesh.vertices[0]
    step = 2 * np.arctanh(np.sin(np.pi / around))
    s = below.gauss_image.vertices[0]
    # of the circle in which the horizontal edges of S touch the sphere
    latitude = np.arctan2(s[2], np.hypot(s[0], s[1]) * np.cos(np.pi / around))
    middle = np.arcsin(np.tanh(np.arctanh(np.sin(latitude)) - step / 2))
    image = rotational_koebe(BandTiling.QUADS, around, 1, latitude=middle)
    return constant_mean_of_revolution(image, -1.0, radius=float(np.hypot(end[0], end[1])))


def test_hexagons_and_quads_in_closed_form_are_one_mesh_of_constant_mean_curvature() -> None:
    hexagons = bulge()
    quads = ring_of_quads(24, hexagons)
    found = join_pairs([hexagons, placed(quads, 3), placed(quads, 4)])
    assert found.gaps.max() < EXACT
    np.testing.assert_allclose(face_curvatures(found).mean, -1.0, atol=1e-9)
    np.testing.assert_allclose(found.pair.edge_distances, 1.0, atol=1e-9)
    assert np.bincount(found.pair.mesh.combinatorics.face_sizes).tolist() == [0, 0, 0, 0, 48, 48, 24]


def test_a_joined_mesh_gets_constant_mean_curvature_in_all_pieces() -> None:
    hexagons = bulge()
    quads = widened(ring_of_quads(24, hexagons), 0.01)
    joined = join_pairs([hexagons, quads, quads])
    assert np.abs(face_curvatures(joined).mean + 1).max() > 5e-3
    found = optimise_pair(joined, PairTargets(mean=-1.0))
    np.testing.assert_allclose(face_curvatures(found).mean, -1.0, atol=1e-11)
    assert parallelity(found.mesh, found.gauss_image).max() < 1e-12
    assert relative_plane_deviations(found.mesh).max() < 1e-12
    assert np.abs(found.pair.edge_distances - 1).max() < 0.02


@pytest.mark.parametrize(("around", "n_rows"), [(3, 1), (7, 3), (24, 4)])
def test_level_ends_are_regular_polygons_whose_edges_touch_the_sphere(around: int, n_rows: int) -> None:
    band = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, around, n_rows, level_ends=True)
    pair = Pair(band, band)
    np.testing.assert_allclose(pair.edge_distances, 1.0, atol=1e-12)
    assert relative_plane_deviations(band).max() < 1e-12
    sizes: IntArray = np.bincount(band.combinatorics.face_sizes, minlength=7)
    assert sizes.tolist() == [0, 0, 0, 0, around, 0, 0] if n_rows == 1 else sizes[5] == 2 * around
    for loop in band.combinatorics.boundary_loops:
        assert len(loop) == around
        assert np.ptp(band.vertices[loop, 2]) < 1e-12


def test_only_pointy_tops_can_be_cut_off() -> None:
    with pytest.raises(GeometryError, match="leave out level_ends"):
        rotational_koebe(BandTiling.QUADS, 12, 3, level_ends=True)
