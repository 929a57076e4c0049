"""Many solids as arrays: all their vertices in one, solid after solid."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fabkit.parts.ragged import Ragged
from fabkit.parts.shapes import Solid, SolidArray, Topology, prism_topology
from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers

__all__ = ["Solids"]


@dataclass(frozen=True, eq=False)
class Solids:
    """Solids in their own frames.

    topologies: those that occur. topology (S,): which of them each solid has. vertices: (n, 3) of each solid, in mm.

    >>> from fabkit.parts import Ragged, Solids
    >>> outlines = Ragged.of([[[0, 0], [4, 0], [0, 3]], [[0, 0], [2, 0], [2, 2], [0, 2]]], shape=(2,))
    >>> solids = Solids.prisms(outlines, np.zeros(2), np.ones(2))
    >>> solids.volumes.round(9).tolist(), len(solids.by_topology())
    ([6.0, 4.0], 2)
    """

    topologies: tuple[Topology, ...]
    topology: IntArray
    vertices: Ragged

    def __post_init__(self) -> None:
        object.__setattr__(self, "topology", integers(self.topology))
        sizes = np.array([each.n_vertices for each in self.topologies], dtype=np.int64)
        if not np.array_equal(sizes[self.topology], self.vertices.sizes):
            raise ValueError("each solid must have as many vertices as its topology")

    @classmethod
    def of(cls, solids: Iterable[Solid]) -> Solids:
        given = list(solids)
        numbers: dict[Topology, int] = {}
        which = [numbers.setdefault(solid.topology, len(numbers)) for solid in given]
        vertices = Ragged.of([solid.vertices for solid in given], shape=(3,))
        return cls(tuple(numbers), np.array(which, dtype=np.int64), vertices)

    @classmethod
    def alike(cls, vertices: FloatArray, topology: Topology) -> Solids:
        """Of one topology: vertices (S, n, 3)."""
        count, n = vertices.shape[:2]
        starts = n * np.arange(count + 1)
        return cls((topology,), np.zeros(count, dtype=np.int64), Ragged(vertices.reshape(-1, 3), starts))

    @classmethod
    def prisms(cls, outlines: Ragged, bottoms: FloatArray, tops: FloatArray, upper: FloatArray | None = None) -> Solids:
        """Prisms over polygons, rows of (k, 2) in the xy-plane, from z = bottoms (S,) to z = tops (S,); their corners
        are numbered as those of `prism_topology`. upper (K, 2): the corners at the tops, if they are others."""
        vertices = np.empty((2 * len(outlines.values), 3))
        below = outlines.starts[outlines.row] + np.arange(len(outlines.values))
        above = below + outlines.sizes[outlines.row]
        corners = outlines.values if upper is None else upper
        for places, points, levels in ((below, outlines.values, bottoms), (above, corners, tops)):
            vertices[places, :2] = points
            vertices[places, 2] = levels[outlines.row]
        sizes, topology = np.unique(outlines.sizes, return_inverse=True)
        topologies = tuple(prism_topology(size) for size in sizes.tolist())
        return cls(topologies, topology, Ragged(vertices, 2 * outlines.starts))

    @classmethod
    def gathered(cls, rows: Sequence[IntArray], batches: Sequence[Solids]) -> Solids:
        """The solids of several batches as one: solid k of a batch is solid number rows[batch][k] of the result."""
        topologies = tuple(topology for batch in batches for topology in batch.topologies)
        topology = np.empty(sum(map(len, rows)), dtype=np.int64)
        first = 0
        for own, batch in zip(rows, batches, strict=True):
            topology[own] = first + batch.topology
            first += len(batch.topologies)
        sizes = np.array([each.n_vertices for each in topologies], dtype=np.int64)[topology]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        values = np.empty((starts[-1], 3))
        for own, batch in zip(rows, batches, strict=True):
            values[starts[own[batch.vertices.row]] + batch.vertices.place] = batch.vertices.values
        return cls(topologies, topology, Ragged(values, starts))

    def __len__(self) -> int:
        return len(self.topology)

    def __getitem__(self, position: int) -> Solid:
        return Solid(self.vertices[position], self.topologies[self.topology[position]])

    def take(self, chosen: BoolArray | IntArray) -> Solids:
        """The solids chosen by a mask or by indices."""
        return Solids(self.topologies, self.topology[chosen], self.vertices[chosen])

    def by_topology(self, chosen: IntArray | None = None) -> list[SolidArray]:
        """These solids, or all, by topology; SolidArray.parts: positions in what is chosen."""
        chosen = np.arange(len(self)) if chosen is None else chosen
        which = self.topology[chosen]
        found = []
        for number, topology in enumerate(self.topologies):
            places = np.flatnonzero(which == number)
            if len(places):
                starts = self.vertices.starts[chosen[places]]
                found.append(
                    SolidArray(topology, places, self.vertices.values[starts[:, None] + np.arange(topology.n_vertices)])
                )
        return found

    @cached_property
    def volumes(self) -> FloatArray:
        """(S,) in mm3."""
        volumes = np.empty(len(self))
        for batch in self.by_topology():
            volumes[batch.parts] = batch.volumes
        return floats(volumes)

    @cached_property
    def centroids(self) -> FloatArray:
        """(S, 3) in mm, in the solids' own frames."""
        centroids = np.empty((len(self), 3))
        for batch in self.by_topology():
            centroids[batch.parts] = batch.centroids
        return floats(centroids)
