"""Drawings of bars and blocks: each mark seen from the side and from above, with what its cut list says of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from fabkit.kinds import NODE
from fabkit.parts import Assembly, Curves, Measures, Parts, Ragged
from fabkit.production.cut_lists import CutList, Table
from fabkit.production.drawing import Drawing
from fabkit.production.part_views import views
from fabkit.production.strokes import text_strokes, text_widths
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["HIDDEN", "LABEL", "VISIBLE", "part_drawings"]

R = TypeVar("R", bound=Ragged)

VISIBLE, HIDDEN, LABEL = "VISIBLE", "HIDDEN", "LABEL"

FROM_SIDE = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
FROM_ABOVE = np.eye(3)
"""Frames of the views: to the right, up, towards the eye."""

VIEW_GAP_MM = 60.0
"""Distance in mm between the two views, for the labels around them."""
LABEL_MM = 12.0
"""Height in mm of the letters of ends and the numbers of facets: to be read on a print at 1 to 5."""
SAME_LINE_MM = 1e-3
"""Distance in mm of the ends of two lines up to which they are one: the shortest edge of a solid is as long."""
PLACES_ACROSS = 2**32
"""Number of places, SAME_LINE_MM apart, on which a line can end in each direction: 4 km."""

VIEWS = "Above: from the side, outer side up. Below: from outside."
NOTES = (f"Millimetres, 1:1. {VIEWS} Layers: VISIBLE and HIDDEN edges, LABEL ends and facets, TITLE text.",)


def part_drawings(assembly: Assembly, lists: CutList, *, title: str = "") -> Iterator[Drawing]:
    """One drawing for each mark of bars and blocks, named like the mark: the view from the side and, below it, the one
    from outside, in the own frame of the first part of the mark, with hidden edges; A and B at the ends of bars,
    numbers at the facets of nodes. title: first words below each; then come the row of the mark in its cut list and
    what the views are.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import cut_list, part_drawings
    >>> drawings = list(part_drawings(built.assembly, cut_list(built.assembly, built.nest)))
    >>> drawings[0].name, len(drawings), drawings[0].title[2]
    ('B001', 8, 'Section: rhs 120x60x5')
    """
    for group in assembly.groups:
        if group.kind.form in ("bar", "block"):
            yield from _of_group(group, lists[group.kind.group], title)


def _of_group(parts: Parts[Any], table: Table, title: str) -> Iterator[Drawing]:
    n, batches = len(parts.firsts), parts.solids.by_topology(parts.shape[parts.firsts])
    if not n:
        return
    reach = np.zeros((n, 2, 3))
    for batch in batches:
        reach[batch.parts] = np.stack([batch.vertices.min(axis=1), batch.vertices.max(axis=1)], axis=1)
    down = np.stack([np.zeros(n), reach[:, 0, 2] - VIEW_GAP_MM - reach[:, 1, 1]], axis=1)
    lines, circles = [], []
    for batch in batches:
        of = Measures(batch.topology, batch.vertices)
        for axes, offset in ((FROM_SIDE, 0 * down), (FROM_ABOVE, down)):
            view = views(of, axes)
            lines.append(_shown(view.lines, batch.parts, offset, Curves.of([])))
            circles.append(_shown(view.circles, batch.parts, offset, Ragged.of([], shape=(3,))))
    layers = zip(*_by_layer(lines, n), _labels(parts, reach, down), *_by_layer(circles, n), strict=True)
    said = [[f"{column.title}: {text}" if text else "" for text in column.texts] for column in table.by_column]
    for mark, row, (*curves, rings, hidden) in zip(parts.mark_names, zip(*said, strict=True), layers, strict=True):
        words = filter(None, row)
        yield Drawing(
            mark,
            dict(zip((VISIBLE, HIDDEN, LABEL), curves, strict=True)),
            NOTES,
            (title, *words, VIEWS) if title else tuple(words),
            {VISIBLE: rings.values, HIDDEN: hidden.values},
        )


def _shown(
    found: Sequence[tuple[FloatArray, BoolArray, BoolArray]], parts: IntArray, offset: FloatArray, nothing: R
) -> tuple[R, IntArray, IntArray]:
    """The lines or circles of a view of P solids, each moved by the offset of its part; the part of each; its layer: 0
    visible, 1 hidden, 2 none. Of those in one place only the first visible one is drawn, or else the first hidden one;
    a line that is seen as a point is not. nothing: none of them."""
    if not found:
        return nothing, nothing.row, nothing.row
    shown, visible, exists = zip(*found, strict=True)
    points = [each.reshape(len(parts), -1, each.shape[-1]) for each in shown]
    places, is_seen = _places(points)
    layer = np.where(np.stack(exists, axis=1) & is_seen, np.where(np.stack(visible, axis=1), 0, 1), 2)
    order = np.lexsort([layer, *np.moveaxis(places, 2, 0)])
    ordered = np.take_along_axis(places, order[:, :, None], axis=1)
    again = np.zeros_like(is_seen)
    np.put_along_axis(again, order[:, 1:], (ordered[:, 1:] == ordered[:, :-1]).all(axis=2), axis=1)
    layer[again] = 2
    rows = np.concatenate(points, axis=1)
    rows[:, :, :2] += offset[parts][:, None]
    sizes = np.tile([each.shape[1] for each in points], len(parts))
    starts = np.concatenate([[0], np.cumsum(sizes)])
    return type(nothing)(rows.reshape(-1, rows.shape[2]), starts), np.repeat(parts, len(points)), layer.ravel()


def _places(points: Sequence[FloatArray]) -> tuple[IntArray, BoolArray]:
    """(P, L, 3) numbers that are equal for lines, or circles, in one place: of their ends and, if not straight, their
    middle; or of the centre, twice, and the radius. (P, L) which are more than a point."""
    ends = np.stack([each[:, [0, -1, each.shape[1] // 2]] for each in points], axis=1)
    rounded = np.round(ends / SAME_LINE_MM).astype(np.int64)
    places = rounded[..., 0] * PLACES_ACROSS + rounded[..., 1]
    if rounded.shape[3] == 3:
        places[..., 2] = rounded[..., 2, 2]
        return places, np.ones(places.shape[:2], dtype=bool)
    is_seen = (places[..., 1:] != places[..., :1]).any(axis=2)
    places[..., :2] = np.sort(places[..., :2], axis=2)
    places[:, [each.shape[1] == 2 for each in points], 2] = 0
    return places, is_seen


def _by_layer(shown: Sequence[tuple[R, IntArray, IntArray]], n: int) -> tuple[list[R], list[R]]:
    """The visible ones and the hidden ones of each of n parts."""
    rows, part, layer = zip(*shown, strict=True)
    every = type(rows[0]).joined(rows).grouped(np.concatenate(layer) * n + np.concatenate(part), 2 * n)
    return every[:n], every[n:]


def _labels(parts: Parts[Any], reach: FloatArray, down: FloatArray) -> list[Curves]:
    """Of each mark the letters of the ends of a bar, or the numbers of the facets of a node. reach (n, 2, 3): from
    where to where its solid reaches; down (n, 2): where the view from above lies."""
    n = len(reach)
    texts: Sequence[str] = ()
    places, part = np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
    if parts.kind.form == "bar":
        texts, part = ("A", "B") * n, np.repeat(np.arange(n), 2)
        x = reach[:, :, 0] + [-1.5 * LABEL_MM, 1.5 * LABEL_MM]
        places = np.stack([x.ravel(), reach[:, :, 2].mean(axis=1)[part]], axis=1)
    elif parts.kind is NODE:
        azimuths = parts.details.azimuths_deg[parts.firsts]
        texts, part = [str(k + 1) for k in azimuths.place.tolist()], azimuths.row
        away, angles = np.abs(reach[:, :, :2]).max(axis=(1, 2)) + LABEL_MM, np.radians(azimuths.values)
        places = away[part, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1) + down[part]
    strokes, text = text_strokes(texts)
    of_point = text[strokes.row]
    middles = np.stack([text_widths(texts) / 2, np.full(len(texts), 0.5)], axis=1)
    values = places[of_point] + LABEL_MM * (strokes.values - middles[of_point])
    return strokes.with_values(values).grouped(part[text], n)
