"""The choices of `fabkit design`; the values are the words to type."""

from __future__ import annotations

from enum import StrEnum

__all__ = ["Bend", "Faces", "MinimalShape", "Tiles"]


class Tiles(StrEnum):
    """Shape of the faces of a patch."""

    QUADS = "quads"
    HEXAGONS = "hexagons"
    PENTAGONS = "pentagons"


class Bend(StrEnum):
    """Form of a mesh that is parallel to a Koebe polyhedron."""

    DOME = "dome"
    SADDLE = "saddle"
    SPHERE = "sphere"


class MinimalShape(StrEnum):
    """Minimal surfaces whose meshes have formulas, at least in part."""

    CATENOID = "catenoid"
    ENNEPER = "enneper"


class Faces(StrEnum):
    """Shape of the faces of a mesh around an axis."""

    QUADS = "quads"
    HEXAGONS = "hexagons"
