"""How high the panels must lie to clear the nodes under them, and so the beams: a block encloses the ends of its beams,
and a beam has one height above the face along its whole length, so it stands no higher than the blocks at its ends."""

from __future__ import annotations

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh.ragged_arrays import row_of_entry

__all__ = ["heights_under_panels"]


def heights_under_panels(structure: SupportStructure, ends: Ends, made: BoolArray, nodes: NodeShapes) -> FloatArray:
    """(C,) how far in mm the node block at each corner of a face stands above the face within its cell; 0 without one.

    That part of the block's top is a polygon with the axis as a corner; its others are corners of the section, and the
    points where the two sides of the sector leave the block: the middles of the facets there, where the beams are
    made (E,). Where a beam is not made, a point outside the block stands for it.
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
    """Each corner of a face with each corner of the section of its node."""
    counts = np.diff(nodes.corner_starts)[node]
    corner = np.repeat(np.arange(len(node)), counts)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return corner, nodes.corner_starts[node][corner] + within
