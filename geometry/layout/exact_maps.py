"""(u, v) as multiples of 2^-20, so that all decisions about isolines are exact [EbkeBommesCampenKobbelt2013]."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import GeometryError
from geometry.layout.quarter_turns import quarter_turned
from geometry.layout.seams import SeamlessMaps
from geometry.layout.windings import wrongly_wound
from geometry.mesh import Combinatorics

__all__ = ["CELL_SIZE", "ExactMap", "cross"]

CELL_SIZE = 1 << 20
"""Side of a cell between isolines, in the whole numbers of an exact map."""

MAX_ISOLINES_PER_TRIANGLE = 512
"""Largest number of isolines of one family through a triangle, so that products of differences are below 2^63."""

LARGEST_ISOLINE = 1 << 38
"""Largest value of u or v in the whole numbers of an exact map, so that sums of products stay below 2^63."""


@dataclass(frozen=True, eq=False)
class ExactMap:
    """values (F, 3, 2) of u and v, times CELL_SIZE, at the corners of triangles.

    Values that need not be integers are rounded to odd numbers, so that no isoline passes through a regular vertex
    inside the surface. turns (C,): quarters by which (u, v) is turned across the half-edge of a corner.
    """

    combinatorics: Combinatorics
    values: IntArray
    turns: IntArray

    @classmethod
    def of(cls, c: Combinatorics, maps: SeamlessMaps, edge_turns: IntArray, x: FloatArray, t: IntArray) -> ExactMap:
        """Raises GeometryError where a triangle has very many isolines."""
        if (
            np.abs(x).max(initial=0.0) > LARGEST_ISOLINE / CELL_SIZE
            or np.abs(t).max(initial=0) > LARGEST_ISOLINE / CELL_SIZE
        ):
            raise GeometryError(
                f"the lines are numbered up to {max(np.abs(x).max(), np.abs(t).max()):.0e}, allowed "
                f"{LARGEST_ISOLINE / CELL_SIZE:.0e}: give a longer edge length"
            )
        odd = 2 * np.floor(x * (CELL_SIZE // 2)).astype(np.int64) + 1
        values = np.asarray(maps.reals.astype(np.int64) @ odd + maps.integers.astype(np.int64) @ (t * CELL_SIZE))
        values = values.reshape(-1, 3, 2)
        extents = (values.max(axis=1) - values.min(axis=1)).max(axis=1) // CELL_SIZE
        if extents.max() >= MAX_ISOLINES_PER_TRIANGLE:
            face = int(extents.argmax())
            raise GeometryError(
                f"triangle {face} of the surface is crossed by {extents[face]} lines, allowed "
                f"{MAX_ISOLINES_PER_TRIANGLE}: divide the triangles of the surface, or give a longer edge length",
                elements=[face],
                value=float(extents[face]),
                bound=MAX_ISOLINES_PER_TRIANGLE,
            )
        turns = np.where(c.runs_along_edge, -edge_turns[c.corner_edge], edge_turns[c.corner_edge])
        return cls(c, integers(values), integers(turns % 4))

    def folded(self, indices: IntArray) -> IntArray:
        """Triangles (n,) that are turned over or have no area, or, if there is none, those around vertices that they
        surround more than once. indices (N,): of the field, see `CombedField`."""
        a, b, c = self.values.swapaxes(0, 1)
        turned_over = np.flatnonzero(cross(b - a, c - a) <= 0)
        if len(turned_over):
            return integers(turned_over)
        return integers(np.flatnonzero(wrongly_wound(self.combinatorics, self.values.astype(np.float64), indices)))

    @cached_property
    def shifts(self) -> IntArray:
        """(C, 2) integers that are added to (u, v), after it is turned, across the half-edge of a corner; 0 at the
        boundary."""
        c = self.combinatorics
        at = self.values.reshape(-1, 2)
        inner = c.twin >= 0
        shifts = np.zeros((c.n_corners, 2), dtype=np.int64)
        other = at[c.next_corner[c.twin[inner]]]
        shifts[inner] = (other - quarter_turned(at[inner], self.turns[inner])) // CELL_SIZE
        return integers(shifts)


def cross(a: IntArray, b: IntArray) -> IntArray:
    """(...,) the cross products of vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
