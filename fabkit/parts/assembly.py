"""All the parts of one structure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from fabkit.parts.part import Beam, Node, Panel, Part
from geometry.arrays import FloatArray, floats

__all__ = ["Assembly", "LeftOut"]


@dataclass(frozen=True)
class LeftOut:
    """A part that was not made. kind: beam, node or panel; element: mesh edge, vertex or face; reason: a sentence that
    names it."""

    kind: str
    element: int
    reason: str


@dataclass(frozen=True, eq=False)
class Assembly:
    """The parts by kind, each kind in the order of its mesh elements, and what had to be left out.

    The parts are placed near zero, since far from it coordinates are coarse. origin_mm (3,): where zero is in the
    coordinates of the mesh file, in mm: a point of a part stands at `part.placement.to_world(point) + origin_mm`.
    """

    name: str
    beams: tuple[Beam, ...]
    nodes: tuple[Node, ...]
    panels: tuple[Panel, ...]
    left_out: tuple[LeftOut, ...] = ()
    origin_mm: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin_mm", floats(self.origin_mm))

    def groups(self) -> dict[str, tuple[Part, ...]]:
        """Parts by the name of their group: beams, nodes, panels."""
        return {"beams": self.beams, "nodes": self.nodes, "panels": self.panels}

    def parts(self) -> Iterator[Part]:
        for group in self.groups().values():
            yield from group
