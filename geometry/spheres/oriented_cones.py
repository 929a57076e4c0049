"""Oriented cones of revolution: what a vertex of an edge offset mesh or a conical mesh is in Laguerre geometry.

A sphere (m, r) has centre m and signed radius r; its unit normals point outwards if and only if r > 0. It touches an
oriented plane n . x = h where n . m + r = h: at m + r n. The spheres that touch all planes n . x = n . m with n . s = 1
are (m - r s, r), a line in R^4. Their envelope is the cone with apex m whose unit normals n lie on the circle
n . s = 1 of the unit sphere: s is the *pole* of the circle, on the axis, at the distance 1 / sin(half-angle). In a
mesh with a Gauss image S, m and s are the vertices m_i and s_i [Pottmann2007, 3.3, Prop. 3].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, short_repr
from geometry.errors import GeometryError
from geometry.spheres.lorentz import array_of

__all__ = ["CONE_TOLERANCE", "VertexCones"]

CONE_TOLERANCE = 1e-9
"""Depth of a pole inside the unit sphere that is allowed, as rounding makes it for a half-angle of 90 degrees; and
least difference of the radii of two spheres over the distance of their centres: below it, the cone is a cylinder."""


@dataclass(frozen=True, eq=False)
class VertexCones:
    """k oriented cones: `apices` (k, 3), and `poles` (k, 3) of length 1 / sin(half-angle), along the axes.

    The unit normals n of a cone have n . pole = 1, so they point to the side the axis points to. A pole of length 1
    is a cone opened to the plane perpendicular to it. Raises GeometryError for a pole inside the unit sphere.

    >>> import numpy as np
    >>> cones = VertexCones.of_revolution([[0, 0, 5]], [[0, 0, 1]], [np.radians(30)])
    >>> cones.poles.round(9).tolist()
    [[0.0, 0.0, 2.0]]
    >>> cones.spheres(1.0).round(9).tolist()  # centre and radius of a sphere that touches the cone
    [[0.0, 0.0, 3.0, 1.0]]
    """

    __repr__ = short_repr

    apices: FloatArray
    poles: FloatArray

    def __post_init__(self) -> None:
        apices = array_of(self.apices, (None, 3), "the array of apices")
        poles = array_of(self.poles, (len(apices), 3), "the array of poles")
        lengths = np.linalg.norm(poles, axis=1)
        wrong = np.flatnonzero(lengths < 1 - CONE_TOLERANCE)
        if len(wrong):
            cone = int(wrong[0])
            raise GeometryError(
                f"the pole of cone {cone} has length {lengths[cone]:.6g}, at least 1 is needed: it is one over the "
                "sine of the half-angle",
                elements=wrong.tolist(),
                value=float(lengths[cone]),
                bound=1.0,
            )
        object.__setattr__(self, "apices", apices)
        object.__setattr__(self, "poles", poles)

    @classmethod
    def of_revolution(cls, apices: Any, axes: Any, half_angles: Any) -> VertexCones:
        """From apices (k, 3), axes (k, 3) of any length and half-angles (k,) in radians, above 0 and at most pi / 2.

        Raises GeometryError for half-angles that are not, and axes without length.
        """
        directions = array_of(axes, (None, 3), "the array of axes")
        angles = array_of(half_angles, (len(directions),), "the array of half-angles")
        lengths = np.linalg.norm(directions, axis=1)
        wrong = np.flatnonzero(~((angles > 0) & (angles <= np.pi / 2) & (lengths > 0)))
        if len(wrong):
            cone = int(wrong[0])
            raise GeometryError(
                f"cone {cone} has half-angle {angles[cone]:.6g} and an axis of length {lengths[cone]:.6g}: the angle "
                "must be above 0 and at most pi / 2, the axis not zero",
                elements=wrong.tolist(),
                value=float(angles[cone]),
                bound=np.pi / 2,
            )
        return cls(apices, directions / (lengths * np.sin(angles))[:, None])

    @classmethod
    def touching(cls, first: Any, second: Any) -> VertexCones:
        """The cones that touch both spheres (m, r) of each row of two arrays (k, 4).

        Raises GeometryError where the radii are the same, which makes a cylinder, and where one sphere is within the
        other, so that no cone touches both.
        """
        one = array_of(first, (None, 4), "the first array of spheres")
        two = array_of(second, (len(one), 4), "the second array of spheres")
        apart, growth = two[:, :3] - one[:, :3], two[:, 3] - one[:, 3]
        distances = np.linalg.norm(apart, axis=1)
        wrong = np.flatnonzero(~(np.abs(growth) > CONE_TOLERANCE * distances))
        if len(wrong):
            pair = int(wrong[0])
            raise GeometryError(
                f"the two spheres of pair {pair} differ in radius by {growth[pair]:.1e}, over {distances[pair]:.1e} "
                f"from centre to centre, at least {CONE_TOLERANCE:.0e} of it is needed: they touch a cylinder",
                elements=wrong.tolist(),
                value=float(growth[pair]),
                bound=CONE_TOLERANCE * float(distances[pair]),
            )
        poles = -apart / growth[:, None]
        return cls(one[:, :3] + one[:, 3:] * poles, poles)

    @property
    def axes(self) -> FloatArray:
        """(k, 3) unit vectors."""
        return np.asarray(self.poles / np.linalg.norm(self.poles, axis=1, keepdims=True))

    @property
    def half_angles(self) -> FloatArray:
        """(k,) in radians, above 0 and at most pi / 2."""
        return np.asarray(np.arcsin(1 / np.maximum(np.linalg.norm(self.poles, axis=1), 1)))

    def spheres(self, radii: Any) -> FloatArray:
        """(k, 4) the spheres with these radii (k,), or one number, that touch the cones: (m - r s, r)."""
        k = len(self.apices)
        r = array_of(np.full(k, radii) if np.ndim(radii) == 0 else radii, (k,), "the array of radii")[:, None]
        return np.concatenate([self.apices - r * self.poles, r], axis=1)
