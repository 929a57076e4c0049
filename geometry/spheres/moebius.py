"""Moebius transformations of the unit sphere, as projective maps of space [Pottmann2007, 3.2].

A Lorentz matrix A takes the point x to y with (y, 1) a multiple of A (x, 1). It maps the unit sphere to itself, planes
to planes and lines to lines, so it takes Koebe polyhedra to Koebe polyhedra. Closed ones with the same combinatorics
differ by nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.errors import GeometryError
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.spheres import lorentz

__all__ = ["NEAR_INFINITY", "MoebiusTransformation", "checked_planes"]

NEAR_INFINITY = 1e-9
"""Weight of a point over the sum of the absolute values of its parts, below which its image counts as at infinity:
rounding leaves it 7 digits."""

UNIT_NORMAL_TOLERANCE = 1e-9
"""Deviation of the length of a plane's normal from 1 that is allowed."""


@dataclass(frozen=True, eq=False)
class MoebiusTransformation:
    """x -> y with (y, 1) a multiple of A (x, 1): `matrix` A (4, 4) with A^T J A = J.

    A and -A do the same; the last entry of `matrix` is made positive. `f @ g` is f after g.
    Raises GeometryError where the matrix is not of the Lorentz group, see `lorentz.orthonormalised`.

    >>> move = MoebiusTransformation.boost([0.5, 0, 0])
    >>> move.map_points([[0, 0, 0], [1, 0, 0]]).round(9).tolist()
    [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]]
    >>> (move.inverse() @ move).map_points([[0.1, 0.2, 0.3]]).round(9).tolist()
    [[0.1, 0.2, 0.3]]
    """

    __repr__ = short_repr

    matrix: FloatArray

    def __post_init__(self) -> None:
        matrix = lorentz.orthonormalised(self.matrix)
        object.__setattr__(self, "matrix", floats(matrix * np.sign(matrix[3, 3])))

    @classmethod
    def identity(cls) -> MoebiusTransformation:
        return cls(np.eye(4))

    @classmethod
    def rotation(cls, orthogonal: Any) -> MoebiusTransformation:
        """x -> R x, a rotation or a reflection R (3, 3)."""
        return cls(lorentz.rotation(orthogonal))

    @classmethod
    def boost(cls, velocity: Any) -> MoebiusTransformation:
        """Moves the origin to `velocity` (3,), shorter than 1, along the line of both; see `lorentz.boost`."""
        return cls(lorentz.boost(velocity))

    def __matmul__(self, other: MoebiusTransformation) -> MoebiusTransformation:
        return MoebiusTransformation(self.matrix @ other.matrix)

    def inverse(self) -> MoebiusTransformation:
        return MoebiusTransformation(lorentz.inverse(self.matrix))

    @property
    def reverses_orientation(self) -> bool:
        """Whether circles on the sphere that ran counter-clockwise seen from outside run clockwise afterwards."""
        return bool(np.linalg.det(self.matrix) < 0)

    def map_points(self, points: Any, *, what: str = "point") -> FloatArray:
        """(k, 3) images of points (k, 3). Points of the closed unit ball stay there.

        Raises GeometryError, naming the point (`what` they are), its weight and the bound, for points that go to
        infinity, or through it as the transformation grows from a rotation: those on the plane that goes to
        infinity, which misses the unit ball, and beyond it.
        """
        given = lorentz.array_of(points, (None, 3), "the array of points")
        v = self.matrix[3, :3] / self.matrix[3, 3]
        weights = 1 + given @ v
        relative = weights / (1 + np.linalg.norm(given, axis=1) * np.linalg.norm(v))
        wrong = np.flatnonzero(relative < NEAR_INFINITY)
        if len(wrong):
            worst = int(relative.argmin())
            raise GeometryError(
                f"{what} {worst} goes to infinity or through it: its weight is {relative[worst]:.1e}, at least "
                f"{NEAR_INFINITY:.0e} is needed; use a smaller boost, or one that leads away from there",
                elements=wrong.tolist(),
                value=float(relative[worst]),
                bound=NEAR_INFINITY,
            )
        moved = given @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return np.asarray(moved / (self.matrix[3, 3] * weights)[:, None])

    def map_planes(self, planes: Any) -> FloatArray:
        """(k, 4) images of planes (k, 4), each its unit normal n and its distance h: n . x = h.

        Normals stay on the same side as seen from the images of the points of the unit ball.
        Raises GeometryError for a plane that goes to infinity, or a normal that is not of length 1.
        """
        given = checked_planes(planes)
        moved = given @ self.matrix.T  # the pole n / h of a plane moves as a point
        lengths = np.linalg.norm(moved[:, :3], axis=1)
        relative = lengths / (1 + np.abs(given[:, 3]) * np.linalg.norm(self.matrix[:3, 3]))
        wrong = np.flatnonzero(relative < NEAR_INFINITY)
        if len(wrong):
            plane = int(wrong[0])
            raise GeometryError(
                f"plane {plane} goes to infinity: its normal is {relative[plane]:.1e} long there, at least "
                f"{NEAR_INFINITY:.0e} is needed; use another boost",
                elements=wrong.tolist(),
                value=float(relative[plane]),
                bound=NEAR_INFINITY,
            )
        return np.asarray(moved / lengths[:, None])

    def map_mesh(self, mesh: MeshLike) -> Mesh:
        """The mesh with its vertices mapped: planar faces stay planar, a Koebe polyhedron stays one.

        Its faces are turned over where the transformation reverses the orientation, so that their outside stays
        outside. Raises as `map_points` does, naming the vertex.
        """
        mesh = as_mesh(mesh)
        moved = mesh.with_vertices(self.map_points(mesh.vertices, what="vertex"))
        return moved.reversed() if self.reverses_orientation else moved


def checked_planes(planes: Any) -> FloatArray:
    """(k, 4) the unit normals and distances of planes. Raises GeometryError where a normal is not of length 1."""
    given = lorentz.array_of(planes, (None, 4), "the array of planes")
    off = np.abs(np.linalg.norm(given[:, :3], axis=1) - 1)
    wrong = np.flatnonzero(off > UNIT_NORMAL_TOLERANCE)
    if len(wrong):
        plane = int(wrong[0])
        raise GeometryError(
            f"the normal of plane {plane} is {off[plane]:.1e} off length 1, allowed {UNIT_NORMAL_TOLERANCE:.0e}; "
            f"divide the normal and "
            "the distance by its length",
            elements=wrong.tolist(),
            value=float(off[plane]),
            bound=UNIT_NORMAL_TOLERANCE,
        )
    return given
