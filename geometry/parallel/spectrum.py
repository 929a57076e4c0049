"""The dimension of P(M), from a gap in the singular values of `EdgeClosure`, without a dense decomposition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, RankError
from geometry.parallel.edge_closure import EdgeClosure

__all__ = ["Spectrum", "least_singular_vectors", "null_dimension", "zero_threshold"]

LEAST_SPECTRAL_GAP = 100.0
"""Least ratio of the first singular value that is not zero to the largest one that counts as zero."""

ZERO_SINGULAR_VALUE = 1e-9
"""Singular values that count as zero however planar the faces are: files give coordinates with about ten digits."""

LARGEST_ZERO_SINGULAR_VALUE = 1e-3
"""Largest singular value that may count as zero; faces that are less planar leave no gap."""

MAX_INVERSE_ITERATIONS = 20
"""Inverse iterations; three to five are usual."""

FIRST_BLOCK_VECTORS = 8
"""Number of vectors of the first inverse iteration."""

MAX_BLOCK_NUMBERS = 50_000_000
"""Largest number of floats in the vectors of an inverse iteration: 0.4 GB."""


@dataclass(frozen=True)
class Spectrum:
    """The dimension of P(M), and the singular values on either side of the gap that shows it.

    They are the singular values of `EdgeClosure` (pure numbers, the largest about 2). last_zero: the largest one that
    counts as zero, or the bound for the effect of faces that are not planar if that is larger; first_nonzero: the next.

    >>> from geometry import ParallelSpace
    >>> from geometry.mesh import shapes
    >>> spectrum = ParallelSpace(shapes.grid(4, 4)).spectrum
    >>> spectrum.dimension, spectrum.last_zero < 1e-14, spectrum.first_nonzero > 0.01
    (11, True, True)
    """

    dimension: int
    last_zero: float
    first_nonzero: float

    @classmethod
    def of(cls, values: FloatArray, extra_dimensions: int, deviation: float) -> Spectrum:
        """values: the least singular values, ascending, up to one above `zero_threshold(deviation)`, or all.

        extra_dimensions: those beside the singular values that count as zero. Raises RankError where there is no gap.
        """
        zero = zero_threshold(deviation)
        kept = int((values <= zero).sum())
        last = max([deviation, *values[:kept][-1:]])
        first = float(values[kept]) if kept < len(values) else np.inf
        needed = LEAST_SPECTRAL_GAP * max(zero, last)
        if first < needed:
            cure = (
                "planarise the mesh first"
                if deviation > ZERO_SINGULAR_VALUE
                else "put faces that are nearly in one plane exactly in it"
            )
            raise RankError(
                f"the singular values have no gap that shows the dimension of P(M): it is {extra_dimensions + kept} if "
                f"those up to {last:.1e} are zero, but the next is {first:.1e}, and at least {needed:.1e} is needed; "
                f"{cure}",
                value=first,
                bound=needed,
            )
        return cls(extra_dimensions + kept, float(last), first)


def null_dimension(matrix: FloatArray) -> int:
    """The dimension of the x (n,) with A x = 0, A (m, n) of orthonormal directions; RankError where there is no gap."""
    values = np.linalg.svd(matrix, compute_uv=False)
    positive = values[values > ZERO_SINGULAR_VALUE]
    needed = LEAST_SPECTRAL_GAP * ZERO_SINGULAR_VALUE
    if positive.min(initial=np.inf) < needed:
        raise RankError(
            f"the singular values have no gap that shows what the fixed vertices leave free: it is "
            f"{matrix.shape[1] - len(positive)} dimensions if those up to {ZERO_SINGULAR_VALUE:.0e} are zero, but the "
            f"next is {positive.min():.1e}, and at least {needed:.1e} is needed; fix other vertices",
            value=float(positive.min()),
            bound=needed,
        )
    return int(matrix.shape[1] - len(positive))


def zero_threshold(deviation: float) -> float:
    """The largest singular value that counts as zero; faces that are not planar change them by up to `deviation`."""
    return min(max(ZERO_SINGULAR_VALUE, deviation), LARGEST_ZERO_SINGULAR_VALUE)


def least_singular_vectors(closure: EdgeClosure, above: float) -> tuple[FloatArray, FloatArray]:
    """The least singular values (k,) of A = closure.narrow (m, n), ascending, and right singular vectors (n, k).

    All up to `above` and at least one more, or k = n. Inverse iteration on a block of vectors with the factor of
    A^T A + shift, then A times the Ritz vectors, so that singular values are accurate to rounding, while eigenvalues of
    A^T A are so only to its root. Those that are not near zero may be slightly too large.

    Raises GeometryError where too many vectors are needed.
    """
    n = closure.narrow.shape[1]
    count = FIRST_BLOCK_VECTORS
    while count <= n // 3:
        _check_size(n, count)
        values, vectors = _inverse_iteration(closure, count, above)
        if values[-1] > above:
            return values, vectors
        count *= 4
    _check_size(n, n)
    rows = np.linalg.qr(closure.narrow.toarray(), mode="r")
    _, values, directions = np.linalg.svd(rows)
    return values[::-1], directions[::-1].T


def _inverse_iteration(closure: EdgeClosure, count: int, above: float) -> tuple[FloatArray, FloatArray]:
    vectors = np.random.default_rng(0).standard_normal((closure.narrow.shape[1], count))
    first = np.inf
    for _ in range(MAX_INVERSE_ITERATIONS):
        vectors = np.linalg.qr(closure.factor.solve(vectors))[0]
        _, values, rotation = np.linalg.svd(np.asarray(closure.narrow @ vectors), full_matrices=False)
        values, vectors = values[::-1], vectors @ rotation[::-1].T
        before, first = first, values[min(int((values <= above).sum()), count - 1)]
        if first > 0.99 * before:
            break
    return values, vectors


def _check_size(n: int, count: int) -> None:
    if n * count > MAX_BLOCK_NUMBERS:
        raise GeometryError(
            f"the dimension of P(M) needs {count} vectors of {n} numbers, at most {MAX_BLOCK_NUMBERS:.0e} numbers in "
            "all are allowed; go by `expected_dimension`, or look at a part of the mesh",
            value=float(n) * count,
            bound=MAX_BLOCK_NUMBERS,
        )
