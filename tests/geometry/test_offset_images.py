"""Which exact offsets a mesh has, whatever its faces, and the S to build it with."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError
from geometry.exact_offsets import best_offset_pair, exact_pairs, offset_deviations
from geometry.gauss import Pair
from geometry.mesh import Mesh, shapes
from geometry.parallel import parallelity
from tests.geometry.parallel_elements import SIMPLE, SOLIDS, boosted, element, solid
from tests.geometry.test_exact_gauss_images import parallelograms

seeds = st.integers(0, 2**32 - 1)
EXACT = 1e-9


def spread(pair: Pair) -> float:
    return float(np.ptp(pair.edge_distances))


def lifted_pentagons(seed: int) -> Mesh:
    """A mesh parallel to an inscribed truncated icosahedron, its vertices on no sphere and its faces on no circles."""
    return element(boosted(solid("truncated_icosahedron", "vertex"), seed), seed, size=0.05, centre=1.0)


@given(st.sampled_from(sorted(SOLIDS)), seeds, st.floats(-3, 3))
def test_solids_of_all_kinds_of_faces_have_an_edge_offset_and_are_their_own_image(
    name: str, seed: int, decades: float
) -> None:
    """Triangles too, wherever the mesh lies: P(M) of the icosahedron has nothing but its scaled copies."""
    image = boosted(solid(name, "edge"), seed)
    rng = np.random.default_rng(seed)
    found = best_offset_pair((image * 10**decades).translated(rng.uniform(-9, 9, 3) * 10**decades))
    assert found is not None
    kind, pair = found
    assert kind == "edge"
    if name in ("icosahedron", "octahedron", "tetrahedron"):
        np.testing.assert_allclose(
            pair.gauss_image.vertices, image.vertices, atol=1e-8
        )  # coordinates are rounded ten sizes away


@given(st.sampled_from(SIMPLE), seeds)
@settings(max_examples=20)
def test_a_mesh_with_an_edge_offset_is_built_with_it(name: str, seed: int) -> None:
    """Beams of one height, where the approximate S leaves some per cent."""
    image = boosted(solid(name, "edge"), seed)
    mesh = element(image, seed, size=0.02, centre=1.0)
    found = best_offset_pair(mesh)
    assert found is not None
    assert found[0] == "edge"
    np.testing.assert_allclose(found[1].edge_distances, 1, atol=EXACT)
    assert found[1].face_distances.min() > 0  # beams point to the outside of all faces
    assert parallelity(mesh, found[1].gauss_image).max() <= 1e-11


@given(st.floats(0.5, 2), st.floats(0.05, 0.4), st.integers(6, 12))
@settings(max_examples=20)
def test_without_an_edge_offset_the_smaller_spread_of_heights_decides(radius: float, bend: float, n: int) -> None:
    heights = np.linspace(0, 1, 6)
    profile = np.stack([radius + bend * heights**2, heights], axis=1)
    mesh = shapes.rotational_mesh(profile, n)  # circular and conical
    pairs = exact_pairs(mesh)
    assert set(pairs) == {"vertex", "face"}
    found = best_offset_pair(mesh)
    assert found is not None
    kind, pair = found
    assert spread(pair) == pytest.approx(min(map(spread, pairs.values())), rel=1e-6)
    distances = pair.vertex_distances if kind == "vertex" else pair.face_distances
    np.testing.assert_allclose(distances, 1, atol=EXACT)


@given(seeds)
@settings(max_examples=10)
def test_what_loses_digits_has_no_offset_any_more_and_what_never_had_one_neither(seed: int) -> None:
    """Faces stay planar: triangles are, and translation surfaces are."""
    rng = np.random.default_rng(seed)
    rough = SOLIDS["icosahedron"].vertices + 1e-5 * rng.normal(size=(12, 3))
    assert best_offset_pair(SOLIDS["icosahedron"].with_vertices(rough)) is None
    assert best_offset_pair(parallelograms()) is None
    assert min(offset_deviations(parallelograms()).values()) > 1e-3


def test_triangles_are_circular_and_have_no_vertex_offset_for_that() -> None:
    """A triangulated patch, no sphere: all faces have circumcircles."""
    grid = shapes.grid(3, 3)
    points = grid.vertices.copy()
    points[:, 2] = 0.2 * points[:, 0] ** 2 + 0.1 * points[:, 1] ** 2 + 0.05 * points[:, 0] * points[:, 1]
    mesh = Mesh.from_faces(points, [t for a, b, c, d in grid.combinatorics.faces for t in ([a, b, c], [a, c, d])])
    off = offset_deviations(mesh)
    assert off["vertex"] > 1e-3
    assert off["face"] > 1e-3
    assert best_offset_pair(mesh) is None


@given(seeds)
@settings(max_examples=10)
def test_pentagons_and_hexagons_parallel_to_an_inscribed_mesh_have_a_vertex_offset(seed: int) -> None:
    mesh = lifted_pentagons(seed)
    off = offset_deviations(mesh)
    assert off["vertex"] <= EXACT
    assert off["face"] <= EXACT  # three planes at a vertex always meet


def test_far_leaning_and_flat_lying_images_are_passed_over() -> None:
    """A steep cone has all three; its faces nearly go through the origin of the S whose edges touch the sphere."""
    ring = shapes.rotational_mesh([[1.0, 0.0], [0.99, 20.0]], 3)
    found = best_offset_pair(ring)
    for pair in [] if found is None else [found[1]]:
        heights = pair.edge_distances
        assert heights.min() >= 0.5
        assert heights.max() <= 2
        assert pair.face_distances.min() >= 0.1 * heights.min()


def test_a_single_point_is_no_offset_to_build_with() -> None:
    """Flat meshes have it, of quads and of triangles."""
    for mesh in (
        shapes.grid(3, 2),
        Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]),
    ):
        assert best_offset_pair(mesh) is None
        assert max(offset_deviations(mesh).values()) <= EXACT


def test_a_tolerance_is_taken_and_checked() -> None:
    mesh = shapes.dome(40, 20)
    found = best_offset_pair(mesh)
    assert found is not None
    assert found[0] != "edge"
    with pytest.raises(GeometryError, match="it must be above 0"):
        best_offset_pair(mesh, tolerance=0.0)
    bent = mesh.vertices.copy()
    bent[7, 2] += 1e-3
    with pytest.raises(GeometryError, match="planarise the mesh first"):
        best_offset_pair(mesh.with_vertices(bent))
