"""Columns of cut lists that several kinds have, and functions that write their cells."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fabkit.parts import Cell, Column, Parts, Ragged, Surroundings, texts
from geometry.arrays import FloatArray, IntArray

__all__ = [
    "LEFT_OUT",
    "NO_NEIGHBOUR",
    "counted",
    "each_value",
    "files",
    "grouped",
    "joined",
    "marks_and_counts",
    "marks_at",
    "marks_in",
    "masses",
    "materials",
    "of_first",
    "over_all",
    "ranges",
    "stock_of_plates",
]

NO_NEIGHBOUR = "-"
"""Text for the neighbour across a boundary edge."""
LEFT_OUT = "left out"
"""Text for a neighbour that was left out."""


def stock_of_plates(plates: Parts[Any]) -> list[str]:
    """What each plate is made from: its thickness and its material."""
    names = [each.name for each in plates.materials]
    rows = zip(plates.details.thickness_mm.tolist(), plates.material.tolist(), strict=True)
    return [f"{thickness:g} mm {names[material]}" for thickness, material in rows]


def marks_and_counts(parts: Parts[Any]) -> list[Column]:
    return [
        Column("Mark", None, parts.mark_names, "Total"),
        Column("Count", 0, parts.counts.tolist(), len(parts)),
    ]


def materials(parts: Parts[Any]) -> Column:
    return Column("Material", None, [parts.materials[k].name for k in parts.material[parts.firsts].tolist()])


def masses(parts: Parts[Any]) -> list[Column]:
    each = parts.masses_kg[parts.firsts]
    of_marks = (parts.counts * each).tolist()
    return [Column("Mass each (kg)", 3, each.tolist()), Column("Mass (kg)", 3, of_marks, float(sum(of_marks)))]


def files(parts: Parts[Any], pattern: str) -> Column:
    """The files of the marks. pattern: a path with {} in place of the mark."""
    return Column("File", None, [pattern.format(mark) for mark in parts.mark_names])


def of_first(title: str, decimals: int, parts: Parts[Any], values: FloatArray | IntArray) -> Column:
    """The value of the first part of each mark, empty where it is NaN; values (n,) are the same for equal parts."""
    return Column(title, decimals, [None if value != value else value for value in values[parts.firsts].tolist()])


def over_all(title: str, decimals: int, parts: Parts[Any], values: FloatArray) -> list[Column]:
    """The least and the largest value of all parts of each mark, two columns; values (n,) may differ between equal
    parts. Their cells are empty where all are NaN."""
    columns = []
    for which, reduce in (("Least", np.fmin), ("Largest", np.fmax)):
        found = np.full(len(parts.mark_names), np.nan)
        reduce.at(found, parts.mark, values)
        cells = [None if value != value else value for value in found.tolist()]
        columns.append(Column(f"{which} {title[0].lower()}{title[1:]}", decimals, cells))
    return columns


def each_value(title: str, decimals: int, parts: Parts[Any], values: Ragged) -> Column:
    """All values of the first part of each mark, in one text."""
    first = values[parts.firsts]
    return Column(title, None, joined(texts(first.values.tolist(), decimals), first.starts), several=True)


def counted(title: str, parts: Parts[Any], words: Sequence[str]) -> Column:
    """The different words (n,) of all parts of each mark, with their number where a word occurs more than once."""
    order = np.argsort(parts.mark, kind="stable").tolist()
    cells = []
    for own in grouped([words[k] for k in order], np.concatenate([[0], np.cumsum(parts.counts)])):
        counts: dict[str, int] = {}
        for word in own:
            counts[word] = counts.get(word, 0) + 1
        cells.append("; ".join(word if count == 1 else f"{word} (x{count})" for word, count in counts.items()))
    return Column(title, None, cells, several=True)


def marks_in(around: Surroundings, group: str, elements: IntArray) -> list[str]:
    """As `marks_at`, of the parts of a group, which may be missing."""
    for parts in around.assembly.groups:
        if parts.kind.group == group:
            return marks_at(parts, elements)
    return [LEFT_OUT if element >= 0 else NO_NEIGHBOUR for element in elements.tolist()]


def marks_at(parts: Parts[Any], elements: IntArray) -> list[str]:
    """The mark of the part on each mesh element (k,): NO_NEIGHBOUR if that is negative, LEFT_OUT without a part.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.kinds import marks_at
    >>> marks_at(built.assembly["panels"], np.array([0, 11, -1, 99]))
    ['P001', 'P002', '-', 'left out']
    """
    names = [*parts.mark_names, LEFT_OUT, NO_NEIGHBOUR]
    which = np.append(parts.mark, len(names) - 2)[parts.find(elements)]
    return [names[k] for k in np.where(elements < 0, len(names) - 1, which).tolist()]


def grouped(words: Sequence[str], starts: IntArray) -> Iterable[Sequence[str]]:
    """The words in groups: group r has words[starts[r]:starts[r + 1]]."""
    return (words[start:end] for start, end in pairwise(starts.tolist()))


def joined(words: Sequence[str], starts: IntArray) -> list[str]:
    return [" / ".join(own) for own in grouped(words, starts)]


def ranges(values: FloatArray, group: IntArray, decimals: int) -> list[Cell]:
    """For each group the first of its values (k,), if all are the same to these decimals; if not, "smallest to
    largest". None where all are NaN. group (k,): numbered from 0, none is empty."""
    if not len(values):
        return []
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    own = values[order]
    smallest, largest = np.fmin.reduceat(own, starts), np.fmax.reduceat(own, starts)
    known = np.minimum.reduceat(np.where(np.isnan(own), len(own), np.arange(len(own))), starts)
    first = np.append(own, np.nan)[known].tolist()
    both = zip(first, texts(smallest.tolist(), decimals), texts(largest.tolist(), decimals), strict=True)
    return [None if value != value else value if low == high else f"{low} to {high}" for value, low, high in both]
