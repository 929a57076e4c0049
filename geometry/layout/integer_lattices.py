"""Integer solutions of homogeneous linear equations, and the one nearest to a given point."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray

__all__ = ["integer_kernel", "nearest_integers"]

LATTICE_REGULARISATION = 1e-9
"""Added to the diagonal of the Gram matrix, over its mean, so that it is invertible."""

MAX_PAIRED_INTEGERS = 60
"""Largest number of integers for which pairs of them are also changed together."""

MAX_LATTICE_STEPS = 1000
"""Largest number of steps to a better lattice point."""

GAIN_ROUNDING = 1e-9
"""Gain of a step, over its own length squared, that may be rounding."""


def integer_kernel(equations: IntArray) -> IntArray:
    """(n, m) a basis of the integer solutions of equations (k, n) x = 0: each is an integer combination of its columns.

    It is found by column operations that are invertible over the integers, as for the Hermite normal form
    [Cohen1993, 2.4.3].
    """
    n = equations.shape[1]
    columns = np.concatenate(
        [equations, np.eye(n, dtype=np.int64)]
    ).T.copy()  # transposed: each row is a column of the algorithm
    is_free = np.ones(n, dtype=bool)
    for row in range(len(equations)):
        while True:
            nonzero = np.flatnonzero((columns[:, row] != 0) & is_free)
            if len(nonzero) < 2:
                break
            least = nonzero[np.abs(columns[nonzero, row]).argmin()]
            others = nonzero[nonzero != least]
            quotients = columns[others, row] // columns[least, row]
            columns[others] -= quotients[:, None] * columns[least]
        is_free[nonzero] = False
    return np.asarray(columns[is_free, len(equations) :].T)


def nearest_integers(
    gram: FloatArray, target: FloatArray, differences: IntArray, gaps: IntArray, least_gaps: IntArray
) -> IntArray:
    """(m,) integers t with small (t - target) . gram (t - target), such that no differences[k] @ t is (0, 0), and
    gaps @ t >= least_gaps.

    differences (k, 2, m), gaps (n, m), least_gaps (n,). The integers are rounded one after another, the least change
    first, and the others adapted; then single integers and pairs of them are changed by 1 while that is an improvement:
    a search for the closest vector of a lattice [Babai1986]. A difference that is zero, and each 1 that a gap lacks,
    costs more than any distance; they may remain, which the caller has to check.
    """
    m = len(target)
    gram = gram + LATTICE_REGULARISATION * max(np.trace(gram) / max(m, 1), np.finfo(float).tiny) * np.eye(m)
    t = _rounded_in_turn(gram, target)
    steps = _steps(m)
    step_norms = np.einsum("ki,ij,kj->k", steps, gram, steps)
    difference_steps = np.einsum("pcm,km->kpc", differences, steps)
    gap_steps = steps @ gaps.T
    penalty = 1 + 4 * float(np.abs(gram).sum())
    for _ in range(MAX_LATTICE_STEPS):
        gains = step_norms + 2 * steps @ (gram @ (t - target))
        values = differences @ t
        added_zeros = (values + difference_steps == 0).all(axis=2).sum(axis=1) - (values == 0).all(axis=1).sum()
        lacking = least_gaps - gaps @ t
        added_lacks = (lacking - gap_steps).clip(min=0).sum(axis=1) - lacking.clip(min=0).sum()
        gains = gains + penalty * (added_zeros + added_lacks)
        best = int(gains.argmin()) if len(gains) else 0
        if not len(gains) or gains[best] >= -GAIN_ROUNDING * step_norms[best]:
            break
        t = t + steps[best]
    return t


def _rounded_in_turn(gram: FloatArray, target: FloatArray) -> IntArray:
    t, inverse = target.copy(), np.linalg.inv(gram)
    is_real = np.ones(len(t), dtype=bool)
    for _ in range(len(t)):
        rounding_steps = np.where(is_real, np.abs(t - np.rint(t)), np.inf)
        i = int(rounding_steps.argmin())
        t = t + inverse[:, i] * (np.rint(t[i]) - t[i]) / inverse[i, i]
        inverse = inverse - np.outer(inverse[:, i], inverse[i]) / inverse[i, i]
        is_real[i] = False
        inverse[i, i] = 1.0
    return np.asarray(np.rint(t).astype(np.int64))


def _steps(m: int) -> IntArray:
    """(k, m) changes by 1 of one integer, and of two if there are at most MAX_PAIRED_INTEGERS."""
    one = np.eye(m, dtype=np.int64)
    if m > MAX_PAIRED_INTEGERS:
        return np.concatenate([one, -one])
    i, j = np.triu_indices(m, 1)
    return np.concatenate([sign * part for sign in (1, -1) for part in (one, one[i] + one[j], one[i] - one[j])])
