"""Triangulations of solids, for formats that know triangles only: exact ones of planar faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fabkit.errors import OutputError
from fabkit.formats.shown.faceted import faceted
from fabkit.parts import SolidArray, Solids, Topology
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Facets", "facets"]

CONVEX_CORNER_SINE = 1e-9
"""Sine of the inward turn at a corner up to which a face counts as convex: rounding of a straight corner."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Flat-shaded solids of one topology. solids (K,): their numbers. flat: with planar faces only. points and normals
    (K, C, 3): one for each corner of each face; triangles (K, T, 3): corners, counter-clockwise seen from outside."""

    solids: IntArray
    flat: SolidArray
    points: FloatArray
    normals: FloatArray
    triangles: IntArray


def facets(solids: Solids, names: Sequence[str]) -> list[Facets]:
    """Triangulated solids, by topology. No point is added, but on rounds, which become strips that are at most
    CHORD_ERROR_MM off, with the normals of the round.

    Convex faces become fans, other ones and faces with inner loops constrained Delaunay triangulations.
    Raises `OutputError` with the solid's name where a face's outline crosses itself.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> panels = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["panels"]
    >>> from fabkit.formats.shown import facets
    >>> [len(batch.triangles) for batch in facets(panels.solids, panels.mark_names)]
    [2]
    """
    result = []
    for batch in solids.by_topology():
        flat, normals = faceted(batch)
        points = flat.vertices[:, flat.topology.corners]
        of_faces = normals if flat is batch else flat.normals[:, flat.topology.corner_face]
        triangles = _triangles(points, of_faces, flat.topology, [names[n] for n in batch.parts.tolist()])
        result.append(Facets(batch.parts, flat, points, normals, triangles))
    return result


def _triangles(points: FloatArray, normals: FloatArray, topology: Topology, names: list[str]) -> IntArray:
    """(K, T, 3) corners of the triangles of solids with points and normals (K, C, 3) at their corners.

    A face with n corners and h inner loops has n + 2h - 2 triangles however it is cut, so T is the topology's.
    """
    first = topology.first_corner
    counts = np.diff(topology.loop_starts[topology.face_starts]) + 2 * np.diff(topology.face_starts) - 4
    starts = np.concatenate([[0], np.cumsum(counts)])
    fan = np.arange(starts[-1]) - np.repeat(starts[:-1], counts) + 1
    fans = np.repeat(first, counts)[:, None] + np.stack([np.zeros_like(fan), fan, fan + 1], axis=1)
    triangles = np.tile(fans, (len(points), 1, 1))
    others = ~_convex(points, normals, topology)
    for face in np.flatnonzero(others.any(axis=0)).tolist():
        rows = np.flatnonzero(others[:, face])
        while len(rows):
            found = _constrained(points[rows[0]], normals[rows[0], first[face]], topology, face)
            if len(found) != counts[face]:
                raise OutputError(
                    f"face {face} of {names[rows[0]]} cannot be triangulated: {len(found)} triangles instead of "
                    f"{counts[face]}; its outline crosses or touches itself"
                )
            fits = _all_upwards(points[rows], normals[rows, first[face]], found)  # most faces are cut like the first
            fits[0] = True
            triangles[rows[fits], starts[face] : starts[face + 1]] = found
            rows = rows[~fits]
    return triangles


def _all_upwards(points: FloatArray, normals: FloatArray, triangles: IntArray) -> BoolArray:
    """(K,) whether triangles (m, 3) of corners (K, C, 3) all run counter-clockwise about normals (K, 3): as their areas
    add up to that of the face, they then cover it once."""
    a, b, c = (points[:, triangles[:, k]] for k in range(3))
    upwards: BoolArray = (np.einsum("kmj,kj->km", np.cross(b - a, c - a), normals) > 0).all(axis=1)
    return upwards


def _convex(points: FloatArray, normals: FloatArray, topology: Topology) -> BoolArray:
    """(K, F) whether each face has one loop without a corner that turns inwards."""
    x = np.ascontiguousarray(np.moveaxis(points, 2, 0))  # coordinates first: whole rows of numbers are fastest
    ahead = x[:, :, topology.next_corner] - x
    ahead /= np.sqrt((ahead * ahead).sum(axis=0))
    behind = np.empty_like(ahead)
    behind[:, :, topology.next_corner] = ahead
    turns = sum((behind[i - 2] * ahead[i - 1] - behind[i - 1] * ahead[i - 2]) * normals[:, :, i] for i in range(3))
    first = topology.first_corner
    inwards = np.minimum.reduceat(turns, first, axis=1) < -CONVEX_CORNER_SINE
    convex: BoolArray = ~inwards & (np.diff(topology.face_starts) == 1)
    return convex


def _constrained(points: FloatArray, normal: FloatArray, topology: Topology, face: int) -> IntArray:
    """(m, 3) corners of the triangles of one face of a solid with points (C, 3) at its corners."""
    ends = topology.loop_starts[topology.face_starts[face] : topology.face_starts[face + 1] + 1]
    x = points[ends[0] + 1] - points[ends[0]]
    flat = (points[ends[0] : ends[-1]] - points[ends[0]]) @ np.stack([x, np.cross(normal, x)], axis=1)
    outer, *inner = np.split(flat, ends[1:-1] - ends[0])
    polygon = shapely.Polygon(outer, inner)
    if not polygon.is_valid:
        return np.zeros((0, 3), dtype=np.int64)
    rings = shapely.get_coordinates(shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)))
    corner_at = {tuple(point): ends[0] + n for n, point in enumerate(flat.tolist())}
    corners = [corner_at[tuple(point)] for point in rings.reshape(-1, 4, 2)[:, :3].reshape(-1, 2).tolist()]
    (a, b, c), triangles = rings.reshape(-1, 4, 2)[:, :3].transpose(1, 0, 2), np.array(corners).reshape(-1, 3)
    turned = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    triangles[turned] = triangles[turned][:, ::-1]
    return triangles
