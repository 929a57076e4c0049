"""Bores in solids that are made already."""

from fabkit.drilling.bores import BLIND, Bores, bored_along_axis, drilled
from fabkit.drilling.dots import DOT_INSET_MM, drilled_dots, stamped

__all__ = ["BLIND", "DOT_INSET_MM", "Bores", "bored_along_axis", "drilled", "drilled_dots", "stamped"]
