"""Minimal meshes over real Gauss images, and how minimal a real mesh is."""

from __future__ import annotations

import numpy as np

from geometry.curvature import ChristoffelDuals, face_curvatures
from geometry.edge_offset.rotational import BandTiling, rotational_koebe
from geometry.exact_offsets import edge_offset_pair
from geometry.gauss import Pair
from geometry.meshing import planarise
from geometry.parallel import edge_factors
from tests.real_data.meshes import CATENOID, HEXAGONAL, needs_data, read

pytestmark = needs_data


def test_the_hexagonal_koebe_polyhedron_has_a_minimal_dual() -> None:
    """|H| times the mean edge length of M is below 1e-9: of 41 independent duals, the fairest is a catenoid."""
    image = planarise(read(HEXAGONAL)).mesh
    duals = ChristoffelDuals(image)
    assert duals.dimension == 41  # E - 3F = 40, and one of its equations follows from others
    mesh = duals.fairest()
    curvatures = face_curvatures(Pair(mesh, image))
    assert np.abs(curvatures.mean).max() * mesh.mean_edge_length <= 1e-9
    assert (curvatures.gaussian < 0).all()
    around_axis = np.cross(image.vertices, [0, 0, 1])[image.combinatorics.edges[:, 0]]
    meridian = np.abs((around_axis * image.edge_directions).sum(axis=1)) < 1e-6
    signs = np.sign(edge_factors(image, mesh))  # Fig. 18: the edges of one kind are reversed
    assert (signs == np.where(meridian, signs[meridian][0], -signs[meridian][0])).all()


def test_it_is_the_band_of_standing_hexagons_but_for_its_boundary() -> None:
    image = read(HEXAGONAL)
    inner = ~image.combinatorics.is_boundary_vertex
    ours = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, 20, 9)
    radii = np.sort(np.linalg.norm(image.vertices[inner, :2], axis=1))
    found = np.sort(np.linalg.norm(ours.vertices[~ours.combinatorics.is_boundary_vertex, :2], axis=1))
    np.testing.assert_allclose(radii, found, rtol=0, atol=1e-10)  # what the file states


def test_the_catenoid_is_minimal_with_respect_to_its_edge_gauss_image() -> None:
    """As measured on the file, made planar: |H| over sqrt(-K), a pure number, is 0 on a minimal surface."""
    mesh = planarise(read(CATENOID)).mesh
    curvatures = face_curvatures(edge_offset_pair(mesh, tolerance=1e-5))  # the file has six digits
    assert (curvatures.gaussian < 0).all()
    relative = np.abs(curvatures.mean) / np.sqrt(-curvatures.gaussian)
    assert np.median(relative) <= 2e-3
