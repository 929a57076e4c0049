"""(u, v) in whole numbers of 2^-20: what is decided of isolines is decided exactly [EbkeBommesCampenKobbelt2013]."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import GeometryError
from geometry.layout.quarter_turns import quarter_turned
from geometry.layout.seams import SeamlessMaps
from geometry.mesh import Combinatorics

__all__ = ["ISOLINE_SPACING", "ExactMap", "cross"]

ISOLINE_SPACING = 1 << 20
"""The distance of two isolines."""

MAX_TRIANGLE_ISOLINES = 512
"""Isolines of one family through a triangle, so that products of differences are below 2^63."""

LARGEST_ISOLINE_VALUE = 1 << 38
"""Largest value of an isoline, in the unit of ISOLINE_SPACING: sums of products of these stay below 2^63."""


@dataclass(frozen=True, eq=False)
class ExactMap:
    """values (F, 3, 2) of u and v, times ISOLINE_SPACING, at the corners of triangles.

    Where (u, v) may be any real number, it is an odd one here: no isoline u or v = integer meets a regular vertex
    inside the surface. turns (C,): quarters by which (u, v) is turned across the half-edge of a corner.
    """

    combinatorics: Combinatorics
    values: IntArray
    turns: IntArray

    @classmethod
    def of(cls, c: Combinatorics, maps: SeamlessMaps, edge_turns: IntArray, x: FloatArray, t: IntArray) -> ExactMap:
        """Raises GeometryError where a triangle has very many isolines."""
        largest = LARGEST_ISOLINE_VALUE / ISOLINE_SPACING
        if np.abs(x).max(initial=0.0) > largest or np.abs(t).max(initial=0) > largest:
            raise GeometryError(
                f"a line has the number {max(np.abs(x).max(), np.abs(t).max()):.0e}, {largest:.0e} is "
                "the largest one: give a longer edge length"
            )
        odd = 2 * np.floor(x * (ISOLINE_SPACING // 2)).astype(np.int64) + 1
        values = np.asarray(maps.reals.astype(np.int64) @ odd + maps.integers.astype(np.int64) @ (t * ISOLINE_SPACING))
        values = values.reshape(-1, 3, 2)
        extents = (values.max(axis=1) - values.min(axis=1)).max(axis=1) // ISOLINE_SPACING
        if extents.max() >= MAX_TRIANGLE_ISOLINES:
            face = int(extents.argmax())
            raise GeometryError(
                f"triangle {face} of the surface is crossed by {extents[face]} lines, {MAX_TRIANGLE_ISOLINES} at most "
                "are possible: divide its triangles, or give a longer edge length",
                elements=[face],
                value=float(extents[face]),
                bound=MAX_TRIANGLE_ISOLINES,
            )
        turns = np.where(c.runs_along_edge, -edge_turns[c.corner_edge], edge_turns[c.corner_edge])
        return cls(c, integers(values), integers(turns % 4))

    @cached_property
    def folded(self) -> IntArray:
        """Triangles (n,) that are turned over, or have no area."""
        a, b, c = self.values.swapaxes(0, 1)
        return integers(np.flatnonzero(cross(b - a, c - a) <= 0))

    @cached_property
    def shifts(self) -> IntArray:
        """(C, 2) what is added to (u, v), in cells, after it is turned, across the half-edge of a corner; 0 at rims."""
        c = self.combinatorics
        at = self.values.reshape(-1, 2)
        inner = c.twin >= 0
        shifts = np.zeros((c.n_corners, 2), dtype=np.int64)
        other = at[c.next_corner[c.twin[inner]]]
        shifts[inner] = (other - quarter_turned(at[inner], self.turns[inner])) // ISOLINE_SPACING
        return integers(shifts)


def cross(a: IntArray, b: IntArray) -> IntArray:
    """(...,) of vectors (..., 2): twice the area between them."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
