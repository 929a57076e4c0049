"""Integer solutions of homogeneous linear equations, and the one nearest to a given point."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray

__all__ = ["integer_kernel", "nearest_integers"]

FREE_DIRECTION_REGULARISATION = 1e-9
"""Of directions in which the integers may move freely, over the mean."""

MAX_PAIRED_INTEGERS = 60
"""Integers up to which pairs of them are moved."""

MAX_LATTICE_MOVES = 1000
"""Moves of integers to a better neighbour, at most."""

GAIN_ROUNDING = 1e-9
"""Relative gain that may be rounding."""


def integer_kernel(equations: IntArray) -> IntArray:
    """(n, m) a basis of all integer solutions of equations (k, n): each solution is one integer combination of columns.

    By column operations that are invertible over the integers, as for the Hermite normal form [Cohen1993, 2.4.3].
    """
    n = equations.shape[1]
    columns = np.concatenate([equations, np.eye(n, dtype=np.int64)]).T.copy()  # a row of this is a column
    is_free = np.ones(n, dtype=bool)
    for row in range(len(equations)):
        while True:
            at = np.flatnonzero((columns[:, row] != 0) & is_free)
            if len(at) < 2:
                break
            least = at[np.abs(columns[at, row]).argmin()]
            others = at[at != least]
            quotients = columns[others, row] // columns[least, row]
            columns[others] -= quotients[:, None] * columns[least]
        is_free[at] = False
    return np.asarray(columns[is_free, len(equations) :].T)


def nearest_integers(gram: FloatArray, wanted: FloatArray, apart: IntArray) -> IntArray:
    """(m,) integers t of small (t - wanted).gram (t - wanted), for which no apart (k, 2, m) @ t is (0, 0).

    One after another, the least rounding first and the rest following, and then single integers and pairs of them are
    moved by 1 while that is better: a search for the closest vector of a lattice [Babai1986]. What must be apart and is
    not counts more than any distance; where that remains so, the caller sees it in the result.
    """
    m = len(wanted)
    gram = gram + FREE_DIRECTION_REGULARISATION * max(np.trace(gram) / max(m, 1), np.finfo(float).tiny) * np.eye(m)
    t = _rounded_in_turn(gram, wanted)
    steps = _steps(m)
    own = np.einsum("ki,ij,kj->k", steps, gram, steps)
    moved = np.einsum("pcm,km->kpc", apart, steps)
    penalty = 1 + 4 * float(np.abs(gram).sum())
    for _ in range(MAX_LATTICE_MOVES):
        gains = own + 2 * steps @ (gram @ (t - wanted))
        now = apart @ t
        equal = (now + moved == 0).all(axis=2).sum(axis=1) - (now == 0).all(axis=1).sum()
        gains = gains + penalty * equal
        best = int(gains.argmin()) if len(gains) else 0
        if not len(gains) or gains[best] >= -GAIN_ROUNDING * own[best]:
            break
        t = t + steps[best]
    return t


def _rounded_in_turn(gram: FloatArray, wanted: FloatArray) -> IntArray:
    t, inverse = wanted.copy(), np.linalg.inv(gram)
    is_open = np.ones(len(t), dtype=bool)
    for _ in range(len(t)):
        offs = np.where(is_open, np.abs(t - np.rint(t)), np.inf)
        i = int(offs.argmin())
        t = t + inverse[:, i] * (np.rint(t[i]) - t[i]) / inverse[i, i]
        inverse = inverse - np.outer(inverse[:, i], inverse[i]) / inverse[i, i]
        is_open[i] = False
        inverse[i, i] = 1.0
    return np.asarray(np.rint(t).astype(np.int64))


def _steps(m: int) -> IntArray:
    """(k, m) changes by 1 of one integer, and of two while these are few."""
    one = np.eye(m, dtype=np.int64)
    if m > MAX_PAIRED_INTEGERS:
        return np.concatenate([one, -one])
    i, j = np.triu_indices(m, 1)
    return np.concatenate([sign * part for sign in (1, -1) for part in (one, one[i] + one[j], one[i] - one[j])])
