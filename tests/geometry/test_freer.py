"""Rounding of a file does not decide about the Gauss image of a mesh whose conditions depend on each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import RankError
from geometry.gauss import approximate_pair, rounded_mesh_pair
from geometry.mesh import Mesh, shapes
from geometry.meshing import planarise
from geometry.parallel import ParallelSpace, parallelity

from .bent_meshes import shaken, vault
from .box_meshes import block, noisy, turning

seeds = st.integers(0, 2**32 - 1)


def stretched_torus() -> Mesh:
    profile = np.array([[3.0, -1.2], [4.4, -0.7], [4.4, 0.7], [3.0, 1.2], [2.0, 0.0]])
    torus = shapes.torus(profile, 12)
    return torus.with_vertices(torus.vertices * [1.4, 1.0, 0.7])


def stretched_dome() -> Mesh:
    dome = shapes.dome(12, 4)
    return dome.with_vertices(dome.vertices * [1.4, 1.0, 0.8])


def with_triangles() -> Mesh:
    """A surface of translation, of which every third quad is cut in two."""
    steps = np.arange(6) - 2.5
    first = np.stack([steps, 0 * steps, -0.06 * steps**2], axis=1)
    second = np.stack([0 * steps, steps, -0.05 * steps**2], axis=1)
    quads = shapes.translation_surface(first, second)
    faces: list[list[int]] = []
    for k, (a, b, c, d) in enumerate(quads.combinatorics.faces):
        faces += [[a, b, c], [a, c, d]] if k % 3 == 0 else [[a, b, c, d]]
    return Mesh.from_faces(quads.vertices, faces)


FREE = {"torus": stretched_torus(), "dome": stretched_dome(), "triangles": with_triangles()}


def made_planar(mesh: Mesh) -> tuple[Mesh, float]:
    planar = planarise(mesh).mesh
    return planar, float(np.linalg.norm(planar.vertices - mesh.vertices, axis=1).max())


@given(st.sampled_from(sorted(FREE)), st.floats(-10, -5.5), seeds)
@settings(max_examples=40, deadline=None)
def test_copies_that_are_rounded_have_the_same_image(name: str, decade: float, seed: int) -> None:
    """S is off by no more than the rounding, over singular values of a hundredth."""
    mesh, turn = FREE[name], turning(seed)
    planar, moved = made_planar(noisy(mesh.with_vertices(mesh.vertices @ turn.T), 10**decade, seed))
    pair = rounded_mesh_pair(planar, moved)
    found, image = pair.mesh, pair.gauss_image
    np.testing.assert_allclose(
        image.vertices, approximate_pair(mesh).gauss_image.vertices @ turn.T, atol=1e-8 + 300 * 10**decade
    )
    assert parallelity(found, image).max() < 1e-11
    assert found.planarity.max() < 1e-12
    assert np.linalg.norm(found.vertices - planar.vertices, axis=1).max() <= 4 * moved


def test_a_rounded_mesh_alone_has_another_image() -> None:
    """What is mended: made planar, the torus has lost dimensions."""
    mesh = FREE["torus"]
    planar, _ = made_planar(noisy(mesh, 1e-7, 1))
    assert ParallelSpace(planar).expected_dimension < ParallelSpace(mesh).dimension
    assert (
        np.abs(approximate_pair(planar).gauss_image.vertices - approximate_pair(mesh).gauss_image.vertices).max() > 0.1
    )


@given(st.floats(-10, -3), seeds)
@settings(max_examples=20, deadline=None)
def test_other_meshes_stay_as_they_are(decade: float, seed: int) -> None:
    planar, moved = made_planar(shaken(vault(), 10**decade, seed))
    found = rounded_mesh_pair(planar, moved)
    assert found.mesh is planar
    np.testing.assert_array_equal(found.gauss_image.vertices, approximate_pair(planar).gauss_image.vertices)


def test_where_nothing_was_rounded_the_deciding_equations_are_reported() -> None:
    """Faces in one plane, but for the last digits, which were not made so by planarising."""
    planar, moved = made_planar(noisy(block(4), 1e-12, 0))
    for within in (0.0, 1.1e-4 * planar.mean_edge_length):
        with pytest.raises(RankError, match="rounding decides"):
            rounded_mesh_pair(planar, within)
    if moved:
        assert np.isfinite(rounded_mesh_pair(planar, moved).gauss_image.vertices).all()


@pytest.mark.parametrize("rounds", [1, 4])
def test_weights_and_rounds_are_those_of_the_gauss_image(rounds: int) -> None:
    mesh = FREE["torus"]
    planar, moved = made_planar(noisy(mesh, 1e-8, 5))
    weights = {"faces": 0.5, "edges": 1.0, "vertices": 0.2, "rounds": rounds}
    image = rounded_mesh_pair(planar, moved, **weights).gauss_image
    expected = approximate_pair(mesh, **weights).gauss_image
    np.testing.assert_allclose(image.vertices, expected.vertices, atol=1e-5)
