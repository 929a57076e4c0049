"""Points of a surface where a mesh along isolines has vertices: integer (u, v), and where isolines end at the boundary.

A *node* is such a point, or a vertex of the boundary. All is decided in whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.layout.exact_maps import ISOLINE_SPACING, ExactMap, cross
from geometry.layout.quarter_turns import quarter_turned

__all__ = ["Crossings", "GridPoints"]


@dataclass(frozen=True, eq=False)
class Crossings:
    """Where isolines end at the boundary between integer points: half-edges (n,), the component (n,) that is constant
    there, and its value (n,) in cells; nodes (n,).
    """

    halves: IntArray
    components: IntArray
    values: IntArray
    nodes: IntArray


@dataclass(frozen=True, eq=False)
class GridPoints:
    """The nodes of an exact map without folds, in this order: at vertices, on sides, inside triangles, crossings."""

    of: ExactMap

    @cached_property
    def _table(self) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """low (F, 2) and counts (F, 2) of integers in each triangle's box, starts (F,), and all points (n, 3) of boxes:
        triangle, u, v."""
        values = self.of.values
        low = -(-values.min(axis=1) // ISOLINE_SPACING)
        counts = np.maximum(values.max(axis=1) // ISOLINE_SPACING - low + 1, 0)
        sizes = counts.prod(axis=1)
        starts = np.cumsum(sizes) - sizes
        triangle = np.repeat(np.arange(len(sizes)), sizes)
        offset = np.arange(sizes.sum()) - starts[triangle]
        rows = counts[triangle, 1]
        points = np.stack([triangle, low[triangle, 0] + offset // rows, low[triangle, 1] + offset % rows], axis=1)
        return integers(low), integers(counts), integers(starts), integers(points)

    @cached_property
    def _inside(self) -> tuple[IntArray, BoolArray]:
        """Which points of the table are in their closed triangle (n,), and on which of its sides these lie (n, 3)."""
        points = self._table[3]
        corners = self.of.values[points[:, 0]]
        along = np.roll(corners, -1, axis=1) - corners
        left = cross(along, points[:, None, 1:] * ISOLINE_SPACING - corners)
        inside = np.flatnonzero((left >= 0).all(axis=1))
        return integers(inside), np.asarray(left[inside] == 0)

    @cached_property
    def at_vertices(self) -> IntArray:
        """(N,) node of each vertex, -1 where it is none."""
        c = self.of.combinatorics
        is_node = c.is_boundary_vertex.copy()
        whole = (self.of.values.reshape(-1, 2) % ISOLINE_SPACING == 0).all(axis=1)
        is_node[c.corners[whole]] = True
        nodes = np.full(c.n_vertices, -1)
        nodes[is_node] = np.arange(is_node.sum())
        return integers(nodes)

    @cached_property
    def _node_of_entry(self) -> tuple[IntArray, int]:
        """Node of each point of the table, -1 outside of its triangle, and the number of these nodes and vertices."""
        c = self.of.combinatorics
        points = self._table[3]
        inside, on_side = self._inside
        sides = on_side.sum(axis=1)
        nodes = np.full(len(points), -1)
        corner = inside[sides == 2]
        k = np.where(on_side[sides == 2, 0], np.where(on_side[sides == 2, 1], 1, 0), 2)  # sides k - 1 and k
        nodes[corner] = self.at_vertices[c.corners[3 * points[corner, 0] + k]]
        count = int(self.at_vertices.max(initial=-1)) + 1

        on_one = inside[sides == 1]
        half = 3 * points[on_one, 0] + on_side[sides == 1].argmax(axis=1)
        is_left = c.runs_along_edge[half]
        nodes[on_one[is_left]] = count + np.arange(is_left.sum())
        count += int(is_left.sum())
        right, half = on_one[~is_left], half[~is_left]
        there = quarter_turned(points[right, 1:], self.of.turns[half]) + self.of.shifts[half]
        nodes[right] = nodes[self.entries(c.twin[half] // 3, there)]
        within = inside[sides == 0]
        nodes[within] = count + np.arange(len(within))
        return integers(nodes), count + len(within)

    def entries(self, triangles: IntArray, points: IntArray) -> IntArray:
        """(n,) places in the table of integer points (n, 2) in closed triangles (n,)."""
        low, counts, starts, _ = self._table
        offset = points - low[triangles]
        return np.asarray(starts[triangles] + offset[:, 0] * counts[triangles, 1] + offset[:, 1])

    def nodes(self, triangles: IntArray, points: IntArray) -> IntArray:
        """(n,) nodes at integer points (n, 2) in closed triangles (n,)."""
        return np.asarray(self._node_of_entry[0][self.entries(triangles, points)])

    @cached_property
    def inner(self) -> tuple[IntArray, IntArray, IntArray]:
        """Triangles (n,), integer points (n, 2) inside them and their nodes (n,)."""
        inside, on_side = self._inside
        at = inside[~on_side.any(axis=1)]
        points = self._table[3][at]
        return points[:, 0], points[:, 1:], self._node_of_entry[0][at]

    @cached_property
    def on_sides(self) -> tuple[IntArray, IntArray, IntArray]:
        """Half-edges (n,), integer points (n, 2) inside them and their nodes (n,): twice where there is a twin."""
        inside, on_side = self._inside
        one = on_side.sum(axis=1) == 1
        points = self._table[3][inside[one]]
        return 3 * points[:, 0] + on_side[one].argmax(axis=1), points[:, 1:], self._node_of_entry[0][inside[one]]

    @cached_property
    def _crossing_table(self) -> tuple[IntArray, IntArray, Crossings]:
        """Boundary half-edges' and components' first integer (2b,), start (2b,) in the list of crossings; the list."""
        c = self.of.combinatorics
        halves = np.flatnonzero(c.twin < 0)
        at = self.of.values.reshape(-1, 2)
        ends = np.stack([at[halves], at[c.next_corner[halves]]])
        low = ends.min(axis=0) // ISOLINE_SPACING + 1  # strictly between
        counts = np.maximum(-(-ends.max(axis=0) // ISOLINE_SPACING) - low, 0).ravel()
        starts = np.cumsum(counts) - counts
        owner = np.repeat(np.arange(len(counts)), counts)
        values = low.ravel()[owner] + np.arange(counts.sum()) - starts[owner]
        half, component = halves[owner // 2], owner % 2
        other = 1 - component
        tail, head = at[half], at[c.next_corner[half]]
        rows = np.arange(len(half))
        du = head[rows, component] - tail[rows, component]
        base = tail[rows, other] // ISOLINE_SPACING
        numerator = (tail[rows, other] - base * ISOLINE_SPACING) * du + (head - tail)[rows, other] * (
            values * ISOLINE_SPACING - tail[rows, component]
        )
        exact = numerator % (du * ISOLINE_SPACING) == 0
        nodes = np.empty(len(half), dtype=np.int64)
        count = self._node_of_entry[1]
        nodes[~exact] = count + np.arange((~exact).sum())
        point = np.empty((len(half), 2), dtype=np.int64)
        point[rows, component], point[rows, other] = values, base + numerator // (du * ISOLINE_SPACING)
        nodes[exact] = self.nodes(half[exact] // 3, point[exact])
        return integers(low.ravel()), integers(starts), Crossings(half, component, values, integers(nodes))

    @cached_property
    def crossings(self) -> Crossings:
        """All of the boundary; with those at integer points, twice."""
        return self._crossing_table[2]

    @property
    def n_points(self) -> int:
        """Number of nodes at vertices and integer points; those of other crossings come after them."""
        return self._node_of_entry[1]

    @property
    def n_nodes(self) -> int:
        return max(self._node_of_entry[1], int(self.crossings.nodes.max(initial=-1)) + 1)

    def crossing_nodes(self, halves: IntArray, components: IntArray, values: IntArray) -> IntArray:
        """(n,) nodes where isolines, with components (n,) of integer values (n,), cross boundary half-edges (n,)."""
        low, starts, crossings = self._crossing_table
        place = np.full(self.of.combinatorics.n_corners, -1)
        boundary = np.flatnonzero(self.of.combinatorics.twin < 0)
        place[boundary] = np.arange(len(boundary))
        row = 2 * place[halves] + components
        return np.asarray(crossings.nodes[starts[row] + values - low[row]])

    @cached_property
    def positions(self) -> tuple[IntArray, FloatArray]:
        """Triangles (n,) and barycentric coordinates (n, 3) of the nodes."""
        c = self.of.combinatorics
        triangles = np.zeros(self.n_nodes, dtype=np.int64)
        weights = np.zeros((self.n_nodes, 3))
        corners = np.flatnonzero(self.at_vertices[c.corners] >= 0)
        node = self.at_vertices[c.corners[corners]]
        triangles[node] = corners // 3
        weights[node] = np.eye(3)[corners % 3]
        inside, on_side = self._inside
        free = inside[on_side.sum(axis=1) < 2]
        points = self._table[3][free]
        values = self.of.values[points[:, 0]]
        node = self._node_of_entry[0][free]
        offset = values - points[:, None, 1:] * ISOLINE_SPACING
        parts = cross(np.roll(offset, -1, axis=1), np.roll(offset, -2, axis=1)).astype(np.float64)
        triangles[node], weights[node] = points[:, 0], parts / parts.sum(axis=1, keepdims=True)
        x = self.crossings
        tail = self.of.values.reshape(-1, 2)[x.halves, x.components]
        head = self.of.values.reshape(-1, 2)[c.next_corner[x.halves], x.components]
        share = (x.values * ISOLINE_SPACING - tail) / (head - tail)
        triangles[x.nodes] = x.halves // 3
        k = x.halves % 3
        weights[x.nodes] = (1 - share)[:, None] * np.eye(3)[k] + share[:, None] * np.eye(3)[(k + 1) % 3]
        return integers(triangles), weights
