"""Stereographic projection of the unit sphere from its north pole (0, 0, 1) onto the plane z = 0, and its inverse.

Circles go to circles and lines. A circle on the sphere is a plane n . x = h with |n| = 1 and -1 < h < 1; its *cap* is
the side n . x > h. The disc within a circle of the plane, and the side of a line its normal points to, go to caps. The
*pole* n / h of a circle is the apex of the cone that touches the sphere along it.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import ComplexArray, FloatArray

__all__ = ["circle_planes", "line_planes", "pairs", "plane_circles", "poles", "to_plane", "to_sphere"]


def pairs(points: ComplexArray) -> FloatArray:
    """(n, 2) the coordinates of complex numbers (n,)."""
    return np.stack([points.real, points.imag], axis=1)


def to_sphere(points: FloatArray) -> FloatArray:
    """(..., 3) the points of the unit sphere over points (..., 2) of the plane; the unit circle stays where it is."""
    squares = np.square(points).sum(axis=-1, keepdims=True)
    lifted: FloatArray = np.concatenate([2 * points, squares - 1], axis=-1) / (squares + 1)
    return lifted


def to_plane(points: FloatArray) -> FloatArray:
    """(..., 2) the projections of points (..., 3) of the unit sphere; not finite for the north pole."""
    x, y, z = np.moveaxis(points, -1, 0)
    # near the north pole 1 - z would lose digits, so it is replaced by (x^2 + y^2) / (1 + z)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(z > 0, (1 + z) / (x**2 + y**2), 1 / (1 - z))
        projected: FloatArray = np.stack([x, y], axis=-1) * scale[..., None]
    return projected


def circle_planes(centres: FloatArray, radii: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit normals (..., 3) and distances h (...) of the planes of the circles over circles of the plane.

    centres (..., 2), radii (...), positive.
    """
    distances = np.hypot(centres[..., 0], centres[..., 1])
    power = (distances - radii) * (distances + radii)  # power of the origin, |c|^2 - r^2 without loss of digits
    normals = np.concatenate([2 * centres, (power - 1)[..., None]], axis=-1)
    lengths = np.linalg.norm(normals, axis=-1)
    return normals / lengths[..., None], (power + 1) / lengths


def line_planes(normals: FloatArray, distances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit normals (..., 3) and distances h (...) of the planes of the circles over the lines normal . z = distance.

    normals (..., 2), of length 1; distances (...). The circles pass through the north pole.
    """
    lengths = np.hypot(1.0, distances)
    return np.concatenate([normals, distances[..., None]], axis=-1) / lengths[..., None], distances / lengths


def plane_circles(normals: FloatArray, distances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centres (..., 2) and radii (...) of the projections of the circles n . x = h.

    normals (..., 3), of length 1; distances h (...), between -1 and 1. The radius is positive where the cap goes to the
    disc, negative where it goes to the outside, as it does when it contains the north pole; not finite for
    a circle through the north pole.
    """
    weights = distances - normals[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        centres: FloatArray = normals[..., :2] / weights[..., None]
        radii: FloatArray = np.sqrt((1 - distances) * (1 + distances)) / weights
    return centres, radii


def poles(normals: FloatArray, distances: FloatArray) -> FloatArray:
    """(..., 3) the poles n / h of the circles n . x = h; not finite for great circles."""
    with np.errstate(divide="ignore", invalid="ignore"):
        apices: FloatArray = normals / distances[..., None]
    return apices
