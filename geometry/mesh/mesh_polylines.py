"""The polylines of a quad mesh: edges that continue each other across regular vertices."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import IntArray, integers
from geometry.mesh.combinatorics import Combinatorics

__all__ = ["mesh_polylines"]


def mesh_polylines(c: Combinatorics) -> tuple[tuple[IntArray, ...], IntArray]:
    """Vertices along each polyline of inner edges, and the polyline (E,) of each edge, -1 at the boundary.

    Polylines continue through inner vertices with four edges. A closed one begins and ends with the same vertex.
    """
    is_regular = ~c.is_boundary_vertex & (c.vertex_degrees == 4)
    inner = ~c.is_boundary_edge[c.corner_edge]
    next_half = c.next_corner  # the next half-edge in the same face
    opposite = np.where(inner, c.twin[next_half], -1)
    opposite = np.where(
        opposite >= 0, c.next_corner[opposite], -1
    )  # the half-edge after next about the head, clockwise
    continues = inner & is_regular[c.corners[c.next_corner]] & (opposite >= 0)
    halves = np.flatnonzero(inner)
    following = np.where(continues, opposite, -1)
    pairs = np.stack([halves, following[halves]])[:, continues[halves]]
    n = c.n_corners
    label = connected_components(coo_array((np.ones(pairs.shape[1]), pairs), shape=(n, n)), directed=False)[1]
    reverse_label = label[c.twin[halves]]
    chosen = halves[label[halves] < reverse_label]  # each polyline occurs once in each direction
    begins = np.zeros(n, dtype=bool)
    begins[chosen] = True
    begins[following[chosen][following[chosen] >= 0]] = False
    closed = np.setdiff1d(np.unique(label[chosen]), label[begins])
    first_of = np.unique(label[chosen], return_index=True)
    begins[chosen[first_of[1][np.isin(first_of[0], closed)]]] = True
    starts = np.flatnonzero(begins)
    line_of_edge = np.full(c.n_edges, -1)
    steps, lines = [], []
    at, line = starts, np.arange(len(starts))
    while len(at):
        steps.append(at)
        lines.append(line)
        line_of_edge[c.corner_edge[at]] = line
        continues_on = following[at] >= 0
        continues_on &= following[at] != starts[line]
        at, line = following[at[continues_on]], line[continues_on]
    order = np.argsort(np.concatenate(lines), kind="stable") if steps else np.zeros(0, dtype=np.int64)
    half = np.concatenate(steps)[order] if steps else order
    cuts = np.cumsum(np.bincount(np.concatenate(lines), minlength=len(starts)))[:-1] if steps else order
    vertices = [np.append(c.corners[part], c.corners[c.next_corner[part[-1]]]) for part in np.split(half, cuts)]
    return tuple(integers(part) for part in vertices if len(part) > 1), integers(line_of_edge)
