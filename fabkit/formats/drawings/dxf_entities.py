"""Entities of many DXF files as text, those of one kind together: a column for each part of their text.

The entities begin with the end of the line before them. Each function takes how many there are in each of n files, and
the first free handle of each file (n,); it gives the text in each file, and what handle is free then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic_core import to_json

from fabkit.parts import Curves, Ragged
from geometry.arrays import FloatArray, IntArray

__all__ = ["ModelSpace", "Version", "bounds", "circles", "number_texts", "polylines", "texts"]

Version = Literal["R2018", "R2010", "R12"]
Texts = npt.NDArray[np.object_]
Added = tuple[list[str], IntArray]
"""The text of the entities in each file, and the first handle that is free after them."""


@dataclass(frozen=True)
class ModelSpace:
    """Where the entities are. handle: its own, the owner of the entities."""

    version: Version
    handle: str

    def common(self, layer: str, subclass: str) -> str:
        """What stands in an entity between its handle and its own values."""
        if self.version == "R12":
            return f"\n  8\n{layer}"
        return f"\n330\n{self.handle}\n100\nAcDbEntity\n  8\n{layer}\n100\n{subclass}"


def number_texts(values: FloatArray) -> Texts:
    """Numbers, all finite, as text; pydantic's JSON writer is ten times as fast as repr."""
    found = to_json(values.ravel().tolist()).decode()[1:-1].split(",")
    return np.array(found[: values.size], dtype=object).reshape(values.shape)


def bounds(counts: IntArray) -> IntArray:
    """(n+1,) where the entities of each file begin and end."""
    return np.concatenate([[0], np.cumsum(counts)])


def polylines(space: ModelSpace, layers: Sequence[str], curves: Curves, counts: IntArray, first: IntArray) -> Added:
    """counts (n, L): of curves in each file and layer. A closed curve is written without its last point."""
    layer = np.repeat(np.tile(np.arange(len(layers)), len(counts)), counts.ravel())
    closed, counts = curves.is_closed.astype(int), counts.sum(axis=1)
    is_written = np.ones(len(curves.values), dtype=bool)
    is_written[curves.starts[1:][curves.is_closed] - 1] = False
    points = Ragged(number_texts(curves.values[is_written]), curves.starts - bounds(closed))
    common = np.array([space.common(name, "AcDbPolyline") for name in layers], dtype=object)
    write = _of_vertices if space.version == "R12" else _lightweight
    return write(common, layer, closed, points, counts, first)


def _lightweight(
    common: Texts, layer: IntArray, closed: IntArray, points: Ragged, counts: IntArray, first: IntArray
) -> Added:
    """common (L,): of each layer; layer, closed (k,): its index and 0 or 1, of each curve."""
    shape = (len(common), points.sizes.max(initial=0) + 1, 2)
    codes, kind = np.unique(np.ravel_multi_index((layer, points.sizes, closed), shape), return_inverse=True)
    of_kinds = np.stack(np.unravel_index(codes, shape), axis=1).tolist()
    heads = [f"{common[k]}\n 90\n{size}\n 70\n{is_closed}\n 10\n" for k, size, is_closed in of_kinds]
    before = np.array(["\n 10\n"], dtype=object).repeat(len(points.values))
    before[points.starts[:-1]] = (
        _handles("\n  0\nLWPOLYLINE\n  5\n", first, counts) + np.array(heads, dtype=object)[kind]
    )
    n_points = np.diff(points.starts[bounds(counts)])
    return _joined(n_points, before, points.values[:, 0], "\n 20\n", points.values[:, 1]), first + counts


def _of_vertices(
    common: Texts, layer: IntArray, closed: IntArray, points: Ragged, counts: IntArray, first: IntArray
) -> Added:
    """A POLYLINE, a VERTEX for each point, and a SEQEND, each with a handle; otherwise as of lightweight ones."""
    before = 2 * np.arange(len(points))
    begins, ends = points.starts[:-1] + before, points.starts[1:] + before + 1
    names = np.full(len(points.values) + 2 * len(points), "\n  0\nVERTEX\n  5\n", dtype=object)
    names[begins], names[ends] = "\n  0\nPOLYLINE\n  5\n", "\n  0\nSEQEND\n  5\n"
    own = np.full(len(names), "", dtype=object)
    head = "\n 66\n1\n 10\n0.0\n 20\n0.0\n 30\n0.0\n 70\n"
    own[begins] = np.array([f"{head}0", f"{head}1"], dtype=object)[closed]
    places = np.arange(len(points.values)) + 2 * points.row + 1
    own[places] = "\n 10\n" + points.values[:, 0] + "\n 20\n" + points.values[:, 1] + "\n 30\n0.0"
    n_handles = np.diff(points.starts[bounds(counts)]) + 2 * counts
    in_layer = np.repeat(common[layer], points.sizes + 2)
    return _joined(n_handles, names, _handles("", first, n_handles), in_layer, own), first + n_handles


def circles(space: ModelSpace, layers: Sequence[str], rings: FloatArray, counts: IntArray, first: IntArray) -> Added:
    """layers: of each circle; rings (k, 3): centre and radius."""
    handles = _handles("\n  0\nCIRCLE\n  5\n", first, counts)
    head = np.array([f"{space.common(name, 'AcDbCircle')}\n 10\n" for name in layers], dtype=object)
    x, y, radius = number_texts(rings).T
    return _joined(counts, handles, head, x, "\n 20\n", y, "\n 30\n0.0\n 40\n", radius), first + counts


def texts(
    space: ModelSpace,
    layer: str,
    lines: Sequence[str],
    places: tuple[FloatArray, FloatArray, FloatArray],
    counts: IntArray,
    first: IntArray,
) -> Added:
    """lines (k,): of text; places: x (n,) where those of a file begin, y (k,) of each line, and their height (n,)."""
    handles = _handles("\n  0\nTEXT\n  5\n", first, counts)
    x, y, height = map(number_texts, places)
    before = f"{space.common(layer, 'AcDbText')}\n 10\n" + x + "\n 20\n"
    between = "\n 30\n0.0\n 40\n" + height + "\n  1\n"
    end = "" if space.version == "R12" else "\n100\nAcDbText"
    columns = handles, before.repeat(counts), y, between.repeat(counts), np.array(lines, dtype=object), end
    return _joined(counts, *columns), first + counts


def _handles(before: str, first: IntArray, counts: IntArray) -> Texts:
    """The handles of the entities, each after the same text."""
    numbers = np.arange(counts.sum()) + np.repeat(first - bounds(counts)[:-1], counts)
    every = [f"{before}{number:X}" for number in range(numbers.max(initial=0) + 1)]
    return np.asarray(np.array(every, dtype=object)[numbers])


def _joined(counts: IntArray, *columns: str | Texts) -> list[str]:
    """The rows of each file in one text, of each row its texts of all columns."""
    rows = np.empty((counts.sum(), len(columns)), dtype=object)
    for k, column in enumerate(columns):
        rows[:, k] = column
    flat, ends = rows.ravel().tolist(), (bounds(counts) * len(columns)).tolist()
    return ["".join(flat[start:end]) for start, end in pairwise(ends)]
