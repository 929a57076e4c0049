"""A spanning forest of a graph, such as the vertices and edges of a mesh: breadth first, level by level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from geometry.arrays import IntArray, integers

__all__ = ["Level", "SpanningForest", "spanning_forest"]


@dataclass(frozen=True, eq=False)
class Level:
    """The vertices that are reached in one step: children (n,), their parents (n,) in the level before, and the edges
    (n,) between them."""

    parents: IntArray
    children: IntArray
    edges: IntArray


@dataclass(frozen=True, eq=False)
class SpanningForest:
    """roots (c,): a vertex of each component; components (N,): the component of each vertex; levels: from the roots
    outwards."""

    roots: IntArray
    components: IntArray
    levels: tuple[Level, ...]


def spanning_forest(n_vertices: int, edges: IntArray, *, start: int = 0) -> SpanningForest:
    """The forest over all vertices along edges (E, 2), breadth first.

    Several edges may join the same two vertices. The root of a component is its first vertex, or `start`. A vertex
    without edges is a separate component.
    """
    n = n_vertices
    ends = np.concatenate([edges, edges[:, ::-1]])
    graph = coo_array((np.ones(len(ends)), ends.T), shape=(n, n)).tocsr()
    components = connected_components(graph, directed=False)[1]
    roots = np.unique(components, return_index=True)[1]
    roots[components[start]] = start

    rooted = np.stack([np.full(len(roots), n), roots], axis=1)  # an additional vertex n is the parent of all roots
    rooted_ends = np.concatenate([ends, rooted])
    ones = np.ones(len(rooted_ends))
    order, parents = breadth_first_order(coo_array((ones, rooted_ends.T), shape=(n + 1, n + 1)).tocsr(), n)
    place = np.empty(n + 1, dtype=np.int64)
    place[order] = np.arange(n + 1)
    parent_places = place[parents[order[1:]]]  # ascending
    keys, any_edge = np.unique(edges.min(axis=1) * n + edges.max(axis=1), return_index=True)
    levels = []
    first, last = 1, 1 + len(roots)
    while last < n + 1:
        first, last = last, int(np.searchsorted(parent_places, last)) + 1
        children = order[first:last].astype(np.int64)
        level_parents = parents[children].astype(np.int64)
        pairs = np.minimum(level_parents, children) * n + np.maximum(level_parents, children)
        level_edges = any_edge[np.searchsorted(keys, pairs)]
        levels.append(Level(integers(level_parents), integers(children), integers(level_edges)))
    return SpanningForest(integers(roots), integers(components), tuple(levels))
