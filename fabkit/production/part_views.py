"""Views of solids along an axis, as lines: which edges are seen, and which are hidden."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fabkit.parts import SHAFT, Measures, Topology
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["View", "views"]

EDGE_ON_COSINE = 1e-7
"""Cosine of the angle between the line of sight and a normal below which a face is seen as a line: rounding of
directions, and 1e-4 mm of a face of 1 m."""
BEHIND_MM = 1e-3
"""Distance in mm from which on an edge counts as behind a face: the shortest edge of a solid is as long."""
CHORDS = 24
"""Number of chords of half a circle that is seen obliquely: 0.02 mm off one of 20 mm."""
MAX_CROSSINGS_IN_MEMORY = 4_000_000
"""Number of comparisons of points with sides of faces held in memory at a time: 32 MB."""


@dataclass(frozen=True, eq=False)
class View:
    """What is seen of P solids. lines: arrays (P, k, 2), each a line of every solid, with visible (P,) and exists (P,):
    whether it is in front, and whether it is drawn at all. circles: (P, 3) centre and radius, in the same way."""

    lines: list[tuple[FloatArray, BoolArray, BoolArray]]
    circles: list[tuple[FloatArray, BoolArray, BoolArray]]


@dataclass(frozen=True, eq=False)
class _Sight:
    """Solids and the frame of a view: right, up and towards the eye, the rows of axes (3, 3)."""

    of: Measures
    axes: FloatArray

    def flat(self, points: FloatArray) -> FloatArray:
        return points @ self.axes[:2].T

    def facing(self, normals: FloatArray) -> FloatArray:
        """Cosines of the angles between normals (..., 3) and the direction towards the eye."""
        return np.asarray(normals @ self.axes[2])

    def is_free(self, points: FloatArray) -> BoolArray:
        """(P, S) whether points (P, S, 3) have no polygonal face of their solid before them."""
        t = self.of.topology
        free = np.ones(points.shape[:2], dtype=bool)
        if not len(t.polygonal):
            return free
        size = max(1, MAX_CROSSINGS_IN_MEMORY // (points.shape[1] * len(t.corners)))
        for start in range(0, len(points), size):
            rows = slice(start, start + size)
            free[rows] = self._is_free(points[rows], self.of.vertices[rows], self.of.normals[rows])
        return free

    def _is_free(self, points: FloatArray, vertices: FloatArray, normals: FloatArray) -> BoolArray:
        t = self.of.topology
        own = normals[:, t.polygonal]
        facing = self.facing(own)
        levels = np.einsum("pgk,pgk->pg", own, vertices[:, t.corners[t.first_corner]])
        heights = levels[:, None] - points @ np.moveaxis(own, 1, 2)  # of the planes over the points
        before = (heights > BEHIND_MM * facing[:, None]) & (facing > EDGE_ON_COSINE)[:, None]  # (P, S, G)
        face = np.searchsorted(t.polygonal, t.corner_face)
        sides = np.flatnonzero(before.any(axis=(0, 1))[face])
        face, flat = face[sides], self.flat(vertices)
        starts, ends = flat[:, t.corners[sides]], flat[:, t.corners[t.next_corner[sides]]]
        x, y = np.moveaxis(self.flat(points), 2, 0)
        is_level = (starts[:, None, :, 1] > y[:, :, None]) != (ends[:, None, :, 1] > y[:, :, None])
        p, s, side = np.nonzero(is_level & before[:, :, face])
        (a, b), (c, d) = starts[p, side].T, ends[p, side].T
        is_right = a + (c - a) * (y[p, s] - b) / (d - b) > x[p, s]
        crossed = np.ravel_multi_index((p, s, face[side]), before.shape)[is_right]
        covered = np.flatnonzero(np.bincount(crossed) & 1) // len(t.polygonal)
        return np.isin(np.arange(x.size), covered, invert=True).reshape(x.shape)


def views(of: Measures, axes: FloatArray) -> View:
    """The view of the solids in the frame with rows right, up and towards the eye, axes (3, 3).

    An edge is visible or hidden as a whole, as its middle is. Lines at which a fillet begins are drawn only where they
    are the outline.
    """
    sight = _Sight(of, axes)
    found = _edges(sight)
    for k in range(len(of.topology.rounds)):
        found += [*_outlines(sight, k), *_end(sight, k, 0), *_end(sight, k, 1)]
    shapes, middles, fronts, exists = zip(*found, strict=True)
    visible = sight.is_free(np.stack(middles, axis=1)).T & np.stack(fronts)
    drawn = list(zip(shapes, visible, exists, strict=True))
    return View([each for each in drawn if each[0].ndim == 3], [each for each in drawn if each[0].ndim == 2])


_Drawn = tuple[FloatArray, FloatArray, BoolArray, BoolArray]
"""A line of every solid (P, k, 2), or a circle (P, 3); the point of it that shows whether it is hidden (P, 3); whether
it can be seen, and whether it is drawn at all (P,)."""


@lru_cache(maxsize=256)
def _faces_at_edges(topology: Topology) -> IntArray:
    """(E, 2) the two faces at each straight edge."""
    t = topology
    sides = zip(t.corners.tolist(), t.corners[t.next_corner].tolist(), t.corner_face.tolist(), strict=True)
    face = {(a, b): f for a, b, f in sides}
    return np.array([(face[a, b], face[b, a]) for a, b in t.edges.tolist()], dtype=np.int64).reshape(-1, 2)


def _edges(sight: _Sight) -> list[_Drawn]:
    """Straight edges and arcs."""
    t, vertices = sight.of.topology, sight.of.vertices
    straight = vertices[:, t.edges]  # (P, E, 2, 3)
    first, second = _faces_at_edges(t).T
    is_fillet = np.isin(np.arange(t.n_faces), t.fillets[:, 0])
    slanted = is_fillet | (np.abs(sight.facing(sight.of.normals)) > EDGE_ON_COSINE)
    exists = ~((is_fillet[first] | is_fillet[second]) & slanted[:, first] & slanted[:, second])
    arcs = _arcs(sight) if len(t.fillets) else np.zeros((len(vertices), 0, 1, 3))
    middles = np.concatenate([straight.mean(axis=2), arcs[:, :, arcs.shape[2] // 2]], axis=1)
    every = np.ones((len(vertices), arcs.shape[1]), dtype=bool)
    lines = [*np.moveaxis(sight.flat(vertices)[:, t.edges], 1, 0), *np.moveaxis(sight.flat(arcs), 1, 0)]
    exists = np.concatenate([exists, every], axis=1)
    fronts = np.ones(len(vertices), dtype=bool)
    return [(line, middles[:, k], fronts, exists[:, k]) for k, line in enumerate(lines)]


def _arcs(sight: _Sight) -> FloatArray:
    """(P, 2Q, n, 3) points of the arcs of the fillets."""
    t, of = sight.of.topology, sight.of
    ends = sight.of.vertices[:, t.fillet_corners[:, [[0, 1], [3, 2]]]]  # (P, Q, end, 2, 3)
    centres = np.transpose(of.fillets.centres, (2, 3, 0, 1)) + of.middles[:, None, None]
    from_centre = ends - centres[:, :, :, None]
    angles = np.linspace(0, np.pi / 2, CHORDS // 2 + 1)
    turned = np.einsum("nk,pqeki->pqeni", np.stack([np.cos(angles), np.sin(angles)], axis=1), from_centre)
    arcs = centres[:, :, :, None] + turned
    return np.asarray(arcs.reshape(len(arcs), -1, *arcs.shape[3:]))


def _outlines(sight: _Sight, k: int) -> list[_Drawn]:
    """The lines along a round that are its outline; hidden of a bore."""
    aside, _ = _across(sight, k)
    exists = np.abs(sight.facing(sight.of.round_axes[:, :, k].T)) < 1 - EDGE_ON_COSINE
    found = []
    for side in (1, -1):
        line = np.stack([_at_end(sight, k, end, side * aside[:, None])[:, 0] for end in (0, 1)], axis=1)
        front = np.full(len(line), sight.of.topology.rounds[k, 6] == SHAFT)
        found.append((sight.flat(line), line.mean(axis=1), front, exists))
    return found


def _end(sight: _Sight, k: int, end: int) -> list[_Drawn]:
    """The edge of a round in the face at one of its ends: a circle where all solids show it as one, else the halves
    before and behind the axis. Edge on, that of a bore in a face with corners is a part of that face's own line, and is
    not drawn."""
    t, of = sight.of.topology, sight.of
    face, is_shaft = int(t.rounds[k, 4 + end]), bool(t.rounds[k, 6] == SHAFT)
    facing = sight.facing(of.normals[:, face])
    exists = (np.abs(facing) > EDGE_ON_COSINE) | is_shaft | (face not in t.polygonal)
    aside, before = _across(sight, k)
    angles = np.pi * np.arange(CHORDS + 1)[:, None] / CHORDS
    found = []
    for side in (1, -1):
        half = aside[:, None] * np.cos(angles) + side * before[:, None] * np.sin(angles)
        line = _at_end(sight, k, end, half)
        front = (facing > EDGE_ON_COSINE) | (is_shaft and side == 1)
        found.append((sight.flat(line), line[:, CHORDS // 2], front, exists))
    along = np.abs(sight.facing(of.round_axes[:, :, k].T))
    if (np.minimum(np.abs(facing), along) > 1 - EDGE_ON_COSINE).all():
        circle = np.concatenate([sight.flat(_at_end(sight, k, end, 0 * aside[:, None])[:, 0]), of.radii[:, k, None]], 1)
        _, middle, front, _ = found[0]
        return [(circle, middle, front & (facing > 0), exists)]
    return found


def _across(sight: _Sight, k: int) -> tuple[FloatArray, FloatArray]:
    """(P, 3) twice, as long as the radius and perpendicular to the axis of a round: seen from its side, and towards the
    eye."""
    of = sight.of
    axes, radii = of.round_axes[:, :, k].T, of.radii[:, k, None]
    aside = np.cross(axes, sight.axes[2])
    sizes = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(sizes > EDGE_ON_COSINE, aside / np.where(sizes > 0, sizes, 1.0), of.round_across[:, :, k].T)
    return radii * aside, radii * np.cross(aside, axes)


def _at_end(sight: _Sight, k: int, end: int, across: FloatArray) -> FloatArray:
    """(P, n, 3) the points of the face at an end of a round that lie across its axis by vectors (P, n, 3)."""
    t, of = sight.of.topology, sight.of
    axes, normals = of.round_axes[:, :, k].T, of.normals[:, t.rounds[k, 4 + end]]
    lean = np.einsum("pnk,pk->pn", across, normals) / np.einsum("pk,pk->p", axes, normals)[:, None]
    centres = sight.of.vertices[:, None, t.rounds[k, 2 * end]]
    return np.asarray(centres + across - lean[..., None] * axes[:, None])
