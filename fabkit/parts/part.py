"""Beams, nodes and panels: what a workshop makes. Records without decisions; lengths in mm, angles in degrees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from fabkit.parts.frame import Frame
from fabkit.parts.material import Material
from fabkit.parts.section import Section
from fabkit.parts.solid import Solid
from geometry.arrays import FloatArray

__all__ = ["Beam", "Node", "Panel", "Part"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """A solid in its own frame, and where it stands.

    mark: the name that equal parts share; ASCII. element: index of the mesh edge, vertex or face it stands for.
    """

    kind: ClassVar[str]

    mark: str
    solid: Solid
    placement: Frame
    material: Material
    element: int

    @property
    def mass_kg(self) -> float:
        return self.material.mass_kg(self.solid.volume_mm3)


@dataclass(frozen=True, eq=False, kw_only=True)
class Beam(Part):
    """A straight bar of constant section along a mesh edge.

    Own frame: origin in the outer middle of end A, at its cut; x from end A to end B, z outwards in the central
    plane. nodes: mesh vertices at ends A and B. cut_angles_deg: angle between each end's cut and a square cut,
    positive where the outer side is the longer one. long_point_mm and short_point_mm: longest and shortest extent
    along the axis. dihedral_deg: angle through which the outside turns over the edge, positive where convex, NaN
    at the boundary. height_deviation_mm: how much more (or less) than the section's height the two parallel meshes
    are apart at this edge. twist_deg: angle between the central plane at its two ends.
    """

    kind = "beam"

    nodes: tuple[int, int]
    section: Section
    cut_angles_deg: tuple[float, float]
    long_point_mm: float
    short_point_mm: float
    dihedral_deg: float
    height_deviation_mm: float
    twist_deg: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Node(Part):
    """A prism along a node axis, with a facet for each beam.

    Own frame: origin at the mesh vertex, z along the node axis outwards, x towards the first beam. The tuples run
    over the beams counter-clockwise seen from outside. beams: mesh edges. azimuths_deg: directions of the beams
    about the axis, the first one zero. inclinations_deg: angles of the beams' axes above the plane perpendicular
    to the node axis. setbacks_mm: distances of the facets from the axis. height_mm: from bottom to top.
    top_spread_mm: how far the outer edges of the beams' ends are from level with each other. axis_spread_mm: the same
    of the points in which the lines along the middles of the beams' outer sides, or of their inner sides, meet the
    axis: zero in edge offset meshes, also where some beams fall from the node and others rise, so that ends differ.
    """

    kind = "node"

    beams: tuple[int, ...]
    azimuths_deg: tuple[float, ...]
    inclinations_deg: tuple[float, ...]
    setbacks_mm: tuple[float, ...]
    height_mm: float
    top_spread_mm: float
    axis_spread_mm: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Panel(Part):
    """A planar plate with square edges over a mesh face.

    Own frame: outer side up (the plate lies between z = 0 and z = thickness), origin at the start of the longest
    edge of the outline, x along it. outline (k, 2), counter-clockwise. The tuples run over the edges of the
    outline, edge n from corner n to corner n+1: beams, the mesh edges; neighbours, the faces across, -1 where
    none; dihedrals_deg, as for beams. corner_angles_deg: inner angle at each corner. lift_mm: height of the lower
    side above the mesh face.
    """

    kind = "panel"

    outline: FloatArray
    thickness_mm: float
    lift_mm: float
    area_mm2: float
    edge_lengths_mm: tuple[float, ...]
    corner_angles_deg: tuple[float, ...]
    dihedrals_deg: tuple[float, ...]
    beams: tuple[int, ...]
    neighbours: tuple[int, ...]
