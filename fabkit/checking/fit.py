"""The fit of the beams' ends on the facets of the node blocks, found from the solids alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.kinds import BeamDetails, NodeDetails
from fabkit.parts import Parts, SolidArray, Topology
from geometry.arrays import FloatArray, IntArray

__all__ = ["EndFits", "end_fits"]

MAX_FIT_VALUES_IN_MEMORY = 4_000_000
"""Number of values held in memory while beam ends are compared with facets: 32 MB."""


@dataclass(frozen=True, eq=False)
class EndFits:
    """Ends of beams and the facets they meet: one row for each end whose node exists.

    beams, nodes (K,): positions in the groups given; ends (K,): 0 for end A, 1 for end B.
    plane_gap_mm (K,): largest distance of the end face, moved by the gap that it has by its record, from the plane of
    the facet. overhang_mm (K,): largest distance by which the end face exceeds the facet's outline, negative inside.
    Both are infinite where no facet faces the end.
    """

    beams: IntArray
    ends: IntArray
    nodes: IntArray
    plane_gap_mm: FloatArray
    overhang_mm: FloatArray


def end_fits(beams: Parts[BeamDetails], nodes: Parts[NodeDetails]) -> EndFits:
    """Each end face compared with the best fitting facet of its node's block, of those that face it."""
    at = nodes.find(beams.details.nodes)
    beam, end = np.nonzero(at >= 0)
    node = at[beam, end]
    gaps, overhangs = np.empty(len(node)), np.empty(len(node))
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
                gaps[some], overhangs[some] = _misfits(moved, normals[own], blocks[row[node[some]]])
    return EndFits(beam, end, node, gaps, overhangs)


def _in_batches(rows: IntArray, topology: Topology) -> list[IntArray]:
    """These rows in batches of at most MAX_FIT_VALUES_IN_MEMORY values, some twenty for each corner of a block."""
    size = max(1, MAX_FIT_VALUES_IN_MEMORY // (20 * len(topology.corners)))
    return [rows[start : start + size] for start in range(0, len(rows), size)]


def _end_faces(bars: SolidArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corners (P, 2, m, 3), some of them repeated, and outward normals (P, 2, 3) of the faces at end A and end B: those
    whose normals point most against, and most along, the bars' x-axes (P, 3)."""
    normals = bars.normals
    cosines = np.einsum("pfk,pk->pf", normals, along)
    faces = np.stack([cosines.argmin(axis=1), cosines.argmax(axis=1)], axis=1)
    rows = np.arange(len(faces))[:, None]
    corners = _face_corners(bars.topology)[faces]
    return bars.vertices[rows[..., None], corners], normals[rows, faces]


def _face_corners(topology: Topology) -> IntArray:
    """(F, m) vertices of each face's outer loop, the last one repeated where a face has fewer than m."""
    loops = topology.first_corner
    sizes = np.diff(topology.loop_starts)[topology.face_starts[:-1]]
    corners: IntArray = topology.corners[loops[:, None] + np.minimum(np.arange(sizes.max()), sizes[:, None] - 1)]
    return corners


def _misfits(corners: FloatArray, normals: FloatArray, blocks: SolidArray) -> tuple[FloatArray, FloatArray]:
    """(K,) plane_gap_mm and (K,) overhang_mm of end faces with corners (K, m, 3) and normals (K, 3), each on the block
    of its own row."""
    t = blocks.topology
    starts, facing = t.first_corner, blocks.normals
    here, following = blocks.vertices[:, t.corners], blocks.vertices[:, t.corners[t.next_corner]]
    gaps = np.abs(_levels(facing, here[:, starts], corners)).max(axis=-1)
    outward = np.cross(following - here, facing[:, t.corner_face])
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    overhangs = np.maximum.reduceat(_levels(outward, here, corners).max(axis=-1), starts, axis=1)
    misfit = np.maximum(gaps, overhangs)
    misfit[np.einsum("kfj,kj->kf", facing, normals) >= 0] = np.inf
    rows, best = np.arange(len(misfit)), misfit.argmin(axis=1)
    none = np.isinf(misfit[rows, best])
    return np.where(none, np.inf, gaps[rows, best]), np.where(none, np.inf, overhangs[rows, best])


def _levels(normals: FloatArray, anchors: FloatArray, points: FloatArray) -> FloatArray:
    """(K, n, m) heights of points (K, m, 3) above planes through anchors (K, n, 3) with unit normals (K, n, 3)."""
    heights: FloatArray = normals @ points.transpose(0, 2, 1)
    heights -= np.einsum("knj,knj->kn", normals, anchors)[..., None]
    return heights
