"""The rim of a mesh of isolines: vertices without an inner edge are removed and short edges contracted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.ragged_arrays import next_in_row, row_of_entry

__all__ = ["Polygons", "simplified_rim"]

SHORT_RIM_EDGE = 0.42
"""Length below which an edge that touches the rim is contracted, over the edge length wanted there."""

SHARP_RIM_CORNER = np.radians(22.0)
"""Angle of a face at the rim, in radians, below which the shortest of its edges that touch the rim is contracted."""

LONGEST_CONTRACTED_EDGE = 0.9
"""Length below which such an edge of a face with a sharp corner is contracted, over the edge length wanted there."""

FEWEST_RIM_EDGES = 4
"""Number of edges of a boundary loop up to which none of them is contracted, since the hole would be closed."""

MAX_CONTRACTION_ROUNDS = 60
"""Largest number of rounds of contractions at the rim."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces as corners and starts, of Combinatorics, over positions (N, 3). origins (N,): the vertex that each vertex
    was originally. lengths (N,): edge lengths wanted there. is_kept (N,): vertices that are neither removed nor
    contracted into another one.
    """

    positions: FloatArray
    origins: IntArray
    lengths: FloatArray
    is_kept: BoolArray
    corners: IntArray
    starts: IntArray

    @property
    def combinatorics(self) -> Combinatorics:
        return Combinatorics(len(self.positions), self.corners, self.starts)

    def relabelled(self, target: IntArray) -> Polygons:
        """The faces with each vertex replaced by target (N,), or removed where that is -1. Faces with fewer than three
        corners are removed."""
        vertex = target[self.corners]
        face = row_of_entry(self.starts)
        vertex, face = vertex[vertex >= 0], face[vertex >= 0]
        sizes = np.bincount(face, minlength=len(self.starts) - 1)
        starts = np.cumsum(sizes) - sizes
        before = np.arange(len(vertex)) - 1
        first = starts[face] == np.arange(len(vertex))
        before[first] = (starts + sizes - 1)[face[first]]
        keep = (vertex != vertex[before]) | (sizes[face] < 2)
        vertex, face = vertex[keep], face[keep]
        sizes = np.bincount(face, minlength=len(self.starts) - 1)
        vertex, sizes = vertex[sizes[face] > 2], sizes[sizes > 2]
        used, numbered = np.unique(vertex, return_inverse=True)
        return Polygons(
            self.positions[used],
            self.origins[used],
            self.lengths[used],
            self.is_kept[used],
            integers(numbered),
            integers(np.concatenate([[0], np.cumsum(sizes)])),
        )


def simplified_rim(polygons: Polygons) -> Polygons:
    """The polygons without rim vertices at which no line ends, and with short edges at the rim contracted.

    Contracted are edges that touch the rim and are shorter than `SHORT_RIM_EDGE`, or the shortest ones of a face with a
    sharp corner; in each round those that are the shortest ones nearby, until there is none. Those that would damage
    the mesh are left, and tried again when all others are done.
    """
    polygons = _without_rim_vertices(polygons)
    forbidden, n_tried = np.zeros(0, dtype=np.int64), 0
    for _ in range(MAX_CONTRACTION_ROUNDS):
        c = polygons.combinatorics
        costs = _costs(polygons, c)
        keys = _edge_keys(polygons, c.edges)
        costs[np.isin(keys, forbidden)] = np.inf
        least = np.full(c.n_vertices, np.inf)
        np.minimum.at(least, c.edges.ravel(), np.repeat(costs, 2))
        least_nearby = least.copy()
        np.minimum.at(least_nearby, c.edges[:, 0], least[c.edges[:, 1]])
        np.minimum.at(least_nearby, c.edges[:, 1], least[c.edges[:, 0]])
        chosen = np.flatnonzero(np.isfinite(costs) & (costs <= least_nearby[c.edges].min(axis=1)))
        if not len(chosen) and len(polygons.positions) == n_tried:
            break
        if not len(chosen):  # edges that were refused are tried again beside what has changed
            forbidden, n_tried = forbidden[:0], len(polygons.positions)
            continue
        contracted, refused = _contracted(polygons, c, chosen)
        forbidden = np.union1d(forbidden, keys[refused])
        polygons = _without_rim_vertices(contracted)
    return polygons


def _edge_keys(polygons: Polygons, edges: IntArray) -> IntArray:
    ends = np.sort(polygons.origins[edges], axis=1)
    return np.asarray(ends[:, 0] * (1 << 31) + ends[:, 1])


def _without_rim_vertices(polygons: Polygons) -> Polygons:
    """The polygons without those rim vertices that have only two edges."""
    while True:
        c = polygons.combinatorics
        is_removed = c.is_boundary_vertex & (c.vertex_degrees == 2) & ~polygons.is_kept
        if not is_removed.any():
            return polygons
        smaller = polygons.relabelled(np.where(is_removed, -1, np.arange(c.n_vertices)))
        if not len(smaller.starts) > 1:
            return polygons
        polygons = smaller


def _costs(polygons: Polygons, c: Combinatorics) -> FloatArray:
    """(E,) lengths of edges that may be contracted, over the wanted ones; others infinite."""
    tail, head = c.edges.T
    lengths = np.linalg.norm(polygons.positions[head] - polygons.positions[tail], axis=1)
    lengths = lengths / polygons.lengths[c.edges].mean(axis=1)
    at_rim = c.is_boundary_vertex[c.edges]
    can_move = ~polygons.is_kept[c.edges] & (~at_rim | at_rim[:, ::-1])  # the ends that may move to the other end
    possible = at_rim.any(axis=1) & can_move.any(axis=1) & (c.is_boundary_edge | ~at_rim.all(axis=1))
    third = c.corners[c.previous_corner]  # the third vertex of a triangle, which loses an edge
    loses_edge = (c.face_sizes[c.corner_face] == 3) & ~c.is_boundary_vertex[third]
    possible[c.corner_edge[loses_edge]] = False
    smallest = [loop for loop in c.boundary_loops if len(loop) <= FEWEST_RIM_EDGES]
    is_of_hole = np.isin(c.edges, np.concatenate([np.zeros(0, dtype=np.int64), *smallest])).all(axis=1)
    possible[is_of_hole & c.is_boundary_edge] = False
    sharpest = _smallest_angles(polygons, c)
    costs = np.where(possible, lengths, np.inf)
    shortest = np.full(c.n_faces, np.inf)
    np.minimum.at(shortest, c.corner_face, costs[c.corner_edge])
    at_sharp_corner = (sharpest[c.corner_face] < SHARP_RIM_CORNER) & (costs[c.corner_edge] <= shortest[c.corner_face])
    is_contracted = lengths < SHORT_RIM_EDGE
    is_contracted[c.corner_edge[at_sharp_corner]] |= lengths[c.corner_edge[at_sharp_corner]] < LONGEST_CONTRACTED_EDGE
    return np.asarray(np.where(is_contracted, costs, np.inf))


def _smallest_angles(polygons: Polygons, c: Combinatorics) -> FloatArray:
    """(F,) the smallest angle of each face."""
    angles = Mesh(polygons.positions, c).corner_angles
    sharpest = np.full(c.n_faces, np.inf)
    np.minimum.at(sharpest, c.corner_face, angles)
    return sharpest


def _smallest_angles_at(polygons: Polygons, c: Combinatorics, n_origins: int) -> FloatArray:
    """(n_origins,) for each original vertex the smallest angle in the faces that contain it."""
    least_nearby = np.full(n_origins, np.inf)
    np.minimum.at(least_nearby, polygons.origins[c.corners], _smallest_angles(polygons, c)[c.corner_face])
    return least_nearby


def _contracted(polygons: Polygons, c: Combinatorics, chosen: IntArray) -> tuple[Polygons, IntArray]:
    """The polygons with chosen edges contracted to the end that is kept or on the rim; and the edges (k,) that are not
    contracted, since that would damage the mesh or make corners too sharp.
    """
    n_origins = int(polygons.origins.max()) + 1
    before = _smallest_angles_at(polygons, c, n_origins)[polygons.origins]
    refused = np.zeros(0, dtype=np.int64)
    while True:
        target = np.arange(c.n_vertices)
        accepted = np.setdiff1d(chosen, refused)
        tail, head = c.edges[accepted].T
        keeps_tail = polygons.is_kept[tail] | (c.is_boundary_vertex[tail] & ~c.is_boundary_vertex[head])
        both = (
            c.is_boundary_vertex[tail] & c.is_boundary_vertex[head] & ~polygons.is_kept[tail] & ~polygons.is_kept[head]
        )
        keeps_tail |= both
        target[np.where(keeps_tail, head, tail)] = np.where(keeps_tail, tail, head)
        smaller = polygons.relabelled(target)
        if not len(accepted):
            return smaller, refused
        wrong = _faults(smaller)
        if not len(wrong):
            after = _smallest_angles_at(smaller, smaller.combinatorics, n_origins)[polygons.origins]
            sharp = (after[target] < SHARP_RIM_CORNER) & (after[target] < before)
            tail, head = c.edges[accepted].T
            wrong = polygons.origins[target[tail][sharp[tail] & sharp[head] & c.is_boundary_edge[accepted]]]
        if not len(wrong):
            return smaller, refused
        damaging = accepted[np.isin(polygons.origins[target[c.edges[accepted]]], wrong).any(axis=1)]
        refused = np.union1d(refused, damaging if len(damaging) else accepted)


def _faults(polygons: Polygons) -> IntArray:
    """Original vertices of defects: vertices that occur twice in a face, ends of directed edges of two faces, and
    vertices where two fans of faces meet."""
    corners, starts = polygons.corners, polygons.starts
    face, following = row_of_entry(starts), next_in_row(starts)
    n = len(polygons.positions)
    wrong = []
    for keys, vertex in ((face * n + corners, corners), (corners * n + corners[following], corners)):
        order = np.argsort(keys, kind="stable")
        twice = keys[order][1:] == keys[order][:-1]
        wrong += [vertex[order[1:][twice]], corners[following[order[1:][twice]]]]
    found = np.concatenate(wrong)
    if not len(found):
        c = polygons.combinatorics
        rims = np.bincount(c.corners[c.twin < 0], minlength=n)
        found = np.flatnonzero(rims > 1)
    return np.asarray(polygons.origins[found])
