"""Parts of one topology as one array, placed in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabkit.parts.part import Part
from fabkit.parts.solid import Topology
from geometry.arrays import BoolArray, FloatArray, IntArray, integers

__all__ = ["Stack", "stacks"]


@dataclass(frozen=True, eq=False)
class Stack:
    """Solids of one topology in world coordinates.

    parts (P,): their positions in the list of parts they were taken from. vertices (P, n, 3) in mm.
    """

    topology: Topology
    parts: IntArray
    vertices: FloatArray

    def __getitem__(self, chosen: BoolArray | IntArray) -> Stack:
        """The solids chosen by a mask or by indices (P,)."""
        return Stack(self.topology, self.parts[chosen], self.vertices[chosen])


def stacks(parts: Sequence[Part]) -> list[Stack]:
    """All the parts, by topology, in the order in which the topologies first appear."""
    positions: dict[Topology, list[int]] = {}
    for position, part in enumerate(parts):
        positions.setdefault(part.solid.topology, []).append(position)
    return [Stack(topology, integers(own), _placed(parts, own)) for topology, own in positions.items()]


def _placed(parts: Sequence[Part], positions: Sequence[int]) -> FloatArray:
    vertices = np.array([parts[k].solid.vertices for k in positions])
    origins = np.array([parts[k].placement.origin for k in positions])
    axes = np.array([parts[k].placement.axes for k in positions])
    placed: FloatArray = origins[:, None, :] + vertices @ axes
    return placed
