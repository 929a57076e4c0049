"""Isolines followed from node to node, triangle by triangle, in whole numbers.

A *ray* leaves a node along an isoline, in one of the directions +u, +v, -u, -v (0 .. 3) of the (u, v) of a triangle.
Its *target* is the next integer point in this direction, which may be beyond the boundary of the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, IntArray, integers
from geometry.errors import GeometryError
from geometry.layout.exact_maps import CELL_SIZE, ExactMap, cross
from geometry.layout.grid_points import GridPoints
from geometry.layout.quarter_turns import quarter_turned
from geometry.mesh import Combinatorics

__all__ = ["Rays", "rays_between"]

DIRECTIONS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])

MAX_RAY_TRIANGLES = 100_000
"""Largest number of triangles that a ray crosses; more are a defect of the map."""


@dataclass(frozen=True, eq=False)
class Rays:
    """tails, heads (R,): the nodes where each ray begins and ends; twins (R,): the same ray in the other direction.
    fans, ranks (R,): sorted by fan and then by rank, the rays that leave a node are in counter-clockwise order.
    """

    tails: IntArray
    heads: IntArray
    twins: IntArray
    fans: IntArray
    ranks: IntArray


@dataclass(frozen=True, eq=False)
class Starts:
    """Where rays begin: nodes, triangles, targets (R, 2), directions, fans and ranks (R,)."""

    nodes: IntArray
    triangles: IntArray
    targets: IntArray
    directions: IntArray
    fans: IntArray
    ranks: IntArray


def rays_between(points: GridPoints) -> Rays:
    parts = (_from_inner(points), _from_sides(points), _from_vertices(points), _from_crossings(points))
    fields = ("nodes", "triangles", "targets", "directions", "fans", "ranks")
    starts = Starts(*(np.concatenate([getattr(part, name) for part in parts]) for name in fields))
    heads, keys = _followed(points, starts)
    keys_here = (starts.triangles * 4 + starts.directions) * points.n_nodes + starts.nodes
    order = np.argsort(keys_here)
    place = np.searchsorted(keys_here[order], keys)
    twins = order[np.minimum(place, len(order) - 1)]
    if not (np.array_equal(keys_here[twins], keys) and np.array_equal(twins[twins], np.arange(len(keys_here)))):
        unmatched = int(np.flatnonzero((keys_here[twins] != keys) | (twins[twins] != np.arange(len(keys_here))))[0])
        raise GeometryError(
            f"an isoline through triangle {starts.triangles[unmatched]} cannot be followed back: smooth the surface, "
            "or give a longer edge length",
            elements=[unmatched],
        )
    return Rays(starts.nodes, heads, integers(twins), starts.fans, starts.ranks)


def _from_inner(points: GridPoints) -> Starts:
    triangles, at, nodes = points.inner
    direction = np.tile(np.arange(4), len(nodes))
    triangles, nodes = np.repeat(triangles, 4), np.repeat(nodes, 4)
    return Starts(
        nodes, triangles, np.repeat(at, 4, axis=0) + DIRECTIONS[direction], direction, np.zeros_like(nodes), direction
    )


def _from_sides(points: GridPoints) -> Starts:
    halves, at, nodes = points.on_sides
    c = points.exact_map.combinatorics
    along = _half_edge_vectors(points.exact_map)[halves]
    enters = _is_left(along) | (_is_along(along) & (c.twin[halves] >= 0)[:, None])
    row, direction = np.nonzero(enters)
    fans = np.where(c.runs_along_edge[halves], 0, 1)[row]
    return Starts(
        nodes[row],
        halves[row] // 3,
        at[row] + DIRECTIONS[direction],
        direction,
        fans,
        (direction - _first_axis(along)[row]) % 4,
    )


def _from_vertices(points: GridPoints) -> Starts:
    c = points.exact_map.combinatorics
    node = points.at_vertices[c.corners]
    corners = np.flatnonzero(node >= 0)
    vectors = _half_edge_vectors(points.exact_map)
    first, last = vectors[corners], -vectors[c.previous_corner[corners]]
    inside = (_is_left(first) | (_is_along(first) & (c.twin[corners] >= 0)[:, None])) & _is_right(last)
    at = points.exact_map.values.reshape(-1, 2)[corners]
    whole = at % CELL_SIZE == 0
    inside &= whole[:, [1, 0, 1, 0]]  # rays in +v and -v run on lines u = integer
    row, direction = np.nonzero(inside)
    ahead = DIRECTIONS[direction]
    cells = at[row] // CELL_SIZE
    targets = np.where(ahead > 0, cells + 1, np.where(ahead < 0, -(-at[row] // CELL_SIZE) - 1, cells))
    return Starts(
        node[corners[row]],
        corners[row] // 3,
        targets,
        direction,
        fan_positions(c)[corners[row]],
        (direction - _first_axis(first)[row]) % 4,
    )


def _from_crossings(points: GridPoints) -> Starts:
    x = points.crossings
    at = points.exact_map.values.reshape(-1, 2)
    other_crossings = np.flatnonzero(x.nodes >= points.n_points)
    half, component, value = x.halves[other_crossings], x.components[other_crossings], x.values[other_crossings]
    other, rows = 1 - component, np.arange(len(other_crossings))
    along = _half_edge_vectors(points.exact_map)[half]
    inward = np.where(component == 0, along[:, 0] > 0, along[:, 1] < 0)  # +v is left of +u, +u of -v
    direction = np.where(component == 0, np.where(inward, 1, 3), np.where(inward, 0, 2))
    tail = at[half]
    base = tail[rows, other] // CELL_SIZE
    du = along[rows, component]
    numerator = (tail[rows, other] - base * CELL_SIZE) * du + along[rows, other] * (
        value * CELL_SIZE - tail[rows, component]
    )
    below = base + numerator // (du * CELL_SIZE)
    targets = np.empty((len(other_crossings), 2), dtype=np.int64)
    targets[rows, component], targets[rows, other] = value, np.where(inward, below + 1, below)
    zeros = np.zeros_like(other_crossings)
    return Starts(x.nodes[other_crossings], half // 3, targets, direction, zeros, zeros)


def _followed(points: GridPoints, starts: Starts) -> tuple[IntArray, IntArray]:
    """The node (R,) where each ray ends, and the key (R,) of its twin, made of triangle, direction and node."""
    c, exact_map = points.exact_map.combinatorics, points.exact_map
    heads, keys = np.full(len(starts.nodes), -1), np.full(len(starts.nodes), -1)
    ray, triangle = np.arange(len(starts.nodes)), starts.triangles
    target, direction = starts.targets, starts.directions
    for _ in range(MAX_RAY_TRIANGLES):
        if not len(ray):
            break
        offsets = exact_map.values[triangle] - target[:, None] * CELL_SIZE
        left = cross(offsets, np.roll(offsets, -1, axis=1))  # positive where the target is left of a side
        side = np.sign(cross(DIRECTIONS[direction][:, None], offsets))
        following = np.roll(side, -1, axis=1)
        along = (side == 0) & (following == 0)
        exits = (side < 0) & (following > 0)
        arrived = (left >= 0).all(axis=1)
        leaves = ~arrived & exits.any(axis=1)
        half = 3 * triangle + exits.argmax(axis=1)
        twin = c.twin[half]

        head = np.full(len(ray), -1)
        head[arrived] = points.nodes(triangle[arrived], target[arrived])
        at_rim = leaves & (twin < 0)
        component = 1 - direction % 2
        head[at_rim] = points.crossing_nodes(half[at_rim], component[at_rim], target[at_rim, component[at_rim]])
        at_vertex = ~arrived & ~leaves
        extents = np.where(side == 0, np.einsum("nki,ni->nk", offsets, DIRECTIONS[direction]), np.iinfo(np.int64).min)
        head[at_vertex] = points.at_vertices[c.corners[3 * triangle + extents.argmax(axis=1)]][at_vertex]
        done = arrived | at_rim | at_vertex
        heads[ray[done]] = head[done]
        keys[ray[done]] = _keys_back(points, triangle, direction, along, head)[done]

        unfinished = ~done
        ray, half = ray[unfinished], half[unfinished]
        triangle = twin[unfinished] // 3
        target = quarter_turned(target[unfinished], exact_map.turns[half]) + exact_map.shifts[half]
        direction = (direction[unfinished] + exact_map.turns[half]) % 4
    return integers(heads), integers(keys)


def _keys_back(
    points: GridPoints, triangle: IntArray, direction: IntArray, along: BoolArray, head: IntArray
) -> IntArray:
    """Keys of the twins of rays that end in a triangle; the twin of a ray along (n, 3) a side is in the triangle on the
    other side."""
    half = 3 * triangle + along.argmax(axis=1)
    twin = points.exact_map.combinatorics.twin[half]
    has_neighbour = along.any(axis=1) & (twin >= 0)
    back = np.where(has_neighbour, direction + 2 + points.exact_map.turns[half], direction + 2) % 4
    return np.asarray((np.where(has_neighbour, twin // 3, triangle) * 4 + back) * points.n_nodes + head)


def fan_positions(c: Combinatorics) -> IntArray:
    """(C,) the position of each corner in the counter-clockwise order about its vertex, which begins at the boundary if
    the vertex is on it."""
    start = np.full(c.n_vertices, -1)
    for first in (np.arange(c.n_corners), np.flatnonzero(c.twin < 0)):
        start[c.corners[first]] = first
    positions = np.zeros(c.n_corners, dtype=np.int64)
    start = start[start >= 0]
    corner, place = start, 0
    while len(corner):
        place += 1
        following = c.twin[c.previous_corner[corner]]
        has_next = (following >= 0) & (following != start)
        corner, start = following[has_next], start[has_next]
        positions[corner] = place
    return integers(positions)


def _half_edge_vectors(exact_map: ExactMap) -> IntArray:
    """(C, 2) differences of (u, v) from each corner to the next one of its triangle."""
    return np.asarray((np.roll(exact_map.values, -1, axis=1) - exact_map.values).reshape(-1, 2))


def _is_left(vectors: IntArray) -> BoolArray:
    """(n, 4) which directions are to the left of vectors (n, 2)."""
    return np.asarray(cross(vectors[:, None], DIRECTIONS[None]) > 0)


def _is_right(vectors: IntArray) -> BoolArray:
    return np.asarray(cross(vectors[:, None], DIRECTIONS[None]) < 0)


def _is_along(vectors: IntArray) -> BoolArray:
    return np.asarray((cross(vectors[:, None], DIRECTIONS[None]) == 0) & (vectors @ DIRECTIONS.T > 0))


def _first_axis(vectors: IntArray) -> IntArray:
    """(n,) the first of the directions 0 .. 3 counter-clockwise from vectors (n, 2), their own direction included."""
    x, y = vectors.T
    quadrant = np.where((x > 0) & (y >= 0), 0, np.where((x <= 0) & (y > 0), 1, np.where((x < 0) & (y <= 0), 2, 3)))
    on_axis = (x == 0) | (y == 0)
    return np.asarray((quadrant + ~on_axis) % 4)
