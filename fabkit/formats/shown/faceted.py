"""Solids with their rounds and fillets cut into flat strips, for formats that know planar faces only."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fabkit.parts import SHAFT, Measures, SolidArray, Topology
from geometry.arrays import FloatArray, IntArray

__all__ = ["CHORD_ERROR_MM", "faceted"]

CHORD_ERROR_MM = 0.5
"""Largest distance in mm of a strip from the round or fillet that it stands for: not to be seen in a structure, and 12
to 40 strips for what is 20 to 300 mm thick."""
LEAST_STRIPS = 12
"""Minimum number of strips of a round, so that small ones look round too; a fillet has a quarter of them."""


def faceted(batch: SolidArray) -> tuple[SolidArray, FloatArray]:
    """The solids, with corners on the circles and ellipses in place of rounds and fillets; (P, C, 3) unit normals at
    all corners, those of the cylinders where the face is a strip. Solids without either stay as they are."""
    t = batch.topology
    if not len(t.rounds) + len(t.fillets):
        return batch, batch.normals[:, t.corner_face]
    of = Measures(t, batch.vertices)
    strips, quarters = _strips(of.radii), _strips(of.fillets.radii) // 4
    points, radial = [batch.vertices], [np.zeros_like(batch.vertices)]
    for k, n in enumerate(strips.tolist()):
        angles = 2 * np.pi * np.arange(n) / n
        axis, across, half_axes = of.round_axes[:, :, k].T, of.round_across[:, :, k].T, of.rims[:, :, :, k]
        minor = np.cross(axis, across)
        outwards = across[:, None] * np.cos(angles)[:, None] + minor[:, None] * np.sin(angles)[:, None]
        for end in (0, 1):
            major = half_axes[end].T[:, None] * np.cos(angles)[:, None]
            other = (of.radii[:, k, None] * minor)[:, None] * np.sin(angles)[:, None]
            points.append(batch.vertices[:, t.rounds[k, 2 * end], None] + major + other)
            radial.append(t.rounds[k, 6] * outwards)
    for k, n in enumerate(quarters.tolist()):
        for end in (0, 1):
            arc = _arc(batch, of, k, end, n)
            points.append(arc[:, 1:-1])
            outwards = arc - (of.middles + of.fillets.centres[end, :, :, k].T)[:, None]
            axis = of.fillets.axes[:, :, k].T[:, None]
            outwards = outwards - (outwards * axis).sum(axis=2, keepdims=True) * axis
            outwards *= t.fillets[k, 3] / np.linalg.norm(outwards, axis=2, keepdims=True)
            radial.append(outwards[:, 1:-1])
            ends = t.fillet_corners[k, [0, 1] if end == 0 else [3, 2]]
            radial[0][:, ends] = outwards[:, [0, -1]]
    topology = _flat_topology(t, tuple(strips.tolist()), tuple(quarters.tolist()))
    flat = SolidArray(topology, batch.parts, np.concatenate(points, axis=1))
    is_strip = topology.corner_face >= t.n_faces - len(t.fillets)
    normals = np.concatenate(radial, axis=1)[:, topology.corners]
    planes = np.setdiff1d(np.arange(t.n_faces), t.fillets[:, 0])
    normals[:, ~is_strip] = batch.normals[:, planes[topology.corner_face[~is_strip]]]
    return flat, normals


def _strips(radii: FloatArray) -> IntArray:
    """(K,) number of strips of rounds with radii (P, K)."""
    cosines = 1 - CHORD_ERROR_MM / np.maximum(radii.max(axis=0), 2 * CHORD_ERROR_MM)
    strips: IntArray = np.maximum(LEAST_STRIPS, 4 * np.ceil(np.pi / np.arccos(cosines) / 4).astype(np.int64))
    return strips


def _arc(batch: SolidArray, of: Measures, k: int, end: int, n: int) -> FloatArray:
    """(P, n + 1, 3) points on an arc of a fillet, from the first to the last corner as the fillet sees it at its first
    end."""
    first, last = (batch.vertices[:, t] for t in of.topology.fillet_corners[k, [0, 1] if end == 0 else [3, 2]])
    centre = of.middles + of.fillets.centres[end, :, :, k].T
    angles = np.pi / 2 * np.arange(n + 1)[:, None] / n
    return np.asarray(
        centre[:, None] + (first - centre)[:, None] * np.cos(angles) + (last - centre)[:, None] * np.sin(angles)
    )


@lru_cache(maxsize=256)
def _flat_topology(topology: Topology, strips: tuple[int, ...], quarters: tuple[int, ...]) -> Topology:
    """Corners on the first and second edge of each round, then those between the ends of both arcs of each fillet,
    follow the vertices; the strips are the last faces, in place of the fillets."""
    t, start = topology, topology.n_vertices
    faces, sides = [t.loops(face) for face in range(t.n_faces)], []
    for k, n in enumerate(strips):
        first = start + np.arange(n)
        second, start = first + n, start + 2 * n
        sense = int(t.rounds[k, 6])
        for end, loop in ((0, first), (1, second)):
            face = int(t.rounds[k, 4 + end])
            turned = loop if (end == 1) == (sense == SHAFT) else loop[::-1]
            faces[face].insert(0 if t.outer_round[face] == k else len(faces[face]), turned)
        around = np.stack([first, np.roll(first, -1), np.roll(second, -1), second], axis=1)
        sides += list(around if sense == SHAFT else around[:, ::-1])
    between: dict[tuple[int, int], list[int]] = {}  # the corners between the ends of each arc
    for (a, b, c, d), n in zip(t.fillet_corners.tolist(), quarters, strict=True):
        low, high = ([*range(first, first + n - 1)] for first in (start, start + n - 1))
        start += 2 * (n - 1)
        between |= {(b, a): low[::-1], (d, c): high}
        below, above = [a, *low, b], [d, *high, c]
        sides += [np.array(strip) for strip in zip(below, below[1:], above[1:], above, strict=False)]
    planes = [faces[face] for face in np.setdiff1d(np.arange(t.n_faces), t.fillets[:, 0]).tolist()]
    planes = [[_with_arcs(loop, between) for loop in face] for face in planes]
    loops = [loop for face in planes for loop in face] + sides
    face_starts = np.cumsum([0, *map(len, planes), *[1] * len(sides)])
    return Topology(start, np.concatenate(loops), np.cumsum([0, *map(len, loops)]), face_starts)


def _with_arcs(loop: IntArray, between: dict[tuple[int, int], list[int]]) -> IntArray:
    """The loop with the corners between both ends of each arc."""
    ahead = np.roll(loop, -1)
    sides = zip(loop.tolist(), ahead.tolist(), strict=True)
    return np.array([k for a, b in sides for k in (a, *between.get((a, b), []))], dtype=np.int64)
