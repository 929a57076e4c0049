"""The order in which a structure goes up: zone by zone, in each from its supports, ring by ring.

A beam *brings* a node where only its other node stands yet. A *closing* beam comes last between two nodes that stand;
only it has to fit between two fixed facets. Which beams close is a choice: each ring is joined to those before it by a
spanning forest of the beams that would need the largest gaps. Nodes of earlier zones stand from the beginning.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

from fabkit.kinds import BASE_PLATE, BEAM, FIN, NODE, PANEL, STRUT, STUB, NodeDetails, PanelDetails
from fabkit.parts import Assembly, Parts
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh.spanning_forests import spanning_forest

__all__ = ["Erection", "erection_order"]


class _Stage(IntEnum):
    """What goes up one after the other in a zone."""

    SUPPORTS = 0
    FRAME = 1
    PANELS = 2
    FINS = 3
    OTHERS = 4


@dataclass(frozen=True, eq=False)
class Erection:
    """The order of erection, counted from 1.

    numbers: by the name of a group, the number (n,) of each of its parts; those with the same number go up together: a
    beam and the node that it brings, with what is fixed to them; a stub and its base plate; the panes of a layer over a
    face. is_closing: by groups of beams, which (n,) of them come last between two nodes that stand. n_fixed: number of
    nodes of the first layer of beams that stand from the beginning. propped (k,): mesh vertices of those of them that
    hang in the air: they have neither a support, where there are any, nor a node of an earlier zone to join, nor, where
    there are none, a boundary on which they could stand.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.production import erection_order
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> erection = erection_order(built.assembly)
    >>> erection.n_fixed, erection.is_closing["beams"].sum().item(), 30 - 18 + 1
    (1, 13, 13)
    >>> bool(erection.numbers["beams"].max() < erection.numbers["panels"].min())
    True
    """

    numbers: Mapping[str, IntArray]
    is_closing: Mapping[str, BoolArray]
    n_fixed: int
    propped: IntArray


def erection_order(assembly: Assembly, supports: IntArray | None = None) -> Erection:
    """The order in which the parts go up, as early as their nodes stand.

    In each zone the supports come first; then the layer of beams in which these are, or else the inner one, ring by
    ring; struts; the other layer of beams; layers of panels, from the beams outwards, then those inside; fins.

    supports: mesh vertices of nodes that stand from the beginning, by default those with base plates. A part of a zone
    without any, and without a node of an earlier zone, begins with the lowest node of its lowest boundary, and with
    this boundary as first ring; where it has none, with its lowest node.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.production import erection_order
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> erection = erection_order(built.assembly, np.arange(12, 18))
    >>> erection.n_fixed, erection.is_closing["beams"].sum().item(), 30 - (18 - 6)
    (6, 18, 18)
    """
    layers = sorted(assembly.of_layers(NODE), key=lambda nodes: nodes.kind.layer != "lower")
    walks = {nodes.kind.layer: _walk(assembly, nodes, supports) for nodes in layers}
    steps = {parts.kind.group: _steps(parts, assembly, walks) for parts in assembly.groups}
    every = np.concatenate([np.zeros((0, 5), dtype=np.int64), *steps.values()])
    number = np.unique(every, axis=0, return_inverse=True)[1].ravel() + 1
    ends = np.cumsum([len(own) for own in steps.values()])
    numbers = dict(zip(steps, np.split(number, ends[:-1]), strict=True)) if steps else {}
    beams = [assembly.beside(nodes, BEAM) for nodes in layers]
    closing = {own.kind.group: walks[own.kind.layer].closing for own in beams}
    return Erection(numbers, closing, walks[""].n_fixed, walks[layers[0].kind.layer].propped)


def _steps(parts: Parts[Any], assembly: Assembly, walks: Mapping[str, _Walk]) -> IntArray:
    """(n, 5) what orders these parts: zone, stage, layer, place in it, and the face of those that lie on one."""
    kind, layers = parts.kind, list(walks)
    inner, panelled = walks[layers[0]], walks[""]
    stage, layer, place, own = _Stage.OTHERS, np.array(0), parts.elements, np.array(0)
    if kind is BASE_PLATE or kind is STUB:
        stage, place = _Stage.SUPPORTS, inner.of_vertices(parts.elements)
    elif kind is STRUT:
        stage, layer, place = _Stage.FRAME, np.array(1), inner.of_vertices(parts.elements)
    elif kind is PANEL:
        stage, layer, place = _Stage.PANELS, _layers_of_panels(parts, assembly), panelled.after_beams(parts)
        own = parts.elements
    elif kind is FIN:
        stage, place = _Stage.FINS, panelled.of_edges(parts.elements)
    elif kind.element != "face":
        name = kind.layer if kind.layer in walks else ""
        stage, layer, walk = _Stage.FRAME, np.array(2 * layers.index(name)), walks[name]
        place = walk.of_edges(parts.elements) if kind.element == "edge" else walk.of_vertices(parts.elements)
    each = np.broadcast_arrays(assembly.zones.of(parts), int(stage), layer, place, own)
    return np.stack(each, axis=1).astype(np.int64)


@dataclass(frozen=True, eq=False)
class _Walk:
    """The order in a layer of beams. vertices (n,), ascending, and the places of their nodes, counted from 1; the same
    of edges (m,); a beam that brings a node has its place. closing (m,): in the order of the beams."""

    vertices: IntArray
    node_places: IntArray
    edges: IntArray
    beam_places: IntArray
    closing: BoolArray
    n_fixed: int
    propped: IntArray

    def of_vertices(self, elements: IntArray) -> IntArray:
        return _found(self.vertices, self.node_places, elements)

    def of_edges(self, elements: IntArray) -> IntArray:
        return _found(self.edges, self.beam_places, elements)

    def after_beams(self, panels: Parts[PanelDetails]) -> IntArray:
        """(n,) the place of the last beam around each panel, 0 without one."""
        around = panels.details.beams
        known = np.isin(around.values, self.edges)
        last = around.with_values(np.where(known, self.of_edges(around.values), 0))
        return np.asarray(last.reduced(np.maximum, empty=0))


def _found(known: IntArray, places: IntArray, elements: IntArray) -> IntArray:
    """The places of elements, after all others where they have none."""
    if not len(known):
        return np.ones(len(elements), dtype=np.int64)
    at = np.minimum(np.searchsorted(known, elements), len(known) - 1)
    return np.where(known[at] == elements, places[at], places.max() + 1)


def _walk(assembly: Assembly, nodes: Parts[NodeDetails], supports: IntArray | None) -> _Walk:
    beams, zones = assembly.beside(nodes, BEAM), assembly.zones
    order = np.argsort(beams.elements)
    edges, gaps = beams.elements[order], np.nan_to_num(beams.details.going_in_gaps_mm[order, 0])
    vertices = np.unique(np.concatenate([nodes.elements, beams.details.nodes.ravel()]))
    n, n_zones = len(vertices), max(1, len(zones.names))
    zone, own_zone = np.zeros(n, dtype=np.int64), np.zeros(len(edges), dtype=np.int64)
    if zones.names:
        zone, own_zone = zones.of_vertices[vertices], zones.of_edges[edges]
    ends = np.searchsorted(vertices, beams.details.nodes[order])
    ends = np.where(zone[ends] < own_zone[:, None], n + own_zone[:, None], ends)  # earlier zones are one node
    zone = np.r_[zone, np.arange(n_zones)]
    on_support = np.isin(vertices, assembly.of(BASE_PLATE).elements if supports is None else supports)
    standing = np.r_[on_support, np.ones(n_zones, dtype=bool)]
    is_rim = np.isnan(beams.details.dihedral_deg[order])
    first, fixed = _beginning(nodes, vertices, ends, is_rim, standing)
    can_stand = np.isin(np.arange(n), ends[is_rim]) | (not zones.names)
    propped = vertices[fixed[:n] & ~on_support & ~(can_stand & ~on_support.any())]
    ring, place = _rings(len(zone), ends, first)
    own_ring = ring[ends].max(axis=1, initial=0)
    stands = fixed[ends] | (ring[ends] < own_ring[:, None])
    joined = np.where(stands, len(zone) + own_ring[:, None], ends)
    brings = _spanning(joined, gaps, len(zone))
    depth = _depths(len(zone), len(zone) + int(ring.max()) + 1, joined[brings])
    depth[fixed] = 0
    rank = np.empty(len(zone), dtype=np.int64)
    rank[np.lexsort((place, depth, ring, zone))] = np.arange(len(zone))
    of_nodes, of_edges = _numbered(rank, rank[ends].max(axis=1, initial=0), np.flatnonzero(~brings))
    closing = np.empty(len(edges), dtype=bool)
    closing[order] = ~brings
    return _Walk(vertices, of_nodes[:n], edges, of_edges, closing, int(fixed[:n].sum()), propped)


def _numbered(rank: IntArray, later: IntArray, closing: IntArray) -> tuple[IntArray, IntArray]:
    """Numbers of the nodes (n,) and of the edges (m,), counted from 1. rank (n,): order of the nodes; later (m,): rank
    of the later node of each edge, after which those follow that are closing, by their indices."""
    n = len(rank)
    steps = np.lexsort((np.r_[np.zeros(n), closing + 1], np.r_[rank, later[closing]]))
    number = np.empty(len(steps), dtype=np.int64)
    number[steps] = np.arange(1, len(steps) + 1)
    of_edges = number[np.argsort(rank)][later]
    of_edges[closing] = number[n:]
    return number[:n], of_edges


def _beginning(
    nodes: Parts[NodeDetails], vertices: IntArray, ends: IntArray, is_rim: BoolArray, standing: BoolArray
) -> tuple[BoolArray, BoolArray]:
    """(n,) the nodes of the first ring, and those that stand from the beginning. vertices (k,): of the nodes, before
    those that stand for earlier zones; standing (n,): nodes on supports, or of earlier zones."""
    n, of_node = len(standing), nodes.find(vertices)
    level = np.full(n, np.inf)
    level[: len(vertices)] = np.where(of_node >= 0, np.append(nodes.origins[:, 2], np.inf)[of_node], np.inf)
    first, fixed = standing.copy(), standing.copy()
    component = _components(n, ends)
    without = ~np.isin(component, component[fixed])
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


def _layers_of_panels(panels: Parts[PanelDetails], assembly: Assembly) -> IntArray:
    """(n,) when the layer of each panel goes up: those outside the beams from the inner to the outer one, then those
    inside from the outer to the inner one."""
    layer, around, beams = panels.details.layer, panels.details.beams, assembly.of(BEAM)
    if not len(panels) or not len(beams):
        return np.zeros(len(panels), dtype=np.int64)
    met = beams.find(around.values)
    apart = np.einsum("nk,nk->n", panels.centres_mm[around.row] - beams.centres_mm[met], panels.axes[around.row, 2])
    counts = np.bincount(layer[around.row], weights=met >= 0)
    heights = np.bincount(layer[around.row], weights=np.where(met >= 0, apart, 0.0)) / np.maximum(counts, 1)
    rank = np.empty(len(heights), dtype=np.int64)
    rank[np.lexsort((np.abs(heights), heights < 0))] = np.arange(len(heights))
    return rank[layer]
