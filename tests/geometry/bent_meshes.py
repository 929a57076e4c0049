"""Meshes with planar faces, what bends them, and an independent measure of planarity."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh, shapes


def vault(nx: int = 5, ny: int = 4) -> Mesh:
    """A curved mesh of exact parallelograms."""
    u, v = np.linspace(-1, 1, nx + 1), np.linspace(-0.8, 0.8, ny + 1)
    first = np.stack([3 * u, 0.2 * u, -(u**2)], axis=1)
    second = np.stack([0.1 * v, 3 * v, -0.7 * v**2 + 0.2 * v**3], axis=1)
    return shapes.translation_surface(first, second)


def with_midpoints(mesh: Mesh, chosen: IntArray) -> Mesh:
    """Mesh with a new vertex in the middle of each chosen edge: n-gons with collinear corners."""
    c = mesh.combinatorics
    number = {int(edge): [mesh.n_vertices + k] for k, edge in enumerate(chosen)}
    faces: list[list[int]] = [[] for _ in range(c.n_faces)]
    for vertex, edge, face in zip(c.corners.tolist(), c.corner_edge.tolist(), c.corner_face.tolist(), strict=True):
        faces[face] += [vertex, *number.get(edge, [])]
    return Mesh.from_faces(np.concatenate([mesh.vertices, mesh.vertices[c.edges[chosen]].mean(axis=1)]), faces)


def shaken(mesh: Mesh, amount: float, seed: int) -> Mesh:
    """Each coordinate moved by up to `amount` mean edge lengths."""
    noise = np.random.default_rng(seed).uniform(-amount, amount, size=mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + noise * mesh.mean_edge_length)


def out_of_plane(mesh: Mesh) -> float:
    """The largest distance of a corner from its face's best plane over the mean edge length, face by face, by SVD."""
    worst = 0.0
    for face in range(mesh.n_faces):
        corners = mesh.vertices[mesh.combinatorics.face(face)]
        corners = corners - corners.mean(axis=0)
        worst = max(worst, float(np.abs(corners @ np.linalg.svd(corners)[2][2]).max()))
    return worst / mesh.mean_edge_length


def rotation(seed: int) -> FloatArray:
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return q * np.linalg.det(q)


def graph(n: int, height: Callable[[FloatArray, FloatArray], FloatArray]) -> Mesh:
    """n x n squares lifted to the graph of a function on [-1, 1] x [-1, 1], enlarged n times."""
    grid = shapes.grid(n, n)
    x, y = (grid.vertices[:, :2] * 2 / n - 1).T
    return grid.with_vertices(grid.vertices + np.outer(n * height(x, y), [0, 0, 1]))
