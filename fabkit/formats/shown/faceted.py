"""Solids with their rounds cut into flat strips, for formats that know planar faces only."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fabkit.parts import SHAFT, Measures, SolidArray, Topology
from geometry.arrays import FloatArray

__all__ = ["CHORD_ERROR_MM", "faceted"]

CHORD_ERROR_MM = 0.5
"""Largest distance in mm of a strip from the round that it stands for: not to be seen in a structure, and 12 to 40
strips for what is 20 to 300 mm thick."""
LEAST_STRIPS = 12
"""Minimum number of strips of a round, so that small ones look round too."""


def faceted(batch: SolidArray) -> tuple[SolidArray, FloatArray]:
    """The solids, with corners on the circles and ellipses in place of rounds; (P, C, 3) unit normals at all corners,
    those of the rounds where the face is a strip. Solids without rounds stay as they are."""
    t = batch.topology
    if not len(t.rounds):
        return batch, batch.normals[:, t.corner_face]
    of = Measures(t, batch.vertices)
    cosines = 1 - CHORD_ERROR_MM / np.maximum(of.radii.max(axis=0), 2 * CHORD_ERROR_MM)
    strips = np.maximum(LEAST_STRIPS, 4 * np.ceil(np.pi / np.arccos(cosines) / 4).astype(np.int64))
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
    flat = SolidArray(_flat_topology(t, tuple(strips.tolist())), batch.parts, np.concatenate(points, axis=1))
    is_strip = flat.topology.corner_face >= t.n_faces
    normals = np.concatenate(radial, axis=1)[:, flat.topology.corners]
    normals[:, ~is_strip] = batch.normals[:, flat.topology.corner_face[~is_strip]]
    return flat, normals


@lru_cache(maxsize=256)
def _flat_topology(topology: Topology, strips: tuple[int, ...]) -> Topology:
    """Corners on the first and second edge of each round follow the vertices; the strips are the last faces."""
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
    loops = [loop for face in faces for loop in face] + sides
    face_starts = np.cumsum([0, *map(len, faces), *[1] * len(sides)])
    return Topology(start, np.concatenate(loops), np.cumsum([0, *map(len, loops)]), face_starts)
