"""The choices that a design offers, by the words in which they are typed."""

from __future__ import annotations

from enum import StrEnum

__all__ = ["Bend", "Faces", "MinimalShape", "Tiles"]


class Tiles(StrEnum):
    """Faces of a patch."""

    QUADS = "quads"
    HEXAGONS = "hexagons"
    PENTAGONS = "pentagons"


class Bend(StrEnum):
    """How a mesh bends that is parallel to a Koebe polyhedron."""

    DOME = "dome"
    SADDLE = "saddle"
    SPHERE = "sphere"


class MinimalShape(StrEnum):
    """Minimal surfaces that have meshes in closed form, or nearly so."""

    CATENOID = "catenoid"
    ENNEPER = "enneper"


class Faces(StrEnum):
    """Faces around an axis."""

    QUADS = "quads"
    HEXAGONS = "hexagons"
