"""Meshes of 1 000 faces laid on three roofs and planarised: what a fabricator may rely on."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.layout import lay_quads
from geometry.layout.quality import corner_angles
from geometry.meshing import Guides, planarise
from geometry.surface import refined
from tests.geometry.design_surfaces import roof
from tests.real_data.meshes import needs_data


@needs_data
@pytest.mark.parametrize(
    ("name", "valences"), [("train-station", {5: 8}), ("botanic-garden-bubble", {3: 1}), ("dome", {5: 2})]
)
def test_roofs(name: str, valences: dict[int, int]) -> None:
    surface = roof(name)
    laid = lay_quads(surface, n_faces=1000)
    c, quality = laid.mesh.combinatorics, laid.quality
    assert abs(c.n_faces - 1000) < 50
    assert quality.valences == valences
    assert c.euler_characteristic == surface.mesh.combinatorics.euler_characteristic
    assert len(c.boundary_loops) == len(surface.mesh.combinatorics.boundary_loops)
    assert quality.quad_share > 0.95
    assert np.quantile(quality.off_network, 0.9) < np.radians(10)

    smooth = refined(surface)
    planar = planarise(laid.mesh, Guides(surface=smooth))
    off = np.linalg.norm(smooth.closest(planar.mesh.vertices)[0] - planar.mesh.vertices, axis=1)
    off /= laid.mesh.mean_edge_length
    angles = np.degrees(corner_angles(planar.mesh))
    assert planar.mesh.planarity.max() < 1e-12
    assert np.quantile(planar.moves, 0.95) < 0.08
    assert np.quantile(off, 0.95) < 0.03
    assert off.max() < 0.1
    assert angles.min() > 20
    assert angles.max() < 172
