"""Runs: many short closed sequences (faces, loops) in one flat array, one after another.

starts (R+1,): run r has the places starts[r] .. starts[r+1] - 1.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers

__all__ = ["next_in_run", "run_of_place", "runs_by_size"]


def next_in_run(starts: IntArray) -> IntArray:
    """(C,) the place after each place in its run, the first one after the last; no run may be empty."""
    following = np.arange(1, starts[-1] + 1)
    following[starts[1:] - 1] = starts[:-1]
    return integers(following)


def run_of_place(starts: IntArray) -> IntArray:
    """(C,) the run of each place."""
    return integers(np.repeat(np.arange(len(starts) - 1), np.diff(starts)))


def runs_by_size(starts: IntArray) -> list[tuple[IntArray, IntArray]]:
    """For each size k, from the least: the runs of k places (n,), and their places (n, k)."""
    sizes = np.diff(starts)
    order = np.argsort(sizes, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(sizes[order])) + 1)
    return [(runs, starts[runs][:, None] + np.arange(sizes[runs[0]])) for runs in groups if len(runs)]
