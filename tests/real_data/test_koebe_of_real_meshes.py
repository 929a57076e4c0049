"""The hexagonal Koebe polyhedron of a real file, recognised and made again from its combinatorics."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.arrays import FloatArray
from geometry.circle_patterns.boundary_values import open_circle_pattern
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron, koebe
from geometry.errors import GeometryError
from geometry.mesh import Combinatorics, Mesh
from geometry.spheres.stereographic import plane_circles
from tests.geometry.test_koebe import misfit_up_to_rotation
from tests.real_data.meshes import CATENOID, HEXAGONAL, needs_data, read

pytestmark = needs_data

AS_WRITTEN = 1e-9
"""The file has 13 digits, but its edges are at distance 1 to 3e-11 only."""


def without_straight_vertices() -> Mesh:
    """The mesh without the 20 vertices on either boundary in the middle of a straight edge: they are on the sphere."""
    mesh = read(HEXAGONAL)
    straight = np.linalg.norm(mesh.vertices, axis=1) < 1 + 1e-6
    kept = np.flatnonzero(~straight)
    number = np.cumsum(~straight) - 1
    faces = [[number[v] for v in face if not straight[v]] for face in mesh.combinatorics.faces]
    return Mesh.from_faces(mesh.vertices[kept], faces)


def test_the_hexagonal_mesh_is_a_koebe_polyhedron() -> None:
    S = KoebePolyhedron(read(HEXAGONAL))
    np.testing.assert_allclose(np.linalg.norm(S.tangency_points, axis=1), 1, atol=AS_WRITTEN)
    with pytest.raises(GeometryError, match=r"the line of edge \d+ .* misses the unit sphere"):
        KoebePolyhedron(read(CATENOID))


def test_it_is_made_again_from_its_combinatorics_closed_by_two_faces() -> None:
    theirs = without_straight_vertices()
    c = theirs.combinatorics
    assert [len(loop) for loop in c.boundary_loops] == [20, 20]
    closed = Combinatorics.from_faces(
        c.n_vertices, [face.tolist() for face in c.faces] + [loop[::-1].tolist() for loop in c.boundary_loops]
    )
    S = koebe(closed)
    assert S.mesh.n_faces == 182
    assert misfit_up_to_rotation(S.mesh.vertices, theirs.vertices) <= AS_WRITTEN


def test_it_is_made_again_from_its_combinatorics_as_a_ring() -> None:
    theirs = without_straight_vertices()
    S = koebe(theirs.combinatorics, coverage=1.0)
    assert misfit_up_to_rotation(S.mesh.vertices, theirs.vertices) <= AS_WRITTEN


def test_it_is_made_again_from_the_radii_along_its_boundary() -> None:
    """Projected from a point beside the axis, all radii along its boundary differ."""
    theirs = without_straight_vertices()
    c = theirs.combinatorics
    turned = theirs.vertices @ rotation_about_y(0.2)
    lengths = np.linalg.norm(turned, axis=1)
    _, sizes = plane_circles(turned * [1, 1, -1] / lengths[:, None], 1 / lengths)
    assert (sizes > 0).all()
    boundary = np.where(c.is_boundary_vertex, sizes, np.nan)
    assert np.nanmax(boundary) > 3 * np.nanmin(boundary[boundary > np.nanmedian(boundary)])
    pattern = open_circle_pattern(c, radii=boundary, outer=int(np.nanargmax(boundary)))
    np.testing.assert_allclose(pattern.vertex_radii, sizes, rtol=1e-8)
    S = koebe(c, radii=boundary, outer=int(np.nanargmax(boundary)), coverage=1.0)
    assert misfit_up_to_rotation(S.mesh.vertices, theirs.vertices) <= AS_WRITTEN


def rotation_about_y(angle: float) -> FloatArray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
