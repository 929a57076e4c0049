"""The Lorentz group: 4 x 4 matrices A with A^T J A = J, J = diag(1, 1, 1, -1) [Pottmann2007, 3.3].

It acts on the points (x, 1) of space as the Moebius group of the unit sphere (moebius.py), and on the oriented spheres
(m, r) as the linear part of the Laguerre group (laguerre.py). Each of its matrices is, up to a sign, a boost after a
rotation or a reflection of space.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError

__all__ = [
    "FORM",
    "LORENTZ_TOLERANCE",
    "array_of",
    "boost",
    "deviation",
    "inverse",
    "orthonormalised",
    "product",
    "rotation",
]

FORM = floats(np.diag([1.0, 1.0, 1.0, -1.0]))
"""J, the matrix of the Lorentz product."""

LORENTZ_TOLERANCE = 1e-9
"""Largest entry of A^T J A - J over the square of the norm of A, for which A counts as a Lorentz matrix: ten digits
are enough, and orthonormalising changes A by no more than that."""

LORENTZ_ROUNDING = 1e-14
"""`deviation` of a product of a hundred matrices; a matrix below it is not made orthonormal."""


def product(x: Any, y: Any) -> FloatArray:
    """(...) Lorentz products x1 y1 + x2 y2 + x3 y3 - x4 y4 of vectors (..., 4)."""
    return np.asarray(np.einsum("...i,i,...i->...", x, np.diag(FORM), y))


def boost(velocity: Any) -> FloatArray:
    """(4, 4) the boost that takes (0, 0, 0, 1) to a multiple of (velocity, 1): the symmetric matrix among all that do.

    velocity (3,). boost(-velocity) is its inverse; boost(0) the identity. As a Moebius transformation it moves the
    origin to `velocity` along a line.

    Raises GeometryError where the velocity has length 1 or more, at or beyond the cone, or is not finite.
    """
    v = array_of(velocity, (3,), "a velocity")
    length = float(np.linalg.norm(v))
    if length >= 1:
        raise GeometryError(
            f"the velocity of the boost has length {length:.6g}, at or beyond the cone; it must be less than 1",
            value=length,
            bound=1.0,
        )
    return floats(_boost(v / np.sqrt((1 - length) * (1 + length))))


def _boost(celerity: FloatArray) -> FloatArray:
    """The boost with last column (u, gamma), u = gamma v, for any u."""
    gamma = np.sqrt(1 + celerity @ celerity)
    matrix = np.empty((4, 4))
    matrix[:3, :3] = np.eye(3) + np.outer(celerity, celerity) / (1 + gamma)
    matrix[:3, 3] = matrix[3, :3] = celerity
    matrix[3, 3] = gamma
    return matrix


def rotation(orthogonal: Any) -> FloatArray:
    """(4, 4) a rotation or a reflection (3, 3) of space as a Lorentz matrix. Raises GeometryError where it is none."""
    matrix = np.eye(4)
    matrix[:3, :3] = array_of(orthogonal, (3, 3), "a rotation")
    return orthonormalised(matrix)


def inverse(matrix: FloatArray) -> FloatArray:
    """(4, 4) J A^T J, the inverse of a Lorentz matrix A."""
    return floats(FORM @ matrix.T @ FORM)


def deviation(matrix: FloatArray) -> float:
    """Largest entry of A^T J A - J over the square of the norm of A: 0 for a Lorentz matrix A, which has norm >= 1.

    1 for a matrix of a norm below a half.
    """
    size = np.abs(matrix).max()
    norm = size * np.linalg.norm(matrix / size, 2) if size > 0 else 0.0
    if norm < 0.5:
        return 1.0
    unit = matrix / norm
    return float(np.abs(unit.T @ FORM @ unit - FORM / norm / norm).max())


def orthonormalised(matrix: Any, *, tolerance: float = LORENTZ_TOLERANCE) -> FloatArray:
    """(4, 4) the Lorentz matrix nearest to A, so that products of many matrices stay in the group.

    Its last column has the direction of that of A; the factor that remains without this boost is made orthogonal. A is
    returned unchanged where it deviates by rounding only.
    Raises GeometryError where `deviation` exceeds `tolerance`, or the shape or an entry is wrong.
    """
    given = array_of(matrix, (4, 4), "a Lorentz matrix")
    off = deviation(given)
    if off > tolerance:
        raise GeometryError(
            f"A^T J A differs from J = diag(1, 1, 1, -1) by {off:.1e} of the square of the norm of A, allowed "
            f"{tolerance:.1e}: A is not a Lorentz matrix; make it from boosts and rotations",
            value=off,
            bound=tolerance,
        )
    if off <= LORENTZ_ROUNDING:
        return given
    sign = 1.0 if given[3, 3] > 0 else -1.0
    u = sign * given[:3, 3]
    left, _, right = np.linalg.svd((_boost(-u) @ given)[:3, :3])
    across = np.eye(4)
    across[:3, :3] = left @ right
    across[3, 3] = sign
    return floats(_boost(u) @ across)


def array_of(values: Any, shape: tuple[int | None, ...], what: str) -> FloatArray:
    """Numbers of this shape, None for any size. Raises GeometryError, saying `what` they are, where they are not."""
    array = floats(values)
    if array.ndim != len(shape) or any(n not in (None, found) for n, found in zip(shape, array.shape, strict=True)):
        wanted = ", ".join("k" if n is None else str(n) for n in shape)
        raise GeometryError(f"{what} has shape {array.shape}, an array of shape ({wanted}) is needed")
    broken = np.argwhere(~np.isfinite(array))
    if len(broken):
        place = tuple(int(i) for i in broken[0])
        raise GeometryError(f"{what} has {array[place]} at {place}, its numbers must be finite", elements=place)
    return array
