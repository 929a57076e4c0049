"""Minimal and constant mean curvature meshes of rotational symmetry [Pottmann2007, 5; Figs 10, 17 to 19].

In closed form for Gauss images S that consist of rings, see `Rings`: quads of generalised rotational symmetry, and
pointy-top hexagons. Flat-top hexagons have no rings: there M is found near a smooth surface by `constant_mean`, or as a
Christoffel dual. The axis is the z axis.

The first integral is that of the surfaces of Delaunay: with R and r the radii of M and S, H R^2 + r R is the same on
all rings of quads, just as on the smooth surface whose normals have the horizontal part r.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.curvature.christoffel_duals import christoffel_dual
from geometry.curvature.constant_mean_curvature import constant_mean
from geometry.curvature.hexagon_levels import levels_of_flat_top_hexagons
from geometry.curvature.rings import Rings
from geometry.errors import GeometryError, raise_worst
from geometry.gauss import Pair
from geometry.mesh import Mesh, MeshLike, as_gauss_image, shapes

__all__ = ["constant_mean_of_revolution", "minimal_of_revolution", "radii_at_inflections"]

SMOOTH_BAND_QUADS = 8
"""Quads around the axis that represent a smooth band: their first integral is the smooth one for any number."""

INFLECTION_ROUNDING = 1e-12
"""Depth of 1 + 4 H G below zero that counts as zero at an inflection: G is a product of many ratios."""


def minimal_of_revolution(gauss_image: MeshLike, *, waist: float = 1.0) -> Pair:
    """S with an M that has H = 0 in every face: a discrete catenoid, when S goes round [Pottmann2007, Figs 17, 18].

    waist: the least distance of a vertex from the axis. Edges in rings keep their orientation, meridian edges are
    reversed; of flat-top hexagons the horizontal edges keep it. M is centred in height.

    Raises MeshError where S does not consist of rings about the z axis, nor of flat-top hexagons; GeometryError where
    waist is not positive.

    >>> import numpy as np
    >>> from geometry.curvature import face_curvatures
    >>> from geometry.edge_offset import BandTiling, rotational_koebe
    >>> catenoid = minimal_of_revolution(rotational_koebe(BandTiling.QUADS, around=12, rows=4), waist=2.0)
    >>> bool(np.abs(face_curvatures(catenoid).mean).max() < 1e-9)
    True
    >>> np.linalg.norm(catenoid.mesh.vertices[:, :2], axis=1).min().round(9).item()
    2.0
    """
    gauss_image = as_gauss_image(gauss_image)
    _check_length("waist", waist)
    rings = Rings(gauss_image)
    is_ringed = rings.is_meridian.any()
    mesh = _minimal(rings, waist) if is_ringed else _minimal_of_flat_top_hexagons(gauss_image, waist)
    return Pair(mesh, gauss_image)


def _minimal(rings: Rings, waist: float) -> Mesh:
    factors = np.concatenate([[1.0], np.cumprod(rings.ratios)])
    return rings.parallel_mesh(factors * (waist / (factors[rings.of_vertices] * rings.radii).min()), 0.0)


def constant_mean_of_revolution(gauss_image: MeshLike, mean: float, *, radius: float | None = None) -> Pair:
    """S with an M that has H_F = mean in every face: a discrete surface of Delaunay [Pottmann2007, Figs 10, 19].

    mean: H, not zero; negative where M bulges as a sphere does. radius: distance from the axis of the vertices of M
    whose images are the furthest from it. With H < 0 and a = -r / (2 H), r the distance of those images (about 1),
    cylinders have a, spheres 2 a, bulges of unduloids something between; their necks are below a, nodoids beyond 2 a.
    None: such that the inflections of M are where S folds. At a fold of S (see `Rings.folds`) M changes from bulge to
    neck or back.

    The correspondence of edges keeps orientations in bulges and reverses meridians in necks. M is centred in height.

    Raises MeshError where S does not consist of rings about the z axis; GeometryError for numbers out of range,
    for a radius of None and an S without folds, and where S reaches beyond the inflection, naming the ring.

    >>> import numpy as np
    >>> from geometry.curvature import face_curvatures
    >>> from geometry.edge_offset import BandTiling, rotational_koebe
    >>> S = rotational_koebe(BandTiling.QUADS, around=12, rows=2)
    >>> unduloid = constant_mean_of_revolution(S, -1.0, radius=0.8)
    >>> bool(np.abs(face_curvatures(unduloid).mean + 1).max() < 1e-9)
    True
    """
    gauss_image = as_gauss_image(gauss_image)
    rings = Rings(gauss_image)
    if not (np.isfinite(mean) and mean != 0):
        raise GeometryError(
            f"the mean curvature is {mean}: a finite number is needed, and for zero take `minimal_of_revolution`",
            value=mean,
        )
    if not rings.is_meridian.any():
        return _constant_mean_of_flat_top_hexagons(gauss_image, mean, radius)
    return Pair(_constant_mean(rings, mean, radius), gauss_image)


def _constant_mean(rings: Rings, mean: float, radius: float | None) -> Mesh:
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
            "the Gauss image has no fold where inflections could be: give the radius of the mesh, or take a folded band"
        )
    return float(-1 / (4 * mean * relative[rings.folds].max()))


def _factors(rings: Rings, integrals: FloatArray, mean: float, branch: float) -> FloatArray:
    """nu of each ring with H nu^2 + nu = G; branch: which solution on the largest ring of S, the sign of 2 H nu + 1."""
    squares = 1 + 4 * mean * integrals

    def say(ring: int, square: float) -> str:
        reached = float(np.abs(rings.profiles).min(axis=1)[min(ring, rings.n_rings - 2), 0])
        return (
            f"the Gauss image reaches beyond the inflection of the mesh, most in ring {ring}, at a distance of "
            f"{reached:.3f} from the axis: inflections are at {reached * np.sqrt(1 - square):.3f}; take fewer "
            "rings, let them fold there, or take a radius further from that of the cylinder"
        )

    raise_worst(squares, ">=", -INFLECTION_ROUNDING, say)
    start = rings.of_vertices[rings.radii.argmax()]
    turns = np.searchsorted(rings.folds, np.arange(rings.n_rings))  # folds before each ring
    signs = branch * (-1.0) ** (turns - turns[start])
    sums = 1 + np.sqrt(np.maximum(squares, 0.0))  # which the smaller root is divided by, so that nothing cancels
    return np.asarray(np.where(signs > 0, 2 * integrals / sums, -sums / (2 * mean)))


def radii_at_inflections(gauss_image: Mesh) -> tuple[float, float]:
    """Radii that M with H = -1 has where S is widest, if its inflections are where S is narrowest: of a neck, and of a
    bulge. They add up to the radius of the sphere.

    Raises MeshError where S does not consist of rings about the z axis.

    >>> from geometry.edge_offset import BandTiling, rotational_koebe
    >>> neck, bulge = radii_at_inflections(rotational_koebe(BandTiling.QUADS, around=12, rows=4))
    >>> neck < bulge, round(neck, 3), round(bulge, 3)
    (True, 0.111, 0.924)
    """
    rings = Rings(gauss_image)
    relative = np.concatenate([[1.0], np.cumprod(rings.ratios)])
    widest = int(rings.radii.argmax())
    root = float(np.sqrt(1 - relative[rings.of_vertices[widest]] / relative.max()))
    return float(rings.radii[widest]) * (1 - root) / 2, float(rings.radii[widest]) * (1 + root) / 2


def _check_length(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise GeometryError(f"the {name} is {value}: a length above 0 is needed", value=value, bound=0.0)


# --- flat-top hexagons


def _minimal_of_flat_top_hexagons(gauss_image: Mesh, waist: float) -> Mesh:
    start = _lifted(gauss_image, _minimal(Rings(_smooth_band(gauss_image)), 1.0))
    mesh = christoffel_dual(gauss_image, near=start).mesh
    return mesh * (waist / float(np.linalg.norm(mesh.vertices[:, :2], axis=1).min()))


def _constant_mean_of_flat_top_hexagons(gauss_image: Mesh, mean: float, radius: float | None) -> Pair:
    rings = Rings(_smooth_band(gauss_image))
    if radius is not None and len(rings.folds):
        raise GeometryError(
            f"the radius is {radius}, but where flat-top hexagons fold over, the folds determine the radius: leave "
            "it out",
            value=radius,
        )
    start = _lifted(gauss_image, _constant_mean(rings, mean, radius))
    return constant_mean(gauss_image, mean, start)


def _smooth_band(gauss_image: Mesh) -> Mesh:
    """Quads inscribed in the unit sphere, with a ring at the latitude of each level of S.

    Where S folds over itself, a row of faces is folded flat, and the inflection of M is where its plane is tangent.
    """
    c, levels = gauss_image.combinatorics, levels_of_flat_top_hexagons(gauss_image)
    vertices = gauss_image.vertices[np.unique(levels, return_index=True)[1]]
    steps = np.diff(vertices[:, 2])
    folds = np.flatnonzero(steps[1:] * steps[:-1] < 0) + 1
    sines = vertices[:, 2] / np.linalg.norm(vertices, axis=1)
    if len(folds):
        rows = np.minimum.reduceat(levels[c.corners], c.face_starts[:-1])
        normals = gauss_image.face_normals[np.unique(rows, return_index=True)[1][folds - 1]]
        furthest = np.abs(normals[:, 2]).max()
        sines = np.clip(sines, -furthest, furthest)
    profile = np.stack([np.sqrt(1 - sines**2), sines], axis=1)
    return shapes.rotational_mesh(profile, SMOOTH_BAND_QUADS)


def _lifted(gauss_image: Mesh, smooth: Mesh) -> Mesh:
    """Vertices in the meridian planes of those of S, and in the rings of a mesh over `_smooth_band`."""
    levels = levels_of_flat_top_hexagons(gauss_image)
    radii, _, heights = smooth.vertices[: levels.max() + 1].T  # the first meridian is over the x axis
    flat = gauss_image.vertices[:, :2]
    flat = flat * (radii[levels] / np.linalg.norm(flat, axis=1))[:, None]
    return gauss_image.with_vertices(np.concatenate([flat, heights[levels, None]], axis=1))
