"""Drawings of bars and blocks: each mark seen from the side and from above, with what its cut list says of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from fabkit.kinds import NODE
from fabkit.parts import Assembly, Curves, Parts
from fabkit.production.cut_lists import CutList, Table
from fabkit.production.drawing import Drawing
from fabkit.production.part_views import View, views
from fabkit.production.strokes import text_strokes, text_widths
from geometry.arrays import FloatArray, IntArray

__all__ = ["HIDDEN", "LABEL", "VISIBLE", "part_drawings"]

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
    firsts = parts.firsts
    where: dict[int, tuple[_Lines, _Lines, FloatArray, int]] = {}
    for batch in parts.solids.by_topology(parts.shape[firsts]):
        side, above = (_Lines.of(views(batch, axes)) for axes in (FROM_SIDE, FROM_ABOVE))
        reach = np.stack([batch.vertices.min(axis=1), batch.vertices.max(axis=1)], axis=1)
        where |= {n: (side, above, reach[row], row) for row, n in enumerate(batch.parts.tolist())}
    for number, mark in enumerate(parts.mark_names):
        side, above, reach, row = where[number]
        down = np.array([0.0, reach[0, 2] - VIEW_GAP_MM - reach[1, 1]])
        curves: dict[str, list[Curves]] = {VISIBLE: [], HIDDEN: []}
        circles: dict[str, list[FloatArray]] = {VISIBLE: [], HIDDEN: []}
        for view, offset in ((side, np.zeros(2)), (above, down)):
            for layer, (lines, rings) in zip(curves, view.drawn(row), strict=True):
                curves[layer].append(Curves(lines.values + offset, lines.starts))
                circles[layer].append(rings + np.append(offset, 0.0))
        labels = _labels(parts, int(firsts[number]), reach, down)
        words = [f"{name}: {text}" for name, text in zip(table.columns, table.texts[number], strict=True) if text]
        yield Drawing(
            mark,
            {**{layer: Curves.joined(own) for layer, own in curves.items()}, LABEL: labels},
            NOTES,
            (title, *words, VIEWS) if title else tuple(words),
            {layer: np.concatenate(own) for layer, own in circles.items()},
        )


@dataclass(frozen=True, eq=False)
class _Lines:
    """The L lines of a view of P solids, and then its circles. points (P, n, 2) of all lines, one line after the other,
    and starts (L + 1,); circles (P, m, 3). keys: for each solid that of each line or circle, equal for those that are
    in one place; visible, exists (P, L + m)."""

    points: FloatArray
    starts: IntArray
    circles: FloatArray
    keys: list[list[tuple[int, ...]]]
    visible: list[list[bool]]
    exists: list[list[bool]]

    @classmethod
    def of(cls, view: View) -> _Lines:
        both = [*view.lines, *view.circles]
        lines, circles = ([line for line, *_ in each] for each in (view.lines, view.circles))
        keys, is_line = [], []
        for line in lines:
            ends = np.round(line[:, [0, -1, line.shape[1] // 2]] / SAME_LINE_MM).astype(np.int64)
            is_line.append(np.ptp(ends, axis=1).any(axis=1))
            turned = (ends[:, 0, 0] > ends[:, 1, 0]) | (
                (ends[:, 0] == ends[:, 1])[:, 0] & (ends[:, 0, 1] > ends[:, 1, 1])
            )
            ends[turned, :2] = ends[turned, 1::-1]
            ends[:, 2] = 0 if line.shape[1] == 2 else ends[:, 2]
            keys.append(ends.reshape(len(ends), -1).tolist())
        for circle in circles:
            is_line.append(np.ones(len(circle), dtype=bool))
            keys.append(np.round(circle / SAME_LINE_MM).astype(np.int64).tolist())
        n = len(both[0][0])
        return cls(
            np.concatenate([*lines, np.zeros((n, 0, 2))], axis=1),
            np.cumsum([0, *(line.shape[1] for line in lines)]),
            np.stack(circles, axis=1) if circles else np.zeros((n, 0, 3)),
            [list(map(tuple, row)) for row in zip(*keys, strict=True)],
            np.stack([visible for _, visible, _ in both], axis=1).tolist(),
            np.stack([exists & own for (_, _, exists), own in zip(both, is_line, strict=True)], axis=1).tolist(),
        )

    def drawn(self, row: int) -> Iterator[tuple[Curves, FloatArray]]:
        """The visible lines and circles of one solid, and the hidden ones that are not behind these; none twice."""
        n, drawn = len(self.starts) - 1, set()
        which = list(zip(self.keys[row], self.visible[row], self.exists[row], strict=True))
        for wanted in (True, False):
            chosen = []
            for k, (key, visible, exists) in enumerate(which):
                if exists and visible == wanted and key not in drawn:
                    drawn.add(key)
                    chosen.append(k)
            lines, rings = [k for k in chosen if k < n], [k - n for k in chosen if k >= n]
            yield Curves(self.points[row], self.starts)[np.array(lines, dtype=np.int64)], self.circles[row, rings]


def _labels(parts: Parts[Any], row: int, reach: FloatArray, down: FloatArray) -> Curves:
    """The letters of the ends of a bar, or the numbers of the facets of a node."""
    texts: Sequence[str] = ()
    places = np.zeros((0, 2))
    if parts.kind.form == "bar":
        texts = ("A", "B")
        middle = (reach[0, 2] + reach[1, 2]) / 2
        places = np.array([[reach[0, 0] - 1.5 * LABEL_MM, middle], [reach[1, 0] + 1.5 * LABEL_MM, middle]])
    elif parts.kind is NODE:
        details = parts.details[row]
        azimuths = np.radians(np.asarray(details.azimuths_deg))
        away = np.abs(reach[:, :2]).max() + LABEL_MM
        texts = [str(k + 1) for k in range(len(azimuths))]
        places = away * np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1) + down
    curves, label = _centred(tuple(texts))
    return Curves(places[label] + LABEL_MM * curves.values, curves.starts)


@lru_cache(maxsize=64)
def _centred(texts: tuple[str, ...]) -> tuple[Curves, IntArray]:
    """Strokes of texts of height 1 with their middles at the origin, and the text of each point."""
    curves, text = text_strokes(texts)
    label = text[curves.row]
    middle = np.stack([text_widths(texts) / 2, np.full(len(texts), 0.5)], axis=1)
    return Curves(curves.values - middle[label], curves.starts), label
