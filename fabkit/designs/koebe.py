"""Edge offset meshes from a Koebe polyhedron of any combinatorics [Pottmann2007, 3.2, Fig. 11]."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.designs.pair import EdgeOffsetDesign
from fabkit.errors import ProjectError
from geometry.edge_offset.design import edge_offset_mesh, saddle_signs
from geometry.edge_offset.koebe import koebe
from geometry.edge_offset.patterns import dual, hexagon_patch, pentagon_patch, quad_patch
from geometry.errors import GeometryError
from geometry.mesh import Combinatorics, Mesh, read_mesh

__all__ = ["Bend", "Tiles", "koebe_design"]

SOUTH = (0.0, 0.0, -1.0)
"""Opposite the middle of an open polyhedron: directions on it are those of the plane seen from there."""


class Tiles(StrEnum):
    QUADS = "quads"
    HEXAGONS = "hexagons"
    PENTAGONS = "pentagons"

    def patch(self, count: int) -> Combinatorics:
        """About as long as wide."""
        if self is Tiles.QUADS:
            return quad_patch(count, count)
        if self is Tiles.PENTAGONS:
            return pentagon_patch(count, count)
        return hexagon_patch(count, round(count * 2 / 3**0.5))


class Bend(StrEnum):
    DOME = "dome"
    SADDLE = "saddle"
    SPHERE = "sphere"


def koebe_design(
    *,
    tiles: Tiles = Tiles.QUADS,
    count: int = 12,
    combinatorics: Path | None = None,
    take_dual: bool = False,
    coverage: float | None = None,
    bend: Bend = Bend.DOME,
    direction_deg: float = 45.0,
) -> EdgeOffsetDesign:
    """The fairest mesh parallel to a Koebe polyhedron S, with no edge shorter than 1.

    tiles: faces of a patch of `count` by about as many; combinatorics: instead of these, the file of a mesh of which
    only the faces count, open or closed; take_dual: or rather those of its dual. coverage: how much of the sphere an
    open S covers, 0.4 if left out; more bends M more. bend: a dome keeps the orientation of all edges of S; a saddle
    reverses those across a direction, an angle from the x axis; a sphere is S itself.

    Raises GeometryError where no polyhedron has these combinatorics, where no mesh has these orientations, naming
    edges, and for numbers out of range.
    """
    told: dict[str, Any] = {"tiles": str(tiles), "count": count}
    if combinatorics is not None:
        told = {"combinatorics": combinatorics.name}
    faces = tiles.patch(count) if combinatorics is None else read_mesh(combinatorics).mesh.combinatorics
    if take_dual:
        faces = dual(faces)
    is_open = bool(faces.is_boundary_edge.any())
    share = (0.4 if coverage is None else coverage) if is_open else coverage
    image = koebe(faces, coverage=share).mesh
    told |= {"dual": take_dual, "coverage": share, "bend": str(bend), "direction_deg": direction_deg}
    return EdgeOffsetDesign.of("koebe", _bent(image, bend, direction_deg, is_open), image, told)


def _bent(image: Mesh, bend: Bend, direction_deg: float, is_open: bool) -> Mesh:
    if bend is Bend.SPHERE:
        return image
    if bend is Bend.DOME:
        return edge_offset_mesh(image, signs=1, lengths=(1.0, np.inf))
    if not is_open:
        raise ProjectError(
            "a closed polyhedron has no saddle parallel to it: take a mesh with boundary, or another bend"
        )
    angle = np.radians(direction_deg)
    signs = saddle_signs(image, [np.cos(angle), np.sin(angle), 0.0], pole=SOUTH)
    try:
        return edge_offset_mesh(image, signs=signs, lengths=(1.0, np.inf))
    except GeometryError as error:
        raise ProjectError(
            f"no saddle reverses the edges across the direction of {direction_deg:g} degrees ({error.message}): take "
            "another --direction, or quads"
        ) from error
