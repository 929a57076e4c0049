"""Runs: many short closed sequences (faces, loops) in one flat array, one after another.

starts (R+1,): run r has the places starts[r] .. starts[r+1] - 1.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray, integers

__all__ = ["next_in_run", "run_of_place"]


def next_in_run(starts: IntArray) -> IntArray:
    """(C,) the place after each place in its run, the first one after the last; no run may be empty."""
    following = np.arange(1, starts[-1] + 1)
    following[starts[1:] - 1] = starts[:-1]
    return integers(following)


def run_of_place(starts: IntArray) -> IntArray:
    """(C,) the run of each place."""
    return integers(np.repeat(np.arange(len(starts) - 1), np.diff(starts)))
