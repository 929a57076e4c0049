"""Isolines followed from node to node, triangle by triangle, in whole numbers.

A *ray* leaves a node along an isoline, in one of the directions +u, +v, -u, -v (0 .. 3) of the chart of a triangle; its
*target* is the next integer point ahead, if the surface reaches so far.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, IntArray, integers
from geometry.errors import GeometryError
from geometry.layout.exact_maps import ISOLINE_SPACING, ExactMap, cross
from geometry.layout.grid_points import GridPoints
from geometry.layout.quarter_turns import quarter_turned
from geometry.mesh import Combinatorics

__all__ = ["Rays", "rays_between"]

DIRECTIONS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])

MAX_TRIANGLES = 100_000
"""Triangles that a ray may cross: more is a fault."""


@dataclass(frozen=True, eq=False)
class Rays:
    """tails, heads (R,): nodes; twins (R,): the ray back. fans, ranks (R,): the order of those that leave a node,
    counter-clockwise, fans first.
    """

    tails: IntArray
    heads: IntArray
    twins: IntArray
    fans: IntArray
    ranks: IntArray


@dataclass(frozen=True, eq=False)
class Starts:
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
    own = (starts.triangles * 4 + starts.directions) * points.n_nodes + starts.nodes
    order = np.argsort(own)
    place = np.searchsorted(own[order], keys)
    twins = order[np.minimum(place, len(order) - 1)]
    if not (np.array_equal(own[twins], keys) and np.array_equal(twins[twins], np.arange(len(own)))):
        lost = int(np.flatnonzero((own[twins] != keys) | (twins[twins] != np.arange(len(own))))[0])
        raise GeometryError(
            f"an isoline through triangle {starts.triangles[lost]} cannot be followed back", elements=[lost]
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
    c = points.of.combinatorics
    along = _half_edge_vectors(points.of)[halves]
    into = _is_left(along) | (_is_along(along) & (c.twin[halves] >= 0)[:, None])
    row, direction = np.nonzero(into)
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
    c = points.of.combinatorics
    node = points.at_vertices[c.corners]
    corners = np.flatnonzero(node >= 0)
    vectors = _half_edge_vectors(points.of)
    first, last = vectors[corners], -vectors[c.previous_corner[corners]]
    inside = (_is_left(first) | (_is_along(first) & (c.twin[corners] >= 0)[:, None])) & _is_right(last)
    at = points.of.values.reshape(-1, 2)[corners]
    whole = at % ISOLINE_SPACING == 0
    inside &= whole[:, [1, 0, 1, 0]]  # on a line u = integer go +v and -v
    row, direction = np.nonzero(inside)
    ahead = DIRECTIONS[direction]
    targets = np.where(
        ahead > 0,
        at[row] // ISOLINE_SPACING + 1,
        np.where(ahead < 0, -(-at[row] // ISOLINE_SPACING) - 1, at[row] // ISOLINE_SPACING),
    )
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
    at = points.of.values.reshape(-1, 2)
    new = np.flatnonzero(x.nodes >= points.n_points)
    half, component, value = x.halves[new], x.components[new], x.values[new]
    other, rows = 1 - component, np.arange(len(new))
    along = _half_edge_vectors(points.of)[half]
    inward = np.where(component == 0, along[:, 0] > 0, along[:, 1] < 0)  # +v is left of +u, +u of -v
    direction = np.where(component == 0, np.where(inward, 1, 3), np.where(inward, 0, 2))
    tail = at[half]
    base = tail[rows, other] // ISOLINE_SPACING
    du = along[rows, component]
    numerator = (tail[rows, other] - base * ISOLINE_SPACING) * du + along[rows, other] * (
        value * ISOLINE_SPACING - tail[rows, component]
    )
    below = base + numerator // (du * ISOLINE_SPACING)
    targets = np.empty((len(new), 2), dtype=np.int64)
    targets[rows, component], targets[rows, other] = value, np.where(inward, below + 1, below)
    zeros = np.zeros_like(new)
    return Starts(x.nodes[new], half // 3, targets, direction, zeros, zeros)


def _followed(points: GridPoints, starts: Starts) -> tuple[IntArray, IntArray]:
    """The node (R,) where each ray ends, and the key (R,) of the ray back: of its triangle, direction and node."""
    c, of = points.of.combinatorics, points.of
    heads, keys = np.full(len(starts.nodes), -1), np.full(len(starts.nodes), -1)
    ray, triangle = np.arange(len(starts.nodes)), starts.triangles
    target, direction = starts.targets, starts.directions
    for _ in range(MAX_TRIANGLES):
        if not len(ray):
            break
        offset = of.values[triangle] - target[:, None] * ISOLINE_SPACING
        left = cross(offset, np.roll(offset, -1, axis=1))  # of the target from the sides
        side = np.sign(cross(DIRECTIONS[direction][:, None], offset))
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
        far = np.where(side == 0, np.einsum("nki,ni->nk", offset, DIRECTIONS[direction]), np.iinfo(np.int64).min)
        head[at_vertex] = points.at_vertices[c.corners[3 * triangle + far.argmax(axis=1)]][at_vertex]
        done = arrived | at_rim | at_vertex
        heads[ray[done]] = head[done]
        keys[ray[done]] = _keys_back(points, triangle, direction, along, head)[done]

        on = ~done
        ray, half = ray[on], half[on]
        triangle = twin[on] // 3
        target = quarter_turned(target[on], of.turns[half]) + of.shifts[half]
        direction = (direction[on] + of.turns[half]) % 4
    return integers(heads), integers(keys)


def _keys_back(
    points: GridPoints, triangle: IntArray, direction: IntArray, along: BoolArray, head: IntArray
) -> IntArray:
    """Of rays that end in a triangle; those along (n, 3) one of its sides go back in the triangle beyond it."""
    half = 3 * triangle + along.argmax(axis=1)
    twin = points.of.combinatorics.twin[half]
    beyond = along.any(axis=1) & (twin >= 0)
    back = np.where(beyond, direction + 2 + points.of.turns[half], direction + 2) % 4
    return np.asarray((np.where(beyond, twin // 3, triangle) * 4 + back) * points.n_nodes + head)


def fan_positions(c: Combinatorics) -> IntArray:
    """(C,) place of each corner about its vertex, counter-clockwise; from the boundary on, if the vertex is there."""
    start = np.full(c.n_vertices, -1)
    for first in (np.arange(c.n_corners), np.flatnonzero(c.twin < 0)):
        start[c.corners[first]] = first
    positions = np.zeros(c.n_corners, dtype=np.int64)
    start = start[start >= 0]
    corner, place = start, 0
    while len(corner):
        place += 1
        following = c.twin[c.previous_corner[corner]]
        onwards = (following >= 0) & (following != start)
        corner, start = following[onwards], start[onwards]
        positions[corner] = place
    return integers(positions)


def _half_edge_vectors(of: ExactMap) -> IntArray:
    """(C, 2) from each corner to the next."""
    return np.asarray((np.roll(of.values, -1, axis=1) - of.values).reshape(-1, 2))


def _is_left(vectors: IntArray) -> BoolArray:
    """(n, 4) which directions are to the left of vectors (n, 2)."""
    return np.asarray(cross(vectors[:, None], DIRECTIONS[None]) > 0)


def _is_right(vectors: IntArray) -> BoolArray:
    return np.asarray(cross(vectors[:, None], DIRECTIONS[None]) < 0)


def _is_along(vectors: IntArray) -> BoolArray:
    return np.asarray((cross(vectors[:, None], DIRECTIONS[None]) == 0) & (vectors @ DIRECTIONS.T > 0))


def _first_axis(vectors: IntArray) -> IntArray:
    """(n,) the direction, 0 .. 3, that is met first when vectors (n, 2) turn counter-clockwise; their own, if any."""
    x, y = vectors.T
    quadrant = np.where((x > 0) & (y >= 0), 0, np.where((x <= 0) & (y > 0), 1, np.where((x < 0) & (y <= 0), 2, 3)))
    on_axis = (x == 0) | (y == 0)
    return np.asarray((quadrant + ~on_axis) % 4)
