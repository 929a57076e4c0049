"""The polylines of a quad mesh: edges that continue each other across regular vertices."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import IntArray, integers
from geometry.mesh import Combinatorics

__all__ = ["mesh_polylines"]


def mesh_polylines(c: Combinatorics) -> tuple[tuple[IntArray, ...], IntArray]:
    """Vertices along each polyline of inner edges, and the polyline (E,) of each edge, -1 at the boundary.

    They continue where four edges meet inside. A closed one has its first vertex at its end, too.
    """
    is_regular = ~c.is_boundary_vertex & (c.vertex_degrees == 4)
    inner = ~c.is_boundary_edge[c.corner_edge]
    ahead = c.next_corner  # the half-edge from the head of another one, its face to the left of both
    opposite = np.where(inner, c.twin[ahead], -1)
    opposite = np.where(opposite >= 0, c.next_corner[opposite], -1)  # one further about the head, clockwise
    continues = inner & is_regular[c.corners[c.next_corner]] & (opposite >= 0)
    halves = np.flatnonzero(inner)
    following = np.where(continues, opposite, -1)
    pairs = np.stack([halves, following[halves]])[:, continues[halves]]
    n = c.n_corners
    label = connected_components(coo_array((np.ones(pairs.shape[1]), pairs), shape=(n, n)), directed=False)[1]
    mate = label[c.twin[halves]]
    own = halves[label[halves] < mate]  # each polyline runs once in each direction; on itself reversed it cannot
    begins = np.zeros(n, dtype=bool)
    begins[own] = True
    begins[following[own][following[own] >= 0]] = False
    closed = np.setdiff1d(np.unique(label[own]), label[begins])
    first_of = np.unique(label[own], return_index=True)
    begins[own[first_of[1][np.isin(first_of[0], closed)]]] = True
    starts = np.flatnonzero(begins)
    line_of_edge = np.full(c.n_edges, -1)
    steps, lines = [], []
    at, line = starts, np.arange(len(starts))
    while len(at):
        steps.append(at)
        lines.append(line)
        line_of_edge[c.corner_edge[at]] = line
        onwards = following[at] >= 0
        onwards &= following[at] != starts[line]
        at, line = following[at[onwards]], line[onwards]
    order = np.argsort(np.concatenate(lines), kind="stable") if steps else np.zeros(0, dtype=np.int64)
    half = np.concatenate(steps)[order] if steps else order
    cuts = np.cumsum(np.bincount(np.concatenate(lines), minlength=len(starts)))[:-1] if steps else order
    vertices = [np.append(c.corners[part], c.corners[c.next_corner[part[-1]]]) for part in np.split(half, cuts)]
    return tuple(integers(part) for part in vertices if len(part) > 1), integers(line_of_edge)
