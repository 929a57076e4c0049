"""The order in which a structure goes up: from its supports, ring by ring.

A beam *brings* a node where only its other node stands yet. A *closing* beam comes last between two nodes that stand;
only it has to fit between two fixed facets. Which beams close is a choice: each ring is joined to those before it by a
spanning forest of the beams that would need the largest gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

from fabkit.kinds import BASE_PLATE, BEAM, NODE, PANEL, BeamDetails
from fabkit.parts import Assembly, Parts
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh.spanning_forests import spanning_forest

__all__ = ["Erection", "erection_order"]


@dataclass(frozen=True, eq=False)
class Erection:
    """The order of erection, counted from 1.

    vertices, of_vertices (n,): the mesh vertices with nodes, ascending, and their numbers. edges, of_edges, is_closing
    (m,): the same of the beams; a beam that brings a node has the number of that node. faces, of_faces (f,): of the
    panels, which follow when all beams are in place. n_fixed: number of nodes that stand from the beginning.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.production import erection_order
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> erection = erection_order(built.assembly)
    >>> erection.n_fixed, erection.is_closing.sum().item(), 30 - 18 + 1
    (1, 13, 13)
    >>> bool(erection.of(built.assembly["beams"]).max() < erection.of(built.assembly["panels"]).min())
    True
    """

    vertices: IntArray
    of_vertices: IntArray
    edges: IntArray
    of_edges: IntArray
    is_closing: BoolArray
    faces: IntArray
    of_faces: IntArray
    n_fixed: int

    def of(self, parts: Parts[Any]) -> IntArray:
        """(n,) the numbers of these parts: those of the node, beam or panel at their mesh elements; 0 without one."""
        known, numbers = {
            "vertex": (self.vertices, self.of_vertices),
            "edge": (self.edges, self.of_edges),
            "face": (self.faces, self.of_faces),
        }[parts.kind.element]
        if not len(known):
            return np.zeros(len(parts), dtype=np.int64)
        place = np.minimum(np.searchsorted(known, parts.elements), len(known) - 1)
        return np.where(known[place] == parts.elements, numbers[place], 0)

    def closing(self, beams: Parts[BeamDetails]) -> BoolArray:
        """(n,) which of these beams come last between two nodes that stand."""
        place = np.searchsorted(self.edges, beams.elements)
        return np.asarray(self.is_closing[place])


def erection_order(assembly: Assembly, supports: IntArray | None = None) -> Erection:
    """The order in which the parts go up, as early as their nodes stand.

    supports: mesh vertices of nodes that stand from the beginning, by default those with base plates. A part of the
    structure without any begins with the lowest node of its lowest boundary, and with this boundary as first ring;
    where it has none, with its lowest node.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.production import erection_order
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> erection = erection_order(built.assembly, np.arange(12, 18))
    >>> erection.n_fixed, erection.is_closing.sum().item(), 30 - (18 - 6)
    (6, 18, 18)
    """
    beams, nodes = assembly.of(BEAM), assembly.of(NODE)
    order = np.argsort(beams.elements)
    edges, gaps = beams.elements[order], np.nan_to_num(beams.details.going_in_gaps_mm[order, 0])
    vertices = np.unique(np.concatenate([nodes.elements, beams.details.nodes.ravel()]))
    ends = np.searchsorted(vertices, beams.details.nodes[order])
    first, fixed = _beginning(assembly, vertices, ends, order, supports)
    ring, place = _rings(len(vertices), ends, first)
    own_ring = ring[ends].max(axis=1, initial=0)
    n, stands = len(vertices), fixed[ends] | (ring[ends] < own_ring[:, None])
    joined = np.where(stands, n + own_ring[:, None], ends)
    brings = _spanning(joined, gaps, n)
    depth = _depths(n, n + int(ring.max(initial=0)) + 1, joined[brings])
    depth[fixed] = 0
    rank = np.empty(n, dtype=np.int64)
    rank[np.lexsort((place, depth, ring))] = np.arange(n)
    later = rank[ends].max(axis=1, initial=0)
    closing = np.flatnonzero(~brings)
    steps = np.lexsort((np.r_[np.zeros(n), closing + 1], np.r_[rank, later[closing]]))
    number = np.empty(len(steps), dtype=np.int64)
    number[steps] = np.arange(1, len(steps) + 1)
    of_edges = number[np.argsort(rank)][later] if n else later
    of_edges[closing] = number[n:]
    faces, of_faces = _panels(assembly, edges, of_edges, len(steps))
    return Erection(vertices, number[:n], edges, of_edges, ~brings, faces, of_faces, int(fixed.sum()))


def _beginning(
    assembly: Assembly, vertices: IntArray, ends: IntArray, order: IntArray, supports: IntArray | None
) -> tuple[BoolArray, BoolArray]:
    """(n,) the nodes of the first ring, and those that stand from the beginning."""
    n, nodes = len(vertices), assembly.of(NODE)
    of_node = nodes.find(vertices)
    level = np.where(of_node >= 0, np.append(nodes.origins[:, 2], 0.0)[of_node], np.inf)
    fixed = np.isin(vertices, assembly.of(BASE_PLATE).elements if supports is None else supports)
    first = fixed.copy()
    component = _components(n, ends)
    without = ~np.isin(component, component[fixed])
    is_rim = np.isnan(assembly.of(BEAM).details.dihedral_deg[order])
    on_rim = np.zeros(n, dtype=bool)
    on_rim[ends[is_rim]] = True
    rim = np.where(on_rim, _components(n, ends[is_rim]), -1)
    counts = np.bincount(rim[on_rim], minlength=n)
    means = np.bincount(rim[on_rim], weights=level[on_rim], minlength=n) / np.maximum(counts, 1)
    key = np.where(on_rim, means[rim], np.inf)
    chosen = _first_of_each(component, (level, key), without)
    fixed[chosen] = True
    is_chosen = np.zeros(n + 1, dtype=bool)
    is_chosen[rim[chosen[on_rim[chosen]]]] = True
    first |= fixed | on_rim & is_chosen[rim] & without
    return first, fixed


def _first_of_each(component: IntArray, keys: tuple[FloatArray, FloatArray], among: BoolArray) -> IntArray:
    """The node of each component with the smallest keys, the last one first, of those that count."""
    order = np.lexsort((*keys, component))
    order = order[among[order]]
    return np.asarray(order[np.diff(component[order], prepend=-1) != 0])


def _components(n: int, pairs: IntArray) -> IntArray:
    graph = coo_array((np.ones(len(pairs)), pairs.T.reshape(2, -1)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _rings(n: int, ends: IntArray, first: BoolArray) -> tuple[IntArray, IntArray]:
    """(n,) number of beams from each node to the first ring, and its place in the order of the walk outwards."""
    starts = np.flatnonzero(first)
    rooted = np.concatenate([ends, np.stack([np.full(len(starts), n), starts], axis=1)])
    ring, place, done = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64), 0
    for k, level in enumerate(spanning_forest(n + 1, rooted, start=n).levels):
        ring[level.children], place[level.children] = k, done + np.arange(len(level.children))
        done += len(level.children)
    return ring, place


def _spanning(joined: IntArray, gaps: FloatArray, n_nodes: int) -> BoolArray:
    """(m,) the beams of a spanning forest with the largest sum of gaps (m,), preferably beams from earlier rings where
    no gap is needed. joined (m, 2): their nodes, those of earlier rings as one, numbered from n_nodes on."""
    n, largest = int(joined.max(initial=0)) + 1, gaps.max(initial=0.0)
    low, high = joined.min(axis=1, initial=n), joined.max(axis=1, initial=0)
    costs = np.where(gaps > 0, 1 + largest - gaps, np.where(high < n_nodes, 3 + largest, 2 + largest))
    order = np.lexsort((costs, high, low))
    order = order[(low < high)[order]]
    pairs = low[order] * n + high[order]
    is_first = np.diff(pairs, prepend=-1) != 0
    kept, pairs = order[is_first], pairs[is_first]
    tree = minimum_spanning_tree(coo_array((costs[kept], (low[kept], high[kept])), shape=(n, n)).tocsr()).tocoo()
    brings = np.zeros(len(joined), dtype=bool)
    brings[kept[np.isin(pairs, tree.row.astype(np.int64) * n + tree.col)]] = True
    return brings


def _depths(n: int, n_all: int, tree: IntArray) -> IntArray:
    """(n,) number of beams (k, 2) of the forest between each node and those of earlier rings, numbered from n on."""
    roots = np.arange(n, n_all)
    rooted = np.concatenate([tree, np.stack([np.full(len(roots), n_all), roots], axis=1)])
    depth = np.zeros(n_all + 1, dtype=np.int64)
    for k, level in enumerate(spanning_forest(n_all + 1, rooted, start=n_all).levels):
        depth[level.children] = k
    return depth[:n]


def _panels(assembly: Assembly, edges: IntArray, of_edges: IntArray, done: int) -> tuple[IntArray, IntArray]:
    """The faces with panels, and their numbers after the `done` ones before: in the order of the last of their
    beams."""
    panels = assembly.of(PANEL)
    around = panels.details.beams
    place = np.minimum(np.searchsorted(edges, around.values), max(len(edges) - 1, 0))
    known = edges[place] == around.values if len(edges) else np.zeros(len(place), dtype=bool)
    last = around.with_values(np.where(known, np.append(of_edges, 0)[place], 0)).reduced(np.maximum, empty=0)
    faces, first = np.unique(panels.elements, return_index=True)
    numbers = np.empty(len(faces), dtype=np.int64)
    numbers[np.argsort(last[first], kind="stable")] = done + 1 + np.arange(len(faces))
    return faces, numbers
