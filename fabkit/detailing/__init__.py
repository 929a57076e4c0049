"""Detailing: from a support structure to an assembly by the rules of the shop, with a check that all parts fit."""

from fabkit.detailing.assembling import Detailed, detail
from fabkit.detailing.ends import Ends, beam_ends
from fabkit.detailing.nodes import axis_misalignments

__all__ = ["Detailed", "Ends", "axis_misalignments", "beam_ends", "detail"]
