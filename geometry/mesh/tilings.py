"""Combinatorics from which Koebe polyhedra are made, and the dual of any combinatorics."""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray
from geometry.errors import MeshError
from geometry.mesh import shapes
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh_arguments import CombinatoricsLike, as_combinatorics

__all__ = ["dual", "hexagon_patch", "pentagon_patch", "quad_patch", "rotational_hexagons", "rotational_quads"]


def quad_patch(nx: int, ny: int) -> Combinatorics:
    """A disc of nx by ny quads; vertex (i, j) has number i (ny + 1) + j.

    >>> from geometry.mesh import tilings
    >>> tilings.quad_patch(3, 2)
    Combinatorics(12 vertices, 6 faces, 17 edges)
    """
    _check_counts(columns=(nx, 1), rows=(ny, 1))
    return shapes.grid(nx, ny).combinatorics


def hexagon_patch(nx: int, ny: int) -> Combinatorics:
    """A disc of ny rows of nx hexagons, every other row shifted by half a hexagon.

    >>> from geometry.mesh import tilings
    >>> tilings.hexagon_patch(3, 2)
    Combinatorics(22 vertices, 6 faces, 27 edges)
    """
    _check_counts(columns=(nx, 1), rows=(ny, 1))
    return shapes.hexagonal_paraboloid(nx, ny).combinatorics


def pentagon_patch(nx: int, ny: int, *, closed: bool = False) -> Combinatorics:
    """Pentagons of the Cairo tiling, two vertices of valence 4 and three of valence 3 each [Pottmann2007, Fig. 11].

    In a grid of nx by ny squares, each edge between two squares becomes a pentagon: its two ends, and one or two points
    inside each of the squares, which have a short edge inside, alternately horizontal and vertical. closed: the first
    column of squares follows the last one around an axis, which makes an annulus; nx must then be even and at least 4.
    Raises MeshError for other numbers. The paper shows its pattern in a picture only, so this is an interpretation.

    >>> from geometry.mesh import tilings
    >>> tilings.pentagon_patch(4, 3)
    Combinatorics(40 vertices, 17 faces, 56 edges)
    >>> tilings.pentagon_patch(4, 3, closed=True)
    Combinatorics(40 vertices, 20 faces, 60 edges)
    """
    _check_counts(columns=(nx, 4 if closed else 1), rows=(ny, 1), squares=(nx * ny, 2))
    if closed and nx % 2:
        raise MeshError(f"{nx} columns around an axis: the edges inside squares alternate, so give an even number")
    n_columns = nx + (not closed)
    corner = np.arange(n_columns * (ny + 1)).reshape(n_columns, ny + 1)
    inside = corner.size + np.arange(2 * nx * ny).reshape(nx, ny, 2)  # left and right, or lower and upper point
    i, j = np.indices((nx, ny - 1)).reshape(2, -1)  # squares with another one above
    p, q, here, above = corner[i, j + 1], corner[(i + 1) % n_columns, j + 1], inside[i, j].T, inside[i, j + 1].T
    level = ((i + j) % 2 == 0)[:, None]
    upwards = np.where(level, _rows(p, here[0], here[1], q, above[0]), _rows(p, here[1], q, above[1], above[0]))
    i, j = np.indices((nx - (not closed), ny)).reshape(2, -1)  # squares with another one to the right
    right = (i + 1) % n_columns
    p, q, here, there = corner[right, j], corner[right, j + 1], inside[i, j].T, inside[right, j].T
    level = ((i + j) % 2 == 0)[:, None]
    sideways = np.where(level, _rows(p, there[0], there[1], q, here[1]), _rows(p, there[0], q, here[1], here[0]))
    return _numbered(np.concatenate([upwards, sideways]))


def rotational_quads(n: int, rings: int) -> Combinatorics:
    """An annulus of `rings` rings of n quads around an axis; vertex (i, j) has number i (rings + 1) + j.

    >>> from geometry.mesh import tilings
    >>> tilings.rotational_quads(12, 3)
    Combinatorics(48 vertices, 36 faces, 84 edges)
    """
    _check_counts(quads=(n, 3), rings=(rings, 1))
    ring = np.stack([np.ones(rings + 1), np.arange(rings + 1.0)], axis=1)
    return shapes.rotational_mesh(ring, n).combinatorics


def rotational_hexagons(n: int, rings: int) -> Combinatorics:
    """An annulus of `rings` rings of n hexagons around an axis, every other ring shifted by half a hexagon.

    Vertex (k, j), the k-th of the 2 n vertices on line j of rings + 1 lines around the axis, has number 2 n j + k;
    vertices with even k + j have an edge to the next line.

    >>> from geometry.mesh import tilings
    >>> tilings.rotational_hexagons(12, 3)
    Combinatorics(96 vertices, 36 faces, 132 edges)
    """
    _check_counts(hexagons=(n, 3), rings=(rings, 1))
    j, i = np.divmod(np.arange(n * rings), n)
    k = (2 * i + j % 2)[:, None] + [0, 1, 2]
    lower, upper = 2 * n * j[:, None] + k % (2 * n), 2 * n * (j + 1)[:, None] + k % (2 * n)
    faces = np.concatenate([lower, upper[:, ::-1]], axis=1)
    return Combinatorics(2 * n * (rings + 1), faces.ravel(), np.arange(0, faces.size + 1, 6))


def dual(combinatorics: CombinatoricsLike) -> Combinatorics:
    """The dual: a face for each inner vertex, and a vertex for each face that has an inner vertex, in the same order.

    For a closed polyhedron the dual of the dual is the original one. Raises MeshError where the mesh has no inner
    vertex.

    >>> from geometry.mesh import tilings, solids
    >>> tilings.dual(solids.cube())
    Combinatorics(6 vertices, 8 faces, 12 edges)
    >>> tilings.dual(tilings.quad_patch(4, 4))
    Combinatorics(16 vertices, 9 faces, 24 edges)
    """
    combinatorics = as_combinatorics(combinatorics)
    c = combinatorics
    inner = np.flatnonzero(c.is_used & ~c.is_boundary_vertex)
    if not len(inner):
        raise MeshError("no vertex is inside the mesh, so the dual would have no face: add a ring of faces")
    following = c.twin[c.previous_corner]  # counter-clockwise around its vertex
    any_corner = np.empty(c.n_vertices, dtype=np.int64)
    any_corner[c.corners] = np.arange(c.n_corners)
    sizes = c.vertex_degrees[inner]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    fan_corners = np.empty(starts[-1], dtype=np.int64)
    corner = any_corner[inner]
    for step in range(int(sizes.max())):
        has_more = sizes > step
        fan_corners[starts[:-1][has_more] + step] = corner[has_more]
        corner = following[corner]
    used, corners = np.unique(c.corner_face[fan_corners], return_inverse=True)
    return Combinatorics(len(used), corners, starts)


def _rows(*columns: IntArray) -> IntArray:
    return np.stack(columns, axis=1)


def _numbered(faces: IntArray) -> Combinatorics:
    """The combinatorics of faces (F, k) after their vertices are renumbered without gaps."""
    used, corners = np.unique(faces, return_inverse=True)
    return Combinatorics(len(used), corners.ravel(), np.arange(0, faces.size + 1, faces.shape[1]))


def _check_counts(**counts: tuple[int, int]) -> None:
    """Raises MeshError for a count that is not an integer or less than the second number, its least value."""
    for name, (count, least) in counts.items():
        if not isinstance(count, (int, np.integer)) or count < least:
            raise MeshError(
                f"{count} {name} are asked for, an integer from {least} upwards is needed", value=count, bound=least
            )
