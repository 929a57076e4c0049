"""The fit of the beams' ends on the facets of the node blocks, found from the solids alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fabkit.kinds import BeamDetails, NodeDetails
from fabkit.parts import Measures, Parts, SolidArray, Topology
from geometry.arrays import FloatArray, IntArray

__all__ = ["EndFits", "end_fits"]

MAX_FIT_VALUES_IN_MEMORY = 1_000_000
"""Number of values held in memory while beam ends are compared with facets: 8 MB, near to the processor."""

STEEPEST_END_COSINE = 0.1
"""Cosine of the angle between the normal of a face and the bar's axis, up to which the face is a side: no end is cut at
84 degrees from square."""


OVERHANG_ROUNDING_MM = 1e-9
"""Distance in mm up to which an end only exceeds its facet by rounding, and leaves nothing of itself uncovered."""
SAME_PLANE_MM = 1e-3
"""Distance in mm between two facets up to which a beam end counts as near both, and belongs to the one that it exceeds
less. The shortest edge of a solid is as long."""


@dataclass(frozen=True, eq=False)
class EndFits:
    """Ends of beams and the facets they meet: one row for each end whose node exists.

    beams, nodes (K,): positions in the groups given; ends (K,): 0 for end A, 1 for end B.
    plane_gap_mm (K,): largest distance of the end face, moved by the gap that it has by its record, from the plane of
    the facet. overhang_mm (K,): largest distance by which the end face exceeds the facet's outline, negative inside.
    Both are infinite where no facet faces the end. uncovered_percent (K,): how much of the rectangle about the end face
    lies outside the facet.
    """

    beams: IntArray
    ends: IntArray
    nodes: IntArray
    plane_gap_mm: FloatArray
    overhang_mm: FloatArray
    uncovered_percent: FloatArray


def end_fits(beams: Parts[BeamDetails], nodes: Parts[NodeDetails]) -> EndFits:
    """Each end face compared with the best fitting facet of its node's block, of those that face it."""
    at = nodes.find(beams.details.nodes)
    beam, end = np.nonzero(at >= 0)
    node = at[beam, end]
    gaps, overhangs, uncovered = np.empty((3, len(node)))
    node_batches = nodes.placed()
    which, row = np.empty(len(nodes), dtype=np.int64), np.empty(len(nodes), dtype=np.int64)
    for k, blocks in enumerate(node_batches):
        which[blocks.parts], row[blocks.parts] = k, np.arange(len(blocks.parts))
    for bars in beams.placed():
        corners, normals = _end_faces(bars, beams.axes[bars.parts, 0])
        bar = np.full(len(beams), -1)
        bar[bars.parts] = np.arange(len(bars.parts))
        for k, blocks in enumerate(node_batches):
            rows = np.flatnonzero((bar[beam] >= 0) & (which[node] == k))
            for some in _in_batches(rows, blocks.topology):
                own = bar[beam[some]], end[some]
                moves = beams.details.end_gaps_mm[beam[some], end[some], None] * normals[own]
                moved = corners[own] + moves[:, None]
                block = row[node[some]]
                own_blocks = blocks[block]
                gaps[some], overhangs[some], facets = _misfits(moved, normals[own], own_blocks, blocks.normals[block])
                uncovered[some] = _uncovered_percent(moved, normals[own], own_blocks, facets, overhangs[some])
    return EndFits(beam, end, node, gaps, overhangs, uncovered)


