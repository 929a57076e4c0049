"""The kinds of part that a structure is made of, a file a kind: what is known of its parts, how it is listed, measured
and labelled, and from where else a part may be seen."""

from fabkit.kinds.beams import BEAM, BeamDetails
from fabkit.kinds.columns import LEFT_OUT, NO_NEIGHBOUR, marks_at
from fabkit.kinds.nodes import NODE, NodeDetails
from fabkit.kinds.panels import PANEL, PanelDetails, panel_outlines
from fabkit.kinds.plain import plain_kind

__all__ = [
    "BEAM",
    "LEFT_OUT",
    "NODE",
    "NO_NEIGHBOUR",
    "PANEL",
    "BeamDetails",
    "NodeDetails",
    "PanelDetails",
    "marks_at",
    "panel_outlines",
    "plain_kind",
]
