"""Nouns of the workshop, frozen, without decisions: solids, frames, kinds of part, parts, assemblies. Millimetres and
degrees."""

from fabkit.parts.assembly import LEFT_OUT_COLOUR, Assembly, LeftOut, Surroundings
from fabkit.parts.build_up import BuildUp, Pane, plate_of_glass
from fabkit.parts.columns import Cell, Column, texts
from fabkit.parts.curves import Curves
from fabkit.parts.finish import CoatedSide, EdgeWork, Finish
from fabkit.parts.frame import Frame
from fabkit.parts.kind import Details, Kind, Measure, in_layer
from fabkit.parts.material import Material
from fabkit.parts.parts import Part, Parts
from fabkit.parts.plates import blanks
from fabkit.parts.ragged import Ragged
from fabkit.parts.section import Section
from fabkit.parts.shapes import (
    BORE,
    SHAFT,
    Measures,
    Solid,
    SolidArray,
    Topology,
    bore_vertices,
    prism_topology,
    prism_vertices,
    profile_topology,
    profile_vertices,
    round_vertices,
    shaft_topology,
)
from fabkit.parts.solids import Solids
from fabkit.parts.symmetry import Symmetry, Turns, moved, other_end, shifted
from fabkit.parts.zones import Zones

__all__ = [
    "BORE",
    "LEFT_OUT_COLOUR",
    "SHAFT",
    "Assembly",
    "BuildUp",
    "Cell",
    "CoatedSide",
    "Column",
    "Curves",
    "Details",
    "EdgeWork",
    "Finish",
    "Frame",
    "Kind",
    "LeftOut",
    "Material",
    "Measure",
    "Measures",
    "Pane",
    "Part",
    "Parts",
    "Ragged",
    "Section",
    "Solid",
    "SolidArray",
    "Solids",
    "Surroundings",
    "Symmetry",
    "Topology",
    "Turns",
    "Zones",
    "blanks",
    "bore_vertices",
    "in_layer",
    "moved",
    "other_end",
    "plate_of_glass",
    "prism_topology",
    "prism_vertices",
    "profile_topology",
    "profile_vertices",
    "round_vertices",
    "shaft_topology",
    "shifted",
    "texts",
]
