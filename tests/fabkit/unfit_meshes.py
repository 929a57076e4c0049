"""Meshes that are not fit to be built from, or only just: each stands for a kind."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import Mesh, shapes


def along_rulings(n: int = 8, bend: float = 0.06) -> Mesh:
    """z = bend x y on n x n unit squares: the lines of the mesh are straight, and no planar mesh lies along them."""
    grid = shapes.grid(n, n)
    x, y, _ = grid.vertices.T
    return grid.with_vertices(np.stack([x, y, bend * x * y], axis=1))


def _parabola(direction: FloatArray, steps: FloatArray, bend: float) -> FloatArray:
    x, y = np.outer(direction, steps)
    return np.stack([x, y, bend * (x**2 - y**2) / 2], axis=1)


def across_rulings(n: int = 8, bend: float = 0.06) -> Mesh:
    """The same surface along lines turned by 45 degrees, those of principal curvature: exact parallelograms."""
    steps = np.arange(n + 1) - n / 2
    return shapes.translation_surface(*(_parabola(np.array(d), steps, bend) for d in ([1.0, 0.0], [0.0, 1.0])))


def askew(n: int = 16, bend: float = 0.15, turn_deg: float = 40.0) -> Mesh:
    """A saddle along conjugate directions that are only 90 - 2 turn degrees apart: planar, and its axes lean far."""
    steps, (c, s) = np.arange(n + 1) - n / 2, (np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg)))
    return shapes.translation_surface(*(_parabola(np.array(d), steps, bend) for d in ([c, s], [s, c])))


def through_itself(n: int = 4) -> Mesh:
    """Two vaulted sheets of n x n faces that cross each other in the middle."""
    steps = np.arange(n + 1) - n / 2
    first = np.stack([steps, 0 * steps, -0.04 * steps**2], axis=1)
    second = np.stack([0 * steps, steps, -0.05 * steps**2], axis=1)
    sheet = shapes.translation_surface(first, second)
    tilted = sheet.vertices @ np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]) + [0.13, 0.21, 0.17]
    faces = list(sheet.combinatorics.faces)
    others = [[int(vertex) + sheet.n_vertices for vertex in face] for face in faces]
    return Mesh.from_faces(np.concatenate([sheet.vertices, tilted]), [*map(list, faces), *others])


def two_flat_faces() -> Mesh:
    """Two trapezoids in one plane: nothing tells where the axes between them should point."""
    vertices = [(0, 0, 0), (2, 0, 0), (4, 0, 0), (0, 1.5, 0), (2, 1.5, 0), (4, 1.5, 0)]
    return Mesh.from_faces(vertices, [[0, 1, 4, 3], [1, 2, 5, 4]])


def narrow() -> Mesh:
    """Two quads, one with a corner of less than two degrees."""
    vertices = [(0, 0, 0), (1.5, 0, 0), (3, 0, 0), (1.4, 0.04, 0), (1.5, 1.5, 0), (3, 1.5, 0)]
    return Mesh.from_faces(vertices, [[0, 1, 4, 3], [1, 2, 5, 4]])


def rough(n: int = 10) -> Mesh:
    """Noise as heights: faces fold over when they are made planar."""
    grid = shapes.grid(n, n)
    heights = np.random.default_rng(0).uniform(-1, 1, grid.n_vertices)
    return grid.with_vertices(grid.vertices + np.outer(heights, [0, 0, 1]))


def triangles(n: int = 3) -> Mesh:
    """Squares cut in two: meshes parallel to it are scaled copies of it."""
    grid = shapes.grid(n, n)
    bent = grid.with_vertices(grid.vertices + np.outer(0.1 * grid.vertices[:, 0] ** 2, [0, 0, 1]))
    faces = [[int(v) for v in face] for face in grid.combinatorics.faces]
    return Mesh.from_faces(bent.vertices, [half for a, b, c, d in faces for half in ([a, b, c], [a, c, d])])
