"""How far the weights of a linear combination of parallel meshes may go until an edge collapses [Pottmann2007, Fig. 5].

Edge factors are linear in each weight, so each edge has one value of it at which it collapses.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.errors import raise_worst

__all__ = ["weight_ranges"]

SMALLEST_FACTOR = 1e-12
"""Edge factor over the sum of the absolute values it is made of, up to which it is rounding of zero."""


def weight_ranges(weights: FloatArray, factors: FloatArray) -> FloatArray:
    """(k, 2) from where to where each weight may go while the others stay, until an edge has the factor zero.

    weights (k,), factors (k, E): the edge factors of each mesh, so that those of the blend are their sum with these
    weights. Infinite where no edge sets a limit. Beyond a limit an edge runs the other way than at these weights.
    Raises GeometryError, naming the edge, where one has the factor zero at these weights already.
    """
    found = weights @ factors
    sizes = np.abs(weights) @ np.abs(factors)
    raise_worst(
        np.abs(found) / np.maximum(sizes, np.finfo(float).tiny),
        ">",
        SMALLEST_FACTOR,
        lambda edge, _: (
            f"edge {edge} has no length in this blend, so there is no range in which it keeps its direction: choose "
            "weights for which all edges have a length"
        ),
    )
    moves = np.abs(factors) > SMALLEST_FACTOR * np.abs(factors).max(axis=1, keepdims=True)
    steps = np.divide(-found, factors, out=np.full(factors.shape, np.inf), where=moves)
    down = np.where(moves & (steps < 0), steps, -np.inf).max(axis=1)
    up = np.where(moves & (steps > 0), steps, np.inf).min(axis=1)
    return np.stack([weights + down, weights + up], axis=1)
