"""Panels must lie within their cells: between the support planes of their faces, over the whole thickness."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from fabkit.checking.placed_parts import FIT_MM
from fabkit.kinds import PanelDetails, panel_sides
from fabkit.parts import Parts
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["panels_crossing_support_planes"]


def panels_crossing_support_planes(structure: SupportStructure, panels: Parts[PanelDetails]) -> IntArray:
    """Positions of the panels that extend beyond their cells by more than FIT_MM.

    At each level the cell is the polygon in which the node axes at the corners of the face meet the plane of the panel.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.checking import panels_crossing_support_planes
    >>> panels_crossing_support_planes(built.structure, built.assembly["panels"]).tolist()
    []
    """
    outside = np.zeros(len(panels), dtype=bool)
    if not len(panels):
        return np.flatnonzero(outside)
    sides = panel_sides(panels)
    corners, panel = structure.mesh.combinatorics.corners_of(panels.elements)
    vertices = structure.mesh.combinatorics.corners[corners]
    to_own = panels.axes[panel]
    points = np.einsum("ckj,cj->ck", to_own, structure.mesh.vertices[vertices] - panels.origins[panel])
    axes = np.einsum("ckj,cj->ck", to_own, structure.axes[vertices])
    for side, level in zip(sides, (np.zeros(len(panels)), panels.details.thickness_mm), strict=True):
        rise = (level[panel] - points[:, 2]) / axes[:, 2]
        cells = shapely.buffer(_polygons((points + rise[:, None] * axes)[:, :2], panel), FIT_MM, join_style="mitre")
        outside |= ~shapely.covers(cells, _polygons(side.values, side.row))
    return np.flatnonzero(outside)


def _polygons(points: FloatArray, polygon: IntArray) -> npt.NDArray[np.object_]:
    """Polygons with corners (c, 2); polygon (c,): the number of the polygon to which each corner belongs."""
    found: npt.NDArray[np.object_] = shapely.polygons(shapely.linearrings(points, indices=polygon))
    return found
