"""Drawings for cutting machines, as data: layers of curves in millimetres.

Layers: CUT, the nominal contours; MARK, open strokes to engrave or plot: the mark in the middle of the panel, an
arrow along its first (longest) edge, in the drawing of a single panel also the neighbours' marks along the edges;
SHEET, the stock. No line is drawn twice, and nothing is on the drawing that is not to be cut or marked but the stock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
import shapely

from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Panel
from fabkit.production.neighbours import LEFT_OUT, NOTHING, panel_neighbours
from fabkit.production.nests import Nest, moved, polygons
from fabkit.production.strokes import ARROW, text_strokes, text_width
from geometry.arrays import FloatArray, IntArray, floats

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
    """Curves by layer, each curve points (k, 2) in mm; a closed curve ends where it begins.

    name: becomes that of the file. notes: sentences for the head of the file.
    """

    name: str
    layers: Mapping[str, tuple[FloatArray, ...]]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _Labels:
    """Texts on panels: panel (m,), middle of the foot of the text (m, 2), its direction (m, 2), its height (m,)."""

    texts: Sequence[str]
    panel: IntArray
    foot: FloatArray
    along: FloatArray
    height: FloatArray

    def strokes(self, n_panels: int) -> list[list[FloatArray]]:
        """Polylines (k, 2) of each panel, in its own frame."""
        strokes: list[list[FloatArray]] = [[] for _ in range(n_panels)]
        if not len(self.texts):
            return strokes
        x = self.along * self.height[:, None]
        y = np.stack([-x[:, 1], x[:, 0]], axis=1)
        start = self.foot - x * np.array([[text_width(text) / 2] for text in self.texts])
        curves = [text_strokes(text) for text in self.texts]
        flat = [stroke for of_text in curves for stroke in of_text]
        text = np.repeat(np.arange(len(curves)), [sum(map(len, of_text)) for of_text in curves])
        points = np.concatenate(flat)
        placed = iter(_runs(start[text] + points[:, :1] * x[text] + points[:, 1:] * y[text], flat))
        for panel, of_text in zip(self.panel.tolist(), curves, strict=True):
            strokes[panel] += islice(placed, len(of_text))
        return strokes

    def boxes(self) -> FloatArray:
        """(m, 4, 2) corners of the texts."""
        up = np.stack([-self.along[:, 1], self.along[:, 0]], axis=1) * self.height[:, None]
        widths = np.array([text_width(text) for text in self.texts])
        half = self.along * (self.height * widths / 2)[:, None]
        corners = [self.foot - half, self.foot + half, self.foot + half + up, self.foot - half + up]
        return np.stack(corners, axis=1)


def sheet_drawings(nest: Nest, panels: Sequence[Panel]) -> tuple[Drawing, ...]:
    """One drawing for each sheet of the nest, named sheet-001 and so on."""
    marks = _marks(panels, [("",) * len(panel.outline) for panel in panels])
    sheet = nest.sheet
    stock = np.array([[0, 0], [sheet.length_mm, 0], [sheet.length_mm, sheet.width_mm], [0, sheet.width_mm]])
    cut: list[list[FloatArray]] = [[] for _ in range(nest.n_sheets)]
    mark: list[list[FloatArray]] = [[] for _ in range(nest.n_sheets)]
    for place in nest.placements:
        cut[place.sheet].append(_closed(moved(panels[place.panel].outline, place)))
        strokes = marks[place.panel]
        mark[place.sheet] += _runs(moved(np.concatenate(strokes), place), strokes)
    notes = (
        f"Contours are nominal: the kerf is not taken off; parts are at least {nest.gap_mm:g} mm apart.",
        "Millimetres. Outer side up. Layers: CUT contours, MARK open strokes, SHEET stock.",
    )
    return tuple(
        Drawing(f"sheet-{k + 1:03d}", {SHEET: (_closed(stock),), CUT: tuple(cut[k]), MARK: tuple(mark[k])}, notes)
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
    marks = _marks(panels, list(common.values()))
    notes = (
        "Contours are nominal: the kerf is not taken off.",
        "Millimetres. Outer side up. Layers: CUT contour, MARK open strokes.",
    )
    return tuple(
        Drawing(panel.mark, {CUT: (_closed(panel.outline),), MARK: tuple(strokes)}, notes)
        for panel, strokes in zip(panels, marks, strict=True)
    )


def _marks(panels: Sequence[Panel], edge_texts: Sequence[Sequence[str]]) -> list[list[FloatArray]]:
    """Strokes of each panel in its own frame: its mark, an arrow along its first edge, a text along each edge."""
    if not panels:
        return []
    shapes = polygons([panel.outline for panel in panels])
    circles = shapely.get_coordinates(shapely.maximum_inscribed_circle(shapes)).reshape(-1, 2, 2)
    radii = np.linalg.norm(circles[:, 1] - circles[:, 0], axis=1)
    middle = _middle_labels([panel.mark for panel in panels], circles[:, 0], radii).strokes(len(panels))
    edges = _edge_labels(panels, edge_texts, shapes, radii).strokes(len(panels))
    return [own + others for own, others in zip(middle, edges, strict=True)]


def _middle_labels(texts: Sequence[str], centres: FloatArray, radii: FloatArray) -> _Labels:
    widths = np.array([text_width(text) for text in texts])
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
    widths = np.array([text_width(text) for text in texts])
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


def _runs(points: FloatArray, alike: Sequence[FloatArray]) -> list[FloatArray]:
    """Points (n, 2) as curves as long as those alike, one after the other."""
    points, ends = floats(points), np.cumsum([len(curve) for curve in alike]).tolist()
    return [points[start:end] for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def _closed(outline: FloatArray) -> FloatArray:
    return floats(np.concatenate([outline, outline[:1]]))
