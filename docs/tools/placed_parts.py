"""Triangles of parts in their places, for pictures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fabkit.formats.shown.triangles import facets
from fabkit.parts import Parts
from geometry.arrays import FloatArray, IntArray

__all__ = ["placed_triangles"]


def placed_triangles(parts: Parts[Any]) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """By topology: the numbers of n parts, and corners and normals (n, T, 3, 3) of the triangles of each."""
    for batch in facets(parts.solids, parts.mark_names):
        own = np.flatnonzero(np.isin(parts.shape, batch.solids))
        row = np.searchsorted(batch.solids, parts.shape[own])
        triangles = batch.triangles[row][..., None]
        points = batch.points[row] @ parts.axes[own] + parts.origins[own][:, None]
        normals = batch.normals[row] @ parts.axes[own]
        corners, upright = (np.take_along_axis(each[:, None], triangles, axis=2) for each in (points, normals))
        yield own, corners, upright
