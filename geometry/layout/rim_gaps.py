"""Numbers of lines along aligned boundaries and between these and singular vertices, which must not be zero."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from geometry.arrays import ComplexArray, FloatArray, IntArray, integers
from geometry.layout.seams import SeamlessMaps
from geometry.layout.singular_points import carried_rows, integer_rows, triangle_graph
from geometry.networks.combed_fields import CombedField
from geometry.networks.networks import Network
from geometry.optimise import SparseMatrix

__all__ = ["rim_gaps"]

RIM_DISTANCE = 3.0
"""Distance from an aligned boundary below which a singular vertex must be beside it by a line, in edge lengths."""

BESIDE_COSINE = 0.9
"""Cosine of the angle between a boundary edge and the vector to a vertex, below which the vertex is beside the edge."""

LEAST_LINES_AROUND = 3
"""Least number of lines that end at a closed boundary without corners: fewer make no face."""


def rim_gaps(network: Network, field: CombedField, maps: SeamlessMaps, edge_length: float) -> tuple[IntArray, IntArray]:
    """(k, m) matrix from the integers t of the maps to numbers of lines, and what each has to be at least (k,): along
    the straight stretches of aligned boundaries, and from these to singular vertices near them. Where such a number is
    rounded to zero, triangles have no area in (u, v).
    """
    halves = np.flatnonzero(maps.on_lines.any(axis=1))
    if not len(halves):
        return np.zeros((0, maps.integers.shape[1]), dtype=np.int64), np.zeros(0, dtype=np.int64)
    stretches, is_closed = _stretches(network, maps, halves)
    lengths, is_fixed = _lengths(network, maps, halves, stretches)
    least = np.where(is_closed, LEAST_LINES_AROUND, 1)
    distances = _singular_distances(network, field, maps, halves, stretches, edge_length)
    return (
        integers(np.concatenate([lengths[is_fixed], distances])),
        integers(np.concatenate([least[is_fixed], np.ones(len(distances), dtype=np.int64)])),
    )


def _coordinates(network: Network, halves: IntArray, vectors: ComplexArray) -> FloatArray:
    """(n, 2) components along the two directions of the network of vectors (n,) in the triangles of half-edges."""
    first, second = network.first[halves // 3], network.second[halves // 3]
    areas = (first.conj() * second).imag
    return np.stack([(vectors.conj() * second).imag / areas, (first.conj() * vectors).imag / areas], axis=1)


def _stretches(network: Network, maps: SeamlessMaps, halves: IntArray) -> tuple[IntArray, IntArray]:
    """(n,) the straight stretch of the boundary that each half-edge is part of, and which of them are closed."""
    c = network.frames.combinatorics
    along = np.where(maps.on_lines[halves, 0], 1, 0)
    place = np.full(c.n_vertices, -1)
    place[c.corners[halves]] = np.arange(len(halves))
    following = place[c.corners[c.next_corner[halves]]]
    is_real = np.diff(maps.reals.indptr) > 0  # where u or v at a corner need not be an integer
    goes_on = (following >= 0) & is_real[2 * c.next_corner[halves] + along]
    goes_on[goes_on] = is_real[2 * halves[following[goes_on]] + along[following[goes_on]]]
    n, here = len(halves), np.flatnonzero(goes_on)
    graph = coo_array((np.ones(len(here)), (here, following[here])), shape=(n, n))
    label = connected_components(graph, directed=False)[1].astype(np.int64)
    return label, np.bincount(label, ~goes_on) == 0


def _lengths(network: Network, maps: SeamlessMaps, halves: IntArray, stretches: IntArray) -> tuple[IntArray, IntArray]:
    """(k, m) the numbers of lines that end at the stretches, and which of them the integers alone determine."""
    along = np.where(maps.on_lines[halves, 0], 1, 0)
    sides = network.frames.sides.ravel()[halves]
    signs = np.sign(_coordinates(network, halves, sides)[np.arange(len(halves)), along])
    n = len(halves)
    sums = csr_array(coo_array((signs, (stretches, np.arange(n))), shape=(stretches.max() + 1, n)))
    ends = 2 * network.frames.combinatorics.next_corner[halves] + along, 2 * halves + along

    def summed(rows: SparseMatrix) -> SparseMatrix:
        return csr_array(sums @ csr_array(rows[ends[0]] - rows[ends[1]]))

    reals: FloatArray = abs(summed(maps.reals)).sum(axis=1)
    return np.rint(summed(maps.integers).toarray()).astype(np.int64), np.asarray(reals == 0)


def _singular_distances(
    network: Network,
    field: CombedField,
    maps: SeamlessMaps,
    halves: IntArray,
    stretches: IntArray,
    edge_length: float,
) -> IntArray:
    """(k, m) the numbers of lines from stretches of the boundary inwards to singular vertices beside them."""
    frames, c = network.frames, network.frames.combinatorics
    points = frames.mesh.vertices
    tails, heads = points[c.corners[halves]], points[c.corners[c.next_corner[halves]]]
    constant = np.where(maps.on_lines[halves, 0], 0, 1)
    inwards = np.sign(_coordinates(network, halves, 1j * frames.sides.ravel()[halves]))
    corner = np.zeros(c.n_vertices, dtype=np.int64)
    corner[c.corners] = np.arange(c.n_corners)
    rows, graph, limit = maps.integers.tocsr(), triangle_graph(frames), RIM_DISTANCE * edge_length
    found = [np.zeros((0, rows.shape[1]), dtype=np.int64)]
    for vertex in np.flatnonzero(field.indices).tolist():
        offsets = points[vertex] - (tails + heads) / 2
        distances = np.linalg.norm(offsets, axis=1)
        lengths = distances * np.linalg.norm(heads - tails, axis=1)
        is_beside = np.abs(np.einsum("ni,ni->n", offsets, heads - tails)) < BESIDE_COSINE * lengths
        near = np.flatnonzero(is_beside & (distances < limit))
        near = near[np.argsort(distances[near], kind="stable")]
        for k in near[np.unique(stretches[near], return_index=True)[1]].tolist():
            half = int(halves[k])
            reached, paths = dijkstra(
                graph, directed=False, indices=halves[k] // 3, return_predecessors=True, limit=2 * limit
            )
            if not np.isfinite(reached[corner[vertex] // 3]):
                continue
            there = carried_rows(frames, field, rows, integers(paths), int(corner[vertex]))
            across = there - integer_rows(rows, np.array([half]))[0]
            found.append(inwards[k, constant[k]] * across[None, :, constant[k]])
    return integers(np.rint(np.concatenate(found)).astype(np.int64))
