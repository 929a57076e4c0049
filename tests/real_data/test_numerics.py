"""Planarising, parallel spaces and Gauss images on real meshes: as good as has been reached on them before."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geometry.errors import GeometryError, RankError
from geometry.exact_offsets import circularity, conicality, edge_axis_twist
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.gauss.distances import edge_distances
from geometry.meshing import Effort, Guides, OptimisedMesh, planarise
from geometry.parallel.edge_parallelity import parallelity
from geometry.parallel.space import ParallelSpace
from tests.real_data.meshes import (
    BOTANIC,
    CATENOID,
    CIRCULAR,
    CONICAL,
    CONJUGATE,
    GITTER,
    HEXAGONAL,
    SIX_ARMED,
    YAS,
    needs_data,
    read,
)

pytestmark = needs_data


@cache
def planar(name: str) -> OptimisedMesh:
    return planarise(read(name))


@pytest.mark.parametrize(
    ("name", "steps", "largest_move"),
    [
        (CONICAL, 3, 1e-3),
        (SIX_ARMED, 3, 1e-3),
        (BOTANIC, 20, 0.28),
        (YAS, 4, 2e-3),
        (GITTER, 3, 1e-4),
        (HEXAGONAL, 2, 3e-10),
        (CATENOID, 3, 1e-4),
        (CIRCULAR, 20, 0.14),
        (CONJUGATE, 20, 0.48),
    ],
)
def test_planarise(name: str, steps: int, largest_move: float) -> None:
    result = planar(name)
    assert result.plane_deviation_after <= 1e-12
    assert result.iterations <= steps
    assert result.largest_move <= largest_move
    # edges stay edges that can be built
    ratio = result.mesh.edge_lengths / read(name).edge_lengths
    assert 0.45 < ratio.min() <= ratio.max() < 1.45


def test_less_fairness_stays_closer_to_the_surface() -> None:
    result = planarise(read(BOTANIC), Guides(fairness=0.01), Effort(anchored_steps=8))
    assert result.plane_deviation_after <= 1e-12
    assert result.largest_move < 0.25


@pytest.mark.parametrize(
    ("name", "dimension", "first_nonzero"),
    [(HEXAGONAL, 222, 0.1), (SIX_ARMED, 64, 5e-5), (YAS, 107, 3e-4), (CONICAL, 69, 0.05), (GITTER, 119, 1e-5)],
)
def test_dimensions(name: str, dimension: int, first_nonzero: float) -> None:
    spectrum = ParallelSpace(planar(name).mesh).spectrum
    assert spectrum.dimension == dimension
    # the hexagonal one owes two of its dimensions to being a Koebe polyhedron, which its file states to 4e-11
    assert spectrum.last_zero < 2e-10
    assert spectrum.first_nonzero > first_nonzero


@pytest.mark.parametrize("name", [SIX_ARMED, YAS, GITTER])
def test_there_is_no_gap_before_planarising(name: str) -> None:
    with pytest.raises(RankError, match="no gap"):
        _ = ParallelSpace(read(name)).dimension


@pytest.mark.parametrize(
    ("name", "heights", "radii"),
    [
        # percentiles 0, 5, 50, 95, 100 of the beam heights over d; range of the vertices
        (CONICAL, (0.997, 0.999, 1.001, 1.010, 1.026), (0.99, 1.035)),
        (SIX_ARMED, (0.96, 0.98, 1.00, 1.03, 1.05), (0.97, 1.05)),
        (BOTANIC, (0.85, 0.93, 1.00, 1.09, 1.22), (0.90, 1.23)),
        (YAS, (0.56, 0.83, 1.01, 1.29, 1.79), (0.71, 1.83)),
        (GITTER, (0.87, 0.94, 1.01, 1.11, 1.28), (0.92, 1.31)),
        (HEXAGONAL, (0.998, 0.998, 1.006, 1.010, 1.010), (0.998, 1.014)),
        (CATENOID, (0.998, 0.998, 1.0, 1.002, 1.002), (0.998, 1.002)),
        (CIRCULAR, (0.99, 0.99, 1.0, 1.01, 1.01), (0.99, 1.01)),
        (CONJUGATE, (0.965, 0.98, 1.00, 1.02, 1.05), (0.97, 1.09)),
    ],
)
def test_gauss_image(name: str, heights: tuple[float, ...], radii: tuple[float, float]) -> None:
    mesh = planar(name).mesh
    pair = approximate_pair(mesh, normals=mesh.vertex_normals)  # as beams are built
    assert parallelity(mesh, pair.gauss_image).max() <= 1e-13
    found = np.percentile(pair.edge_distances, [0, 5, 50, 95, 100])
    below, above = np.array(heights[:2]), np.array(heights[3:])
    assert (found[:2] >= below).all(), found
    assert (found[3:] <= above).all(), found
    assert found[2] == pytest.approx(heights[2], abs=0.02)
    distances = pair.vertex_distances
    assert radii[0] <= distances.min() <= distances.max() <= radii[1]


def test_a_file_that_is_not_planar_is_refused() -> None:
    with pytest.raises(GeometryError, match="planarise the mesh first"):
        approximate_pair(read(GITTER))


def test_a_conical_mesh_nearly_has_a_face_offset() -> None:
    mesh = planar(CONICAL).mesh
    assert np.nanmax(conicality(mesh)) < 1e-5
    assert np.nanmedian(conicality(planar(GITTER).mesh)) > 1e-3
    distances = approximate_pair(mesh, vertices=1e-3).face_distances
    np.testing.assert_allclose(distances, 1.0, atol=1e-4)


def test_a_circular_mesh_is_distinguished_from_others() -> None:
    assert np.median(circularity(planar(CIRCULAR).mesh)) < 2e-3
    assert np.median(circularity(planar(SIX_ARMED).mesh)) < 4e-3
    assert np.median(circularity(planar(YAS).mesh)) > 5e-2


def test_meshes_with_edge_offsets_are_recognised() -> None:
    hexagonal = read(HEXAGONAL)
    np.testing.assert_allclose(edge_distances(hexagonal), 1.0, atol=4e-11)
    assert np.nanmax(edge_axis_twist(hexagonal)) < 1e-10
    # some of its edges run the other way in the Gauss image
    assert np.nanmax(edge_axis_twist(read(CATENOID))) < 1.4e-4
    assert np.nanmedian(edge_axis_twist(planar(BOTANIC).mesh)) > 1e-2
