"""Three tubes that meet: a shape for constant mean curvature, as in Fig. 19 of the paper."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import Mesh
from geometry.meshing import planarise

ARMS = np.array([[np.cos(a), np.sin(a), 0.0] for a in 2 * np.pi * np.arange(3) / 3])
LENGTH, BLEND = 3.0, 0.35
"""Of an arm, and over what distance they are blended, in radii."""


def three_tubes(n: int, rings: int) -> Mesh:
    """3 n x rings planar quads around three tubes of radius 1, blended; n is even. Two vertices have valence 6."""
    angles = np.pi / 2 + 2 * np.pi * np.arange(n) / n
    sides = np.cross([0.0, 0.0, 1.0], ARMS)
    around = np.cos(angles)[None, :, None] * sides[:, None] + np.sin(angles)[None, :, None] * [0.0, 0.0, 1.0]
    first = np.abs(np.cos(angles)) / np.tan(np.pi / 3)  # where arms meet, in the plane halfway between them
    steps = first[:, None] + (LENGTH - first[:, None]) * np.linspace(0, 1, rings + 1)
    points = around[:, :, None] + steps[None, :, :, None] * ARMS[:, None, None]
    shape = points.shape[:3]
    at = np.arange(points[..., 0].size).reshape(shape)
    ahead = np.roll(at, -1, axis=1)
    quads = np.stack([at[:, :, :-1], ahead[:, :, :-1], ahead[:, :, 1:], at[:, :, 1:]], axis=-1).reshape(-1, 4)
    _, kept, number = np.unique(points.reshape(-1, 3).round(9) + 0.0, axis=0, return_index=True, return_inverse=True)
    mesh = Mesh.from_faces(points.reshape(-1, 3)[kept], number.ravel()[quads].tolist())
    return planarise(_relaxed(mesh, rounds=2 * n + 6)).mesh


def _relaxed(mesh: Mesh, rounds: int) -> Mesh:
    """Inner vertices evenly spread over the blended tubes."""
    c, points = mesh.combinatorics, mesh.vertices.copy()
    free = ~c.is_boundary_vertex
    for _ in range(rounds):
        means = (c.adjacency @ points) / c.vertex_degrees[:, None]
        points[free] += 0.5 * (means - points)[free]
        for _ in range(3):
            slopes = np.stack([(_height(points + h) - _height(points - h)) / 2e-5 for h in 1e-5 * np.eye(3)], axis=1)
            steps = _height(points)[:, None] * slopes / np.square(slopes).sum(axis=1).clip(min=1e-3)[:, None]
            points[free] -= steps[free]
    return mesh.with_vertices(points)


def _height(points: FloatArray) -> FloatArray:
    """(N,) distances from three half cylinders of radius 1, blended."""
    along = np.maximum(points @ ARMS.T, 0.0)
    distances = np.linalg.norm(points[:, None] - along[:, :, None] * ARMS, axis=2) - 1.0
    return np.asarray(-BLEND * np.log(np.exp(-distances / BLEND).sum(axis=1)))
