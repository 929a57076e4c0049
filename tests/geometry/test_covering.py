"""A surface covered by hexagons: S looks where the surface does, and what is parallel to it touches the surface."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geometry.edge_offset import koebe, mean_normal, surface_cover
from geometry.gauss import Pair
from geometry.mesh import Mesh, shapes, tilings
from geometry.surface import Surface

S = koebe(tilings.hexagon_patch(6, 7), coverage=0.05).mesh


def cap(turn: Rotation) -> Mesh:
    """Of the unit sphere, over a square about its middle."""
    grid = shapes.grid(24, 24)
    x, y = (grid.vertices[:, :2].T - 12) / 20
    return grid.with_vertices(turn.apply(np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=1)))


def area(mesh: Mesh) -> float:
    return float(np.linalg.norm(mesh.vector_areas, axis=1).sum())


@pytest.mark.parametrize("vector", [(0.0, 0.0, 0.0), (0.7, -0.4, 0.0), (3.0, 0.3, 0.2), (0.0, np.pi, 0.0)])
@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_s_is_turned_to_the_mean_normal_and_its_planes_touch(vector: tuple[float, float, float], angle: float) -> None:
    turn = Rotation.from_rotvec(vector)
    surface = cap(turn)
    axis, widest = mean_normal(surface)
    np.testing.assert_allclose(axis, turn.apply([0.0, 0.0, 1.0]), rtol=0, atol=1e-9)
    assert widest == pytest.approx(np.arcsin(0.6 * 2**0.5), abs=0.07)  # half a face, seen along the slope
    cover = surface_cover(Surface(surface), S, angle)
    middle = cover.gauss_image.face_normals.mean(axis=0)
    assert middle @ axis / np.linalg.norm(middle) > 1 - 1e-3
    assert len(cover.kept) == cover.gauss_image.n_faces == S.n_faces  # well within the normals of the surface
    pair = Pair(cover.found.mesh, cover.gauss_image)
    assert not pair.is_inwards
    heights = np.einsum("fk,fk->f", cover.found.touching, pair.mesh.face_normals)
    np.testing.assert_allclose(heights, 1.0, rtol=0, atol=1e-2)  # of a sphere in triangles
    assert cover.times == pytest.approx(area(surface) / area(S), rel=0.1)  # the sphere is its own Gauss image
    assert 0 < cover.fitness < 1


def test_the_angle_turns_s_about_its_axis() -> None:
    surface = Surface(cap(Rotation.identity()))
    straight, turned = surface_cover(surface, S), surface_cover(surface, S, 0.4)
    expected = Rotation.from_rotvec([0.0, 0.0, 0.4]).apply(np.array(straight.gauss_image.vertices))
    np.testing.assert_allclose(turned.gauss_image.vertices, expected, rtol=0, atol=1e-9)
