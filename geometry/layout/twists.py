"""How much the quads of a mesh are twisted, and the correction of a network by it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import FloatArray
from geometry.layout.networks import Network, determinants, forms_of_isolines
from geometry.mesh import Mesh

__all__ = ["twist_corrections"]

AVERAGED_QUADS = 4
"""Quads that a triangle's correction is the mean of."""

AVERAGING_DISTANCE = 0.3
"""Distance over the edge length that quads count alike within."""

LARGEST_TWIST_CORRECTION = 1.0
"""Correction, over the root mean square of the curvature, beyond which it is no small one."""


def twist_corrections(network: Network, at: FloatArray, mesh: Mesh, h: float) -> FloatArray:
    """(F,) what to add to II(first, second) of triangles, over the curvature's root mean square: deferred correction.

    The twist (p0 - p1 + p2 - p3).n of a quad is what II of its isolines' tangents, at (F, 4) as in `integration`, would
    be if the surface were quadratic and the quad a point. The difference from II is what the quads still lack. Of that,
    only the part counts in which quads near to each other agree more than by chance: the rest is noise of the surface.
    """
    c = mesh.combinatorics
    frames = network.frames
    quads = np.setdiff1d(c.inner_faces, np.flatnonzero(c.face_sizes != 4))
    if len(quads) < AVERAGED_QUADS or network.curvature == 0:
        return np.zeros(frames.n_triangles)
    points = mesh.vertices[c.corners[c.face_starts[quads][:, None] + np.arange(4)]]
    centres = points.mean(axis=1)
    nearest = frames.nearest(centres)
    normals = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    twists = np.einsum("qi,qi->q", points[:, 0] - points[:, 1] + points[:, 2] - points[:, 3], normals)
    side = points[:, 1] - points[:, 0] + points[:, 2] - points[:, 3]
    first, second = frames.in_space(network.first), frames.in_space(network.second)

    p, q, r, s = at.T
    form = forms_of_isolines(network.forms, at)
    measured = network.curvature * h**2
    sign = _along(side, first[nearest], second[nearest])
    lacks = sign * twists * determinants(at)[nearest] ** 2 / measured - form[nearest]
    lacks = (lacks / np.maximum(p * s + q * r, 0.2)[nearest]).clip(-LARGEST_TWIST_CORRECTION, LARGEST_TWIST_CORRECTION)

    distance, quad = KDTree(centres).query(frames.centres, AVERAGED_QUADS)
    weights = (np.asarray(distance) / h + AVERAGING_DISTANCE) ** -2
    alike = sign[quad] * _along(side[quad], first[:, None], second[:, None])
    weights /= weights.sum(axis=1, keepdims=True)
    near = alike * lacks[quad]
    mean, square, chance = (weights * near).sum(axis=1), (weights * near**2).sum(axis=1), (weights**2).sum(axis=1)
    agreement = np.divide(mean**2, square, out=np.ones_like(mean), where=square > 0)
    return np.asarray(mean * ((agreement - chance) / (1 - chance)).clip(min=0.0))


def _along(side: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """1 where a side runs along the first direction, -1 where along the second."""
    by_first, by_second = (np.abs((side * axis).sum(axis=-1)) for axis in (first, second))
    return np.asarray(np.where(by_first >= by_second, 1.0, -1.0))
