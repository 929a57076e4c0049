"""The Moebius image of points of the unit sphere whose centre is at the origin.

It is unique up to rotations [Springborn2005]: the sum of the distances of a point x of hyperbolic space from the points
at infinity is convex, and its minimum is the point that has to be moved to the origin. Along a line through
x, the second derivative of each distance changes at most by the factor exp(2 s) over a length s; so Newton's step v may
be taken up to log(1 + 2 |v|) / 2, and the sum falls all along it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import ComplexArray, FloatArray
from geometry.errors import GeometryError
from geometry.spheres import MoebiusTransformation
from geometry.spheres.stereographic import pairs, to_sphere

__all__ = ["centring_similarity", "centring_transformation"]

CENTRING_TOLERANCE = 1e-12
"""Distance of the centre from where it should be that is allowed; steps continue while they halve it."""

MAX_CENTRING_STEPS = 100
"""Most Newton steps: 6 to 10 are enough, unless half of the points are nearly in one place."""


def centring_similarity(points: ComplexArray, coverage: float = 1.0) -> tuple[complex, float]:
    """z0 and t0 > 0: the points (z - z0) / t0, lifted to the sphere, have their centre at (0, 0, coverage - 1).

    points (n,); one that is not finite is the north pole. coverage: above 0, at most 1; a cap about the south pole,
    covered evenly, has such a centre where it has that part of the area of the sphere.
    Raises GeometryError where half of the points or more are in one place.
    """
    finite = points[np.isfinite(points)]
    z0, t0 = complex(np.median(finite.real), np.median(finite.imag)), 1.0
    t0 = float(np.median(np.abs(finite - z0))) or t0
    at_pole = len(points) - len(finite)
    descent = _Descent(len(points))
    while True:
        # points added at the north pole keep the others from it
        weight = at_pole + (1 - coverage) * len(points)
        step = descent.step(to_sphere(pairs((finite - z0) / t0)), weight)
        if step is None:
            return z0, t0
        length = float(np.linalg.norm(step))
        x1, x2, x3 = np.sinh(length) * step / length
        stretch = 1 / (np.cosh(length) - x3)
        z0, t0 = z0 + t0 * stretch * complex(x1, x2), t0 * stretch


def centring_transformation(points: FloatArray) -> MoebiusTransformation:
    """The Moebius transformation, without a rotation, that takes points (n, 3) of the sphere to where their sum is 0.

    Raises GeometryError where half of the points or more are in one place.
    """
    transformation = MoebiusTransformation.identity()
    descent = _Descent(len(points))
    while True:
        moved = transformation.map_points(points)
        step = descent.step(moved / np.linalg.norm(moved, axis=1, keepdims=True), 0.0)
        if step is None:
            return transformation
        length = float(np.linalg.norm(step))
        transformation = MoebiusTransformation.boost(-np.tanh(length) * step / length) @ transformation


@dataclass
class _Descent:
    """Newton's method for n points, and its residual `off`: the distance of the centre from where it should be, over
    n."""

    n: int
    steps: int = 0
    off: float = np.inf

    def step(self, points: FloatArray, weight: float) -> FloatArray | None:
        """The next step (3,) in hyperbolic space from the origin; None where the centre is as accurate as possible.

        points (k, 3) of the sphere, and one of this weight at the north pole. Raises GeometryError after
        `MAX_CENTRING_STEPS`.
        """
        north = np.array([0.0, 0.0, weight])
        centre = points.sum(axis=0) + north
        before, self.off = self.off, float(np.linalg.norm(centre)) / self.n
        if self.off == 0 or before / 2 < self.off <= CENTRING_TOLERANCE:
            return None
        if self.steps == MAX_CENTRING_STEPS:
            raise GeometryError(
                f"the centre of {self.n} points of the sphere stays {self.off:.1e} from where it should be, allowed "
                f"{CENTRING_TOLERANCE:.0e}: half of them or more are nearly in one place",
                value=self.off,
                bound=CENTRING_TOLERANCE,
            )
        self.steps += 1
        curvature = (len(points) + weight) * np.eye(3) - points.T @ points - np.diag(north)
        newton: FloatArray = np.linalg.solve(curvature, centre)
        length = float(np.linalg.norm(newton))
        return np.asarray(newton * (np.log1p(2 * length) / (2 * length)))
