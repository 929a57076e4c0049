"""One origin: a whole number that moves along with a mesh, and takes nothing of it away."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.files import read_mesh, read_mesh_pair, write_mesh
from geometry.files.mending import mend
from geometry.gauss import approximate_pair
from geometry.mesh import Combinatorics, Mesh, shapes
from geometry.mesh.origin import rounding, whole_origin
from geometry.meshing import Effort, planarise
from geometry.optimise.solution import ConvergenceError

WHOLE = st.tuples(*[st.integers(-5_000_000, 5_000_000)] * 3).map(np.array)
DOUBLES = st.floats(-1e8, 1e8) | st.floats(-10, 10) | st.integers(-(2**40), 2**40).map(float)
POINTS = st.lists(st.tuples(DOUBLES, DOUBLES, DOUBLES), min_size=1, max_size=6).map(np.array)


def dyadic(mesh: Mesh) -> Mesh:
    """With coordinates that are multiples of 2^-24."""
    return mesh.with_vertices(np.round(mesh.vertices * 2.0**24) / 2.0**24)


def rough_dome(seed: int = 0) -> Mesh:
    """Of radius 10, its vertices moved by up to 0.02 in each coordinate."""
    dome = shapes.dome(8, 3)
    noise = np.random.default_rng(seed).uniform(-0.02, 0.02, dome.vertices.shape)
    return dyadic(dome.with_vertices(10 * dome.vertices + noise))


@given(POINTS)
def test_taking_it_out_rounds_nothing(points: FloatArray) -> None:
    origin = whole_origin(points)
    assert np.array_equal(origin, np.floor(origin))
    for row in points.tolist():
        for x, n in zip(row, origin.tolist(), strict=True):
            assert Fraction(x) - Fraction(n) == Fraction(x - n)
            assert (x - n) + n == x


@given(POINTS)
def test_what_is_left_is_no_further_from_zero_than_its_own_extent(points: FloatArray) -> None:
    """A double that is not on the grid of the result is smaller than the result, which is half the extent, rounded."""
    left = points - whole_origin(points)
    assert (np.abs(left).max(axis=0) <= 2 * np.ptp(points, axis=0) + 2).all()


@given(st.integers(0, 99), WHOLE)
def test_it_moves_along(seed: int, move: FloatArray) -> None:
    mesh = rough_dome(seed)
    (near, here), (far, there) = mesh.near_zero(), mesh.translated(move).near_zero()
    np.testing.assert_array_equal(there, here + move)
    np.testing.assert_array_equal(far.vertices, near.vertices)


def test_what_is_about_zero_stays() -> None:
    for mesh in (shapes.dodecahedron(), shapes.cube(), shapes.dome(7, 2).translated([1e-17, -1e-17, 0.1])):
        near, origin = mesh.near_zero()
        assert not origin.any()
        np.testing.assert_array_equal(near.vertices, mesh.vertices)


@given(st.integers(0, 99), WHOLE, st.booleans())
def test_mending_does_not_depend_on_the_place(seed: int, move: FloatArray, closed: bool) -> None:
    """Faces that do not share their vertices, some reversed."""
    mesh = dyadic(shapes.dodecahedron()) if closed else rough_dome(seed)
    rng = np.random.default_rng(seed)
    corners = mesh.combinatorics.corners
    vertices = dyadic(Mesh(mesh.vertices[corners] + rng.uniform(-4e-5, 4e-5, (len(corners), 3)), _apart(mesh))).vertices
    faces = [face[:: rng.choice([-1, 1])] for face in _apart(mesh).faces]
    here, there = mend(vertices, faces), mend(vertices + move, faces)
    np.testing.assert_array_equal(there[0].vertices, here[0].vertices + move)
    assert there[0].combinatorics.same_as(here[0].combinatorics)
    assert there[1] == here[1]
    assert "welded" in here[1][0]


@given(st.integers(0, 9999), WHOLE)
def test_which_side_is_outside_does_not_depend_on_the_place(seed: int, move: FloatArray) -> None:
    """Of a flat hexagon under six triangles with a vertex of their own: its volume is what rounding leaves of zero."""
    rng = np.random.default_rng(seed)
    corner, along, across = np.round(rng.uniform(-1, 1, (3, 3)) * 2.0**24) / 2.0**24
    plan = np.array([[0, 0], [3, -1], [5, 1], [4, 4], [1, 5], [-1, 2], [2, 2]])
    vertices = corner + plan @ np.stack([along, across])
    faces = [[5, 4, 3, 2, 1, 0], *([k, (k + 1) % 6, 6] for k in range(6))]
    here, there = mend(vertices, faces), mend(vertices + move, faces)
    assert there[0].combinatorics.same_as(here[0].combinatorics)
    assert there[1] == here[1]


def _apart(mesh: Mesh) -> Combinatorics:
    """The faces with vertices of their own."""
    c = mesh.combinatorics
    return Combinatorics(len(c.corners), np.arange(len(c.corners)), c.face_starts)


@pytest.mark.parametrize("suffix", [".obj", ".off", ".ply"])
@settings(max_examples=20)
@given(st.integers(0, 99), WHOLE)
def test_a_file_gets_its_own_coordinates_back(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, seed: int, move: FloatArray
) -> None:
    folder = tmp_path_factory.getbasetemp()
    mesh = rough_dome(seed).translated(move)
    write_mesh(folder / f"a{suffix}", mesh)
    read = read_mesh(folder / f"a{suffix}")
    np.testing.assert_array_equal(read.mesh.vertices, mesh.vertices)
    assert not read.origin.any()
    near = read.near_zero()
    assert np.abs(near.mesh.vertices).max() < 11  # its radius, and half a unit
    write_mesh(folder / f"b{suffix}", near.mesh, origin=near.origin)
    assert (folder / f"a{suffix}").read_bytes() == (folder / f"b{suffix}").read_bytes()
    again = near.near_zero()
    np.testing.assert_array_equal(again.origin, near.origin)
    np.testing.assert_array_equal(again.mesh.vertices, near.mesh.vertices)


def test_a_gauss_image_stays_where_it_is(tmp_path: Path) -> None:
    mesh, image = shapes.dome(8, 3), shapes.dome(8, 3).translated([0.0, 0.0, 0.75])
    write_mesh(tmp_path / "M.obj", mesh.translated([2_600_000.0, 1_200_000.0, 400.0]))
    write_mesh(tmp_path / "S.obj", image)
    file, found = read_mesh_pair(tmp_path / "M.obj", tmp_path / "S.obj")
    np.testing.assert_array_equal(found.vertices, image.vertices)
    assert file.near_zero().origin.tolist()[:2] == [2_600_000.0, 1_200_000.0]


# --- arrays far from zero are right, or refused with a cure that helps


def test_what_is_planar_far_away_is_taken_as_near_zero() -> None:
    grid = dyadic(shapes.grid(5, 4))
    far = grid.translated([2_600_000.0, -1_200_000.0, 400.0])
    assert planarise(far).mesh is far
    np.testing.assert_array_equal(
        approximate_pair(far).gauss_image.vertices, approximate_pair(grid).gauss_image.vertices
    )


def test_the_cure_of_the_place_helps() -> None:
    far = rough_dome().translated([2_600_000.0, -1_200_000.0, 400.0])
    cure = r"the mesh is \de\+05 mean edge lengths from the origin, where coordinates are rounded coarsely: begin "
    cure += "with mesh"
    with pytest.raises(ConvergenceError, match=cure):
        planarise(far)
    with pytest.raises(GeometryError, match=cure + r".near_zero\(\)\[0\] and planarise the mesh first"):
        approximate_pair(planarise(far, effort=Effort(tolerance=1e-8)).mesh)
    near, origin = far.near_zero()
    planar = planarise(near).mesh
    assert origin.tolist() == [
        2_600_000.0,
        -1_200_000.0,
        406.0,
    ]  # the middle, from a rim at 401.7 to a top at 409.9
    np.testing.assert_array_equal(planar.vertices, planarise(rough_dome().near_zero()[0]).mesh.vertices)
    approximate_pair(planar)


def test_the_place_is_not_blamed_for_what_it_did_not_do() -> None:
    far = rough_dome().translated([2_600_000.0, -1_200_000.0, 400.0])
    for mesh in (far, rough_dome()):
        with pytest.raises(GeometryError, match="allowed 1e-12; planarise the mesh first"):
            approximate_pair(mesh)


@given(st.integers(0, 99), WHOLE)
def test_what_stands_far_away_exactly_was_not_rounded(seed: int, move: FloatArray) -> None:
    points = rough_dome(seed).vertices + move
    assert rounding(points) == 0.0
    third = points + 1 / 3
    assert rounding(third) == np.spacing(np.abs(third).max())
    assert rounding(np.zeros((0, 3))) == 0.0
