"""Pairs of functions (u, v) on a cut surface that agree across the cuts up to quarter turns and integers.

A *wedge* consists of the triangles about a vertex between two cuts; the vertex has one value (u, v) in it. Across a
cut, from its left to its right side, (u, v) is turned by quarters and moved by a vector of integers, the same one along
the whole *arc* of the cut between two *nodes*: branches, ends, and vertices at the boundary [BommesZimmerKobbelt2009].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.layout.integer_lattices import integer_kernel
from geometry.mesh import Combinatorics
from geometry.networks.combed_fields import CombedField
from geometry.optimise import SparseMatrix, apply

__all__ = ["SeamlessMaps", "seamless_maps"]


@dataclass(frozen=True, eq=False)
class SeamlessMaps:
    """All seamless (u, v): the values (2C,) at the corners, u and v alternately, are reals @ x + integers @ t.

    x: real numbers, the (u, v) of vertices that need not be integers, in their first wedge; t: integers. on_lines
    (C, 2): half-edges along which u (column 0) or v (column 1) is a constant integer.
    """

    reals: SparseMatrix
    integers: SparseMatrix
    on_lines: BoolArray

    def values(self, x: FloatArray, t: FloatArray) -> FloatArray:
        """(C, 2) the (u, v) at the corners."""
        return (apply(self.reals, x) + apply(self.integers, t)).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Fans:
    """The corners at each vertex in counter-clockwise order, beginning at the boundary or at a cut.

    wedges (C,): the number of the wedge that each corner is in. turns (C,): quarters by which (u, v) is turned from the
    first wedge of the vertex to the wedge of the corner. vertex, wedge, turn, arc, power, sign (K,): of each cut that
    is crossed on the way, the vertex, the number of the wedge after it, the quarters from the first wedge to that one,
    and the vector that is added: sign times the vector of the arc, turned by `power` quarters. The last cut about an
    inner vertex leads back to its first wedge.
    """

    turns: IntArray
    wedges: IntArray
    vertex: IntArray
    wedge: IntArray
    turn: IntArray
    arc: IntArray
    power: IntArray
    sign: IntArray


def seamless_maps(c: Combinatorics, field: CombedField, on_lines: BoolArray | None = None) -> SeamlessMaps:
    """All maps for a combed field in which singular vertices have integer (u, v). on_lines: see `SeamlessMaps`."""
    on_lines = np.zeros((c.n_corners, 2), dtype=bool) if on_lines is None else on_lines
    degrees = np.bincount(c.edges[field.is_cut].ravel(), minlength=c.n_vertices)
    is_node = (degrees > 0) & (c.is_boundary_vertex | (field.indices != 0) | (degrees != 2))
    arcs, is_forward = _arcs(c, field.is_cut, is_node)
    n_arcs = int(arcs.max(initial=-1)) + 1
    fans = _fans(c, field, arcs, is_forward)
    first_singular = _first_of_parts(c, np.flatnonzero(field.indices))

    n_integer = 2 * n_arcs
    singular = np.flatnonzero(field.indices)
    column = np.full((c.n_vertices, 2), -1)  # columns of (u, v) that are integers
    column[singular] = n_integer + np.arange(2 * len(singular)).reshape(-1, 2)
    n_integer += 2 * len(singular)
    if on_lines.any():
        column, n_integer = _line_columns(c, fans, on_lines, column, n_integer)
    base, added = _corner_rows(c, fans, column, n_arcs, n_integer)

    equations = [_node_equations(fans, is_node & ~c.is_boundary_vertex, column, n_arcs, n_integer)]
    if on_lines.any():
        equations.append(_line_equations(c, on_lines, added))
    anchored = column[first_singular].ravel()
    equations.append(
        csr_array((np.ones(len(anchored)), (np.arange(len(anchored)), anchored)), shape=(len(anchored), n_integer))
    )
    rows = np.concatenate([_distinct(part) for part in equations])
    kernel = integer_kernel(np.rint(rows).astype(np.int64))
    return SeamlessMaps(base, csr_array(added @ csr_array(kernel.astype(np.float64))), on_lines)


def _distinct(equations: SparseMatrix) -> FloatArray:
    dense = equations[np.flatnonzero(np.diff(equations.indptr))].toarray()
    return np.unique(dense, axis=0) if len(dense) else dense


def _arcs(c: Combinatorics, is_cut: BoolArray, is_node: BoolArray) -> tuple[IntArray, BoolArray]:
    """The arc of the half-edge at each corner (C,), -1 off the cut, and whether it runs in the direction of the arc."""
    halves = np.flatnonzero(is_cut[c.corner_edge])
    heads = c.corners[c.next_corner[halves]]
    tails = c.corners[halves]
    leaving = np.argsort(tails, kind="stable")
    passing = np.flatnonzero(~is_node[heads])
    start = np.searchsorted(tails[leaving], heads[passing])
    pair = leaving[np.stack([start, start + 1])]  # two half-edges leave a vertex of the cut that is not a node
    back = c.twin[halves[passing]]
    following = np.where(halves[pair[0]] == back, pair[1], pair[0])
    n = len(halves)
    label = connected_components(
        coo_array((np.ones(len(passing)), (passing, following)), shape=(n, n)), directed=False
    )[1]
    place = np.full(c.n_corners, -1)
    place[halves] = np.arange(n)
    other = label[place[c.twin[halves]]]
    arcs, forward = np.full(c.n_corners, -1), np.zeros(c.n_corners, dtype=bool)
    arcs[halves] = np.unique(np.minimum(label, other), return_inverse=True)[1]
    forward[halves] = label < other
    return integers(arcs), forward


def _fans(c: Combinatorics, field: CombedField, arcs: IntArray, is_forward: BoolArray) -> Fans:
    on_cut = field.is_cut[c.corner_edge]
    start = np.full(c.n_vertices, -1)
    for first in (np.arange(c.n_corners), np.flatnonzero(on_cut), np.flatnonzero(c.twin < 0)):
        start[c.corners[first]] = first
    vertex = np.flatnonzero(start >= 0)
    corner = start[vertex]
    turns, wedges = np.zeros(c.n_corners, dtype=np.int64), np.zeros(c.n_corners, dtype=np.int64)
    turn, wedge = np.zeros(len(vertex), dtype=np.int64), np.zeros(len(vertex), dtype=np.int64)
    crossed: list[IntArray] = []
    while len(vertex):
        following = c.twin[c.previous_corner[corner]]
        has_next = following >= 0
        vertex, corner, turn, wedge = vertex[has_next], following[has_next], turn[has_next], wedge[has_next]
        cut = np.flatnonzero(on_cut[corner])
        half = corner[cut]  # crossed from its right to its left
        edge = c.corner_edge[half]
        quarters = np.where(c.runs_along_edge[half], field.turns[edge], -field.turns[edge])  # from right to left
        turn[cut] += quarters
        wedge[cut] += 1
        forward = is_forward[half]
        power = np.where(forward, quarters, 0)
        sign = np.where(forward, -1, 1)
        crossed.append(np.stack([vertex[cut], wedge[cut], turn[cut], arcs[half], power, sign]))
        is_unfinished = corner != start[vertex]
        vertex, corner, turn, wedge = (
            vertex[is_unfinished],
            corner[is_unfinished],
            turn[is_unfinished],
            wedge[is_unfinished],
        )
        turns[corner], wedges[corner] = turn, wedge
    table = np.concatenate(crossed, axis=1)
    return Fans(turns, wedges, *table)


def _corner_rows(
    c: Combinatorics, fans: Fans, column: IntArray, n_arcs: int, n_integer: int
) -> tuple[SparseMatrix, SparseMatrix]:
    """(2C, number of reals) and (2C, number of integers): matrices from both to (u, v) at the corners."""
    is_real = (column < 0) & c.is_used[:, None]
    real = np.full(column.shape, -1)
    real[is_real] = np.arange(is_real.sum())
    corner, component, source, value = _turned_rows(np.arange(c.n_corners), fans.turns)
    rows = 2 * corner + component
    vertex = c.corners[corner]
    at_real = real[vertex, source] >= 0
    base = coo_array(
        (value[at_real], (rows[at_real], real[vertex, source][at_real])), shape=(2 * c.n_corners, int(is_real.sum()))
    )
    pairs, place = _pairs_of_terms(c, fans)
    owner, moved, along, signs = _turned_rows(
        np.arange(len(pairs)), fans.turns[place] - fans.turn[pairs] + fans.power[pairs]
    )
    shifts = fans.sign[pairs][owner] * signs
    all_rows = np.concatenate([rows[~at_real], 2 * place[owner] + moved])
    all_columns = np.concatenate([column[vertex, source][~at_real], 2 * fans.arc[pairs][owner] + along])
    values = np.concatenate([value[~at_real], shifts]).astype(np.float64)
    added = coo_array((values, (all_rows, all_columns)), shape=(2 * c.n_corners, n_integer))
    return csr_array(base), csr_array(added)


def _turned_rows(elements: IntArray, turns: IntArray) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Rows of quarter turns, two for each element: the element, the component of the turned vector, the component of
    the original vector that it equals, and the sign."""
    element, component = np.repeat(elements, 2), np.tile([0, 1], len(elements))
    quarter = np.repeat(turns % 4, 2)
    source = (component + quarter) % 2
    sign = np.where(component == 0, np.array([1, -1, -1, 1])[quarter], np.array([1, 1, -1, -1])[quarter])
    return element, component, source, sign


