"""The kinds of part that a structure is made of, one file for each: the record of its parts, its columns in cut lists,
its measures and labels, and its symmetry."""

from fabkit.kinds.beams import BEAM, BeamDetails
from fabkit.kinds.caps import CAP, CapDetails
from fabkit.kinds.columns import LEFT_OUT, NO_NEIGHBOUR, marks_at
from fabkit.kinds.fasteners import BOLT, DOWEL, END_PLATE, BoltDetails, DowelDetails, EndPlateDetails
from fabkit.kinds.nodes import NODE, NodeDetails, smallest_gaps
from fabkit.kinds.panels import PANEL, PanelDetails, neighbour_names, panel_outlines, panel_sides
from fabkit.kinds.plain import plain_kind

__all__ = [
    "BEAM",
    "BOLT",
    "CAP",
    "DOWEL",
    "END_PLATE",
    "LEFT_OUT",
    "NODE",
    "NO_NEIGHBOUR",
    "PANEL",
    "BeamDetails",
    "BoltDetails",
    "CapDetails",
    "DowelDetails",
    "EndPlateDetails",
    "NodeDetails",
    "PanelDetails",
    "marks_at",
    "neighbour_names",
    "panel_outlines",
    "panel_sides",
    "plain_kind",
    "smallest_gaps",
]
