"""Edge offset meshes of revolution with their Koebe polyhedra, in closed form: convex, and like a catenoid."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import Mesh, shapes

__all__ = ["revolved_pair"]


def revolved_pair(n: int, rings: int, *, saddle: bool) -> tuple[Mesh, Mesh]:
    """M with a mean edge near 1, and S with edges at distance 1 from the origin; quads, n around.

    The vertex circles of S are the images on the sphere of circles about the points R_k e^(2 pi i j / n) with radii
    R_k sin(pi/n): neighbours touch, as R_(k+1) (1 - sin) = R_k (1 + sin). A vertex is the pole of its circle, where two
    of its edges meet. M keeps the directions of the profile of S and has lengths of its own: of the same sense all
    over, or with the sense of its profile turned about.
    """
    sine = np.sin(np.pi / n)
    radii = ((1 + sine) / (1 - sine)) ** (np.arange(rings) - (rings - 1) / 2)
    # the sphere's circle over |z - c| = r has the pole (2 c, c^2 - r^2 - 1) / (c^2 - r^2 + 1)
    power = radii**2 * (1 - sine**2)
    profile = np.stack([2 * radii, power - 1], axis=1) / (power + 1)[:, None]
    steps = np.diff(profile, axis=0)
    image = shapes.rotational_mesh(profile, n)
    start = profile[:1] * [3.0, 1.0] if saddle else profile[:1] * [2.0, 1.0]
    factors = np.linspace(1.0, 1.6, len(steps))[:, None]
    own: FloatArray = np.concatenate([start, start + np.cumsum(steps * factors * (-1 if saddle else 1), axis=0)])
    mesh = image.with_vertices(shapes.rotational_mesh(own, n).vertices)
    return mesh * (1 / mesh.mean_edge_length), image * (-1 if saddle else 1)
