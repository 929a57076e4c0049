"""Corners of the boundary: those that smoothing and subdivision keep in place, and those that laid meshes keep."""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray
from geometry.mesh import Mesh

__all__ = ["boundary_corners", "surface_corners"]

SHARP_BOUNDARY_TURN = np.radians(35.0)
"""Turn of the boundary at a vertex, in radians, above which it is a corner."""

CORNER_SPAN = 3
"""Number of boundary edges before and after a corner between whose chords the boundary turns sharply as well; where it
zigzags because triangles were cut away, it does not."""


def boundary_corners(mesh: Mesh) -> BoolArray:
    """(N,) whether the boundary turns at the vertex by more than `SHARP_BOUNDARY_TURN`, 35 degrees.

    >>> from geometry.mesh import shapes
    >>> from geometry.surface import boundary_corners
    >>> boundary_corners(shapes.grid(3, 2)).nonzero()[0].tolist()
    [0, 2, 9, 11]
    """
    return _turns_sharply(mesh, 1)


def surface_corners(mesh: Mesh) -> BoolArray:
    """(N,) the `boundary_corners` that are corners over `CORNER_SPAN` edges to both sides, too: of triangles that are
    small, so that a boundary that zigzags where triangles were cut away has few of them.

    >>> from geometry import Mesh
    >>> from geometry.surface import boundary_corners, surface_corners
    >>> rise = [0, 0.5] * 15 + [0]  # the lowest side is a zigzag
    >>> strip = Mesh.from_grid([[(x, y or rise[x], 0) for y in (0, 3, 4, 5, 6, 7)] for x in range(31)])
    >>> boundary_corners(strip).sum().item(), surface_corners(strip).sum().item()  # 4 more beside its ends
    (33, 8)
    """
    return boundary_corners(mesh) & _turns_sharply(mesh, CORNER_SPAN)


def _turns_sharply(mesh: Mesh, span: int) -> BoolArray:
    """(N,) whether chords over a number of boundary edges before and after a vertex turn sharply."""
    c = mesh.combinatorics
    rim = np.flatnonzero(c.twin < 0)
    tails, heads = c.corners[rim], c.corners[c.next_corner[rim]]
    before, after = np.tile(np.arange(c.n_vertices), (2, 1))
    before[heads], after[tails] = tails, heads
    first = last = np.arange(c.n_vertices)
    for _ in range(span):
        first, last = before[first], after[last]
    into, out = mesh.vertices - mesh.vertices[first], mesh.vertices[last] - mesh.vertices
    turns = np.arctan2(np.linalg.norm(np.cross(into, out), axis=1), np.einsum("ni,ni->n", into, out))
    is_sharp: BoolArray = c.is_boundary_vertex & (turns > SHARP_BOUNDARY_TURN)
    return is_sharp
