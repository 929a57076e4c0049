"""Meshes of 1 000 faces laid on three roofs and planarised: what a fabricator may rely on."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.layout import lay_quads
from geometry.layout.drafts import draft
from geometry.layout.seams import seamless_maps
from geometry.layout.twists import twist_corrections
from geometry.meshing import Guides, planarise
from geometry.networks.conjugate_networks import conjugate_network
from geometry.networks.tangent_frames import TangentFrames
from geometry.remeshing import remesh
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
    angles = np.degrees(planar.mesh.corner_angles)
    assert planar.mesh.planarity.max() < 1e-12
    assert np.quantile(planar.moves, 0.95) < 0.08
    assert np.quantile(off, 0.95) < 0.03
    assert off.max() < 0.1
    assert angles.min() > 20
    assert angles.max() < 172


@needs_data
@pytest.mark.parametrize("name", ["train-station", "botanic-garden-bubble"])
def test_finer_meshes_keep_their_corners_convex(name: str) -> None:
    """Of inner faces, too: vertices glide by half an edge where the surface hardly curves along its lines."""
    result = remesh(roof(name), n_faces=3000)
    assert np.quantile(result.planarised.moves, 0.95) < 0.08
    assert np.quantile(result.surface_distances, 0.95) < 0.03 * result.mesh.mean_edge_length
    angles = np.degrees(result.mesh.corner_angles)
    assert angles.min() > 8
    assert angles.max() < 172


@needs_data
def test_rims_keep_inner_vertices_regular() -> None:
    """Half as high, the bubble has no umbilic, and no contraction at the rim makes one."""
    laid = lay_quads(roof("botanic-garden-bubble"), n_faces=1000, affine=np.diag([1, 1, 0.5]))
    assert len(laid.singularities) == 0
    assert laid.quality.valences == {}


@needs_data
def test_measured_twist_lessens_the_moves() -> None:
    surface = roof("botanic-garden-bubble")
    frames = TangentFrames(surface.triangulated)
    network, field, _ = conjugate_network(frames, None, np.zeros(frames.combinatorics.n_edges, dtype=bool))
    maps = seamless_maps(frames.combinatorics, field)
    first = draft(network, field, maps, 1000)
    twists = twist_corrections(network, first.derivatives, first.mesh, first.edge_length)
    second = draft(network.corrected(twists), field, maps, 1000)
    smooth = Guides(surface=refined(surface))
    moves = [planarise(step.mesh, smooth).mean_move for step in (first, second)]
    assert moves[1] < 0.75 * moves[0]
