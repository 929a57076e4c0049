"""Groups of equal shapes, where each shape may be rotated into several turns; no step compares all pairs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["TurnedShapes", "equal_shapes", "may_have_equals"]

TREE_CORNERS = 8
"""Number of corners, spread evenly over the shape, that are compared first: they distinguish most shapes, and beams and
quads have no more."""
DISTANCE_LEVELS = 5
"""Number of distances of corners from their mean, from the smallest to the largest, that are compared before shapes are
rotated."""
DISTANCE_ROUNDING = 1e-13
"""Rounding error of distances within a shape, over its size: some hundred times the precision of double numbers."""
SAME_DEVIATION = 0.01
"""Difference of the deviations of two turns of a shape, over the tolerance, up to which they are equally good: so
rounding does not decide between the turns of a symmetric shape."""
MOST_TURNED_CORNERS = 20_000
"""Largest number of corners of a shape in all its turns, for which each shape is compared with the one that it was
before: more have only round plates."""
MAX_COORDINATES_IN_MEMORY = 4_000_000
"""Number of coordinates held in memory at a time: 32 MB."""


@dataclass(frozen=True, eq=False)
class TurnedShapes:
    """Shapes with equally many turns and corners.

    A turn is one of the rotations that may bring a shape onto an equal one. at(shapes (q,), turns (q,), corners (c,))
    -> (q, c, d): positions of these corners of each of these shapes after the turn given for it.
    """

    n_shapes: int
    n_turns: int
    n_corners: int
    at: Callable[[IntArray, IntArray, IntArray], FloatArray]


def may_have_equals(corners: FloatArray, within: float) -> BoolArray:
    """(P,) whether solids with corners (P, n, 3) in mm may be equal to another one of them, to `within` in mm.

    No turn changes the distances of the corners from their mean. So solids are grouped where these distances differ
    little, and a solid that is alone in its group has no equal.
    """
    distances = np.sort(np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2), axis=1)
    levels = np.unique(np.linspace(0, distances.shape[1] - 1, DISTANCE_LEVELS).astype(np.int64))
    # `within` in each coordinate of a corner, and again in each coordinate of the mean
    max_difference = 2 * np.sqrt(3) * within + DISTANCE_ROUNDING * distances.max(initial=0.0)
    group = _chained(np.stack([distances.mean(axis=1), *distances[:, levels].T]), max_difference)
    in_company: BoolArray = np.bincount(group)[group] > 1
    return in_company


def _chained(coordinates: FloatArray, max_difference: float) -> IntArray:
    """(P,) groups of points with coordinates (d, P): any two that differ by at most max_difference in
    each coordinate are in one group. Sorting by one coordinate after the other takes n log n."""
    group = np.zeros(coordinates.shape[1], dtype=np.int64)
    for values in coordinates:
        order = np.lexsort((values, group))
        begins = (np.diff(group[order]) > 0) | (np.diff(values[order]) > max_difference)
        group[order] = np.concatenate([[0], np.cumsum(begins)])[: len(order)]
    return group


def equal_shapes(
    shapes: TurnedShapes,
    within: float,
    earlier: FloatArray | None = None,
    own_before: tuple[IntArray, FloatArray] | None = None,
) -> tuple[IntArray, IntArray, IntArray]:
    """(P,) the first shape to which each shape is equal, itself where there is none; (P,) the turn that brings the
    shape onto this first one best, the smallest of equally good ones; (P,) the earlier shape that it has, -1 for none.

    First the earlier shapes (K, n_corners, d), then the given ones are visited in their order. All shapes that belong
    to no group yet, and in some turn differ from the visited one by at most `within` in each coordinate of each corner,
    join its group. A shape that belongs to a group is not visited. So every shape deviates from the one that was
    visited by `within` at most, even where many shapes form a chain of small differences. The first shape of an earlier
    one is the nearest to it, and the turns are those that bring shapes onto the earlier one.

    own_before: the earlier shape (P,) that each shape had before, -1 where it is not known, and how far (P,) it was off
    that one. It keeps it before any is visited, and may be off by `within` more than it was: so what changes by less
    keeps it. What is off by more than `within` then joins the others of its group only where no coordinate of any two
    of them differs by more than twice that.
    """
    parts, turns = (index.ravel() for index in np.indices((shapes.n_shapes, shapes.n_turns)))
    compared_first = np.unique(np.linspace(0, shapes.n_corners - 1, TREE_CORNERS).astype(np.int64))
    points = shapes.at(parts, turns, compared_first).reshape(len(parts), -1)
    tree = cKDTree(points)
    first, turn = np.arange(shapes.n_shapes), np.zeros(shapes.n_shapes, dtype=np.int64)
    kept = np.full(shapes.n_shapes, -1, dtype=np.int64)
    ungrouped = np.ones(shapes.n_shapes, dtype=bool)

    def near(point: FloatArray) -> IntArray:
        """Turned shapes in no group whose corners that are compared first are near to these coordinates: of each shape
        the best turn first, of equally good ones the smallest."""
        hits = np.sort(np.array(tree.query_ball_point(point, within, p=np.inf), dtype=np.int64))
        hits = hits[ungrouped[parts[hits]]]
        return _best_first(hits, shapes.n_turns, np.abs(points[hits] - point).max(axis=1), within)

    def join(hits: IntArray, own: FloatArray) -> IntArray:
        """The shapes of those hits that are equal to one with corners (n_corners, d), taken out with their turns."""
        if shapes.n_corners > TREE_CORNERS:
            hits = _near_in_all_corners(shapes, own, hits, within)
        equal, best = np.unique(parts[hits], return_index=True)
        turn[equal], ungrouped[equal] = turns[hits[best]], False
        return equal

    if earlier is not None and len(earlier):
        beyond = np.zeros(0, dtype=np.int64)
        if own_before is not None:
            rows, beyond = _as_before(shapes, within, earlier, *own_before, turn)
            kept[rows], ungrouped[rows], ungrouped[beyond] = own_before[0][rows], False, False
        fitting = np.zeros(1, dtype=bool)
        while not fitting.all():
            for number, own in enumerate(earlier):
                kept[join(near(own[compared_first].ravel()), own)] = number
            if own_before is not None:
                kept[beyond] = own_before[0][beyond]
            fitting = _near_to_all(shapes, within, kept, turn, beyond)
            kept[beyond[~fitting]], ungrouped[beyond[~fitting]], turn[beyond[~fitting]] = -1, True, 0
            beyond = beyond[fitting]
        rows = np.flatnonzero(kept >= 0)
        deviation = _deviations(shapes, rows, turn[rows], earlier[kept[rows]])
        nearest = np.full(len(earlier), -1, dtype=np.int64)
        order = rows[np.lexsort((deviation, kept[rows]))][::-1]
        nearest[kept[order]] = order  # the last one written is the nearest
        first[rows] = nearest[kept[rows]]
    group = _chained(points.T, within)
    n_together = np.bincount(np.unique(group * shapes.n_shapes + parts) // shapes.n_shapes)
    in_company = n_together[group[:: shapes.n_turns]] > 1  # others are near to themselves only
    for part in np.flatnonzero(in_company).tolist():
        if ungrouped[part]:
            ungrouped[: part + 1] = False  # those before it are visited, or have nothing near to their first turn
            hits = near(points[part * shapes.n_turns])
            if len(hits):
                own = shapes.at(np.array([part]), np.array([0]), np.arange(shapes.n_corners))[0]
                first[join(hits, own)] = part
    return first, turn, kept


def _deviations(shapes: TurnedShapes, parts: IntArray, turns: IntArray, own: FloatArray) -> FloatArray:
    """(q,) largest deviation of these shapes (q,) in these turns (q,) from those with corners (q, n_corners, d)."""
    found, corners = np.zeros(len(parts)), np.arange(shapes.n_corners)
    size = max(1, MAX_COORDINATES_IN_MEMORY // (3 * shapes.n_corners))
    for some in (slice(start, start + size) for start in range(0, len(parts), size)):
        found[some] = np.abs(shapes.at(parts[some], turns[some], corners) - own[some]).max(axis=(1, 2))
    return found


def _as_before(
    shapes: TurnedShapes, within: float, earlier: FloatArray, before: IntArray, off_before: FloatArray, turn: IntArray
) -> tuple[IntArray, IntArray]:
    """The shapes that are within the tolerance of the earlier shape that they had, and those that are beyond it by no
    more than they were off before, or than the tolerance; the best turns of both are written into turn (P,)."""
    rows = np.flatnonzero(before >= 0)
    if shapes.n_turns * shapes.n_corners > MOST_TURNED_CORNERS or not len(rows):
        return rows[:0], rows[:0]
    every = np.repeat(rows, shapes.n_turns), np.tile(np.arange(shapes.n_turns), len(rows))
    deviation = _deviations(shapes, *every, earlier[before[every[0]]]).reshape(len(rows), shapes.n_turns)
    least = deviation.min(axis=1)
    same = least <= within + np.minimum(off_before[rows], within)
    turn[rows[same]] = (deviation[same] <= least[same, None] + SAME_DEVIATION * within).argmax(axis=1)
    return rows[least <= within], rows[same & (least > within)]


def _near_to_all(shapes: TurnedShapes, within: float, group: IntArray, turn: IntArray, some: IntArray) -> BoolArray:
    """Which of some shapes differ by at most twice the tolerance, in each coordinate, from all others of their group
    (P,), each in its turn (P,)."""
    groups = np.unique(group[some])
    rows = np.flatnonzero(np.isin(group, groups))
    number, corners = np.searchsorted(groups, group[rows]), np.arange(shapes.n_corners)
    points = shapes.at(rows, turn[rows], corners)
    low, high = (np.full((len(groups), *points.shape[1:]), bound) for bound in (np.inf, -np.inf))
    np.minimum.at(low, number, points)
    np.maximum.at(high, number, points)
    own, place = np.searchsorted(groups, group[some]), np.searchsorted(rows, some)
    off = np.maximum(high[own] - points[place], points[place] - low[own])
    near: BoolArray = off.max(axis=(1, 2), initial=0.0) <= 2 * within
    return near


def _best_first(hits: IntArray, n_turns: int, deviation: FloatArray, within: float) -> IntArray:
    """Hits, numbers of turned shapes (shape * n_turns + turn), shape by shape: the smallest turn of those that deviate
    least comes first."""
    if not len(hits):
        return hits
    shape, own = np.unique(hits // n_turns, return_inverse=True)
    least = np.full(len(shape), np.inf)
    np.minimum.at(least, own, deviation)
    is_worse = deviation > least[own] + SAME_DEVIATION * within
    return hits[np.lexsort((hits, is_worse, own))]


def _near_in_all_corners(shapes: TurnedShapes, own: FloatArray, hits: IntArray, within: float) -> IntArray:
    """For each shape, one of its hits at which all corners are `within` of those given (n_corners, d), that with the
    least deviation in a few of them.

    hits: numbers of turned shapes, shape * n_turns + turn.
    """

    def deviations(some: IntArray, corners: IntArray) -> FloatArray:
        turned = shapes.at(some // shapes.n_turns, some % shapes.n_turns, corners)
        found: FloatArray = np.abs(turned - own[corners]).max(axis=(1, 2))
        return found

    corners = np.arange(shapes.n_corners)
    # a round outline in a wrong turn deviates most where its bend differs from that of other corners
    bends = np.square(own[2:] - 2 * own[1:-1] + own[:-2]).sum(axis=1)
    unusual = 1 + np.argsort(-np.abs(bends - np.median(bends)), kind="stable")[:TREE_CORNERS]
    deviation = deviations(hits, unusual)
    near = deviation <= within
    hits = _best_first(hits[near], shapes.n_turns, deviation[near], within)
    batch_size = max(1, MAX_COORDINATES_IN_MEMORY // (3 * shapes.n_corners))
    equal = [np.zeros(0, dtype=np.int64)]
    while len(hits):
        # the best remaining turn of each shape, for as many shapes as memory allows
        best = np.unique(hits // shapes.n_turns, return_index=True)[1][:batch_size]
        equal.append(hits[best[deviations(hits[best], corners) <= within]])
        hits = np.delete(hits, best)
        hits = hits[~np.isin(hits // shapes.n_turns, equal[-1] // shapes.n_turns)]
    return np.concatenate(equal)
