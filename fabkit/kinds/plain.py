"""A simple kind of part of one's own, without any data besides the solids."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from fabkit.kinds.columns import files, marks_and_counts, masses, materials
from fabkit.parts import Column, Details, Kind, Parts, Surroundings

__all__ = ["plain_kind"]


def plain_kind(
    name: str,
    *,
    letter: str,
    element: Literal["vertex", "edge", "face"] = "vertex",
    form: Literal["bar", "block", "plate", "pin"] = "block",
    colour: tuple[float, float, float] = (0.85, 0.55, 0.15),
) -> Kind[Parts[Details]]:
    """A kind whose group has the name and an s; its cut list gives marks, counts, materials and masses.

    letter, element, form, colour: as in `Kind`. The details of its parts are `Details()`.

    >>> cap = plain_kind("cap", letter="C")
    >>> cap.group, len(Parts.of(cap))
    ('caps', 0)
    """
    return Kind(
        name=name,
        group=f"{name}s",
        element=element,
        letter=letter,
        colour=colour,
        form=form,
        empty_details=Details(),
        columns=_columns,
        measures=lambda parts: [],
        labels=lambda parts, around: [name] * len(parts),
    )


def _columns(parts: Parts[Details], around: Surroundings) -> Sequence[Column]:
    return [*marks_and_counts(parts), materials(parts), *masses(parts), files(parts, "parts/{}.step")]
