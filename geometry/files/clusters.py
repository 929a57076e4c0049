"""Points that are one: those joined by steps of at most a given reach. No slower where very many coincide."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from geometry.arrays import FloatArray, IntArray

__all__ = ["clusters_within", "joined"]


def joined(n: int, pairs: IntArray) -> IntArray:
    """(n,) number of the connected component of each of n things, of which pairs (m, 2) are connected."""
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def clusters_within(points: FloatArray, reach: float) -> IntArray:
    """(n,) number of the cluster of each point (n, 3): points at most `reach` apart are in one cluster.

    Points of one cell of space that is no wider than the reach belong together. What joins cells is looked for among
    those that are near, of which there are not many, and by a tree where they hold many points: the time grows as
    n log n, and memory as n, however many points lie at one place.
    """
    points, same = np.unique(points, axis=0, return_inverse=True)
    if reach <= 0 or len(points) < 2:
        return same.ravel()
    side = reach / 3**0.5 * (1 - 1e-9)  # the diagonal is the reach, whatever is rounded
    cells, cell = np.unique(np.floor((points - points.min(axis=0)) / side), axis=0, return_inverse=True)
    cell = cell.ravel()
    near = cKDTree(points[np.unique(cell, return_index=True)[1]])
    pairs = near.query_pairs(3 * reach, output_type="ndarray")  # a reach between, and a diagonal to either first point
    first = near.data
    touching = np.linalg.norm(first[pairs[:, 0]] - first[pairs[:, 1]], axis=1) <= reach
    label = joined(len(cells), pairs[touching])
    label = _with_full_cells(points, cell, pairs[~touching], label, reach)
    return np.asarray(label[cell][same.ravel()])


def _with_full_cells(points: FloatArray, cell: IntArray, pairs: IntArray, label: IntArray, reach: float) -> IntArray:
    """Labels (cells,) after cells are joined whose first points are apart, but others are not."""
    counts = np.bincount(cell)
    apart = (label[pairs[:, 0]] != label[pairs[:, 1]]) & (counts[pairs] > 1).any(axis=1)
    if not apart.any():
        return label
    order, ends = np.argsort(cell, kind="stable"), np.cumsum(counts)
    found = []
    for pair in pairs[apart].tolist():
        few, many = (points[order[ends[k] - counts[k] : ends[k]]] for k in sorted(pair, key=lambda k: counts[k]))
        if np.isfinite(cKDTree(many).query(few, distance_upper_bound=np.nextafter(reach, np.inf))[0]).any():
            found.append(pair)
    if not found:
        return label
    return joined(int(label.max()) + 1, label[np.array(found)])[label]
