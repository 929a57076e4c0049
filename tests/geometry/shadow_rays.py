"""Shadows by rays: an independent measure, coarse and slow, of what `geometry.shading` computes as polygons."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import Mesh


def shaded_shares(mesh: Mesh, quads: FloatArray, directions: FloatArray, rays: int) -> FloatArray:
    """(k, F) part of the rays from points spread over each panel that meet a quad (m, 4, 3) on the way to each sun.

    NaN where the panel faces away; `rays` start from each triangle between an edge of a panel and its middle, so panels
    are to be convex.
    """
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    shares = np.full((len(directions), mesh.n_faces), np.nan)
    for face in range(mesh.n_faces):
        corners = mesh.vertices[mesh.combinatorics.face(face)]
        points, weights = spread_points(corners, rays)
        radius = np.linalg.norm(corners - corners.mean(axis=0), axis=1).max()
        middles = triangles.mean(axis=1)
        reach = radius + np.linalg.norm(triangles - middles[:, None], axis=2).max(axis=1)
        for sun, direction in enumerate(directions):
            if mesh.face_normals[face] @ direction > 0:
                away = np.cross(middles - corners.mean(axis=0), direction)
                near = triangles[np.linalg.norm(away, axis=1) < reach]
                shares[sun, face] = weights @ meets_one(points, direction, near)
    return shares


def spread_points(corners: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Points spread evenly over a convex polygon (c, 3), n in each triangle, with the area each stands for."""
    golden = 1.32471795724474602596
    u, v = np.mod(0.5 + np.outer([1 / golden, 1 / golden**2], np.arange(n)), 1)
    u, v = np.where(u + v > 1, (1 - u, 1 - v), (u, v))
    middle, here, there = corners.mean(axis=0), corners, np.roll(corners, -1, axis=0)
    points = middle + u[:, None] * (here - middle)[:, None] + v[:, None] * (there - middle)[:, None]
    areas = np.linalg.norm(np.cross(here - middle, there - middle), axis=1)
    return points.reshape(-1, 3), np.repeat(areas / areas.sum() / n, n)


def meets_one(points: FloatArray, direction: FloatArray, triangles: FloatArray) -> FloatArray:
    """(p,) 1 where the ray from a point (p, 3) in a direction meets one of the triangles (m, 3, 3), else 0."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normal = np.cross(direction, second)
    volume = np.einsum("mk,mk->m", first, normal)
    real = np.abs(volume) > 1e-12
    first, second, normal, volume, base = first[real], second[real], normal[real], volume[real], triangles[real, 0]
    away = points[:, None] - base
    u = np.einsum("pmk,mk->pm", away, normal) / volume
    across = np.cross(away, first)
    v = across @ direction / volume
    t = np.einsum("pmk,mk->pm", across, second) / volume
    return np.asarray(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9)).any(axis=1), dtype=np.float64)
