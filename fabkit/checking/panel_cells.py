"""Whether each panel lies inside its cell: between the support planes of its face, through its whole thickness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fabkit.checking.placed_parts import FIT_MM
from fabkit.parts import Panel
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["panels_outside_cells"]


def panels_outside_cells(structure: SupportStructure, panels: Sequence[Panel]) -> IntArray:
    """Indices of the panels that leave their cells by more than FIT_MM.

    At each level the cell is the polygon in which the node axes at the corners of the face meet the plane of the panel.
    """
    outside = np.zeros(len(panels), dtype=bool)
    if not panels:
        return np.flatnonzero(outside)
    outlines = shapely.polygons([shapely.linearrings(panel.outline) for panel in panels])
    for above in (False, True):
        cells = [_cell(structure, panel, panel.thickness_mm if above else 0.0) for panel in panels]
        polygons = shapely.polygons([shapely.linearrings(cell) for cell in cells])
        outside |= ~shapely.covers(shapely.buffer(polygons, FIT_MM, join_style="mitre"), outlines)
    return np.flatnonzero(outside)


def _cell(structure: SupportStructure, panel: Panel, level: float) -> FloatArray:
    """(k, 2) in the frame of the panel, `level` mm above its lower side."""
    vertices = structure.mesh.combinatorics.face(panel.element)
    points = panel.placement.to_local(structure.mesh.vertices[vertices])
    axes = structure.axes[vertices] @ panel.placement.axes.T
    rise = (level - points[:, 2]) / axes[:, 2]
    cell: FloatArray = points[:, :2] + rise[:, None] * axes[:, :2]
    return cell
