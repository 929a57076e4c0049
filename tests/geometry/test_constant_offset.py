"""Offsets in one call: exact ones of each kind, the nearest else, what is refused; ranges of distances and weights."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import Mesh, Pair, ParallelSpace, approximate_pair, koebe, make_circular, make_conical, offset
from geometry.errors import GeometryError
from geometry.exact_offsets import OffsetKind
from geometry.functionals import close_to
from geometry.mesh import shapes, solids, tilings
from geometry.parallel.blending import weight_ranges
from geometry.parallel.edge_parallelity import edge_factors, parallelity

seeds = st.integers(0, 2**32 - 1)
KINDS: tuple[OffsetKind, ...] = ("edge", "face", "vertex")

WAVY = shapes.translation_surface(
    [[x, 0.0, 0.1 * x**2] for x in range(5)], [[0.2 * y, 1.0 * y, 0.15 * y**2] for y in range(5)]
)


def line_distances(mesh: Mesh, other: Mesh) -> np.ndarray:
    """(E,) between corresponding edge lines, parallel as they are."""
    across = other.vertices[mesh.combinatorics.edges[:, 0]] - mesh.vertices[mesh.combinatorics.edges[:, 0]]
    return np.asarray(np.linalg.norm(np.cross(across, mesh.edge_directions), axis=1))


def plane_distances(mesh: Mesh, other: Mesh) -> np.ndarray:
    """(F,) between corresponding face planes, positive outwards."""
    c = mesh.combinatorics
    corner = c.corners[c.face_starts[:-1]]
    return np.asarray(np.einsum("fi,fi->f", other.vertices[corner] - mesh.vertices[corner], mesh.face_normals))


MESHES: dict[OffsetKind, Mesh] = {
    "edge": ParallelSpace(koebe(tilings.quad_patch(4, 3)).mesh).minimise(
        [(1.0, close_to(3.0 * koebe(tilings.quad_patch(4, 3)).mesh.vertices * [1, 1.2, 1]))]
    ),
    "face": make_conical(WAVY).mesh,
    "vertex": make_circular(WAVY).mesh,
}


@pytest.mark.parametrize("kind", KINDS)
@given(distance=st.floats(-0.3, 0.3))
@settings(max_examples=10)
def test_what_is_asked_for_is_at_constant_distance(kind: OffsetKind, distance: float) -> None:
    mesh = MESHES[kind]
    found = offset(mesh, distance, kind)
    assert found.kind == kind
    assert found.distance == distance
    assert parallelity(mesh, found.mesh).max() <= 1e-11
    measured = {
        "edge": line_distances(mesh, found.mesh),
        "face": plane_distances(mesh, found.mesh),
        "vertex": np.linalg.norm(found.mesh.vertices - mesh.vertices, axis=1),
    }
    expected = distance if kind == "face" else abs(distance)
    np.testing.assert_allclose(measured[kind], expected, atol=1e-9)
    np.testing.assert_allclose(found.edge_distances, measured["edge"], atol=1e-12)
    np.testing.assert_allclose(found.face_distances, measured["face"], atol=1e-12)
    np.testing.assert_allclose(found.vertex_distances, measured["vertex"], atol=1e-12)
    # the same from the pair, of which the kind is found
    again = offset(found.pair, distance)
    np.testing.assert_array_equal(again.mesh.vertices, found.mesh.vertices)
    assert again.kind == kind
    assert offset(found.pair, distance, kind).pair is found.pair


def test_without_a_kind_it_is_the_exact_one_or_the_nearest() -> None:
    assert offset(MESHES["edge"], 0.1).kind == "edge"
    assert offset(solids.cube(), 0.1).kind == "edge"  # of all three
    assert offset(MESHES["face"], 0.1).kind == "face"
    nearest = offset(WAVY, 0.1)
    assert nearest.kind is None
    np.testing.assert_allclose(nearest.face_distances, 0.1, atol=0.005)
    assert np.ptp(nearest.face_distances) > 1e-5
    stretched = MESHES["face"].with_vertices(MESHES["face"].vertices * [1, 1, 1.0003])  # conical to some 1e-5
    assert [offset(stretched, 0.1, tolerance=tolerance).kind for tolerance in (1e-3, 1e-6)] == ["face", None]
    pair = approximate_pair(WAVY)
    assert offset(pair, 0.1).kind is None
    np.testing.assert_array_equal(offset(pair, 0.1).mesh.vertices, pair.offset_mesh(0.1).vertices)


@pytest.mark.parametrize(
    ("kind", "sentence"),
    [
        ("edge", "no edge offset is found: edge .* off distance 1 .* allowed 1e-06; .* `approximate_pair`"),
        ("face", "the mesh has no face offset: face .* off distance 1 .* use `make_conical`"),
        ("vertex", "the mesh has no vertex offset: vertex .* off its place .* use `make_circular`"),
    ],
)
def test_a_mesh_without_that_offset_is_refused(kind: OffsetKind, sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        offset(WAVY, 0.1, kind)
    pair = approximate_pair(WAVY)
    with pytest.raises(
        GeometryError, match=f"the pair has no {kind} offset: {kind} .* allowed 1e-06; .*leave the kind"
    ):
        offset(pair, 0.1, kind)
    loose = 1.5 * float(pair.deviations(kind).max())
    assert offset(pair, 0.1, kind, tolerance=loose).kind == kind


def test_what_else_is_refused() -> None:
    with pytest.raises(GeometryError, match='the kind of the offset is \'edges\': "edge", "face", "vertex" or None'):
        offset(WAVY, 0.1, "edges")  # type: ignore[arg-type]
    with pytest.raises(GeometryError, match="the distance of the offset is nan"):
        offset(WAVY, np.nan)
    cube = solids.cube()  # of edge length 2, S the same: at distance -1 it is a point
    with pytest.raises(GeometryError, match=r"edge 0 .* is -0.5 times as long .* a distance between -1 and inf"):
        offset(cube, -1.5, "face")
    assert offset(cube, -0.99, "face").mesh.mean_edge_length == pytest.approx(0.02)


@given(seeds)
@settings(max_examples=20)
def test_edges_collapse_at_the_ends_of_the_range_of_distances(seed: int) -> None:
    mesh = MESHES["edge"]
    pair = Pair(mesh, ParallelSpace(mesh).elements(1, seed=seed)[0])  # its edges run either way
    low, high = pair.distance_range
    assert low < 0 < high
    for inside, limit in ((0.999 * low, low), (0.999 * high, high)):
        assert (edge_factors(mesh, pair.offset_mesh(inside)) > 0).all()
        assert abs(edge_factors(mesh, pair.offset_mesh(limit)).min()) < 1e-9
        assert (edge_factors(mesh, pair.offset_mesh(1.001 * limit)) < 0).any()


@given(seeds, st.integers(1, 4))
@settings(max_examples=20)
def test_edges_collapse_at_the_ends_of_the_ranges_of_weights(seed: int, count: int) -> None:
    space = ParallelSpace(WAVY)
    elements = [WAVY, *space.elements(count, seed=seed)]
    weights = np.append(1.0, 0.1 * np.random.default_rng(seed).normal(size=count))
    signs = np.sign(edge_factors(WAVY, space.blend(weights, elements)))
    ranges = space.blend_ranges(weights.tolist(), elements)
    assert ranges.shape == (count + 1, 2)
    for place, limits in enumerate(ranges):
        for limit in limits[np.isfinite(limits)]:
            for share, is_kept in ((0.999, True), (1.001, False)):
                changed = weights.copy()
                changed[place] += share * (limit - weights[place])
                kept = np.sign(edge_factors(WAVY, space.blend(changed, elements))) == signs
                assert kept.all() == is_kept
        assert limits[0] < weights[place] < limits[1]
        for limit, far in zip(limits, (-1e3, 1e3), strict=True):  # where there is no limit, nothing ever collapses
            if np.isinf(limit):
                changed = weights.copy()
                changed[place] += far
                assert (np.sign(edge_factors(WAVY, space.blend(changed, elements))) == signs).all()


def test_ranges_without_limits_and_edges_without_length() -> None:
    factors = np.array([[1.0, 1.0], [1e-16, 2.0], [0.0, 0.0]])
    np.testing.assert_array_equal(
        weight_ranges(np.array([1.0, 0.0, 0.0]), factors), [[0, np.inf], [-0.5, np.inf], [-np.inf, np.inf]]
    )
    with pytest.raises(GeometryError, match="edge 1 has no length in this blend"):
        weight_ranges(np.array([2.0, -1.0, 0.0]), factors)
    with pytest.raises(GeometryError, match="give one for each mesh"):
        ParallelSpace(WAVY).blend_ranges([1.0], [])
