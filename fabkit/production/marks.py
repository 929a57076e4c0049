"""Marks: equal parts share one mark and one solid, so that a workshop makes them alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from fabkit.parts import Assembly, Beam, Node, Panel, Part
from fabkit.production.equal_shapes import TurnedShapes, equal_shapes, in_company
from fabkit.production.turns import (
    turn_beam,
    turn_node,
    turn_panel,
    turned_beams,
    turned_nodes,
    turned_panels,
)

__all__ = ["EQUAL_WITHIN_MM", "share_equal_parts"]

EQUAL_WITHIN_MM = 1e-7
"""Parts with all corners within this distance are equal, if nothing else is said. Below what a beam's end may be off
its facet (1e-6 mm), so that sharing solids keeps the fit; far above rounding (1e-10 mm for a building of 100 m)."""

P = TypeVar("P", bound=Part)


@dataclass(frozen=True)
class _Kind(Generic[P]):
    """letter: of its marks. n_turns: in how many turns a part may be seen. turned, turn: many at once, and one."""

    letter: str
    n_turns: Callable[[P], int]
    turned: Callable[[Sequence[P]], TurnedShapes]
    turn: Callable[[P, int], P]


BEAMS: _Kind[Beam] = _Kind("B", lambda beam: 2, turned_beams, turn_beam)
NODES: _Kind[Node] = _Kind("N", lambda node: len(node.beams), turned_nodes, turn_node)
PANELS: _Kind[Panel] = _Kind("P", lambda panel: len(panel.outline), turned_panels, turn_panel)


def share_equal_parts(assembly: Assembly, *, within_mm: float = EQUAL_WITHIN_MM) -> Assembly:
    """The same parts; equal ones share a mark and the solid of the first of them, others have a mark of their own.

    within_mm: how far each coordinate of corners of parts may differ for these to count as equal. Parts then stand off
    their places by as much.

    A beam turned end for end, a node or panel turned about its normal is the same piece; a mirrored one is not.
    The first of equal parts keeps its own frame, the frames of the others are turned to match it. Marks are
    numbered in the order of the mesh elements: B001, N001, P001.
    """
    return replace(
        assembly,
        beams=_share(assembly.beams, BEAMS, within_mm),
        nodes=_share(assembly.nodes, NODES, within_mm),
        panels=_share(assembly.panels, PANELS, within_mm),
    )


def _share(parts: Sequence[P], kind: _Kind[P], within_mm: float) -> tuple[P, ...]:
    """Group equal parts. Only parts of one material with equally many corners and turns are compared."""
    comparable: dict[tuple[int, int, str], list[int]] = {}
    for place, part in enumerate(parts):
        key = (part.solid.topology.n_vertices, kind.n_turns(part), part.material.name)
        comparable.setdefault(key, []).append(place)
    first_of = np.arange(len(parts))
    turns = np.zeros(len(parts), dtype=np.int64)
    for group in comparable.values():
        corners = np.array([parts[place].solid.vertices for place in group])
        places = np.array(group)[in_company(corners, within_mm)]
        if len(places):
            first, turns[places] = equal_shapes(kind.turned([parts[place] for place in places]), within_mm)
            first_of[places] = places[first]
    numbers = np.cumsum(first_of == np.arange(len(parts)))
    width = max(3, len(str(numbers[-1]))) if len(parts) else 3
    marks = [f"{kind.letter}{numbers[first]:0{width}d}" for first in first_of.tolist()]
    return tuple(
        replace(kind.turn(part, k), mark=mark, solid=parts[first].solid)
        for part, mark, first, k in zip(parts, marks, first_of.tolist(), turns.tolist(), strict=True)
    )
