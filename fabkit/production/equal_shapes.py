"""Which of many shapes are equal, each of which may be seen in several turns; no step looks at all pairs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["TurnedShapes", "equal_shapes", "may_have_equals"]

TREE_CORNERS = 8
"""Number of corners, spread evenly, that are compared first: they distinguish most shapes; beams and quads have no
more."""
DISTANCE_LEVELS = 5
"""Number of distances of corners from their mean, from the least to the largest, that are compared before shapes are
rotated."""
DISTANCE_ROUNDING = 1e-13
"""Rounding error of distances within a shape, over its size: some hundred times the precision of double numbers."""
MAX_COORDINATES_IN_MEMORY = 4_000_000
"""Number of coordinates held in memory at a time: 32 MB."""


@dataclass(frozen=True, eq=False)
class TurnedShapes:
    """Shapes alike in their counts of turns and corners.

    at(shapes (q,), turns (q,), corners (c,)) -> (q, c, d): where these corners of each of these shapes are if it is
    seen in that turn.
    """

    n_shapes: int
    n_turns: int
    n_corners: int
    at: Callable[[IntArray, IntArray, IntArray], FloatArray]


def may_have_equals(corners: FloatArray, within: float) -> BoolArray:
    """(P,) whether solids with corners (P, n, 3) may be equal to another one of them.

    No turn changes the distances of the corners from their mean. Solids are linked where these are near; one that is
    linked to no other has no equal. Sorted for one distance after the other, all is n log n.
    """
    distances = np.sort(np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2), axis=1)
    levels = np.unique(np.linspace(0, distances.shape[1] - 1, DISTANCE_LEVELS).astype(np.int64))
    # corners that are off by `within` in each coordinate, and so is their mean
    largest = 2 * np.sqrt(3) * within + DISTANCE_ROUNDING * distances.max(initial=0.0)
    group = np.zeros(len(distances), dtype=np.int64)
    for values in (distances.mean(axis=1), *distances[:, levels].T):
        order = np.lexsort((values, group))
        begins = (np.diff(group[order]) > 0) | (np.diff(values[order]) > largest)
        group[order] = np.concatenate([[0], np.cumsum(begins)])[: len(order)]
    company: BoolArray = np.bincount(group)[group] > 1
    return company


def equal_shapes(shapes: TurnedShapes, within: float) -> tuple[IntArray, IntArray]:
    """The first shape to which each is equal (P,), itself where there is none, and the smallest turn in which it is.

    In their order, shapes that are equal to none before become the first of those equal to them: of all that come
    later, are not taken yet, and have each coordinate of each corner `within` its own in some turn. What is taken is
    no first, so that all deviate from their firsts by no more than that, however many are linked.
    """
    parts, turns = (index.ravel() for index in np.indices((shapes.n_shapes, shapes.n_turns)))
    probes = np.unique(np.linspace(0, shapes.n_corners - 1, TREE_CORNERS).astype(np.int64))
    points = shapes.at(parts, turns, probes).reshape(len(parts), -1)
    tree = cKDTree(points)
    first, turn = np.arange(shapes.n_shapes), np.zeros(shapes.n_shapes, dtype=np.int64)
    free = np.ones(shapes.n_shapes, dtype=bool)
    for part in range(shapes.n_shapes):
        if not free[part]:
            continue
        free[part] = False
        hits = np.sort(np.array(tree.query_ball_point(points[part * shapes.n_turns], within, p=np.inf), dtype=np.int64))
        hits = hits[free[parts[hits]]]
        if shapes.n_corners > TREE_CORNERS:
            hits = _near_in_all_corners(shapes, part, hits, within)
        equal, smallest = np.unique(parts[hits], return_index=True)
        first[equal], turn[equal], free[equal] = part, turns[hits[smallest]], False
    return first, turn


def _near_in_all_corners(shapes: TurnedShapes, part: int, hits: IntArray, within: float) -> IntArray:
    """The first of these numbers (of turns of shapes, sorted) of each shape that is `within` of the part as it is."""

    def off(some: IntArray, corners: IntArray) -> FloatArray:
        turned = shapes.at(some // shapes.n_turns, some % shapes.n_turns, corners)
        found: FloatArray = np.abs(turned - own[:, corners]).max(axis=(1, 2))
        return found

    corners = np.arange(shapes.n_corners)
    own = shapes.at(np.array([part]), np.array([0]), corners)
    # where the outline bends unlike elsewhere is where a round one in a wrong turn is found out
    bends = np.square(own[0, 2:] - 2 * own[0, 1:-1] + own[0, :-2]).sum(axis=1)
    unusual = 1 + np.argsort(-np.abs(bends - np.median(bends)), kind="stable")[:TREE_CORNERS]
    hits = hits[off(hits, unusual) <= within]
    at_once = max(1, MAX_COORDINATES_IN_MEMORY // (3 * shapes.n_corners))
    equal = [np.zeros(0, dtype=np.int64)]
    while len(hits):
        # the smallest turn that is left of each shape, for as many shapes as memory allows
        smallest = np.unique(hits // shapes.n_turns, return_index=True)[1][:at_once]
        equal.append(hits[smallest[off(hits[smallest], corners) <= within]])
        hits = np.delete(hits, smallest)
        hits = hits[~np.isin(hits // shapes.n_turns, equal[-1] // shapes.n_turns)]
    return np.concatenate(equal)
