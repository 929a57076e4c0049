"""Edge lengths that are shorter where a surface curves more."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from geometry.arrays import FloatArray, floats
from geometry.networks.tangent_frames import TangentFrames
from geometry.optimise import factorise
from geometry.surface import Curvature

__all__ = ["graded_sizes"]

MOST_CURVED_SHARE = 0.02
"""Share of the area that may curve more than where edges are shortest: so much of it may be noise or a sharp bend."""

SIZE_SMOOTHING_LENGTH = 1.5
"""Length over which edge lengths are averaged, in mean edge lengths: neighbouring faces do not differ abruptly."""


def graded_sizes(frames: TangentFrames, ratio: float, edge_length: float) -> FloatArray:
    """(F,) edge lengths over the typical one, with as many faces as if all were 1.

    They are inverse to the square root of the curvature, so that chords are equally far from the surface, but the
    longest is at most `ratio` times the shortest.
    """
    tensors = Curvature.of(frames.mesh).triangle_tensors
    curvatures = np.sqrt((tensors**2).sum(axis=(1, 2)) / 2)
    areas = frames.areas / frames.areas.sum()
    order = np.argsort(-curvatures)
    most = curvatures[order][np.searchsorted(np.cumsum(areas[order]), MOST_CURVED_SHARE)]
    if most == 0:
        return floats(np.ones_like(curvatures))
    logarithms = -np.log(np.clip(curvatures / most, ratio**-2.0, 1.0)) / 2
    sizes = np.exp(_diffused(frames, logarithms, (SIZE_SMOOTHING_LENGTH * edge_length) ** 2))
    return floats(sizes * np.sqrt(areas @ sizes**-2.0))


def _diffused(frames: TangentFrames, values: FloatArray, time: float) -> FloatArray:
    """Values (F,) after diffusion during a time, a squared length."""
    _, left, right = frames.inner_edges
    n = frames.n_triangles
    rows, columns = np.concatenate([left, right]), np.concatenate([right, left])
    coupling = coo_array((np.tile(time * frames.stiffness, 2), (rows, columns)), shape=(n, n))
    matrix = diags_array(frames.areas + coupling.sum(axis=1)) - coupling
    return np.asarray(factorise(csr_array(matrix)).solve(frames.areas * values))