def _in_batches(rows: IntArray, topology: Topology) -> list[IntArray]:
    """These rows in batches of at most MAX_FIT_VALUES_IN_MEMORY values, some twenty for each corner of a block."""
    size = max(1, MAX_FIT_VALUES_IN_MEMORY // (20 * max(1, len(topology.corners))))
    return [rows[start : start + size] for start in range(0, len(rows), size)]


def _end_faces(bars: SolidArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corners (P, 2, m, 3), some of them repeated, and outward normals (P, 2, 3) of the faces at end A and end B: those
    whose planes cut the line through the middle along the bar's x axis (P, 3) furthest out."""
    normals, middles = bars.normals, bars.vertices.mean(axis=1, keepdims=True)
    cosines = np.einsum("pfk,pk->pf", normals, along)
    levels = np.einsum("pfk,pfk->pf", normals, bars.vertices[:, bars.topology.face_vertex] - middles)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.where(np.abs(cosines) > STEEPEST_END_COSINE, np.abs(levels / cosines), -np.inf)
    ends = [np.where(sign * cosines > 0, crossings, -np.inf).argmax(axis=1) for sign in (-1.0, 1.0)]
    faces = np.stack(ends, axis=1)
    rows = np.arange(len(faces))[:, None]
    corners = _face_corners(bars.topology)[faces]
    return bars.vertices[rows[..., None], corners], normals[rows, faces]


def _face_corners(topology: Topology) -> IntArray:
    """(F, m) vertices of each face's outer loop, with tips in place of fillets, the last one repeated where a face has
    fewer than m."""
    if len(topology.fillets):
        return _sharp_corners(topology)
    loops, most = topology.first_corner, int(np.diff(topology.loop_starts).max(initial=1))
    corners = np.repeat(topology.face_vertex[:, None], most, axis=1)
    sizes = np.diff(topology.loop_starts)[topology.face_starts[topology.polygonal]]
    within = np.minimum(np.arange(corners.shape[1]), sizes[:, None] - 1)
    corners[topology.polygonal] = topology.corners[loops[:, None] + within]
    return corners


def _sharp_corners(topology: Topology) -> IntArray:
    outlines = [topology.sharp[topology.loops(face)[0]] for face in range(topology.n_faces)]
    outlines = [outline[outline != np.roll(outline, 1)] for outline in outlines]
    most = max(map(len, outlines))
    return np.stack([np.pad(outline, (0, most - len(outline)), mode="edge") for outline in outlines])


def _misfits(
    corners: FloatArray, normals: FloatArray, blocks: SolidArray, outwards: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """(K,) plane_gap_mm, (K,) overhang_mm and (K,) the facet of end faces with corners (K, m, 3) and normals (K, 3),
    each on the block of its own row, whose faces have normals outwards (K, F, 3)."""
    t = blocks.topology
    if not len(t.polygonal):
        return _misfits_on_tubes(corners, normals, blocks)
    x, across, points = (  # ends last, which is fastest
        np.ascontiguousarray(each.transpose(axes))
        for each, axes in ((blocks.vertices, (2, 1, 0)), (outwards, (2, 1, 0)), (corners, (1, 2, 0)))
    )
    here, of = x[:, t.corners], across[:, t.corner_face]
    side = x[:, t.corners[t.next_corner]] - here
    outward = np.stack([side[i - 2] * of[i - 1] - side[i - 1] * of[i - 2] for i in range(3)])
    outward /= np.sqrt((outward * outward).sum(axis=0))
    facing, anchors = across[:, t.polygonal], here[:, t.first_corner]
    gaps = np.max([np.abs((facing * (point[:, None] - anchors)).sum(axis=0)) for point in points], axis=0)
    beyond = np.max([(outward * (point[:, None] - here)).sum(axis=0) for point in points], axis=0)
    overhangs = np.maximum.reduceat(beyond, t.first_corner, axis=0)
    misfit = np.where(gaps > SAME_PLANE_MM, gaps, 0.0) + SAME_PLANE_MM * np.maximum(overhangs, 0.0)
    misfit[np.einsum("jfk,kj->fk", facing, normals) >= 0] = np.inf
    best = misfit.argmin(axis=0), np.arange(len(corners))
    none = np.isinf(misfit[best])
    return np.where(none, np.inf, gaps[best]), np.where(none, np.inf, overhangs[best]), t.polygonal[best[0]]


def _uncovered_percent(
    corners: FloatArray, normals: FloatArray, blocks: SolidArray, facets: IntArray, overhangs: FloatArray
) -> FloatArray:
    """(K,) percentage of the rectangle about each end face, its width times its height, that lies outside its facet,
    both projected along the normal of the end. Ends begin with an edge along their width or height."""
    found = np.zeros(len(corners))
    over = np.flatnonzero((overhangs > OVERHANG_ROUNDING_MM) & np.isfinite(overhangs) & (facets >= 0))
    if not len(over):
        return found
    along = corners[over, 1] - corners[over, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    plane = np.stack([along, np.cross(normals[over], along)], axis=2)
    outlines = blocks.vertices[over[:, None], _face_corners(blocks.topology)[facets[over]]]
    ends, faces = (shapely.polygons((points - corners[over, :1]) @ plane) for points in (corners[over], outlines))
    ends = shapely.envelope(ends)
    areas = shapely.area(ends)
    found[over] = 100 * (areas - shapely.area(shapely.intersection(ends, faces))) / areas
    return found


def _misfits_on_tubes(
    corners: FloatArray, normals: FloatArray, tubes: SolidArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """The same on tubes, -1 for the facet: an end face must lie in a plane that touches the tube, over its line of
    contact, and within its length."""
    measures = Measures(tubes.topology, tubes.vertices)
    from_axis = corners - tubes.vertices[:, None, tubes.topology.rounds[0, 0]]
    axis, radius, length = (
        np.moveaxis(measures.round_axes[:, :, 0], 0, 1),
        measures.radii[:, :1],
        measures.lengths[:, :1],
    )
    gaps = np.abs(np.einsum("kmj,kj->km", from_axis, -normals) - radius).max(axis=1)
    along = np.einsum("kmj,kj->km", from_axis, axis)
    across = np.einsum("kmj,kj->km", from_axis, np.cross(axis, normals))
    past_contact = np.maximum(across.min(axis=1), -across.max(axis=1))
    overhangs = np.maximum(np.maximum(-along, along - length).max(axis=1), past_contact)
    return gaps, overhangs, np.full(len(corners), -1)
