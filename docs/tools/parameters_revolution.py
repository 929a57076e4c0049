"""Studies of meshes determined by S and their mean curvature, and of their Laguerre transformations."""

from __future__ import annotations

from functools import cache

import numpy as np

from docs.tools.parameters_koebe import DIRECTIONS, unit
from docs.tools.parameters_study import Parameter, Study
from geometry.curvature import christoffel_dual, constant_mean_of_revolution, minimal_of_revolution
from geometry.edge_offset.enneper import enneper_koebe
from geometry.edge_offset.rotational import BandTiling, rotational_koebe
from geometry.gauss import Pair
from geometry.spheres.laguerre import LaguerreTransformation

__all__ = ["CONSTANT_MEAN", "LAGUERRE", "MINIMAL"]

KINDS = tuple(tiling.value for tiling in BandTiling)


@cache
def _catenoid(pattern: str, around: int, rows: int, latitude_deg: float = 0.0) -> Pair:
    return minimal_of_revolution(
        rotational_koebe(BandTiling(pattern), around, rows, latitude=float(np.radians(latitude_deg)))
    )


def _enneper(turn_deg: float) -> Pair:
    return christoffel_dual(enneper_koebe(10, reach=float(np.tan(np.radians(turn_deg) / 2))))


CATENOID = "M is a catenoid with waist 1: its mean curvature is zero in every face, and S is given in closed form."
FACES = Parameter("Faces", "Type of faces around the axis.", KINDS)

MINIMAL = (
    Study(
        "Minimal meshes",
        "Catenoid",
        CATENOID,
        (
            FACES,
            Parameter(
                "Faces around",
                "With more faces around the axis, rows become lower, since circles of neighbouring faces touch.",
                (8, 10, 12, 16, 20),
                start=2,
            ),
            Parameter("Rows", "Extent of the band towards the poles, and of M from its waist.", (2, 3, 4, 5), start=2),
        ),
        _catenoid,
        0.15,
        0.0,
    ),
    Study(
        "Minimal meshes",
        "Latitude",
        CATENOID,
        (
            FACES,
            Parameter(
                "Latitude of the middle",
                "The same band of faces, moved over the sphere, gives another part of the catenoid.",
                tuple(range(-40, 41, 10)),
                "{}°",
                4,
            ),
        ),
        lambda pattern, latitude: _catenoid(pattern, 12, 4, latitude),
        0.15,
        0.0,
    ),
    Study(
        "Minimal meshes",
        "Enneper",
        "M is the Christoffel dual of S, a surface of Enneper: zero mean curvature without an axis.",
        (
            Parameter(
                "Rotation of normals",
                "From the centre to the middle of a side; the larger, the more M winds round.",
                tuple(range(40, 121, 10)),
                "{}°",
                4,
            ),
        ),
        _enneper,
        0.06,
        0.0,
    ),
)


# --- constant mean curvature


@cache
def _unduloid(rows: int, folds: int) -> Pair:
    return constant_mean_of_revolution(rotational_koebe(BandTiling.QUADS, 16, rows, folds=folds), -1.0)


def _nodoid(pattern: str, radius: float) -> Pair:
    """radius: over that of S, which is the sphere with the mean curvature -1."""
    S = rotational_koebe(BandTiling(pattern), 16, 3)
    largest = float(np.linalg.norm(S.vertices[:, :2], axis=1).max())
    return constant_mean_of_revolution(S, -1.0, radius=radius * largest)


CONSTANT_MEAN = (
    Study(
        "Constant mean curvature",
        "Cylinder to spheres",
        "M has the mean curvature -1 in every face. S is folded where bulges of M turn into necks.",
        (
            Parameter(
                "Rows between inflections",
                "With few rows M is nearly a cylinder; with more, bulges become spheres and necks become points.",
                (2, 3, 4, 5, 6, 7, 8),
                start=2,
            ),
            Parameter("Folds", "Each fold of S adds a neck or a bulge to M.", (1, 2, 3, 4), start=3),
        ),
        _unduloid,
        0.12,
        -1.0,
    ),
    Study(
        "Constant mean curvature",
        "Beyond the sphere",
        "One band S, and the meshes M parallel to it with mean curvature -1 in every face.",
        (
            Parameter("Faces", "Type of faces around the axis.", KINDS[:2]),
            Parameter(
                "Widest radius",
                "At 1, M is S, a sphere; below 1 the bulge of an unduloid, above 1 a part of a nodoid.",
                (0.8, 0.85, 0.9, 0.95, 1, 1.1, 1.2, 1.3, 1.4, 1.5),
                "{:g}",
                4,
            ),
        ),
        _nodoid,
        0.12,
        -1.0,
    ),
)


# --- Laguerre geometry

BODIES = ("catenoid", "unduloid")


def _body(name: str) -> Pair:
    return _catenoid("pointy-top hexagons", 12, 4) if name == "catenoid" else _unduloid(4, 2)


def _by_boost(body: str, direction: str, speed: float) -> Pair:
    return _body(body).laguerre(LaguerreTransformation.boost(speed * unit(direction)))


def _by_offset(body: str, distance: float) -> Pair:
    return _body(body).laguerre(LaguerreTransformation.offset(distance))


BODY = Parameter("Mesh", "What is transformed: a minimal mesh or one with H = -1.", BODIES)

LAGUERRE = (
    Study(
        "Laguerre geometry",
        "Boost",
        "A Laguerre transformation maps edge offset meshes to edge offset meshes, and S by a Moebius "
        "transformation. H is not preserved.",
        (
            BODY,
            Parameter("Direction", "Along the axis, upwards, or across it.", DIRECTIONS),
            Parameter(
                "Speed",
                "Planes rotate away from this direction; at speed 1 all would be parallel.",
                tuple(k / 10 for k in range(-4, 5)),
                "{:g}",
                6,
            ),
        ),
        _by_boost,
        0.12,
    ),
    Study(
        "Laguerre geometry",
        "Offset",
        "M + d S: edges move by exactly d, beams stay in their planes, and S does not change.",
        (
            BODY,
            Parameter(
                "Distance d",
                "The offset of the unduloid by -1 has H = 1: bulges and necks are exchanged.",
                tuple(k / 5 for k in range(-5, 6)),
                "{:g}",
                5,
            ),
        ),
        _by_offset,
        0.12,
    ),
)
