"""The height at which panels clear the beams and the node blocks under them.

A beam has a constant height above the face along its length. Blocks that enclose the ends of their beams stand at least
as high as these; trimmed blocks are lowered until they stand no higher than given levels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes
from fabkit.detailing.shapes.bar_sections import BarSections
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh.ragged_arrays import row_of_entry

__all__ = ["heights_of_beams", "heights_of_blocks", "trimmed"]


def heights_of_beams(structure: SupportStructure, made: BoolArray, bars: BarSections) -> FloatArray:
    """(C,) height in mm above each face of the half of the beam at its side, of the edge that begins at each of its
    corners; 0 where the beam is not made. made (E,): whether the beam of each edge is made."""
    c = structure.mesh.combinatorics
    edge, normals = c.corner_edge, structure.mesh.face_normals[c.corner_face]
    inwards = structure.width_directions[edge] * np.where(c.runs_along_edge, -1.0, 1.0)[:, None]
    rise = np.einsum("ck,ck->c", inwards, normals)
    upright = np.einsum("ck,ck->c", structure.height_directions[edge], normals)
    outer, half = bars.levels[edge, 1], bars.widths[edge] / 2
    of_round = np.where(rise > 0, (outer - half) * upright + half, outer * upright)
    heights = np.where(bars.are_round[edge], of_round, outer * upright + half * np.maximum(rise, 0.0))
    return np.where(made[edge], heights, 0.0)


def heights_of_blocks(structure: SupportStructure, ends: Ends, made: BoolArray, nodes: NodeShapes) -> FloatArray:
    """(C,) height in mm of the node block above the face at each corner of the face, within the cell of the face; 0
    without a block. made (E,): whether the beam of each edge is made."""
    node = structure.mesh.combinatorics.corners
    top = np.where(np.isfinite(nodes.top)[node], nodes.top[node], 0.0)
    heights = top * _upright(structure) + _rises_of_blocks(structure, ends, made, nodes)
    return np.where(np.isfinite(nodes.top)[node], heights, 0.0)


def trimmed(
    structure: SupportStructure, ends: Ends, made: BoolArray, nodes: NodeShapes, panels: BoolArray, levels: FloatArray
) -> NodeShapes:
    """The blocks lowered until none stands higher above a face with a panel than `levels` (F,), in mm. made (E,),
    panels (F,): whether the beam of each edge and the panel of each face is made."""
    c = structure.mesh.combinatorics
    limits = (levels[c.corner_face] - _rises_of_blocks(structure, ends, made, nodes)) / _upright(structure)
    top = nodes.top.copy()
    below = panels[c.corner_face] & np.isfinite(top[c.corners])
    np.minimum.at(top, c.corners[below], limits[below])
    return replace(nodes, top=top)


def _upright(structure: SupportStructure) -> FloatArray:
    """(C,) cosine of the angle between node axis and normal of the face at each corner."""
    c = structure.mesh.combinatorics
    return np.asarray(np.einsum("ck,ck->c", structure.axes[c.corners], structure.mesh.face_normals[c.corner_face]))


def _rises_of_blocks(structure: SupportStructure, ends: Ends, made: BoolArray, nodes: NodeShapes) -> FloatArray:
    """(C,) largest height of the top of the block at each corner of a face above a plane parallel to the face, through
    the point in which the axis meets the top.

    The top of the block within the cell of the face is a polygon with these corners: the point on the axis, corners of
    the section, and the middles of the facets of the two beams that bound the cell. For a beam that is not made, a
    point outside the block is taken instead.
    """
    c = structure.mesh.combinatorics
    node, normals = c.corners, structure.mesh.face_normals[c.corner_face]
    axis, slope, upright = structure.axes[node], nodes.slope[node], _upright(structure)
    x = np.zeros((structure.mesh.n_vertices, 3))
    first = ends.ring[ends.ring_starts[:-1][np.diff(ends.ring_starts) > 0]]
    x[ends.vertex[first]] = ends.radial[first]
    x = x[node]
    y = np.cross(axis, x)
    rise_x, rise_y = (np.einsum("ck,ck->c", d, normals) + slope[:, k] * upright for k, d in enumerate((x, y)))

    end_ahead = 2 * c.corner_edge + np.where(c.runs_along_edge, 0, 1)
    before = c.previous_corner
    end_back = 2 * c.corner_edge[before] + np.where(c.runs_along_edge[before], 1, 0)
    reach = np.zeros(structure.mesh.n_vertices)
    np.maximum.at(reach, _corner_nodes(nodes), np.linalg.norm(nodes.corners, axis=1))
    highest = np.zeros(len(node))
    for end in (end_ahead, end_back):
        radius = np.where(made[end // 2], ends.setback[end], reach[node])
        azimuth = ends.azimuth[end]
        highest = np.maximum(highest, radius * (np.cos(azimuth) * rise_x + np.sin(azimuth) * rise_y))

    corner, section = _pairs(node, nodes)
    angle = np.arctan2(nodes.corners[section, 1], nodes.corners[section, 0])
    start, stop = ends.azimuth[end_ahead][corner], ends.azimuth[end_back][corner]
    inside = np.mod(angle - start, 2 * np.pi) <= np.mod(stop - start, 2 * np.pi)
    heights = nodes.corners[section, 0] * rise_x[corner] + nodes.corners[section, 1] * rise_y[corner]
    np.maximum.at(highest, corner[inside], heights[inside])
    return highest


def _corner_nodes(nodes: NodeShapes) -> IntArray:
    """(K,) node of each corner of the sections."""
    return row_of_entry(nodes.corner_starts)


def _pairs(node: IntArray, nodes: NodeShapes) -> tuple[IntArray, IntArray]:
    """All pairs of a corner of a face and a corner of the section of its node, as two arrays of numbers."""
    counts = np.diff(nodes.corner_starts)[node]
    corner = np.repeat(np.arange(len(node)), counts)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return corner, nodes.corner_starts[node][corner] + within
