"""The rim of a mesh of isolines: needless vertices dropped, short edges there contracted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.ragged_arrays import next_in_run, run_of_place

__all__ = ["Polygons", "tidied_rim"]

LONGEST_CONTRACTED_RIM_EDGE = 0.42
"""Length of edges at the rim that are contracted, over the edge length wanted."""

LEAST_RIM_CORNER = np.radians(22.0)
"""Corner of a face at the rim below which its shortest edge there is contracted, unless it is longer."""

LONGEST_CONTRACTED_EDGE = 0.9
"""Length of an edge at a sharp corner up to which it is contracted, over the edge length wanted."""

MAX_CONTRACTION_ROUNDS = 60
"""Rounds of contractions at the rim, at most."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces as corners and starts, of Combinatorics, over positions (N, 3). origins (N,): numbers in the beginning.

    stays (N,): neither dropped nor contracted into another vertex.
    """

    positions: FloatArray
    origins: IntArray
    stays: BoolArray
    corners: IntArray
    starts: IntArray

    @property
    def combinatorics(self) -> Combinatorics:
        return Combinatorics(len(self.positions), self.corners, self.starts)

    def relabelled(self, target: IntArray) -> Polygons:
        """Each vertex replaced by another one (N,), or left out: -1. Faces of fewer than three corners vanish."""
        vertex = target[self.corners]
        face = run_of_place(self.starts)
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
            self.stays[used],
            integers(numbered),
            integers(np.concatenate([[0], np.cumsum(sizes)])),
        )


def tidied_rim(polygons: Polygons, edge_length: float) -> Polygons:
    """Until nothing changes: vertices of the rim where no line ends are dropped, then edges that touch the rim are
    contracted which are short, or the shortest ones of faces with a sharp corner; each is the shortest of these nearby.
    """
    polygons = _dropped(polygons)
    forbidden = np.zeros(0, dtype=np.int64)
    for _ in range(MAX_CONTRACTION_ROUNDS):
        c = polygons.combinatorics
        costs = _costs(polygons, c, edge_length)
        keys = _keys(polygons, c.edges)
        costs[np.isin(keys, forbidden)] = np.inf
        least = np.full(c.n_vertices, np.inf)
        np.minimum.at(least, c.edges.ravel(), np.repeat(costs, 2))
        around = least.copy()
        np.minimum.at(around, c.edges[:, 0], least[c.edges[:, 1]])
        np.minimum.at(around, c.edges[:, 1], least[c.edges[:, 0]])
        chosen = np.flatnonzero(np.isfinite(costs) & (costs <= around[c.edges].min(axis=1)))
        if not len(chosen):
            break
        tried, bad = _contracted(polygons, c, chosen)
        forbidden = np.union1d(forbidden, keys[bad])
        polygons = _dropped(tried)
    return polygons


def _keys(polygons: Polygons, edges: IntArray) -> IntArray:
    ends = np.sort(polygons.origins[edges], axis=1)
    return np.asarray(ends[:, 0] * (1 << 31) + ends[:, 1])


def _dropped(polygons: Polygons) -> Polygons:
    """Without vertices of the rim that have two edges only."""
    while True:
        c = polygons.combinatorics
        drop = c.is_boundary_vertex & (c.vertex_degrees == 2) & ~polygons.stays
        if not drop.any():
            return polygons
        smaller = polygons.relabelled(np.where(drop, -1, np.arange(c.n_vertices)))
        if not len(smaller.starts) > 1:
            return polygons
        polygons = smaller


def _costs(polygons: Polygons, c: Combinatorics, edge_length: float) -> FloatArray:
    """(E,) lengths of edges that may be contracted, others infinite."""
    tail, head = c.edges.T
    lengths = np.linalg.norm(polygons.positions[head] - polygons.positions[tail], axis=1) / edge_length
    at_rim = c.is_boundary_vertex[c.edges]
    moves = ~polygons.stays[c.edges] & (~at_rim | at_rim[:, ::-1])  # which end may give way
    possible = at_rim.any(axis=1) & moves.any(axis=1) & (c.is_boundary_edge | ~at_rim.all(axis=1))
    third = c.corners[c.previous_corner]  # of a triangle; inside, it would lose an edge
    spoils = (c.face_sizes[c.corner_face] == 3) & ~c.is_boundary_vertex[third]
    possible[c.corner_edge[spoils]] = False
    sharpest = _sharpest(polygons, c)
    costs = np.where(possible, lengths, np.inf)
    shortest = np.full(c.n_faces, np.inf)
    np.minimum.at(shortest, c.corner_face, costs[c.corner_edge])
    of_sharp = (sharpest[c.corner_face] < LEAST_RIM_CORNER) & (costs[c.corner_edge] <= shortest[c.corner_face])
    is_wanted = lengths < LONGEST_CONTRACTED_RIM_EDGE
    is_wanted[c.corner_edge[of_sharp]] |= lengths[c.corner_edge[of_sharp]] < LONGEST_CONTRACTED_EDGE
    return np.asarray(np.where(is_wanted, costs, np.inf))


def _sharpest(polygons: Polygons, c: Combinatorics) -> FloatArray:
    """(F,) the smallest angle of each face."""
    angles = Mesh(polygons.positions, c).corner_angles
    sharpest = np.full(c.n_faces, np.inf)
    np.minimum.at(sharpest, c.corner_face, angles)
    return sharpest


def _sharpest_around(polygons: Polygons, c: Combinatorics, n_origins: int) -> FloatArray:
    """(n_origins,) the smallest angle of faces at a vertex with that origin."""
    around = np.full(n_origins, np.inf)
    np.minimum.at(around, polygons.origins[c.corners], _sharpest(polygons, c)[c.corner_face])
    return around


def _contracted(polygons: Polygons, c: Combinatorics, chosen: IntArray) -> tuple[Polygons, IntArray]:
    """With edges contracted to the end that stays, or is on the rim; and those (k,) that cannot be, or would make
    corners too sharp.
    """
    n_origins = int(polygons.origins.max()) + 1
    before = _sharpest_around(polygons, c, n_origins)[polygons.origins]
    bad = np.zeros(0, dtype=np.int64)
    while True:
        target = np.arange(c.n_vertices)
        good = np.setdiff1d(chosen, bad)
        tail, head = c.edges[good].T
        keeps_tail = polygons.stays[tail] | (c.is_boundary_vertex[tail] & ~c.is_boundary_vertex[head])
        both = c.is_boundary_vertex[tail] & c.is_boundary_vertex[head] & ~polygons.stays[tail] & ~polygons.stays[head]
        keeps_tail |= both
        target[np.where(keeps_tail, head, tail)] = np.where(keeps_tail, tail, head)
        smaller = polygons.relabelled(target)
        if not len(good):
            return smaller, bad
        wrong = _faults(smaller)
        if not len(wrong):
            after = _sharpest_around(smaller, smaller.combinatorics, n_origins)[polygons.origins]
            sharp = (after[target] < LEAST_RIM_CORNER) & (after[target] < before)
            tail, head = c.edges[good].T
            wrong = polygons.origins[target[tail][sharp[tail] & sharp[head] & c.is_boundary_edge[good]]]
        if not len(wrong):
            return smaller, bad
        worse = good[np.isin(polygons.origins[target[c.edges[good]]], wrong).any(axis=1)]
        bad = np.union1d(bad, worse if len(worse) else good)


def _faults(polygons: Polygons) -> IntArray:
    """Origins of vertices that a face meets twice, or at directed edges that two faces have, or where fans meet."""
    corners, starts = polygons.corners, polygons.starts
    face, following = run_of_place(starts), next_in_run(starts)
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
