"""Planar, circular and conical meshes from real ones, guided as on a job."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from geometry.errors import GeometryError
from geometry.exact_offsets import circularity, conicality
from geometry.mesh import Mesh
from geometry.meshing import Guides, OptimisedMesh, make_circular, make_conical, planarise
from geometry.surface.curve import Curve
from geometry.surface.surface import Surface
from tests.real_data.meshes import BOTANIC, CIRCULAR, CONICAL, CONJUGATE, SIX_ARMED, YAS, needs_data, read

pytestmark = needs_data

ROOF = "directional/botanic-garden-bubble.off"


@pytest.mark.parametrize(
    ("name", "steps", "largest_move", "mean_move"),
    [(CIRCULAR, 12, 0.16, 0.035), (CONICAL, 5, 0.03, 0.005), (SIX_ARMED, 11, 0.14, 0.035)],
)
def test_circular(name: str, steps: int, largest_move: float, mean_move: float) -> None:
    result = make_circular(read(name))
    assert result.plane_deviation_after <= 1e-12
    assert circularity(result.mesh).max() <= 1e-12
    assert result.iterations <= steps
    assert result.largest_move <= largest_move
    assert result.mean_move <= mean_move


@pytest.mark.parametrize(
    ("name", "steps", "largest_move", "mean_move"),
    [(CIRCULAR, 12, 0.16, 0.031), (CONICAL, 3, 1e-3, 1e-4), (SIX_ARMED, 11, 0.20, 0.035)],
)
def test_conical(name: str, steps: int, largest_move: float, mean_move: float) -> None:
    result = make_conical(read(name))
    assert result.plane_deviation_after <= 1e-12
    assert np.nanmax(conicality(result.mesh)) <= 1e-12
    assert result.iterations <= steps
    assert result.largest_move <= largest_move
    assert result.mean_move <= mean_move


@pytest.mark.parametrize("make", [make_circular, make_conical])
@pytest.mark.parametrize("name", [YAS, BOTANIC])
def test_meshes_far_from_lines_of_curvature_are_refused_with_numbers(
    make: Callable[[Mesh], OptimisedMesh], name: str
) -> None:
    with pytest.raises(GeometryError, match="principal curvature lines") as raised:
        make(read(name))
    assert raised.value.elements
    assert raised.value.value is not None
    assert raised.value.bound is not None


def test_a_roof_glides_on_its_surface() -> None:
    mesh, surface = read(BOTANIC), Surface(read(ROOF))
    free, gliding = planarise(mesh), planarise(mesh, Guides(surface=surface))
    distances = [np.linalg.norm(r.mesh.vertices - surface.closest(r.mesh.vertices)[0], axis=1) for r in (free, gliding)]
    assert gliding.plane_deviation_after <= 1e-12
    assert distances[1].mean() < 0.4 * distances[0].mean()
    assert gliding.surface_distance == pytest.approx(distances[1].max() / mesh.mean_edge_length)
    assert distances[1].max() < 0.6 * distances[0].max()


def test_the_boundaries_of_a_roof_are_kept() -> None:
    mesh = read(BOTANIC)
    result = planarise(mesh, Guides(keep_boundary=True)).mesh
    for loop in mesh.combinatorics.boundary_loops:
        curve = Curve.through(mesh.vertices[loop], closed=True)
        feet, _ = curve.closest(result.vertices[loop])
        np.testing.assert_allclose(result.vertices[loop], feet, atol=1e-9 * mesh.mean_edge_length)
        corners = loop[curve.corners]
        np.testing.assert_array_equal(result.vertices[corners], mesh.vertices[corners])


def test_a_face_that_is_a_corner_of_the_boundary_all_around_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"face 1476 is off its plane .* ends, corners or crossings of curves"):
        planarise(read(CONJUGATE), Guides(keep_boundary=True))


def test_all_faces_of_a_roof_come_out_convex() -> None:
    mesh = read(BOTANIC)
    result = planarise(mesh, Guides(convex="all")).mesh
    c = result.combinatorics
    edges = result.vertices[c.corners[c.next_corner]] - result.vertices[c.corners]
    turns = np.einsum("ci,ci->c", np.cross(edges[c.previous_corner], edges), result.face_normals[c.corner_face])
    assert turns.min() > 0
