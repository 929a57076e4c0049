"""Nouns of the workshop, frozen, without decisions: solids, frames, parts, assemblies. Millimetres and degrees."""

from fabkit.parts.assembly import Assembly, LeftOut
from fabkit.parts.frame import Frame
from fabkit.parts.material import Material
from fabkit.parts.part import Beam, Node, Panel, Part
from fabkit.parts.section import Section
from fabkit.parts.solid import (
    Solid,
    Topology,
    centroids,
    face_normals,
    prism_topology,
    prism_vertices,
    volumes,
)

__all__ = [
    "Assembly",
    "Beam",
    "Frame",
    "LeftOut",
    "Material",
    "Node",
    "Panel",
    "Part",
    "Section",
    "Solid",
    "Topology",
    "centroids",
    "face_normals",
    "prism_topology",
    "prism_vertices",
    "volumes",
]
