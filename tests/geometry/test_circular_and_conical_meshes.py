"""Circular and conical meshes: so by independent measures, close by, and the same whatever the units and the place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.exact_offsets import circularity, conicality
from geometry.mesh import Mesh, shapes
from geometry.meshing import Effort, Guides, OptimisedMesh, make_circular, make_conical, planarise
from geometry.optimise.solution import ConvergenceError
from tests.geometry.bent_meshes import graph, out_of_plane, rotation, shaken

seeds = st.integers(0, 2**32 - 1)
Make = Callable[..., OptimisedMesh]
Measure = Callable[[Mesh], FloatArray]

KINDS = pytest.mark.parametrize(("make", "measure"), [(make_circular, circularity), (make_conical, conicality)])
PROFILE = [[1.0, 0.0], [1.3, 0.4], [1.4, 0.9], [1.2, 1.5], [0.8, 1.8]]
MESHES = {
    "annulus": shapes.dome(12, 4),
    "disc": shapes.rotational_mesh(PROFILE, 7, closed=False),
    "hourglass": shapes.rotational_mesh([[2.0, -1.5], [1.3, -0.6], [1.1, 0.1], [1.5, 0.9], [2.2, 1.4]], 10),
    "prism": shapes.regular_prism(5),
}


@KINDS
@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(seed=seeds, amount=st.floats(1e-9, 0.04))
@settings(max_examples=8)
def test_shaken_rotational_meshes_are_mended(
    make: Make, measure: Measure, mesh: Mesh, seed: int, amount: float
) -> None:
    bent = shaken(mesh, amount, seed)
    result = make(bent)
    assert out_of_plane(result.mesh) <= 1e-12
    assert np.nanmax(measure(result.mesh), initial=0.0) <= 1e-12
    assert result.residual_after <= 1e-12
    # a mesh of the kind lies within sqrt(3) times the amount; the strain metric may ask for twice that on average
    assert result.mean_move <= 2 * 3**0.5 * amount


@KINDS
@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_what_is_of_the_kind_comes_back_as_it_is(make: Make, measure: Measure, mesh: Mesh) -> None:
    result = make(mesh)
    assert result.mesh is mesh
    assert result.iterations == 0
    assert result.reason == "the given mesh meets all requirements"
    again = make(make(shaken(mesh, 0.02, 1)).mesh)
    assert again.iterations == 0


@KINDS
def test_planar_faces_alone_are_not_enough(make: Make, measure: Measure) -> None:
    planar = planarise(shaken(shapes.dome(12, 4), 0.03, 5)).mesh
    assert np.nanmax(measure(planar)) > 1e-3
    result = make(planar)
    assert result.residual_before > 1e-3
    assert result.iterations > 0
    assert np.nanmax(measure(result.mesh)) <= 1e-12


@KINDS
@given(seed=seeds, decades=st.floats(-6, 6), shift=st.tuples(*[st.floats(-30, 30)] * 3))
@settings(max_examples=8)
def test_units_place_and_attitude_do_not_matter(
    make: Make, measure: Measure, seed: int, decades: float, shift: tuple[float, float, float]
) -> None:
    bent = shaken(shapes.dome(12, 4), 0.03, 5)
    turn, scale = rotation(seed), 10.0**decades
    moved = bent.with_vertices((bent.vertices @ turn + shift) * scale)
    expected = (make(bent).mesh.vertices @ turn + shift) * scale
    # Newton's steps pass on rounding times the penalty of 1e8
    np.testing.assert_allclose(make(moved).mesh.vertices, expected, rtol=0, atol=1e-6 * scale)


@KINDS
@pytest.mark.parametrize("valence", [3, 5])
def test_vertices_of_other_valences(make: Make, measure: Measure, valence: int) -> None:
    # a pyramid cut off by a second, larger one: `valence` quads, then a ring of them, around one vertex
    angles = 2 * np.pi / valence * np.arange(valence)
    middle = np.stack([np.cos(angles), np.sin(angles), np.full(valence, -0.3)], axis=1)
    between = angles + np.pi / valence
    outer = np.stack([1.9 * np.cos(between), 1.9 * np.sin(between), np.full(valence, -0.9)], axis=1)
    faces = [[0, 1 + i, 1 + valence + i, 1 + (i + 1) % valence] for i in range(valence)]
    exact = planarise(Mesh.from_faces(np.concatenate([np.zeros((1, 3)), middle, outer]), faces)).mesh
    result = make(shaken(exact, 0.03, 2)).mesh
    assert out_of_plane(result) <= 1e-12
    assert np.nanmax(measure(result)) <= 1e-12


@KINDS
def test_fixed_vertices_and_curves_are_kept(make: Make, measure: Measure) -> None:
    mesh = shapes.dome(12, 5)
    lowest = np.arange(0, mesh.n_vertices, 6)
    bent = shaken(mesh, 0.02, 0)
    vertices = bent.vertices.copy()
    vertices[lowest, 2] = 0.1  # level, and so is the curve through them
    bent = mesh.with_vertices(vertices)
    result = make(bent, Guides(curves=[[*lowest, lowest[0]]], fixed=[0, 8])).mesh
    assert np.nanmax(measure(result)) <= 1e-12
    np.testing.assert_array_equal(result.vertices[[0, 8]], bent.vertices[[0, 8]])
    np.testing.assert_allclose(result.vertices[lowest, 2], 0.1, atol=1e-9)
    assert np.abs(result.vertices - bent.vertices)[lowest[1:]].max() > 1e-3


def test_constraints_that_hardly_differ_from_dependent_ones_are_met() -> None:
    # corners on a level circle, all around, with 12 faces beyond: circularity nearly follows once around
    mesh = shapes.dome(12, 5)
    inner = np.flatnonzero(~mesh.combinatorics.is_boundary_vertex)
    vertices = mesh.vertices.copy()
    vertices[inner] += np.random.default_rng(0).uniform(-0.01, 0.01, size=(len(inner), 3))
    result = make_circular(mesh.with_vertices(vertices), Guides(curves=[[*range(0, mesh.n_vertices, 6), 0]]))
    assert result.iterations < 15
    assert circularity(result.mesh).max() <= 1e-12


@KINDS
def test_lines_far_from_those_of_curvature_are_refused(make: Make, measure: Measure) -> None:
    # parallels and straight lines of a hypar: asymptotic directions, along which no planar quads lie
    with pytest.raises(GeometryError, match=r"(folded over|off its plane|off a circle|not conical).*principal"):
        make(graph(8, lambda x, y: 0.5 * x * y))


@pytest.mark.parametrize(
    ("make", "element", "sentence"),
    [
        (make_circular, "face", r"face \d+ is still off a circle by \S+ of the mean edge length, allowed 1e-12"),
        (make_conical, "vertex", r"vertex \d+ is still not conical by \S+ radians, allowed 1e-12"),
    ],
)
def test_what_is_off_is_named(make: Make, element: str, sentence: str) -> None:
    planar = planarise(shaken(shapes.dome(12, 4), 0.03, 5)).mesh  # nothing is done, so only the target is missed
    with pytest.raises(ConvergenceError, match=f"{sentence}, after 0 steps") as raised:
        make(planar, effort=Effort(max_steps=0))
    worst = raised.value.elements[0]
    measured = circularity(planar) if element == "face" else conicality(planar)
    assert measured[worst] > 0.3 * np.nanmax(measured)  # largest by another norm
