"""Combinatorics by name: sizes, valences, orientation; the dual of the dual."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import MeshError
from geometry.mesh import Combinatorics, solids
from geometry.mesh.tilings import (
    dual,
    hexagon_patch,
    pentagon_patch,
    quad_patch,
    rotational_hexagons,
    rotational_quads,
)
from tests.geometry.random_polyhedra import KINDS, random_polyhedron

sizes = st.integers(1, 6)


def face_sets(c: Combinatorics) -> list[list[int]]:
    """Faces in any order, each from its least vertex on."""
    return sorted(np.roll(face, -int(np.argmin(face))).tolist() for face in c.faces)


def inner_degrees(c: Combinatorics) -> set[int]:
    return set(c.vertex_degrees[~c.is_boundary_vertex].tolist())


@given(sizes, sizes)
def test_patches_are_discs(nx: int, ny: int) -> None:
    quads, hexagons = quad_patch(nx, ny), hexagon_patch(nx, ny)
    assert (quads.n_faces, hexagons.n_faces) == (nx * ny, nx * ny)
    assert set(quads.face_sizes) == {4}
    assert set(hexagons.face_sizes) == {6}
    assert quads.euler_characteristic == hexagons.euler_characteristic == 1
    assert inner_degrees(quads) <= {4}
    assert inner_degrees(hexagons) <= {3}


@given(st.integers(2, 6), st.integers(2, 6))
def test_pentagons(nx: int, ny: int) -> None:
    c = pentagon_patch(nx, ny)
    assert c.n_faces == nx * (ny - 1) + (nx - 1) * ny
    assert set(c.face_sizes) == {5}
    assert c.is_used.all()
    assert c.euler_characteristic == 1
    assert inner_degrees(c) <= {3, 4}
    inside = np.add.reduceat(c.is_boundary_vertex[c.corners], c.face_starts[:-1]) == 0
    fours = np.add.reduceat(c.vertex_degrees[c.corners] == 4, c.face_starts[:-1])
    assert set(fours[inside]) <= {2}  # two vertices of valence 4, three of valence 3
    two, four = pentagon_patch(4, 5), pentagon_patch(4, 5, closed=True)
    assert four.n_faces == two.n_faces + 5


@given(st.integers(3, 9), sizes)
def test_rings(n: int, rings: int) -> None:
    for c, size, degree in ((rotational_quads(n, rings), 4, 4), (rotational_hexagons(n, rings), 6, 3)):
        assert c.n_faces == n * rings
        assert set(c.face_sizes) == {size}
        assert c.euler_characteristic == 0
        assert len(c.boundary_loops) == 2
        assert inner_degrees(c) <= {degree}
    closed = pentagon_patch(2 * n, rings + 1, closed=True)
    assert set(closed.face_sizes) == {5}
    assert closed.euler_characteristic == 0
    assert len(closed.boundary_loops) == 2


@given(st.integers(0, 2**32 - 1), st.integers(4, 40), st.sampled_from(KINDS))
@settings(max_examples=30)
def test_the_dual_of_the_dual_is_the_same(seed: int, n: int, kind: str) -> None:
    c = random_polyhedron(np.random.default_rng(seed), n, kind)
    d = dual(c)
    assert (d.n_vertices, d.n_edges, d.n_faces) == (c.n_faces, c.n_edges, c.n_vertices)
    np.testing.assert_array_equal(d.face_sizes, c.vertex_degrees)
    np.testing.assert_array_equal(d.vertex_degrees, c.face_sizes)
    assert face_sets(dual(d)) == face_sets(c)


def test_the_dual_keeps_the_orientation() -> None:
    for solid in (solids.snub_cube(), solids.icosahedron()):  # the first has no mirror
        poles = (
            solid.face_normals
            / np.einsum(
                "fi,fi->f",
                solid.face_normals,
                solid.vertices[solid.combinatorics.corners[solid.combinatorics.face_starts[:-1]]],
            )[:, None]
        )
        other = dual(solid.combinatorics)
        mesh = type(solid)(poles, other)
        assert mesh.planarity.max() < 1e-12
        outwards = np.einsum("fi,fi->f", mesh.face_normals, solid.vertices)
        assert (outwards > 0).all()


def test_the_dual_of_an_open_mesh_has_its_inner_vertices_as_faces() -> None:
    c = dual(quad_patch(4, 3))
    assert face_sets(c) == face_sets(quad_patch(3, 2))
    around = dual(hexagon_patch(4, 3))
    assert set(around.face_sizes) == {3}
    assert around.is_used.all()
    with pytest.raises(MeshError, match="no vertex is inside"):
        dual(quad_patch(1, 5))


def test_what_is_too_small_is_refused() -> None:
    with pytest.raises(MeshError, match="0 columns are asked for, an integer from 1 upwards") as caught:
        quad_patch(0, 3)
    assert (caught.value.value, caught.value.bound) == (0, 1)
    for make in (
        lambda: hexagon_patch(2, 0),
        lambda: pentagon_patch(1, 1),
        lambda: pentagon_patch(2, 2, closed=True),
        lambda: rotational_quads(2, 1),
        lambda: rotational_hexagons(3, 0),
        lambda: quad_patch(2.5, 3),  # type: ignore[arg-type]
        lambda: pentagon_patch(4, float("nan")),  # type: ignore[arg-type]
    ):
        with pytest.raises(MeshError, match="are asked for, an integer from"):
            make()
    with pytest.raises(MeshError, match=r"5 columns around an axis: .* give an even number"):
        pentagon_patch(5, 2, closed=True)
