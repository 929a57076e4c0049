"""Laguerre transformations, and what they do to meshes with exact offsets [Pottmann2007, 3.3, Prop. 4].

Oriented spheres are points x = (m, r) of R^4, and a transformation is x -> A x + a with A^T J A = J. A pair M, S of
meshes is a line (m_i - r s_i, r) of spheres for each vertex (see `oriented_cones`); the lines of two neighbours lie
in a plane, because m_i - m_j is parallel to s_i - s_j. Linear maps keep lines, and lines in planes, so the images
belong to a pair M', S' again: r = 0 cuts out M', and S' is the image of S by the Moebius transformation with the
matrix J A J. That keeps the unit sphere, so S' touches it with its edges, faces or vertices as S does: edge offset
meshes go to edge offset meshes, conical ones to conical, circular ones to circular.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, short_repr
from geometry.spheres import lorentz
from geometry.spheres.lorentz import FORM, array_of
from geometry.spheres.moebius import MoebiusTransformation, checked_planes
from geometry.spheres.oriented_cones import VertexCones

__all__ = ["LaguerreTransformation"]


@dataclass(frozen=True, eq=False)
class LaguerreTransformation:
    """x -> A x + a on oriented spheres x = (m, r): `matrix` A (4, 4) with A^T J A = J, `shift` a (4,).

    `f @ g` is f after g. Raises GeometryError where the matrix is not of the Lorentz group, see
    `lorentz.orthonormalised`, or the shift is not of 4 finite numbers.

    >>> import numpy as np
    >>> from geometry.mesh import solids
    >>> from geometry.exact_offsets import edge_offset_pair
    >>> pair = edge_offset_pair(solids.cuboctahedron() * 5)
    >>> tilt = LaguerreTransformation.boost([0.2, 0, 0]) @ LaguerreTransformation.offset(0.3)
    >>> bool(np.abs(pair.laguerre(tilt).edge_distances - 1).max() < 1e-9)
    True
    >>> tilt.inverse().map_spheres(tilt.map_spheres([[1, 2, 3, 4]])).round(9).tolist()
    [[1.0, 2.0, 3.0, 4.0]]
    """

    __repr__ = short_repr

    matrix: FloatArray
    shift: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "matrix", lorentz.orthonormalised(self.matrix))
        object.__setattr__(self, "shift", array_of(self.shift, (4,), "the shift"))

    # --- elementary ones

    @classmethod
    def identity(cls) -> LaguerreTransformation:
        return cls(np.eye(4), np.zeros(4))

    @classmethod
    def translation(cls, vector: Any) -> LaguerreTransformation:
        """Moves everything by a vector (3,)."""
        return cls(np.eye(4), np.append(array_of(vector, (3,), "a translation"), 0.0))

    @classmethod
    def rotation(cls, orthogonal: Any) -> LaguerreTransformation:
        """x -> R x, a rotation about the origin or a reflection R (3, 3)."""
        return cls(lorentz.rotation(orthogonal), np.zeros(4))

    @classmethod
    def motion(cls, orthogonal: Any, vector: Any) -> LaguerreTransformation:
        """x -> R x + t, a Euclidean motion or, if det R < 0, a reflection with one."""
        return cls.translation(vector) @ cls.rotation(orthogonal)

    @classmethod
    def offset(cls, distance: float) -> LaguerreTransformation:
        """Adds to all radii: planes move along their normals, and M, S become M + distance S, S."""
        return cls(np.eye(4), np.array([0.0, 0.0, 0.0, distance]))

    @classmethod
    def boost(cls, velocity: Any) -> LaguerreTransformation:
        """The transformation with the matrix `lorentz.boost` of a velocity (3,) shorter than 1.

        Planes perpendicular to the velocity keep their normals; all other normals turn towards -velocity.
        """
        return cls(lorentz.boost(velocity), np.zeros(4))

    @classmethod
    def reversal(cls) -> LaguerreTransformation:
        """Reverses the orientation of every sphere and plane: (m, r) becomes (m, -r), and M, S become M, -S with
        reversed faces."""
        return cls(FORM, np.zeros(4))

    # --- the group

    def __matmul__(self, other: LaguerreTransformation) -> LaguerreTransformation:
        return LaguerreTransformation(self.matrix @ other.matrix, self.matrix @ other.shift + self.shift)

    def inverse(self) -> LaguerreTransformation:
        back = lorentz.inverse(self.matrix)
        return LaguerreTransformation(back, -back @ self.shift)

    @cached_property
    def gauss_map(self) -> MoebiusTransformation:
        """What happens to the unit normals of planes, and to Gauss images: it has the matrix J A J."""
        return MoebiusTransformation(FORM @ self.matrix @ FORM)

    # --- the action

    def map_spheres(self, spheres: Any) -> FloatArray:
        """(k, 4) images of oriented spheres (m, r). Lorentz products of differences stay: tangential distances."""
        return np.asarray(array_of(spheres, (None, 4), "the array of spheres") @ self.matrix.T + self.shift)

    def map_planes(self, planes: Any) -> FloatArray:
        """(k, 4) images of oriented planes n . x = h, each its unit normal n and h.

        A plane n, h touches the sphere (m, r) where n . m + r = h, that is where the Lorentz product of (n, -1) and
        (m, r) is h, so (n, -1) is mapped by A. Raises GeometryError for a normal that is not of length 1.
        """
        given = checked_planes(planes)
        moved = np.concatenate([given[:, :3], np.full((len(given), 1), -1.0)], axis=1) @ self.matrix.T
        heights = given[:, 3] + lorentz.product(moved, self.shift)
        lengths = np.linalg.norm(moved[:, :3], axis=1) * np.sign(self.matrix[3, 3])
        return np.asarray(np.concatenate([moved[:, :3], heights[:, None]], axis=1) / lengths[:, None])

    def map_cones(self, cones: VertexCones) -> VertexCones:
        """The cones that touch the images of the spheres that touch the cones.

        Raises GeometryError, naming the cone, where it opens to a cylinder or beyond.
        """
        apices, poles = self.map_lines(cones.apices, cones.poles, what="cone")
        return VertexCones(apices, poles)

    def map_lines(self, apices: FloatArray, poles: FloatArray, *, what: str = "line") -> tuple[FloatArray, FloatArray]:
        """(k, 3) apices m and (k, 3) poles s of the images of the lines (m - r s, r) of spheres: where the image of
        (m, 0) slides to radius 0.

        Raises GeometryError, naming the line (`what` they are), where its pole goes to infinity or through it.
        """
        moved = self.gauss_map.map_points(poles, what=what)
        spheres = apices @ self.matrix[:, :3].T + self.shift
        return spheres[:, :3] + spheres[:, 3:] * moved, moved
