"""The height at which panels clear the node blocks under them. They then clear the beams too: a beam has a constant
height above the face along its length, and the blocks at its ends enclose its end faces."""

from __future__ import annotations

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh.ragged_arrays import row_of_entry

__all__ = ["heights_under_panels"]


def heights_under_panels(structure: SupportStructure, ends: Ends, made: BoolArray, nodes: NodeShapes) -> FloatArray:
    """(C,) height in mm of the node block above the face at each corner of the face, within the cell of the face; 0
    without a block. made (E,): whether the beam of each edge is made.

    The top of the block within the cell is a polygon with these corners: the point on the axis, corners of the section,
    and the middles of the facets of the two beams that bound the cell. For a beam that is not made, a point outside the
    block is taken instead.
    """
    c = structure.mesh.combinatorics
    node, normals = c.corners, structure.mesh.face_normals[c.corner_face]
    has_block = np.isfinite(nodes.top)[node]
    axis, top = structure.axes[node], np.where(has_block, nodes.top[node], 0.0)
    x = np.zeros((structure.mesh.n_vertices, 3))
    first = ends.ring[ends.ring_starts[:-1][np.diff(ends.ring_starts) > 0]]
    x[ends.vertex[first]] = ends.radial[first]
    y = np.cross(structure.axes, x)

    end_ahead = 2 * c.corner_edge + np.where(c.runs_along_edge, 0, 1)
    before = c.previous_corner
    end_back = 2 * c.corner_edge[before] + np.where(c.runs_along_edge[before], 1, 0)
    level = top * np.einsum("ck,ck->c", axis, normals)
    reach = np.zeros(structure.mesh.n_vertices)
    np.maximum.at(reach, _corner_nodes(nodes), np.linalg.norm(nodes.corners, axis=1))
    highest = level.copy()
    for end in (end_ahead, end_back):
        radius = np.where(made[end // 2], ends.setback[end], reach[node])
        highest = np.maximum(highest, level + radius * np.einsum("ck,ck->c", ends.radial[end], normals))

    corner, section = _pairs(node, nodes)
    angle = np.arctan2(nodes.corners[section, 1], nodes.corners[section, 0])
    start, stop = ends.azimuth[end_ahead][corner], ends.azimuth[end_back][corner]
    inside = np.mod(angle - start, 2 * np.pi) <= np.mod(stop - start, 2 * np.pi)
    flat = nodes.corners[section, :1] * x[node[corner]] + nodes.corners[section, 1:] * y[node[corner]]
    heights = level[corner] + np.einsum("pk,pk->p", flat, normals[corner])
    np.maximum.at(highest, corner[inside], heights[inside])
    return np.where(has_block, highest, 0.0)


def _corner_nodes(nodes: NodeShapes) -> IntArray:
    """(K,) node of each corner of the sections."""
    return row_of_entry(nodes.corner_starts)


def _pairs(node: IntArray, nodes: NodeShapes) -> tuple[IntArray, IntArray]:
    """All pairs of a corner of a face and a corner of the section of its node, as two arrays of numbers."""
    counts = np.diff(nodes.corner_starts)[node]
    corner = np.repeat(np.arange(len(node)), counts)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return corner, nodes.corner_starts[node][corner] + within
