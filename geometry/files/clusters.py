"""Clusters of points that are joined by steps of at most a given length, also where very many points coincide."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from geometry.arrays import FloatArray, IntArray

__all__ = ["clusters_within", "joined"]


def joined(n: int, pairs: IntArray) -> IntArray:
    """(n,) number of the connected component of each of n elements, of which pairs (m, 2) are connected."""
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def clusters_within(points: FloatArray, reach: float) -> IntArray:
    """(n,) number of the cluster of each point (n, 3): points at most `reach` apart are in one cluster.

    Space is divided into cubic cells whose diagonal is the reach, so that the points of one cell are in one cluster.
    Only neighbouring cells are compared, by a tree if they contain many points: time grows as n log n and memory as n,
    however many points coincide.
    """
    points, same = np.unique(points, axis=0, return_inverse=True)
    if reach <= 0 or len(points) < 2:
        return same.ravel()
    side = reach / 3**0.5 * (1 - 1e-9)  # the diagonal is at most the reach, also after rounding
    cells, cell = np.unique(np.floor((points - points.min(axis=0)) / side), axis=0, return_inverse=True)
    cell = cell.ravel()
    near = cKDTree(points[np.unique(cell, return_index=True)[1]])
    pairs = near.query_pairs(
        3 * reach, output_type="ndarray"
    )  # the reach between two points, plus a diagonal from each to the first point of its cell
    first = near.data
    touching = np.linalg.norm(first[pairs[:, 0]] - first[pairs[:, 1]], axis=1) <= reach
    label = joined(len(cells), pairs[touching])
    label = _with_full_cells(points, cell, pairs[~touching], label, reach)
    return np.asarray(label[cell][same.ravel()])


def _with_full_cells(points: FloatArray, cell: IntArray, pairs: IntArray, label: IntArray, reach: float) -> IntArray:
    """Labels (cells,) after cells are joined whose first points are farther apart than the reach, but others are
    not."""
    counts = np.bincount(cell)
    apart = (label[pairs[:, 0]] != label[pairs[:, 1]]) & (counts[pairs] > 1).any(axis=1)
    if not apart.any():
        return label
    order, ends = np.argsort(cell, kind="stable"), np.cumsum(counts)
    touching = []
    for pair in pairs[apart].tolist():
        fewer, more = (points[order[ends[k] - counts[k] : ends[k]]] for k in sorted(pair, key=lambda k: counts[k]))
        if np.isfinite(cKDTree(more).query(fewer, distance_upper_bound=np.nextafter(reach, np.inf))[0]).any():
            touching.append(pair)
    if not touching:
        return label
    return joined(int(label.max()) + 1, label[np.array(touching)])[label]
