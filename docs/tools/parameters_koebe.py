"""Studies of Koebe polyhedra S and of the fairest meshes M parallel to them."""

from __future__ import annotations

from functools import cache

import numpy as np

from docs.tools.parameters_study import Parameter, Study
from geometry.arrays import FloatArray, IntArray
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron, koebe
from geometry.edge_offset.signed_meshes import edge_offset_mesh, saddle_signs
from geometry.gauss import Pair
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.tilings import hexagon_patch, pentagon_patch, quad_patch
from geometry.spheres.moebius import MoebiusTransformation

__all__ = ["DIRECTIONS", "KOEBE", "SIGNS", "unit"]

SOUTH = (0.0, 0.0, -1.0)
"""Opposite the middle of an open polyhedron: directions on it are those of the plane seen from there."""

AT_LEAST_1 = (1.0, np.inf)

BEAM = 0.35
"""Height of beams where edges are at least 1 long."""


def _with_fairest(polyhedron: KoebePolyhedron) -> Pair:
    S = polyhedron.mesh
    return Pair(edge_offset_mesh(S, signs=1, lengths=AT_LEAST_1), S)


@cache
def _patch(faces: str) -> Combinatorics:
    return {"quads": quad_patch(8, 8), "hexagons": hexagon_patch(7, 8), "pentagons": pentagon_patch(6, 6)}[faces]


def _by_coverage(faces: str, percent: float) -> Pair:
    return _with_fairest(koebe(_patch(faces), coverage=percent / 100))


def _by_corner_angle(angle_deg: float) -> Pair:
    """The angle at two opposite corners of a patch of quads; at the other two, the supplementary angle."""
    c = _patch("quads")
    angles = np.where(c.is_boundary_vertex, np.pi, np.nan)
    angles[[0, 8, 80, 72]] = np.radians([angle_deg, 180 - angle_deg] * 2)
    return _with_fairest(koebe(c, angles=angles, coverage=0.4))


def _by_boundary_radii(faces: str, ratio: float) -> Pair:
    """Radii grow evenly along y, from one end of the boundary to the other."""
    c = _patch(faces)
    y = koebe(c).mesh.vertices[:, 1]
    along = (y - y.min()) / (y.max() - y.min()) - 0.5
    radii = np.where(c.is_boundary_vertex, ratio**along, np.nan)
    return _with_fairest(koebe(c, radii=radii, coverage=0.4))


def _by_moebius(direction: str, speed: float) -> Pair:
    boost = MoebiusTransformation.boost(speed * unit(direction))
    return _with_fairest(koebe(_patch("quads"), coverage=0.4).mapped(boost))


def unit(direction: str) -> FloatArray:
    """(3,) across the axis or along it."""
    return np.array({"sideways": [1.0, 0.0, 0.0], "upwards": [0.0, 0.0, 1.0]}[direction])


DIRECTIONS = ("sideways", "upwards")
DOMES = "Koebe polyhedra"
FAIREST = "M is the fairest mesh parallel to S whose edges all run as in S and are at least 1 long."
PATCHES = ("quads", "hexagons", "pentagons")
FACES = Parameter("Faces", "The combinatorics, here of a patch, determines S.", PATCHES)

KOEBE = (
    Study(
        DOMES,
        "Coverage",
        FAIREST,
        (
            FACES,
            Parameter(
                "Coverage",
                "Part of the sphere that S covers: the larger, the more M bends.",
                (5, 10, 20, 30, 40, 50, 60, 70, 80),
                "{} %",
                4,
            ),
        ),
        _by_coverage,
        BEAM,
    ),
    Study(
        DOMES,
        "Boundary angles",
        FAIREST,
        (
            Parameter(
                "Angle at two corners",
                "Angles of the circle pattern at boundary vertices of S may be given: here at two opposite corners.",
                tuple(range(40, 141, 10)),
                "{}°",
                5,
            ),
        ),
        _by_corner_angle,
        BEAM,
    ),
    Study(
        DOMES,
        "Boundary radii",
        FAIREST,
        (
            Parameter(FACES.name, FACES.sentence, PATCHES[:2]),
            Parameter(
                "Radii from end to end",
                "Or the radius of its circle may be given: where circles are larger, faces of S and M are larger too.",
                (1, 1.5, 2, 3, 4, 6, 8, 12),
                "1 : {:g}",
                4,
            ),
        ),
        _by_boundary_radii,
        BEAM,
    ),
    Study(
        DOMES,
        "Moebius boost",
        FAIREST,
        (
            Parameter("Direction", "Direction of the point of the sphere around which circles contract.", DIRECTIONS),
            Parameter(
                "Speed",
                "A Moebius transformation maps circles to circles; those near the point shrink, the others grow.",
                tuple(k / 10 for k in range(-6, 7)),
                "{:g}",
                9,
            ),
        ),
        _by_moebius,
        BEAM,
    ),
)


# --- signs


@cache
def _pentagons() -> tuple[Mesh, IntArray]:
    """S, and the signs of a saddle."""
    S = koebe(pentagon_patch(6, 6), coverage=0.35).mesh
    return S, saddle_signs(S, [1.0, 1.0, 0.0], pole=SOUTH)


def _by_signs(choice: str, length: float) -> Pair:
    S, signs = _pentagons()
    least = np.where(signs < 0, length, 1.0)
    wanted = signs if choice == "reversed" else np.abs(signs)
    return Pair(edge_offset_mesh(S, signs=wanted, lengths=(least, np.inf)), S)


SIGNS = (
    Study(
        "Signs and lengths",
        "Pentagons",
        "M is the fairest mesh parallel to one S of pentagons, with edges directed by the signs.",
        (
            Parameter(
                "Edges across",
                "Edges more across than along one diagonal are reversed, so that M is a saddle, or kept.",
                ("reversed", "kept"),
            ),
            Parameter(
                "Least length of these",
                "The other edges are at least 1 long; this lengthens M in one direction only.",
                (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.4),
                "{:g}",
                6,
            ),
        ),
        _by_signs,
        BEAM,
        view=(0.5, 0.8),
    ),
)
