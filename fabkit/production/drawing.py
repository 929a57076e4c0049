"""Drawings for cutting machines, as data: layers of curves in millimetres.

Layers: CUT, the nominal contours; MARK, open strokes to engrave or plot: the mark in the middle of the panel, an
arrow along its first (longest) edge, in the drawing of a single panel also the neighbours' marks along the edges;
SHEET, the stock. No line is drawn twice, and nothing is on the drawing that is not to be cut or marked but the stock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Panel
from fabkit.production.curves import Curves
from fabkit.production.neighbours import LEFT_OUT, NOTHING, panel_neighbours
from fabkit.production.nests import Nest, moved, polygons
from fabkit.production.strokes import ARROW, text_strokes, text_widths
from geometry.arrays import FloatArray, IntArray, floats, integers

__all__ = ["CUT", "MARK", "SHEET", "Drawing", "panel_drawings", "sheet_drawings"]

CUT, MARK, SHEET = "CUT", "MARK", "SHEET"

#: Largest height of a panel's own mark and of what stands along its edges, in mm.
MARK_MM, EDGE_MARK_MM = 80.0, 30.0
#: Neighbours' marks smaller than this cannot be read, and are left away.
READABLE_MM = 3.0
#: In radii of the largest circle inside the panel: half the diagonal of the mark; height and distance from the edge of
#: what stands along the edges. They add up to less than one, so neither meets the other.
MARK_SHARE, EDGE_MARK_SHARE, EDGE_GAP_SHARE = 0.7, 0.14, 0.06
#: Largest share of an edge that a text along it takes.
EDGE_SHARE = 0.4


@dataclass(frozen=True, eq=False)
class Drawing:
    """Curves by layer.

    name: becomes that of the file. notes: sentences for the head of the file.
    """

    name: str
    layers: Mapping[str, Curves]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _Labels:
    """Texts on panels: panel (m,), middle of the foot of the text (m, 2), its direction (m, 2), its height (m,)."""

    texts: Sequence[str]
    panel: IntArray
    foot: FloatArray
    along: FloatArray
    height: FloatArray

    def strokes(self) -> tuple[Curves, IntArray]:
        """Polylines in the frames of their panels, and (k,) the panel of each."""
        curves, text = text_strokes(self.texts)
        x = self.along * self.height[:, None]
        y = np.stack([-x[:, 1], x[:, 0]], axis=1)
        start = self.foot - x * (text_widths(self.texts) / 2)[:, None]
        of_point, points = text[curves.curve_of_point], curves.points
        placed = start[of_point] + points[:, :1] * x[of_point] + points[:, 1:] * y[of_point]
        return Curves(placed, curves.starts), self.panel[text]

    def boxes(self) -> FloatArray:
        """(m, 4, 2) corners of the texts."""
        up = np.stack([-self.along[:, 1], self.along[:, 0]], axis=1) * self.height[:, None]
        half = self.along * (self.height * text_widths(self.texts) / 2)[:, None]
        corners = [self.foot - half, self.foot + half, self.foot + half + up, self.foot - half + up]
        return np.stack(corners, axis=1)


def sheet_drawings(nest: Nest, panels: Sequence[Panel]) -> tuple[Drawing, ...]:
    """One drawing for each sheet of the nest, named sheet-001 and so on."""
    sheet, sheets = nest.sheet, np.array([place.sheet for place in nest.placements], dtype=np.int64)
    stock = np.array([[0, 0], [sheet.length_mm, 0], [sheet.length_mm, sheet.width_mm], [0, sheet.width_mm]])
    outlines = Curves.of([_closed(moved(panels[place.panel].outline, place)) for place in nest.placements])
    strokes, panel = _marks(panels, [("",) * len(panel.outline) for panel in panels])
    ends = strokes.starts[np.searchsorted(panel, np.arange(len(panels) + 1))]
    points = map(moved, np.split(strokes.points, ends[1:-1]), nest.placements)
    strokes = Curves(np.concatenate([np.empty((0, 2)), *points]), strokes.starts)
    cut, mark = outlines.grouped(sheets, nest.n_sheets), strokes.grouped(sheets[panel], nest.n_sheets)
    notes = (
        f"Contours are nominal: the kerf is not taken off; parts are at least {nest.gap_mm:g} mm apart.",
        "Millimetres. Outer side up. Layers: CUT contours, MARK open strokes, SHEET stock.",
    )
    return tuple(
        Drawing(f"sheet-{k + 1:03d}", {SHEET: Curves.of([_closed(stock)]), CUT: cut[k], MARK: mark[k]}, notes)
        for k in range(nest.n_sheets)
    )


def panel_drawings(assembly: Assembly) -> tuple[Drawing, ...]:
    """One drawing for each mark of a panel, named like it, in the panel's own frame, in the order of the panels.

    A neighbour's mark stands along an edge if all panels of this mark have that neighbour, and where there is room.
    """
    neighbours = panel_neighbours(assembly)
    first: dict[str, int] = {}
    common: dict[str, list[str]] = {}
    for index, panel in enumerate(assembly.panels):
        if first.setdefault(panel.mark, index) == index:
            common[panel.mark] = ["" if mark in (NOTHING, LEFT_OUT) else mark for mark in neighbours[index]]
        else:
            known = common[panel.mark]
            known[:] = [a if a == b else "" for a, b in zip(known, neighbours[index], strict=True)]
    panels = [assembly.panels[index] for index in first.values()]
    strokes, panel_of_stroke = _marks(panels, list(common.values()))
    notes = (
        "Contours are nominal: the kerf is not taken off.",
        "Millimetres. Outer side up. Layers: CUT contour, MARK open strokes.",
    )
    return tuple(
        Drawing(panel.mark, {CUT: Curves.of([_closed(panel.outline)]), MARK: own}, notes)
        for panel, own in zip(panels, strokes.grouped(panel_of_stroke, len(panels)), strict=True)
    )


def _marks(panels: Sequence[Panel], edge_texts: Sequence[Sequence[str]]) -> tuple[Curves, IntArray]:
    """Strokes in the panels' own frames, panel after panel, and the panel of each: its mark, an arrow along its first
    edge, a text along each edge."""
    if not panels:
        return Curves.of([]), integers([])
    shapes = polygons([panel.outline for panel in panels])
    circles = shapely.get_coordinates(shapely.maximum_inscribed_circle(shapes)).reshape(-1, 2, 2)
    radii = np.linalg.norm(circles[:, 1] - circles[:, 0], axis=1)
    middle, of_middle = _middle_labels([panel.mark for panel in panels], circles[:, 0], radii).strokes()
    edges, of_edges = _edge_labels(panels, edge_texts, shapes, radii).strokes()
    panel = np.concatenate([of_middle, of_edges])
    order = np.argsort(panel, kind="stable")
    return Curves.joined([middle, edges]).take(order), panel[order]


def _middle_labels(texts: Sequence[str], centres: FloatArray, radii: FloatArray) -> _Labels:
    widths = text_widths(texts)
    height = np.minimum(MARK_MM, 2 * MARK_SHARE * radii / np.hypot(widths, 1.0))
    foot = centres - np.stack([np.zeros(len(texts)), height / 2], axis=1)
    along = np.tile([1.0, 0.0], (len(texts), 1))
    return _Labels(texts, np.arange(len(texts)), foot, along, height)


def _edge_labels(
    panels: Sequence[Panel], edge_texts: Sequence[Sequence[str]], shapes: np.ndarray, radii: FloatArray
) -> _Labels:
    """Texts along edges, upright seen with the edge below; what does not lie inside the panel is made smaller, and
    left away when it becomes unreadable, except for the arrow."""
    counts = [len(panel.outline) for panel in panels]
    panel = np.repeat(np.arange(len(panels)), counts)
    start = np.concatenate([p.outline for p in panels])
    end = np.concatenate([np.roll(p.outline, -1, axis=0) for p in panels])
    texts = [ARROW + t if edge == 0 else t for own in edge_texts for edge, t in enumerate(own)]
    there = np.flatnonzero([text != "" for text in texts])
    texts, panel, start, end = [texts[k] for k in there], panel[there], start[there], end[there]
    lengths = np.linalg.norm(end - start, axis=1)
    along = (end - start) / lengths[:, None]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    widths = text_widths(texts)
    height = np.minimum(EDGE_MARK_MM, np.minimum(EDGE_MARK_SHARE * radii[panel], EDGE_SHARE * lengths / widths))

    def labels(chosen: IntArray) -> _Labels:
        gap = height[chosen] * EDGE_GAP_SHARE / EDGE_MARK_SHARE
        foot = (start + end)[chosen] / 2 + inward[chosen] * gap[:, None]
        return _Labels([texts[k] for k in chosen], panel[chosen], foot, along[chosen], height[chosen])

    outside = np.arange(len(texts))
    shapely.prepare(shapes)  # one with thousands of corners is asked for each of its edges
    while len(outside):
        if height[outside].min() < READABLE_MM * 1e-3:
            marks = ", ".join(panels[k].mark for k in np.unique(panel[outside])[:10])
            raise DetailingError(f"panels {marks}: no mark fits inside; the outline must run counter-clockwise")
        boxes = labels(outside).boxes()
        inside = shapely.contains_properly(shapes[panel[outside]], shapely.polygons(boxes))
        outside = outside[~inside]
        height[outside] /= 2
    arrow = np.array([text[0] == ARROW for text in texts])
    return labels(np.flatnonzero(arrow | (height >= READABLE_MM)))


def _closed(outline: FloatArray) -> FloatArray:
    return floats(np.concatenate([outline, outline[:1]]))
