"""Checks of placed parts, from their solids alone: fit, clashes, panels within their cells."""

from fabkit.checking.clash import clashes, clashing_pairs
from fabkit.checking.panel_bounds import panels_crossing_support_planes
from fabkit.checking.placed_parts import FIT_MM, Violation, check_fit, violations, violations_sentence

__all__ = [
    "FIT_MM",
    "Violation",
    "check_fit",
    "clashes",
    "clashing_pairs",
    "panels_crossing_support_planes",
    "violations",
    "violations_sentence",
]
