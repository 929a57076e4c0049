"""All the parts of one structure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fabkit.parts.part import Beam, Node, Panel, Part

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
    """The parts by kind, each kind in the order of its mesh elements, and what had to be left out."""

    name: str
    beams: tuple[Beam, ...]
    nodes: tuple[Node, ...]
    panels: tuple[Panel, ...]
    left_out: tuple[LeftOut, ...] = ()

    def groups(self) -> dict[str, tuple[Part, ...]]:
        """Parts by the name of their group: beams, nodes, panels."""
        return {"beams": self.beams, "nodes": self.nodes, "panels": self.panels}

    def parts(self) -> Iterator[Part]:
        for group in self.groups().values():
            yield from group
