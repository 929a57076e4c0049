"""Circular faces with any number of corners [Pottmann2007, Prop. 2].

The corners p_i of a planar face lie on a circle if and only if |p_i|^2 = a + b u_i + c v_i with in-plane coordinates u,
v. So with Q as in `face_frames` and q_i = |p_i|^2, both from the centroid, the residuals are Q^T q / 2R, where R is the
root mean square of the |p_i|. A corner at the distance d from a circle of radius r changes q by 2 r d, and r = R for
regular faces, so that residuals are distances there; they are larger where the corners lie on a short arc, r > R.
Division by R instead of r avoids a false zero where corners approach a line and r grows without bound.

Derivative: let m be the centre of the best circle. Q^T removes the effect of moving the plane and its axes, so the
derivative of Q^T q is Q^T [2 (p_i - m) . dp_i], up to terms of the order of the residuals and of the distances from the
plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray
from geometry.functionals.face_frames import FaceFrames, NonTriangularFaces
from geometry.mesh import Combinatorics
from geometry.optimise import SparseMatrix

__all__ = ["CircularFaces"]


@dataclass(frozen=True, eq=False)
class CircularFaces:
    """k - 3 residuals for each face with k corners, in the unit of the coordinates; the unknown is all of them (3N,).

    To be used together with `PlanarFaces`, since it means little for a face that is not planar. Where faces are planar,
    jacobian^T residual is the gradient of |residual|^2 / 2. The corners of a face must not all be collinear.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(1, 1)
    >>> r = CircularFaces(grid.combinatorics)
    >>> kite = grid.vertices + [(0, 0, 0), (0, 0, 0), (0, 0, 0), (0.1, 0.1, 0)]
    >>> abs(r.residual(grid.vertices.ravel())).max().round(12).item(), abs(r.residual(kite.ravel())).round(1).tolist()
    (0.0, [0.1])
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        return self._faces.stacked([_residuals(frames) for frames in self._faces.frames(x)])

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        return self._faces.matrix([_derivatives(frames) for frames in self._faces.frames(x)])

    @cached_property
    def _faces(self) -> NonTriangularFaces:
        return NonTriangularFaces(self.combinatorics)


def _squares(frames: FaceFrames) -> FloatArray:
    """(n, k) q."""
    return np.asarray(np.einsum("fki,fki->fk", frames.here, frames.here))


def _radii(frames: FaceFrames) -> FloatArray:
    """(n,) R."""
    return np.asarray(np.sqrt(_squares(frames).mean(axis=1)))


def _residuals(frames: FaceFrames) -> FloatArray:
    """(n, k-3)"""
    return frames.project_out(_squares(frames)) / (2 * _radii(frames)[:, None])


def _derivatives(frames: FaceFrames) -> FloatArray:
    """(n, k-3, k, 3): with the change of R, without which J^T r would not quite be a gradient."""
    in_plane = frames.axes[:, :, 1:]
    along = frames.here @ in_plane  # u and v are perpendicular to each other and to 1, as the axes are principal
    slopes = np.einsum("fku,fk->fu", along, _squares(frames)) / np.einsum("fku,fku->fu", along, along)
    centres = np.einsum("fiu,fu->fi", in_plane, slopes) / 2
    radii = _radii(frames)[:, None, None]
    outwards = (frames.here - centres[:, None, :]) / radii
    k = frames.here.shape[1]
    growth = frames.here / (k * radii**2)  # of log R
    changes = np.einsum("fkq,fki->fqki", frames.basis, outwards)
    return np.asarray(changes - np.einsum("fq,fki->fqki", _residuals(frames), growth))
