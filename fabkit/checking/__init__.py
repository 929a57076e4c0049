"""What must hold of placed parts, seen from their solids only: fit, clashes, panels in their cells."""

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
