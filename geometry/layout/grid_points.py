"""The vertices of a mesh along isolines: points of a surface with integer (u, v), and ends of isolines at the boundary.

A *node* is such a point, or a vertex of the boundary. All decisions are exact, in whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.layout.exact_maps import CELL_SIZE, ExactMap, cross
from geometry.layout.quarter_turns import quarter_turned

__all__ = ["Crossings", "GridPoints"]


@dataclass(frozen=True, eq=False)
class Crossings:
    """Points where isolines end at the boundary: half-edges (n,); components (n,), 0 for u and 1 for v, that are
    constant along the isoline, and their integer values (n,); nodes (n,).
    """

    halves: IntArray
    components: IntArray
    values: IntArray
    nodes: IntArray


@dataclass(frozen=True, eq=False)
class GridPoints:
    """The nodes of an exact map without folds, numbered in this order: at vertices, on sides, inside triangles, other
    crossings of the boundary."""

    exact_map: ExactMap

    @cached_property
    def _table(self) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """The integer points in the bounding box of each triangle, row after row: the least (u, v) (F, 2), their
        numbers in u and v (F, 2), where the rows of a triangle start (F,), and the rows (n, 3): triangle, u, v."""
        values = self.exact_map.values
        low = -(-values.min(axis=1) // CELL_SIZE)
        counts = np.maximum(values.max(axis=1) // CELL_SIZE - low + 1, 0)
        sizes = counts.prod(axis=1)
        starts = np.cumsum(sizes) - sizes
        triangle = np.repeat(np.arange(len(sizes)), sizes)
        offset = np.arange(sizes.sum()) - starts[triangle]
        rows = counts[triangle, 1]
        points = np.stack([triangle, low[triangle, 0] + offset // rows, low[triangle, 1] + offset % rows], axis=1)
        return integers(low), integers(counts), integers(starts), integers(points)

    @cached_property
    def _inside(self) -> tuple[IntArray, BoolArray]:
        """The rows of the table that are in their closed triangle (n,), and on which of its sides they lie (n, 3)."""
        points = self._table[3]
        corners = self.exact_map.values[points[:, 0]]
        along = np.roll(corners, -1, axis=1) - corners
        left = cross(along, points[:, None, 1:] * CELL_SIZE - corners)
        inside = np.flatnonzero((left >= 0).all(axis=1))
        return integers(inside), np.asarray(left[inside] == 0)

    @cached_property
    def at_vertices(self) -> IntArray:
        """(N,) node of each vertex, -1 where it is none."""
        c = self.exact_map.combinatorics
        is_node = c.is_boundary_vertex.copy()
        whole = (self.exact_map.values.reshape(-1, 2) % CELL_SIZE == 0).all(axis=1)
        is_node[c.corners[whole]] = True
        nodes = np.full(c.n_vertices, -1)
        nodes[is_node] = np.arange(is_node.sum())
        return integers(nodes)

    @cached_property
    def _row_nodes(self) -> tuple[IntArray, int]:
        """The node of each row of the table, -1 outside its triangle, and the number of nodes without crossings."""
        c = self.exact_map.combinatorics
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
        there = quarter_turned(points[right, 1:], self.exact_map.turns[half]) + self.exact_map.shifts[half]
        nodes[right] = nodes[self.rows_of(c.twin[half] // 3, there)]
        within = inside[sides == 0]
        nodes[within] = count + np.arange(len(within))
        return integers(nodes), count + len(within)

    def rows_of(self, triangles: IntArray, points: IntArray) -> IntArray:
        """(n,) rows of the table for integer points (n, 2) in closed triangles (n,)."""
        low, counts, starts, _ = self._table
        offset = points - low[triangles]
        return np.asarray(starts[triangles] + offset[:, 0] * counts[triangles, 1] + offset[:, 1])

    def nodes(self, triangles: IntArray, points: IntArray) -> IntArray:
        """(n,) nodes at integer points (n, 2) in closed triangles (n,)."""
        return np.asarray(self._row_nodes[0][self.rows_of(triangles, points)])

    @cached_property
    def inner(self) -> tuple[IntArray, IntArray, IntArray]:
        """Triangles (n,), integer points (n, 2) inside them and their nodes (n,)."""
        inside, on_side = self._inside
        at = inside[~on_side.any(axis=1)]
        points = self._table[3][at]
        return points[:, 0], points[:, 1:], self._row_nodes[0][at]

    @cached_property
    def on_sides(self) -> tuple[IntArray, IntArray, IntArray]:
        """Half-edges (n,), integer points (n, 2) inside them and their nodes (n,); points on inner edges occur
        twice."""
        inside, on_side = self._inside
        one = on_side.sum(axis=1) == 1
        points = self._table[3][inside[one]]
        return 3 * points[:, 0] + on_side[one].argmax(axis=1), points[:, 1:], self._row_nodes[0][inside[one]]

    @cached_property
    def _crossing_table(self) -> tuple[IntArray, IntArray, Crossings]:
        """For each boundary half-edge and component the first integer (2b,) and the start (2b,) in the list of
        crossings; and this list."""
        c = self.exact_map.combinatorics
        halves = np.flatnonzero(c.twin < 0)
        at = self.exact_map.values.reshape(-1, 2)
        ends = np.stack([at[halves], at[c.next_corner[halves]]])
        low = ends.min(axis=0) // CELL_SIZE + 1  # strictly between
        counts = np.maximum(-(-ends.max(axis=0) // CELL_SIZE) - low, 0).ravel()
        starts = np.cumsum(counts) - counts
        owner = np.repeat(np.arange(len(counts)), counts)
        values = low.ravel()[owner] + np.arange(counts.sum()) - starts[owner]
        half, component = halves[owner // 2], owner % 2
        other = 1 - component
        tail, head = at[half], at[c.next_corner[half]]
        rows = np.arange(len(half))
        du = head[rows, component] - tail[rows, component]
        base = tail[rows, other] // CELL_SIZE
        numerator = (tail[rows, other] - base * CELL_SIZE) * du + (head - tail)[rows, other] * (
            values * CELL_SIZE - tail[rows, component]
        )
        at_integer_point = numerator % (du * CELL_SIZE) == 0
        nodes = np.empty(len(half), dtype=np.int64)
        count = self._row_nodes[1]
        nodes[~at_integer_point] = count + np.arange((~at_integer_point).sum())
        point = np.empty((len(half), 2), dtype=np.int64)
        point[rows, component], point[rows, other] = values, base + numerator // (du * CELL_SIZE)
        nodes[at_integer_point] = self.nodes(half[at_integer_point] // 3, point[at_integer_point])
        return integers(low.ravel()), integers(starts), Crossings(half, component, values, integers(nodes))

    @cached_property
    def crossings(self) -> Crossings:
        """All crossings of the boundary; those at integer points occur twice, once for each component."""
        return self._crossing_table[2]

    @property
    def n_points(self) -> int:
        """Number of nodes at vertices and integer points; nodes of other crossings follow."""
        return self._row_nodes[1]

    @property
    def n_nodes(self) -> int:
        return max(self._row_nodes[1], int(self.crossings.nodes.max(initial=-1)) + 1)

    def crossing_nodes(self, halves: IntArray, components: IntArray, values: IntArray) -> IntArray:
        """(n,) nodes where isolines u or v (components (n,)) = values (n,) cross boundary half-edges (n,)."""
        low, starts, crossings = self._crossing_table
        place = np.full(self.exact_map.combinatorics.n_corners, -1)
        boundary = np.flatnonzero(self.exact_map.combinatorics.twin < 0)
        place[boundary] = np.arange(len(boundary))
        row = 2 * place[halves] + components
        return np.asarray(crossings.nodes[starts[row] + values - low[row]])

    @cached_property
    def positions(self) -> tuple[IntArray, FloatArray]:
        """Triangles (n,) and barycentric coordinates (n, 3) of the nodes."""
        c = self.exact_map.combinatorics
        triangles = np.zeros(self.n_nodes, dtype=np.int64)
        weights = np.zeros((self.n_nodes, 3))
        corners = np.flatnonzero(self.at_vertices[c.corners] >= 0)
        node = self.at_vertices[c.corners[corners]]
        triangles[node] = corners // 3
        weights[node] = np.eye(3)[corners % 3]
        inside, on_side = self._inside
        free = inside[on_side.sum(axis=1) < 2]
        points = self._table[3][free]
        values = self.exact_map.values[points[:, 0]]
        node = self._row_nodes[0][free]
        offsets = values - points[:, None, 1:] * CELL_SIZE
        parts = cross(np.roll(offsets, -1, axis=1), np.roll(offsets, -2, axis=1)).astype(np.float64)
        triangles[node], weights[node] = points[:, 0], parts / parts.sum(axis=1, keepdims=True)
        x = self.crossings
        tail = self.exact_map.values.reshape(-1, 2)[x.halves, x.components]
        head = self.exact_map.values.reshape(-1, 2)[c.next_corner[x.halves], x.components]
        share = (x.values * CELL_SIZE - tail) / (head - tail)
        triangles[x.nodes] = x.halves // 3
        k = x.halves % 3
        weights[x.nodes] = (1 - share)[:, None] * np.eye(3)[k] + share[:, None] * np.eye(3)[(k + 1) % 3]
        return integers(triangles), weights