def _pairs_of_terms(c: Combinatorics, fans: Fans) -> tuple[IntArray, IntArray]:
    """Pairs of crossed cuts (n,) and corners (n,) of the same vertex in a wedge after the cut."""
    corners = np.flatnonzero(fans.wedges > 0)
    order = np.argsort(fans.vertex, kind="stable")
    first = np.searchsorted(fans.vertex[order], c.corners[corners])
    counts = np.searchsorted(fans.vertex[order], c.corners[corners], side="right") - first
    place = np.repeat(corners, counts)
    offset = np.arange(len(place)) - np.repeat(np.cumsum(counts) - counts, counts)
    pairs = order[np.repeat(first, counts) + offset]
    is_after = fans.wedge[pairs] <= fans.wedges[place]
    return pairs[is_after], place[is_after]


def _node_equations(fans: Fans, is_node: BoolArray, column: IntArray, n_arcs: int, n_integer: int) -> SparseMatrix:
    """Equations for the integers: crossing all cuts about an inner node leads back to the same (u, v)."""
    at = np.flatnonzero(is_node[fans.vertex])
    total = np.zeros(len(is_node), dtype=np.int64)
    last = np.zeros(len(is_node), dtype=np.int64)
    np.maximum.at(last, fans.vertex, fans.wedge)
    closing = fans.wedge == last[fans.vertex]
    total[fans.vertex[closing]] = fans.turn[closing]
    element, component, source, value = _turned_rows(at, total[fans.vertex[at]] - fans.turn[at] + fans.power[at])
    rows = [2 * fans.vertex[element] + component]
    columns = [2 * fans.arc[element] + source]
    values = [fans.sign[element] * value]
    nodes = np.flatnonzero(is_node & (column >= 0).any(axis=1))
    element, component, source, value = _turned_rows(nodes, total[nodes])
    rows += [2 * element + component, integers(2 * nodes[:, None] + [0, 1]).ravel()]
    columns += [column[element, source], column[nodes].ravel()]
    values += [value, -np.ones(2 * len(nodes), dtype=np.int64)]
    places = (np.concatenate(rows), np.concatenate(columns))
    return csr_array(
        coo_array((np.concatenate(values).astype(np.float64), places), shape=(2 * len(is_node), n_integer))
    )


