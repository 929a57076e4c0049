"""Meshes of unit cubes, whose faces lie in common planes, and closed quad meshes with vertices of valence 3."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import Mesh

Cell = tuple[int, int, int]


def boxes(cells: Iterable[Cell]) -> Mesh:
    """The surface of unit cubes: the quads between a cell and none, outside outside."""
    solid = set(cells)
    quads: list[list[Cell]] = []
    for cell in sorted(solid):
        for axis in range(3):
            for side in (0, 1):
                step = np.eye(3, dtype=int)[axis] * (2 * side - 1)
                if tuple((np.array(cell) + step).tolist()) in solid:
                    continue
                first, second = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
                start = np.array(cell) + side * np.eye(3, dtype=int)[axis]
                quad = [start, start + first, start + first + second, start + second]
                quads.append([tuple(corner.tolist()) for corner in (quad if side else quad[::-1])])
    places = sorted({corner for quad in quads for corner in quad})
    number = {place: k for k, place in enumerate(places)}
    return Mesh.from_faces(np.array(places, dtype=float), [[number[corner] for corner in quad] for quad in quads])


def tower(n: int) -> Mesh:
    """Layers of n - k by n - k cubes, one corner above the other."""
    return boxes((i, j, k) for k in range(n) for i in range(n - k) for j in range(n - k))


def stairs(n: int, width: int) -> Mesh:
    return boxes((i, j, k) for i in range(n) for j in range(width) for k in range(i + 1))


def block(n: int) -> Mesh:
    return boxes((i, j, k) for i in range(n) for j in range(n) for k in range(n))


def ellipsoid(n: int, axes: tuple[float, float, float]) -> Mesh:
    """A cube of n by n quads a side, blown up: vertices of valence 4 but for 8 of valence 3; faces are not planar."""
    cube = block(n)
    blown = np.tan((2 * cube.vertices / n - 1) * np.pi / 4)
    return cube.with_vertices(blown / np.linalg.norm(blown, axis=1, keepdims=True) * axes)


def noisy(mesh: Mesh, amount: float, seed: int) -> Mesh:
    """Coordinates with normally distributed noise, in mean edge lengths."""
    noise = np.random.default_rng(seed).standard_normal(mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + amount * mesh.mean_edge_length * noise)


def turning(seed: int) -> FloatArray:
    """A random rotation (3, 3)."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return np.asarray(turn * np.linalg.det(turn))
