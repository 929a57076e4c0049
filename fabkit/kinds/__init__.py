"""The kinds of part that a structure is made of, one file for each: the record of its parts, its columns in cut lists,
its measures and labels, and its symmetry."""

from fabkit.kinds.beams import BEAM, BeamDetails
from fabkit.kinds.caps import CAP, CapDetails
from fabkit.kinds.columns import LEFT_OUT, NO_NEIGHBOUR, marks_at
from fabkit.kinds.faces import beam_faces, node_faces, panel_faces
from fabkit.kinds.fasteners import BOLT, DOWEL, END_PLATE, BoltDetails, DowelDetails, EndPlateDetails
from fabkit.kinds.fins import FIN, FinDetails
from fabkit.kinds.nodes import NODE, NodeDetails, block_ends, smallest_gaps
from fabkit.kinds.panels import PANEL, PanelDetails, neighbour_names, panel_outlines, panel_sides
from fabkit.kinds.plain import plain_kind
from fabkit.kinds.struts import STRUT, StrutDetails
from fabkit.kinds.supports import BASE_PLATE, STUB, BasePlateDetails, StubDetails

__all__ = [
    "BASE_PLATE",
    "BEAM",
    "BOLT",
    "CAP",
    "DOWEL",
    "END_PLATE",
    "FIN",
    "LEFT_OUT",
    "NODE",
    "NO_NEIGHBOUR",
    "PANEL",
    "STRUT",
    "STUB",
    "BasePlateDetails",
    "BeamDetails",
    "BoltDetails",
    "CapDetails",
    "DowelDetails",
    "EndPlateDetails",
    "FinDetails",
    "NodeDetails",
    "PanelDetails",
    "StrutDetails",
    "StubDetails",
    "beam_faces",
    "block_ends",
    "marks_at",
    "neighbour_names",
    "node_faces",
    "panel_faces",
    "panel_outlines",
    "panel_sides",
    "plain_kind",
    "smallest_gaps",
]