def _line_columns(
    c: Combinatorics, fans: Fans, on_lines: BoolArray, column: IntArray, n_integer: int
) -> tuple[IntArray, int]:
    """The columns (N, 2) with those of values that are integers along lines, one column for all values that are equal
    along a line without a cut; and the number of integers."""
    corner, component = np.nonzero(on_lines)
    ends = np.stack([corner, c.next_corner[corner]])
    source = (component + fans.turns[ends]) % 2
    values = 2 * c.corners[ends] + source
    is_uncut = ~(fans.wedges[ends].any(axis=0) | (fans.turns[ends] % 4).any(axis=0))
    n = 2 * c.n_vertices
    graph = coo_array((np.ones(is_uncut.sum()), values[:, is_uncut]), shape=(n, n))
    label = connected_components(graph, directed=False)[1]
    used = np.setdiff1d(np.unique(values), np.flatnonzero(column.ravel() >= 0))
    names, numbers = np.unique(label[used], return_inverse=True)
    column = column.copy()
    column.ravel()[used] = n_integer + numbers
    return column, n_integer + len(names)


def _line_equations(c: Combinatorics, on_lines: BoolArray, added: SparseMatrix) -> SparseMatrix:
    corner, component = np.nonzero(on_lines)
    difference = csr_array(added[2 * corner + component] - added[2 * c.next_corner[corner] + component])
    difference.eliminate_zeros()
    return difference


def _first_of_parts(c: Combinatorics, vertices: IntArray) -> IntArray:
    """The first of the vertices in each connected part of the surface that has some."""
    pieces = connected_components(c.adjacency, directed=False)[1]
    return vertices[np.unique(pieces[vertices], return_index=True)[1]]
