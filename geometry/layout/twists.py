"""The twist of the quads of a mesh, and the correction of a network that reduces it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import FloatArray
from geometry.mesh import Mesh
from geometry.networks.networks import Network, determinants, forms_of_isolines

__all__ = ["twist_corrections"]

AVERAGED_QUADS = 4
"""Number of nearest quads that the correction of a triangle is averaged over."""

QUAD_WEIGHT_OFFSET = 0.3
"""Added to the distance of a quad, over the edge length, so that all quads within about this distance have the same
weight."""

LARGEST_TWIST_CORRECTION = 1.0
"""Largest correction, over the root mean square of the curvature."""


def twist_corrections(network: Network, derivatives: FloatArray, mesh: Mesh, h: float) -> FloatArray:
    """(F,) the amounts to be added to II(first, second) of triangles, over the root mean square of the curvature.

    derivatives (F, 4): as in `integration`. For small quads the twist (p0 - p1 + p2 - p3) . n equals II of the tangents
    of the isolines. For quads of the actual size it differs, and the correction is this difference (a deferred
    correction). Only the part in which neighbouring quads agree more than by chance counts: the rest is noise.
    """
    c = mesh.combinatorics
    frames = network.frames
    quads = np.setdiff1d(c.inner_faces, np.flatnonzero(c.face_sizes != 4))
    if len(quads) < AVERAGED_QUADS or network.curvature == 0:
        return np.zeros(frames.n_triangles)
    points = mesh.vertices[c.corners[c.face_starts[quads][:, None] + np.arange(4)]]
    centres = points.mean(axis=1)
    nearest = frames.nearest(centres)
    lengths = h * network.sizes
    normals = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    twists = np.einsum("qi,qi->q", points[:, 0] - points[:, 1] + points[:, 2] - points[:, 3], normals)
    side = points[:, 1] - points[:, 0] + points[:, 2] - points[:, 3]
    first, second = frames.in_space(network.first), frames.in_space(network.second)

    p, q, r, s = derivatives.T
    form = forms_of_isolines(network.forms, derivatives)
    twist_scale = network.curvature * lengths[nearest] ** 2
    sign = _along(side, first[nearest], second[nearest])
    corrections = sign * twists * determinants(derivatives)[nearest] ** 2 / twist_scale - form[nearest]
    corrections = (corrections / np.maximum(p * s + q * r, 0.2)[nearest]).clip(
        -LARGEST_TWIST_CORRECTION, LARGEST_TWIST_CORRECTION
    )

    distance, quad = KDTree(centres).query(frames.centres, AVERAGED_QUADS)
    weights = (np.asarray(distance) / lengths[:, None] + QUAD_WEIGHT_OFFSET) ** -2
    weights /= weights.sum(axis=1, keepdims=True)
    nearby = sign[quad] * _along(side[quad], first[:, None], second[:, None]) * corrections[quad]
    mean, mean_square = (weights * nearby).sum(axis=1), (weights * nearby**2).sum(axis=1)
    agreement = np.divide(mean**2, mean_square, out=np.ones_like(mean), where=mean_square > 0)
    by_chance = (weights**2).sum(axis=1)
    return np.asarray(mean * ((agreement - by_chance) / (1 - by_chance)).clip(min=0.0))


def _along(side: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """1 where a side is nearer to the first direction, -1 where it is nearer to the second."""
    by_first, by_second = (np.abs((side * axis).sum(axis=-1)) for axis in (first, second))
    return np.asarray(np.where(by_first >= by_second, 1.0, -1.0))
