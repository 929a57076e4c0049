"""Faces as rings of vertices: which are the same, regardless of their first vertex and their orientation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geometry.arrays import IntArray
from geometry.mesh.ragged_arrays import rows_by_size

__all__ = ["first_with_same", "rings_by_size", "turned"]


def turned(rings: IntArray) -> IntArray:
    """Rings (n, k) rewritten so that they begin with their least vertex and go on to the lesser of its two
    neighbours."""
    size = rings.shape[1]
    start = rings.argmin(axis=1)[:, None]
    found: IntArray = np.take_along_axis(rings, (start + np.arange(size)) % size, axis=1)
    back = found[:, 1] > found[:, -1]
    found[back, 1:] = found[back, :0:-1]
    return found


def rings_by_size(corners: IntArray, face_starts: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """For each number k of corners, two or more: the faces (n,) with k corners, and their normalised rings (n, k)."""
    for faces, places in rows_by_size(face_starts):
        if places.shape[1] > 1:
            yield faces, turned(corners[places])


def first_with_same(corners: IntArray, face_starts: IntArray) -> IntArray:
    """(F,) for each face the first face with the same ring of vertices, which may be the face itself."""
    first = np.arange(len(face_starts) - 1)
    for faces, rings in rings_by_size(corners, face_starts):
        _, leader, same = np.unique(rings, axis=0, return_index=True, return_inverse=True)
        first[faces] = faces[leader[same.ravel()]]
    return first
