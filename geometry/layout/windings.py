"""Vertices around which (u, v) turns by a wrong angle, though no triangle is turned over."""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Combinatorics

__all__ = ["wrongly_wound"]


def wrongly_wound(c: Combinatorics, points: FloatArray, indices: IntArray) -> BoolArray:
    """(F,) the triangles at inner vertices that they do not surround by 4 quarter turns minus the index.

    points (F, 3, 2): the (u, v) at the corners. indices (N,): of the field, see `CombedField`.
    """
    at = points @ np.array([1, 1j])
    angles = np.angle((np.roll(at, 1, axis=1) - at) / (np.roll(at, -1, axis=1) - at))
    quarters = np.rint(np.bincount(c.corners, angles.ravel() / (np.pi / 2), c.n_vertices)).astype(np.int64)
    is_wrong = c.is_used & ~c.is_boundary_vertex & (quarters != 4 - indices)
    return np.asarray(is_wrong[c.corners.reshape(-1, 3)].any(axis=1))
