"""Corners of the boundary of a surface: vertices that smoothing keeps in place and that laid meshes keep as well."""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray
from geometry.mesh import Mesh

__all__ = ["boundary_corners"]

SHARP_BOUNDARY_TURN = np.radians(35.0)
"""Turn of the boundary at a vertex, in radians, above which it is a corner."""


def boundary_corners(mesh: Mesh) -> BoolArray:
    """(N,) whether the boundary turns at the vertex by more than `SHARP_BOUNDARY_TURN`, 35 degrees.

    >>> from geometry.mesh import shapes
    >>> from geometry.surface import boundary_corners
    >>> boundary_corners(shapes.grid(3, 2)).nonzero()[0].tolist()
    [0, 2, 9, 11]
    """
    c = mesh.combinatorics
    rim = np.flatnonzero(c.twin < 0)
    tails, heads = c.corners[rim], c.corners[c.next_corner[rim]]
    into, out = np.zeros((2, c.n_vertices, 3))
    out[tails] = into[heads] = mesh.vertices[heads] - mesh.vertices[tails]
    turns = np.arctan2(np.linalg.norm(np.cross(into, out), axis=1), np.einsum("ni,ni->n", into, out))
    corners: BoolArray = turns > SHARP_BOUNDARY_TURN
    return corners
