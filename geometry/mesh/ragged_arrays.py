"""Ragged arrays: rows of different lengths (the corners of faces, or loops) in one flat array, one after another.

starts (R+1,): row r has the entries starts[r] .. starts[r+1] - 1.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers

__all__ = ["next_in_row", "row_of_entry", "rows_by_size"]


def next_in_row(starts: IntArray) -> IntArray:
    """(C,) the entry after each entry in its row, the first one after the last; no row may be empty."""
    following = np.arange(1, starts[-1] + 1)
    following[starts[1:] - 1] = starts[:-1]
    return integers(following)


def row_of_entry(starts: IntArray) -> IntArray:
    """(C,) the row of each entry."""
    return integers(np.repeat(np.arange(len(starts) - 1), np.diff(starts)))


def rows_by_size(starts: IntArray) -> list[tuple[IntArray, IntArray]]:
    """For each length k, from the least: the rows (n,) with k entries, and their entries (n, k)."""
    sizes = np.diff(starts)
    order = np.argsort(sizes, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(sizes[order])) + 1)
    return [(rows, starts[rows][:, None] + np.arange(sizes[rows[0]])) for rows in groups if len(rows)]
