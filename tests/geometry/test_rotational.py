"""Koebe polyhedra with rotational symmetry, and over a square grid: edges touch the sphere, faces are plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.edge_offset.enneper import enneper_koebe
from geometry.edge_offset.rotational import BandTiling, rotational_koebe, rows_within
from geometry.errors import GeometryError
from geometry.gauss import edge_distances
from geometry.gauss.distances import edge_feet
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_centroids

ROUNDING = 1e-12
"""Sizes about 1, a few dozen operations; bands here come to 1e-2 of the poles, where that costs two digits."""

tilings = st.sampled_from(list(BandTiling))


def assert_koebe(mesh: Mesh) -> None:
    np.testing.assert_allclose(edge_distances(mesh), 1, rtol=0, atol=ROUNDING)
    assert mesh.planarity.max() <= ROUNDING


def inside(mesh: Mesh) -> FloatArray:
    """(F,) positive where a face is counter-clockwise seen from outside."""
    outwards = face_centroids(mesh.vertices, mesh.combinatorics)
    return np.asarray(np.einsum("fk,fk->f", mesh.vector_areas, outwards))


@given(tilings, st.integers(3, 24), st.integers(2, 6), st.floats(-0.7, 0.7))
def test_edges_touch_the_sphere(tiling: BandTiling, around: int, rows: int, latitude: float) -> None:
    band = rotational_koebe(tiling, around, min(rows, around), latitude=latitude)
    assert_koebe(band)
    assert (inside(band) > 0).all()
    assert band.n_faces == around * min(rows, around)
    assert band.combinatorics.euler_characteristic == 0
    assert set(band.combinatorics.face_sizes) == {4 if tiling is BandTiling.QUADS else 6}


@given(tilings, st.integers(3, 24), st.integers(2, 5))
def test_a_band_about_the_equator_is_symmetric(tiling: BandTiling, around: int, rows: int) -> None:
    band = rotational_koebe(tiling, around, rows).vertices
    turned = band * [1, -1, -1]  # half a turn about the x axis
    for points in (
        turned,
        turned @ [[np.cos(t := np.pi / around), np.sin(t), 0], [-np.sin(t), np.cos(t), 0], [0, 0, 1]],
    ):
        away = np.linalg.norm(points[:, None] - band[None], axis=2).min(axis=1)
        if away.max() <= ROUNDING:
            return
    pytest.fail("the band is no image of itself")


@given(tilings, st.integers(3, 40), st.floats(0.5, 1.4))
def test_as_many_rows_as_fit(tiling: BandTiling, around: int, latitude: float) -> None:
    def reach(rows: int) -> float:
        band = rotational_koebe(tiling, around, rows)
        return float(np.arcsin(np.abs(edge_feet(band)[:, 2]).max()))

    try:
        rows = rows_within(tiling, around, latitude)
    except GeometryError:
        rows = 0
    assert rows == 0 or reach(rows) <= latitude + ROUNDING
    assert reach(max(rows + 1, 2 if tiling is BandTiling.FLAT_TOP_HEXAGONS else 1)) > latitude


@given(st.integers(3, 24), st.integers(1, 4), st.floats(-0.5, 0.5))
def test_caps(around: int, rows: int, latitude: float) -> None:
    solid = rotational_koebe(BandTiling.QUADS, around, rows, latitude=latitude, capped=True)
    assert_koebe(solid)
    assert (inside(solid.translated(-solid.vertices.mean(axis=0))) > 0).all()  # the origin may be outside
    assert solid.combinatorics.euler_characteristic == 2


def test_the_cube() -> None:
    cube = rotational_koebe(BandTiling.QUADS, 4, 1, capped=True)
    np.testing.assert_allclose(np.linalg.norm(cube.vertices, axis=1), np.sqrt(3 / 2), rtol=ROUNDING)


@given(
    st.sampled_from([BandTiling.QUADS, BandTiling.FLAT_TOP_HEXAGONS]),
    st.integers(3, 16),
    st.integers(2, 4),
    st.integers(1, 3),
)
def test_folded_bands_run_over_themselves(tiling: BandTiling, around: int, rows: int, folds: int) -> None:
    once, band = rotational_koebe(tiling, around, rows), rotational_koebe(tiling, around, rows, folds=folds)
    assert_koebe(band)
    away = np.linalg.norm(band.vertices[:, None] - once.vertices[None], axis=2).min(axis=1)
    assert away.max() <= ROUNDING
    turned_over = inside(band) < -ROUNDING
    assert 0 < turned_over.sum() < band.n_faces
    assert band.combinatorics.euler_characteristic == 0


@given(st.integers(2, 12), st.floats(0.1, 1.9))
def test_equal_circles(faces: int, reach: float) -> None:
    patch = enneper_koebe(faces, reach=reach)
    assert_koebe(patch)
    assert (inside(patch) > 0).all()
    assert patch.combinatorics.euler_characteristic == 1


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rotational_koebe(BandTiling.QUADS, 2, 3), "2 faces around are asked for, an integer from 3"),
        (lambda: rotational_koebe(BandTiling.QUADS, 8, 0), "0 rows are asked for, an integer from 1"),
        (lambda: rotational_koebe(BandTiling.FLAT_TOP_HEXAGONS, 8, 1), "1 rows are asked for, an integer from 2"),
        (lambda: rotational_koebe(BandTiling.QUADS, 8, 3, latitude=1.6), "the latitude 1.6 is not between"),
        (lambda: rotational_koebe(BandTiling.QUADS, 8, 3, folds=-1), "-1 folds are asked for"),
        (lambda: rotational_koebe(BandTiling.QUADS, 8, 100), "nearer to the poles than 1e-05"),
        (
            lambda: rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, 8, 3, folds=1),
            "pointy-top hexagons cannot turn back",
        ),
        (lambda: rotational_koebe(BandTiling.FLAT_TOP_HEXAGONS, 8, 3, capped=True), "only a band of quads"),
        (lambda: rotational_koebe(BandTiling.QUADS, 8, 3, folds=1, capped=True), "only a band of quads"),
        (lambda: rotational_koebe("quads", 8, 3), "the tiling is 'quads': one of BandTiling.QUADS, "),  # type: ignore[arg-type]
        (lambda: rotational_koebe(BandTiling.QUADS, 8, 1.5), "1.5 rows are asked for"),  # type: ignore[arg-type]
        (lambda: rows_within(BandTiling.QUADS, 3, 0.1), "no band of 3 faces around fits"),
        (lambda: enneper_koebe(1), "1 faces along a side"),
        (lambda: enneper_koebe(2.5), "2.5 faces along a side"),  # type: ignore[arg-type]
        (lambda: enneper_koebe(4, reach=-1.0), "the reach is -1.0"),
        (lambda: enneper_koebe(2, reach=2.0), "circles in the middle are hemispheres"),
    ],
)
def test_what_cannot_be_is_refused(call: object, words: str) -> None:
    with pytest.raises(GeometryError, match=words):
        call()  # type: ignore[operator]
