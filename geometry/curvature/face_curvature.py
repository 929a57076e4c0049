"""Mean, Gaussian and principal curvatures of faces, from how their areas grow in offsets [Pottmann2007, 5].

Signs are those of (5): the sphere of radius r with its outward S has H = -1/r and K = 1/r^2, so H is positive where the
surface bends towards the side to which S points. Replacing S by -S changes the sign of H and leaves K unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import MeshError, raise_worst
from geometry.gauss import PairLike, as_pair
from geometry.mesh.polygons import face_mean_edge_lengths, mixed_areas
from geometry.parallel.edge_parallelity import check_planar

__all__ = [
    "LEAST_DISCRIMINANT",
    "LEAST_FACE_AREA",
    "FaceCurvatures",
    "face_curvatures",
    "steiner_area",
    "steiner_areas",
]

LEAST_FACE_AREA = 1e-9
"""Least area of a face over the square of its mean edge length: with smaller faces rounding would leave too few digits
of the curvatures."""

LEAST_DISCRIMINANT = 1e-9
"""H^2 - K counts as zero down to minus this, over the square of l l' / area(F) with the mean edge lengths l and l' of
the face and its image: meshes count as parallel to 1e-9, which may change H^2 - K by as much."""


@dataclass(frozen=True, eq=False)
class FaceCurvatures:
    """Curvatures of each face of M with respect to a Gauss image S [Pottmann2007, (7)].

    areas (F,): of the faces F of M, positive. mean (F,): H = -area(F, sigma(F)) / area(F), one over a length.
    gaussian (F,): K = area(sigma(F)) / area(F), negative where the face and its image have opposite orientations.
    principal (F, 2): kappa_1 >= kappa_2, the roots of x^2 - 2 H x + K; NaN in the faces `without_principal`.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import dome
    >>> curvatures = face_curvatures(Pair(dome(12, 4) * 2, dome(12, 4)))
    >>> curvatures.mean.round(9).max().item(), curvatures.gaussian.round(9).max().item()
    (-0.5, 0.25)
    >>> curvatures.principal.shape, len(curvatures.without_principal)
    ((48, 2), 0)
    """

    __repr__ = short_repr

    areas: FloatArray
    mean: FloatArray
    gaussian: FloatArray
    principal: FloatArray

    @property
    def without_principal(self) -> IntArray:
        """Faces with H^2 < K, which have no principal curvatures; neither they nor their images are strictly convex."""
        return integers(np.flatnonzero(np.isnan(self.principal[:, 0])))


def face_curvatures(pair: PairLike, *, negative: float = LEAST_DISCRIMINANT) -> FaceCurvatures:
    """The curvatures of the faces of M with respect to S [Pottmann2007, (7)].

    S may be any Gauss image, exact or not, of unit size. The curvatures do not change when M or S is translated, or
    when both are rotated; for M twice as large, H is half and K a quarter.

    `negative`: how far below zero rounding may take H^2 - K where both principal curvatures are equal; see
    `LEAST_DISCRIMINANT`.

    Raises MeshError where a face of M has no area, GeometryError where one is not planar.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import dome
    >>> face_curvatures(Pair(dome(12, 4) * 2, dome(12, 4))).mean.round(9).max().item()  # a sphere of radius 2
    -0.5
    """
    pair = as_pair(pair)
    mesh, gauss_image, c = pair.mesh, pair.gauss_image, pair.mesh.combinatorics
    check_planar(mesh)
    areas = np.linalg.norm(mesh.vector_areas, axis=1)
    lengths = face_mean_edge_lengths(mesh.vertices, c)
    _check_areas(areas / lengths**2)
    normals = mesh.vector_areas / areas[:, None]  # hence area(F) > 0, as Prop. 5 asks
    mean = -mixed_areas(mesh.vertices, gauss_image.vertices, c, normals) / areas
    gaussian = mixed_areas(gauss_image.vertices, gauss_image.vertices, c, normals) / areas
    scale = (face_mean_edge_lengths(gauss_image.vertices, c) * lengths / areas) ** 2
    return FaceCurvatures(floats(areas), floats(mean), floats(gaussian), _principal(mean, gaussian, negative * scale))


def steiner_areas(pair: PairLike, d: float) -> FloatArray:
    """(F,) areas (1 - 2 d H + d^2 K) area(F) of the faces of the offset M + d S [Pottmann2007, (6)].

    Exact for every d, also negative ones; a face that has turned over in the offset counts negative. Raises as
    `face_curvatures` does.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import cube
    >>> steiner_areas(Pair(cube(), cube()), 0.5).round(9).tolist()  # of faces 2 by 2, then 3 by 3
    [9.0, 9.0, 9.0, 9.0, 9.0, 9.0]
    """
    pair = as_pair(pair)
    curvatures = face_curvatures(pair)
    return (1 - 2 * d * curvatures.mean + d * d * curvatures.gaussian) * curvatures.areas


def steiner_area(pair: PairLike, d: float) -> float:
    """The area of the offset M + d S, as the sum of `steiner_areas` [Pottmann2007, Prop. 5].

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import cube
    >>> round(steiner_area(Pair(cube(), cube()), 0.5), 9)
    54.0
    """
    return float(steiner_areas(pair, d).sum())


def _principal(mean: FloatArray, gaussian: FloatArray, rounding: FloatArray) -> FloatArray:
    """(F, 2) the roots of x^2 - 2 H x + K, the larger one first; NaN where there are none."""
    squares = mean**2 - gaussian
    squares[(squares < 0) & (squares >= -rounding)] = 0.0
    half = np.sqrt(squares, out=np.full_like(squares, np.nan), where=squares >= 0)
    return floats(np.stack([mean + half, mean - half], axis=1))


def _check_areas(relative: FloatArray) -> None:
    """relative (F,): areas over the squares of the mean edge lengths."""
    raise_worst(
        relative,
        ">=",
        LEAST_FACE_AREA,
        lambda face, value: (
            f"face {face} has an area of {value:.1e} of its mean edge length squared, at least "
            f"{LEAST_FACE_AREA:.0e} is needed: it has no curvature; remove the face, or list its corners in their order"
        ),
        error=MeshError,
    )
