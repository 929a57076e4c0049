"""What must hold of placed parts, seen from their solids only: fit, clashes, panels in their cells."""

from fabkit.checking.clash import clashes, clashing_pairs
from fabkit.checking.panel_cells import panels_outside_cells
from fabkit.checking.placed_parts import FIT_MM, Violation, check_fit, in_one_sentence, violations

__all__ = [
    "FIT_MM",
    "Violation",
    "check_fit",
    "clashes",
    "clashing_pairs",
    "in_one_sentence",
    "panels_outside_cells",
    "violations",
]
