"""Meshes of constant mean curvature, zero or not, with Koebe polyhedra as Gauss images [Pottmann2007, 5]."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

import numpy as np

from fabkit.designs.pair import EdgeOffsetDesign
from fabkit.errors import ProjectError
from geometry.curvature import (
    christoffel_dual,
    constant_mean,
    constant_mean_of_revolution,
    face_curvatures,
    minimal_of_revolution,
)
from geometry.edge_offset.planar_patterns import enneper_koebe
from geometry.edge_offset.rotational import Pattern, rotational_koebe, rows_within
from geometry.mesh import read_mesh, read_mesh_pair

__all__ = ["Faces", "MinimalShape", "cmc_design", "cmc_near_design", "minimal_design"]


class MinimalShape(StrEnum):
    """Minimal surfaces that have meshes in closed form, or nearly so."""

    CATENOID = "catenoid"
    ENNEPER = "enneper"


class Faces(StrEnum):
    QUADS = "quads"
    HEXAGONS = "hexagons"

    @property
    def pattern(self) -> Pattern:
        """The faces around an axis."""
        return Pattern.QUADS if self is Faces.QUADS else Pattern.STANDING_HEXAGONS


def minimal_design(
    *,
    shape: MinimalShape = MinimalShape.CATENOID,
    faces: Faces = Faces.QUADS,
    count: int = 24,
    turn_deg: float = 60.0,
    gauss_image: Path | None = None,
) -> EdgeOffsetDesign:
    """A mesh with mean curvature zero in every face [Pottmann2007, Figs 17, 18].

    count: faces around the axis of a catenoid, or along a side of Enneper's surface. turn_deg: by how much normals turn
    from the middle to the rim. gauss_image: instead of all that, the file of a Koebe polyhedron with boundary, whose
    fairest Christoffel dual is taken.

    Raises GeometryError for numbers out of range, and for a Gauss image that has no dual.
    """
    if gauss_image is not None:
        given = read_mesh(gauss_image).mesh
        return EdgeOffsetDesign.of("minimal", christoffel_dual(given), given, {"gauss_image": gauss_image.name})
    _check_turn(turn_deg)
    turn = float(np.radians(turn_deg))
    told = {"shape": str(shape), "faces": str(faces), "count": count, "turn_deg": turn_deg}
    if shape is MinimalShape.CATENOID:
        image = rotational_koebe(faces.pattern, count, rows_within(faces.pattern, count, turn))
        return EdgeOffsetDesign.of("minimal", minimal_of_revolution(image), image, told)
    if faces is not Faces.QUADS:
        raise ProjectError("the surface of Enneper is made of quads; leave out the hexagons, or take the catenoid")
    image = enneper_koebe(count, reach=float(np.tan(turn / 2)))
    return EdgeOffsetDesign.of("minimal", christoffel_dual(image), image, told)


def _check_turn(turn_deg: float) -> None:
    if not 0 < turn_deg < 90:
        raise ProjectError(f"the normals are to turn by {turn_deg:g} degrees: above 0 and below 90 is needed")


def cmc_design(
    *, faces: Faces = Faces.QUADS, count: int = 24, rows: int = 6, folds: int = 2, bulge: float | None = None
) -> EdgeOffsetDesign:
    """A mesh of revolution with the same mean curvature -1 in every face [Pottmann2007, Figs 10, 19].

    count: faces around the axis; rows of them from one inflection to the next; folds: how many inflections there are
    between bulges and necks. bulge: the widest radius, where a sphere has 1 and a cylinder 0.5; left out: such that S
    folds at the inflections.

    Raises GeometryError for numbers out of range and where rows reach beyond the inflections.
    """
    image = rotational_koebe(faces.pattern, count, rows, folds=folds)
    mesh = constant_mean_of_revolution(image, -1.0, radius=bulge)
    told = {"faces": str(faces), "count": count, "rows": rows, "folds": folds, "bulge": bulge}
    return EdgeOffsetDesign.of("cmc", mesh, image, told)


def cmc_near_design(start: Path, gauss_image: Path, *, mean: float | None = None) -> EdgeOffsetDesign:
    """A mesh with the same mean curvature in every face near to a mesh that is there, such as one of `koebe_design`.

    start, gauss_image: files of M and S, a Koebe polyhedron, of the same faces. mean: H, one over the unit of M,
    negative where M bulges as a sphere does; left out: the median over the faces of M, which leaves its size as it is.

    Raises GeometryError where the pair does not fit together, and where there is no such mesh near.
    """
    file, image = read_mesh_pair(start, gauss_image)
    wanted = float(np.median(face_curvatures(file.mesh, image).mean)) if mean is None else mean
    mesh = constant_mean(image, wanted, file.mesh)
    told = {"start": start.name, "gauss_image": gauss_image.name, "mean": wanted}
    return EdgeOffsetDesign.of("cmc", mesh, image, told)
