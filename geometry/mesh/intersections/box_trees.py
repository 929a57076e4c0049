"""Pairs of many small point sets that may meet, found by binary trees of oriented boxes.

For slender sets that are oblique to the coordinate axes, boxes along these axes would all overlap; boxes along the
principal axes of the sets do not [Gottschalk1996]. Sets that share a point always meet. Shared points can be given
names, and whole branches with a common name are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["BoxTree", "box_trees", "meeting_sets"]

PAIRS_AT_ONCE = 2**15
"""Pairs of boxes or polygons that are compared at once: they bound the memory."""

PARALLEL_AXES_MARGIN = 1e-10
"""Added to cosines, so that the rounded cross product of nearly parallel axes never separates two boxes."""


@dataclass(frozen=True, eq=False)
class _Level:
    """m boxes: centres (m, 3), axes (m, 3, 3) in rows, half extents along these axes (halves) and along x, y, z
    (upright), (m, 3) each. starts (m+1,): box k contains the boxes starts[k] .. starts[k+1] - 1 of the next level.
    names (m, 2): the names that all sets in the box share, -1 for none.
    """

    starts: IntArray
    centres: FloatArray
    axes: FloatArray
    halves: FloatArray
    upright: FloatArray
    names: IntArray


@dataclass(frozen=True, eq=False)
class BoxTree:
    """levels: from one box around everything to one box for each set; order (n,): the sets in the order of the last
    level."""

    levels: list[_Level]
    order: IntArray


def box_trees(points: FloatArray, starts: IntArray, margins: FloatArray, names: IntArray) -> list[BoxTree]:
    """One tree of the sets with names and one of those without, of n sets that are not empty.

    points (C, 3): set k has points[starts[k]:starts[k + 1]]; starts (n+1,). margins (n,): distances by which
    sets extend beyond their convex hulls. names (n, 2): names, >= 0, of up to two points of each set that belong to
    very many sets; -1 for none.
    """
    means = np.add.reduceat(points, starts[:-1], axis=0) / np.diff(starts)[:, None]
    groups = np.unique(np.sort(names, axis=1), axis=0, return_inverse=True)[1].ravel()
    middles = np.stack([np.bincount(groups, x) for x in means.T], axis=1) / np.bincount(groups)[:, None]
    named: BoolArray = np.any(names >= 0, axis=1)
    keys = np.stack([np.where(named[:, None], middles[groups], 0.0), means])  # sets with names in common stay together
    kinds = (np.flatnonzero(named), np.flatnonzero(~named))
    return [_box_tree(points, starts, margins, names, keys, order) for order in kinds if len(order)]


def _box_tree(
    points: FloatArray, starts: IntArray, margins: FloatArray, names: IntArray, keys: FloatArray, order: IntArray
) -> BoxTree:
    """The tree of the sets in `order`; keys (2, n, 3): points by which they are sorted, as in `_halved`."""
    n, found = len(order), []
    depth = n.bit_length() - 1
    for level in range(depth + 1):
        bounds = (np.arange(2**level + 1) * n) >> level
        boxes = _boxes(points, starts, margins, order, bounds)
        found.append((2 * np.arange(2**level + 1) if level < depth else bounds, boxes))
        if level < depth:
            ends = (np.arange(2 ** (level + 1) + 1) * n) >> (level + 1)
            order = _halved(points, starts, keys, boxes[1], order, ends)
    shared = names[order]
    levels = [_Level(np.arange(n + 1), *_boxes(points, starts, margins, order, np.arange(n + 1)), shared)]
    for following, boxes in found[::-1]:
        shared = _in_common(shared[following[:-1]], shared[following[1:] - 1])
        levels.append(_Level(following, *boxes, shared))
    return BoxTree(levels[::-1], order)


def meeting_sets(ones: list[BoxTree], others: list[BoxTree]) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs (k,) of a set of the first trees and a set of the other trees whose boxes meet and that share no name, part
    by part."""
    for one in ones:
        for other in others:
            yield from _meeting(one, other)


def _meeting(one: BoxTree, other: BoxTree) -> Iterator[tuple[IntArray, IntArray]]:
    last = len(one.levels) - 1, len(other.levels) - 1
    root = np.zeros(1, dtype=np.int64)
    parts = [(0, 0, root, root)]
    while parts:
        i, j, first, second = parts.pop()
        meet = _meet(one.levels[i], other.levels[j], first, second)
        first, second = first[meet], second[meet]
        remaining = last[0] - i, last[1] - j
        if remaining == (0, 0):
            yield one.order[first], other.order[second]
            continue
        if remaining[0] >= remaining[1]:
            first, again = _within(one.levels[i].starts, first)
            second, i = second[again], i + 1
        if remaining[1] >= remaining[0]:
            second, again = _within(other.levels[j].starts, second)
            first, j = first[again], j + 1
        pieces = range(0, len(first), PAIRS_AT_ONCE)
        parts += [
            (i, j, first[start : start + PAIRS_AT_ONCE], second[start : start + PAIRS_AT_ONCE]) for start in pieces
        ]


def _within(starts: IntArray, boxes: IntArray) -> tuple[IntArray, IntArray]:
    """The boxes (n,) of the next level within boxes (k,), and the index into `boxes` (n,) for each."""
    counts = starts[boxes + 1] - starts[boxes]
    owner = np.repeat(np.arange(len(boxes)), counts)
    before = np.cumsum(counts) - counts
    return starts[boxes][owner] + np.arange(len(owner)) - before[owner], owner


# --- boxes


