"""Bores in solids that are made already."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.parts import Ragged, Solids, bore_vertices
from geometry.arrays import FloatArray, IntArray

__all__ = ["Bores", "bored_along_axis", "drilled"]

BLIND = -1
"""In place of the second face of a bore: it ends inside the solid."""


@dataclass(frozen=True, eq=False)
class Bores:
    """K bores with square ends. solids (K,): position of the solid; faces (K, 2): those where each begins and ends,
    the second one BLIND inside; starts, stops (K, 3): ends of the axes in mm, in the frames of the solids; radii (K,)
    in mm; across (K, 3): directions not along the axes, towards which the rims lie.

    >>> from fabkit.detailing.shapes.drilling import BLIND, Bores
    >>> x, z = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    >>> Bores(np.array([0]), np.array([[1, BLIND]]), 20 * z, 8 * z, np.array([4.0]), across=x).radii.tolist()
    [4.0]
    """

    solids: IntArray
    faces: IntArray
    starts: FloatArray
    stops: FloatArray
    radii: FloatArray
    across: FloatArray


def drilled(solids: Solids, bores: Bores) -> Solids:
    """The solids with these bores, in their order. Solids of one topology with bores in the same faces share one.

    >>> from fabkit.detailing.shapes.drilling import BLIND, Bores, drilled
    >>> from fabkit.parts import Ragged, Solids
    >>> square = Ragged.of([[[-30, -30], [30, -30], [30, 30], [-30, 30]]], shape=(2,))
    >>> block = Solids.prisms(square, np.zeros(1), np.full(1, 20.0))
    >>> x, z = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    >>> bored = drilled(block, Bores(np.array([0]), np.array([[1, BLIND]]), 20 * z, 8 * z, np.array([4.0]), across=x))
    >>> (block.volumes - bored.volumes).round(3).tolist(), round(np.pi * 4**2 * 12, 3)
    ([603.186], 603.186)
    """
    order = np.argsort(bores.solids, kind="stable")
    counts = np.bincount(bores.solids, minlength=len(solids))
    of_solid = Ragged(order, np.concatenate([[0], np.cumsum(counts)]))
    patterns = np.full((len(solids), 1 + 2 * counts.max(initial=0)), -2, dtype=np.int64)
    patterns[:, 0] = solids.topology
    patterns[of_solid.row[:, None], 1 + 2 * of_solid.place[:, None] + np.arange(2)] = bores.faces[order]
    different, topology = np.unique(patterns, axis=0, return_inverse=True)
    topologies = tuple(
        solids.topologies[row[0]].bored([(first, None if second == BLIND else second) for first, second in pairs])
        for row in different.tolist()
        for pairs in [[pair for pair in zip(row[1::2], row[2::2], strict=True) if pair[0] >= 0]]
    )
    own = bore_vertices(bores.starts[order], bores.stops[order], bores.radii[order], bores.across[order])
    old = solids.vertices
    sizes = old.sizes + 4 * counts
    starts = np.concatenate([[0], np.cumsum(sizes)])
    vertices = np.empty((starts[-1], 3))
    vertices[starts[old.row] + old.place] = old.values
    places = (starts[:-1] + old.sizes)[of_solid.row] + 4 * of_solid.place
    vertices[places[:, None] + np.arange(4)] = own
    return Solids(topologies, topology.ravel(), Ragged(vertices, starts))


def bored_along_axis(prisms: Solids, diameter: float) -> Solids:
    """Upright prisms with square ends, as of `Solids.prisms`, with a bore of this diameter about their z axes.

    >>> from fabkit.detailing.shapes.drilling import bored_along_axis
    >>> from fabkit.parts import Ragged, Solids
    >>> square = Ragged.of([[[-30, -30], [30, -30], [30, 30], [-30, 30]]], shape=(2,))
    >>> block = Solids.prisms(square, np.zeros(1), np.full(1, 20.0))
    >>> len(bored_along_axis(block, 22.0).topologies[0].rounds)
    1
    """
    n, levels = len(prisms), prisms.vertices.values[:, 2]
    ends = np.zeros((2, n, 3))
    ends[:, :, 2] = levels[prisms.vertices.starts[:-1]], levels[prisms.vertices.starts[1:] - 1]
    x = np.tile([1.0, 0.0, 0.0], (n, 1))
    return drilled(prisms, Bores(np.arange(n), np.tile([0, 1], (n, 1)), ends[0], ends[1], np.full(n, diameter / 2), x))
