"""Which part lies next to which, in the words of a list: marks, and words for what is not there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from fabkit.parts import Assembly, Part

__all__ = ["LEFT_OUT", "NOTHING", "marks_by_element", "neighbour_marks", "panel_neighbours"]

#: Across a boundary edge.
NOTHING = "-"
#: A mesh element whose part was not made.
LEFT_OUT = "left out"


def marks_by_element(parts: Iterable[Part]) -> dict[int, str]:
    """Mark of the part for each mesh edge, vertex or face that has one."""
    return {part.element: part.mark for part in parts}


def neighbour_marks(elements: Iterable[int], marks: dict[int, str]) -> tuple[str, ...]:
    """The mark of each element; NOTHING for a negative one, LEFT_OUT for one without a part."""
    return tuple(NOTHING if element < 0 else marks.get(element, LEFT_OUT) for element in elements)


def panel_neighbours(assembly: Assembly) -> Sequence[tuple[str, ...]]:
    """For each panel the mark across each edge of its outline."""
    marks = marks_by_element(assembly.panels)
    return [neighbour_marks(panel.neighbours, marks) for panel in assembly.panels]