def _boxes(
    points: FloatArray, starts: IntArray, margins: FloatArray, order: IntArray, bounds: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Centres, axes, half extents along them and along x, y, z of boxes: box k is around the sets
    order[bounds[k] : bounds[k+1]]."""
    places, _ = _within(starts, order)
    first = np.concatenate([[0], np.cumsum(np.diff(starts)[order])])[bounds]
    count = np.diff(first)
    means = np.add.reduceat(points[places], first[:-1], axis=0) / count[:, None]
    here = points[places] - np.repeat(means, count, axis=0)
    spread = np.add.reduceat(here[:, :, None] * here[:, None, :], first[:-1], axis=0) / count[:, None, None]
    axes = np.linalg.eigh(spread)[1].swapaxes(1, 2)
    along = np.einsum("cai,ci->ca", np.repeat(axes, count, axis=0), here)
    low, high = (extreme.reduceat(along, first[:-1]) for extreme in (np.minimum, np.maximum))
    centres = means + np.einsum("mai,ma->mi", axes, (low + high) / 2)
    halves = (high - low) / 2 + np.maximum.reduceat(margins[order], bounds[:-1])[:, None]
    return centres, axes, halves, np.einsum("mai,ma->mi", np.abs(axes), halves)


def _halved(
    points: FloatArray, starts: IntArray, keys: FloatArray, axes: FloatArray, order: IntArray, ends: IntArray
) -> IntArray:
    """The sets in a new order (n,) within each box, so that the boxes around both halves become small.

    keys (2, n, 3): points by which sets are sorted along one of the axes (m, 3, 3) of their box, by the second where
    the first are equal; otherwise along an axis on which the first differ clearly. Each box contains consecutive sets
    of the given order (n,); the halves of box k begin at ends[2 k] and at ends[2 k + 1].
    """
    box = np.repeat(np.arange(len(axes)), np.diff(ends[::2]))
    places, owner = _within(starts, order)
    along = np.einsum("cai,ci->ca", axes[box[owner]], points[places])
    first = np.concatenate([[0], np.cumsum(np.diff(starts)[order])[:-1]])
    low, high = (extreme.reduceat(along, first, axis=0) for extreme in (np.minimum, np.maximum))
    from_first = keys[:, order] - keys[:, order[ends[:-1:2]]][:, box]  # exactly 0 where keys are equal
    sorting = np.einsum("nai,kni->akn", axes[box], from_first)
    orders = np.stack([np.lexsort((*by[::-1], box)) for by in sorting])
    spans = [extreme.reduceat(sorting[:, 0], ends[:-1:2], axis=1) for extreme in (np.maximum, np.minimum)]
    clear = spans[0] - spans[1] >= (spans[0] - spans[1]).max(axis=0) / 2
    sizes = []
    for found in orders:
        x, y, z = (np.maximum.reduceat(high[found], ends[:-1]) - np.minimum.reduceat(low[found], ends[:-1])).T
        sizes.append((x * y + y * z + z * x).reshape(-1, 2).sum(axis=1))
    best = np.where(clear, sizes, np.inf).argmin(axis=0)[box]
    return np.asarray(order[orders[best, np.arange(len(order))]])


def _in_common(one: IntArray, other: IntArray) -> IntArray:
    """(m, 2) the names of one (m, 2) that are in the other (m, 2), -1 elsewhere."""
    return np.where((one[:, :, None] == other[:, None, :]).any(axis=2), one, -1)


def _meet(one: _Level, other: _Level, first: IntArray, second: IntArray) -> BoolArray:
    """(k,) whether boxes of two levels meet and share no name."""
    between_centres = other.centres[second] - one.centres[first]
    meet: BoolArray = np.all(np.abs(between_centres) <= one.upright[first] + other.upright[second], axis=1)
    for column in (0, 1):
        name = one.names[first, column]
        meet &= (name < 0) | (name[:, None] != other.names[second]).all(axis=1)
    for separate in (_separated_by_face, _separated_by_edges):
        remaining = np.flatnonzero(meet)
        a, b = first[remaining], second[remaining]
        cosines = one.axes[a] @ other.axes[b].swapaxes(1, 2)
        along = np.einsum("kai,ki->ka", one.axes[a], between_centres[remaining])
        meet[remaining] = ~separate(
            cosines, np.abs(cosines) + PARALLEL_AXES_MARGIN, along, one.halves[a], other.halves[b]
        )
    return meet


def _separated_by_face(
    cosines: FloatArray, size: FloatArray, along: FloatArray, a: FloatArray, b: FloatArray
) -> BoolArray:
    """(k,) whether a plane parallel to a face of either box separates them.

    cosines (k, 3, 3) between axes of both, and their absolute values; along (k, 3): from centre to centre, in the axes
    of the first box; half extents a, b (k, 3).
    """
    of_first = np.abs(along) > a + np.einsum("kij,kj->ki", size, b)
    of_second = np.abs(np.einsum("kij,ki->kj", cosines, along)) > b + np.einsum("kij,ki->kj", size, a)
    return np.asarray((of_first | of_second).any(axis=1))


def _separated_by_edges(
    cosines: FloatArray, size: FloatArray, along: FloatArray, a: FloatArray, b: FloatArray
) -> BoolArray:
    """(k,) whether a plane parallel to an edge of either box separates them, with the arguments of
    `_separated_by_face`."""
    following, before = [1, 2, 0], [2, 0, 1]
    distance = np.abs(along[:, before, None] * cosines[:, following] - along[:, following, None] * cosines[:, before])
    extreme = a[:, following, None] * size[:, before] + a[:, before, None] * size[:, following]
    extreme += b[:, None, following] * size[:, :, before] + b[:, None, before] * size[:, :, following]
    return np.asarray((distance > extreme).any(axis=(1, 2)))
