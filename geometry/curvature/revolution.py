"""Minimal and constant mean curvature meshes of rotational symmetry, in closed form [Pottmann2007, 5; Figs 17 to 19].

For Gauss images S that consist of rings, see `Rings`: quads of generalised rotational symmetry, and standing hexagons.
The axis is the z axis. The first integral is that of the surfaces of Delaunay: with R and r the radii of M and S,
H R^2 + r R is the same on all rings of quads, just as on the smooth surface with the normal of horizontal part r.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.curvature.rings import Rings
from geometry.errors import GeometryError
from geometry.mesh import Mesh

__all__ = ["constant_mean_of_revolution", "minimal_of_revolution"]

ROUNDING = 1e-12
"""How far 1 + 4 H G may be below zero at an inflection, where it should be zero: G is a product of many ratios."""


def minimal_of_revolution(gauss_image: Mesh, *, waist: float = 1.0) -> Mesh:
    """M with H = 0 in every face with respect to S: a discrete catenoid, when S goes round [Pottmann2007, Figs 17, 18].

    waist: the least distance of a vertex from the axis. Edges in rings keep their orientation, meridian edges are
    reversed. M is centred in height.

    Raises MeshError where S does not consist of rings about the z axis, GeometryError where waist is not positive.
    """
    _check_length("waist", waist)
    rings = Rings(gauss_image)
    factors = np.concatenate([[1.0], np.cumprod(rings.ratios)])
    return rings.parallel_mesh(factors * (waist / (factors[rings.of_vertices] * rings.radii).min()), 0.0)


def constant_mean_of_revolution(gauss_image: Mesh, mean: float, *, radius: float | None = None) -> Mesh:
    """M with H_F = mean in every face with respect to S: a discrete surface of Delaunay [Pottmann2007, Figs 10, 19].

    mean: H, not zero; negative where M bulges as a sphere does, -1 / (2 a) for a cylinder of radius a. radius: distance
    from the axis of the vertices of M whose images are the furthest from it: with H < 0, cylinders have a, spheres 2 a,
    bulges of unduloids something between; their necks are below a, and nodoids beyond 2 a. None: such that
    the inflections of M are where S folds. At a fold of S (see `Rings.folds`) M goes over from bulge to neck or back.

    The correspondence of edges keeps orientations in bulges and reverses meridians in necks. M is centred in height.

    Raises MeshError where S does not consist of rings about the z axis; GeometryError for numbers out of range,
    for a radius of None and an S without folds, and where S reaches beyond the inflection, naming the ring.
    """
    rings = Rings(gauss_image)
    if not (np.isfinite(mean) and mean != 0):
        raise GeometryError(f"the mean curvature is {mean}: for zero take `minimal_of_revolution`", value=mean)
    relative = np.concatenate([[1.0], np.cumprod(rings.ratios)])  # G over that of the first ring
    if radius is None:
        integral, branch = _integral_at_folds(rings, relative, mean), -1.0
    else:
        _check_length("radius", radius)
        vertex = int(rings.radii.argmax())
        factor = radius / rings.radii[vertex]
        integral = (mean * factor + 1) * factor / relative[rings.of_vertices[vertex]]
        branch = 1.0 if 2 * mean * factor + 1 > 0 else -1.0
    return rings.parallel_mesh(_factors(rings, integral * relative, mean, branch), mean)


def _integral_at_folds(rings: Rings, relative: FloatArray, mean: float) -> float:
    """G of the first ring, for which the two solutions nu meet at the fold where S has come furthest."""
    if not len(rings.folds):
        raise GeometryError(
            "the Gauss image has no fold where inflections could be: say the radius of the mesh, or take a folded band"
        )
    return float(-1 / (4 * mean * relative[rings.folds].max()))


def _factors(rings: Rings, integrals: FloatArray, mean: float, branch: float) -> FloatArray:
    """nu of each ring with H nu^2 + nu = G; branch: which solution on the largest ring of S, the sign of 2 H nu + 1."""
    squares = 1 + 4 * mean * integrals
    ring = int(squares.argmin())
    if squares[ring] < -ROUNDING:
        reached = float(np.abs(rings.profiles).min(axis=1)[min(ring, rings.n_rings - 2), 0])
        raise GeometryError(
            f"the Gauss image reaches beyond the inflection of the mesh, most in ring {ring}, at a distance of "
            f"{reached:.3f} from the axis: inflections are at {reached * np.sqrt(1 - squares[ring]):.3f}; take fewer "
            "rings, let them fold there, or take a radius further from that of the cylinder",
            elements=[ring],
            value=float(squares[ring]),
            bound=0.0,
        )
    start = rings.of_vertices[rings.radii.argmax()]
    turns = np.searchsorted(rings.folds, np.arange(rings.n_rings))  # folds before each ring
    signs = branch * (-1.0) ** (turns - turns[start])
    return np.asarray((signs * np.sqrt(np.maximum(squares, 0.0)) - 1) / (2 * mean))


def _check_length(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise GeometryError(f"the {name} is {value}: a length above 0 is needed", value=value, bound=0.0)
