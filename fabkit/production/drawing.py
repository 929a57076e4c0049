"""Drawings for cutting machines, as data: layers of curves in millimetres.

Layers: CUT, the nominal contours; MARK, open strokes to engrave or plot: the mark in the middle of the panel, an
arrow along its first (longest) edge, and in the drawing of a single panel also the neighbours' marks along the edges;
SHEET, the outline of the stock sheet. No line is drawn twice. The title stands below the drawing, as text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import shapely

from fabkit.errors import DetailingError
from fabkit.kinds import LEFT_OUT, NO_NEIGHBOUR, PANEL, PanelDetails, neighbour_names, panel_outlines
from fabkit.parts import Assembly, Curves, Parts, Ragged
from fabkit.production.nesting.nests import Nest, placed, polygons
from fabkit.production.strokes import ARROW, text_strokes, text_widths
from geometry.arrays import FloatArray, IntArray, integers

__all__ = ["CUT", "MARK", "SHEET", "Drawing", "panel_drawings", "sheet_drawings"]

CUT, MARK, SHEET = "CUT", "MARK", "SHEET"

MAX_MARK_HEIGHT_MM, MAX_EDGE_MARK_HEIGHT_MM = 80.0, 30.0
"""Largest height of a panel's own mark, and of the marks along its edges, in mm."""

LEAST_READABLE_HEIGHT_MM = 3.0
"""Minimum height of a neighbour's mark in mm: smaller ones cannot be read and are omitted."""

MARK_SHARE, EDGE_MARK_SHARE, EDGE_GAP_SHARE = 0.7, 0.14, 0.06
"""Half the diagonal of a panel's mark, the height of the marks along its edges, and their distance from the edges, over
the radius of the largest circle inside the panel. They add up to less than one, so the marks do not meet."""

CORNER_GAP_SHARE = 0.075
"""Distance of a label in a corner from the edges, over the size of the corner: 1.5 mm of 20, which leaves letters of 3
mm."""

Labels = Literal["corner", "middle", "none"]
"""Where marks and arrows are drawn on panels."""

MAX_EDGE_SHARE = 0.4
"""Largest length of a mark along an edge, over the length of the edge."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """Curves by layer.

    name: of the file. layers: the curves of each layer in mm. notes: sentences for the head of the file. title: lines
    below the drawing. circles: of some layers (k, 3), centre and radius in mm.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import CUT, panel_drawings
    >>> drawing = panel_drawings(built.assembly)[0]
    >>> drawing.name, list(drawing.layers), len(drawing.layers[CUT])
    ('P001', ['CUT', 'MARK'], 1)
    """

    name: str
    layers: Mapping[str, Curves]
    notes: tuple[str, ...] = ()
    title: tuple[str, ...] = ()
    circles: Mapping[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Labels:
    """Texts on panels. panel (m,): index; foot (m, 2): middle of the base line in mm; along (m, 2): direction of the
    line; height (m,) in mm."""

    texts: Sequence[str]
    panel: IntArray
    foot: FloatArray
    along: FloatArray
    height: FloatArray

    def strokes(self) -> tuple[Curves, IntArray]:
        """Polylines in mm in the frames of their panels, and (k,) the panel of each."""
        curves, text = text_strokes(self.texts)
        x = self.along * self.height[:, None]
        y = np.stack([-x[:, 1], x[:, 0]], axis=1)
        start = self.foot - x * (text_widths(self.texts) / 2)[:, None]
        of_point, points = text[curves.row], curves.values
        placed = start[of_point] + points[:, :1] * x[of_point] + points[:, 1:] * y[of_point]
        return Curves(placed, curves.starts), self.panel[text]

    def boxes(self) -> FloatArray:
        """(m, 4, 2) corners of the boxes of the texts, in mm."""
        up = np.stack([-self.along[:, 1], self.along[:, 0]], axis=1) * self.height[:, None]
        half = self.along * (self.height * text_widths(self.texts) / 2)[:, None]
        corners = [self.foot - half, self.foot + half, self.foot + half + up, self.foot - half + up]
        return np.stack(corners, axis=1)


def sheet_drawings(
    nest: Nest, panels: Parts[PanelDetails], *, labels: Labels = "middle", corner_mm: float = 20.0, title: str = ""
) -> tuple[Drawing, ...]:
    """One drawing for each sheet of the nest, named sheet-001 and so on.

    labels: where mark and arrow of a panel are drawn: in its middle, at its first corner beside its first edge, not
    wider than corner_mm, or nowhere. title: first words below each sheet; then come material, thickness and sheet n
    of m.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import CUT, sheet_drawings
    >>> drawings = sheet_drawings(built.nest, built.assembly["panels"])
    >>> [(drawing.name, len(drawing.layers[CUT])) for drawing in drawings]
    [('sheet-001', 4), ('sheet-002', 6), ('sheet-003', 2)]
    """
    sheets = np.array([place.sheet for place in nest.placements], dtype=np.int64)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    stock = [corners * [sheet.length_mm, sheet.width_mm] for sheet in nest.sheets]
    in_panel_frames = panel_outlines(panels)
    outlines = _closed(
        in_panel_frames.with_values(placed(in_panel_frames.values, in_panel_frames.row, nest.placements))
    )
    no_texts = [""] * len(in_panel_frames.values)
    strokes, panel = _marks(panels.marks, in_panel_frames, no_texts, labels, corner_mm)
    strokes = strokes.with_values(placed(strokes.values, panel[strokes.row], nest.placements))
    cut, mark = outlines.grouped(sheets, nest.n_sheets), strokes.grouped(sheets[panel], nest.n_sheets)
    notes = (
        f"Contours are nominal, without allowance for the kerf; parts are at least {nest.gap_mm:g} mm apart.",
        "Millimetres. Outer side up. Layers: CUT contours, MARK open strokes, SHEET stock, TITLE text.",
    )
    stocks = panels.kind.stock(panels) if panels.kind.stock else [""] * len(panels)
    made_of = [
        ", ".join(dict.fromkeys(stocks[n] for n in np.flatnonzero(sheets == k).tolist())) for k in range(nest.n_sheets)
    ]
    below = [
        _title(title, made, f"sheet {k + 1} of {nest.n_sheets}", labels, panels.kind.first_edge)
        for k, made in enumerate(made_of)
    ]
    return tuple(
        Drawing(
            f"sheet-{k + 1:03d}",
            {SHEET: Curves.of([stock[k]]), CUT: cut[k], MARK: mark[k]},
            notes,
            below[k] if title else (),
        )
        for k in range(nest.n_sheets)
    )


def _title(project: str, made_of: str, which: str, labels: Labels, first_edge: str) -> tuple[str, ...]:
    arrow = () if labels == "none" else (f"arrow: from corner 1 along edge 1, {first_edge}",)
    return (project, ", ".join(word for word in (made_of, which) if word), *arrow)


def panel_drawings(
    assembly: Assembly, *, labels: Labels = "middle", corner_mm: float = 20.0, title: str = ""
) -> tuple[Drawing, ...]:
    """One drawing for each mark of a panel, and of fins and other plates that are cut out of sheets, named like the
    mark, in the plate's own frame, in their order.

    labels, corner_mm, title: as of sheets. With labels in the middle, a neighbour's mark is drawn along an edge if all
    panels of this mark have that neighbour, and if there is room.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import panel_drawings
    >>> [drawing.name for drawing in panel_drawings(built.assembly)]
    ['P001', 'P002']
    """
    kinds = (parts for parts in assembly.groups if parts.kind.first_edge)
    return tuple(drawing for parts in kinds for drawing in _plate_drawings(parts, labels, corner_mm, title))


def _plate_drawings(every: Parts[Any], labels: Labels, corner_mm: float, title: str) -> Iterator[Drawing]:
    outlines = panel_outlines(every)[every.firsts]
    across = _common_neighbours(every) if every.kind is PANEL else [""] * len(outlines.values)
    strokes, panel_of_stroke = _marks(every.mark_names, outlines, across, labels, corner_mm)
    stocks = every.kind.stock(every) if every.kind.stock else [""] * len(every)
    finishes = every.kind.finishes(every) if every.kind.finishes else [""] * len(every)
    made_of = [", ".join(filter(None, (stocks[k], finishes[k]))) for k in every.firsts.tolist()]
    notes = (
        "Contours are nominal, without allowance for the kerf.",
        "Millimetres. Outer side up. Layers: CUT contour, MARK open strokes, TITLE text.",
    )
    contours = _closed(outlines).grouped(np.arange(len(outlines)), len(outlines))
    of_panels = strokes.grouped(panel_of_stroke, len(outlines))
    for mark, contour, own, stock in zip(every.mark_names, contours, of_panels, made_of, strict=True):
        name = f"{every.kind.name} {mark}"
        below = _title(title, stock, name, labels, every.kind.first_edge) if title else ()
        yield Drawing(mark, {CUT: contour, MARK: own}, notes, below)


def _common_neighbours(panels: Parts[PanelDetails]) -> list[str]:
    """For each edge of the first panel of each mark, the neighbour's mark if it is the same for all panels of the mark,
    and an empty text if not."""
    across = panels.details.neighbours
    numbers: dict[str, int] = {"": 0, NO_NEIGHBOUR: 0, LEFT_OUT: 0}
    names = neighbour_names(panels, panels.marks, LEFT_OUT, NO_NEIGHBOUR)
    number = np.array([numbers.setdefault(name, len(numbers)) for name in names], dtype=np.int64)
    starts = np.concatenate([[0], np.cumsum(across.sizes[panels.firsts])])
    edge = starts[panels.mark[across.row]] + across.place
    smallest, largest = np.full(starts[-1], len(numbers)), np.zeros(starts[-1], dtype=np.int64)
    np.minimum.at(smallest, edge, number)
    np.maximum.at(largest, edge, number)
    texts = list(numbers)
    return [texts[k] for k in np.where(smallest == largest, largest, 0).tolist()]


def _marks(
    marks: Sequence[str], outlines: Ragged, edge_texts: Sequence[str], labels: Labels, corner_mm: float
) -> tuple[Curves, IntArray]:
    """Strokes in the panels' own frames, panel after panel, and the panel of each stroke. They draw the panel's mark,
    an arrow along its first edge and, with the mark in the middle, a text along each edge."""
    if not marks or labels == "none":
        return Curves.of([]), integers([])
    shapes = polygons(outlines)
    if labels == "corner":
        return _corner_labels(marks, outlines, shapes, corner_mm).strokes()
    circles = shapely.get_coordinates(shapely.maximum_inscribed_circle(shapes)).reshape(-1, 2, 2)
    radii = np.linalg.norm(circles[:, 1] - circles[:, 0], axis=1)
    middle, of_middle = middle_labels(marks, circles[:, 0], radii).strokes()
    edges, of_edges = _edge_labels(marks, outlines, edge_texts, shapes, radii).strokes()
    panel = np.concatenate([of_middle, of_edges])
    order = np.argsort(panel, kind="stable")
    return Curves.joined([middle, edges])[order], panel[order]


def middle_labels(texts: Sequence[str], centres: FloatArray, radii: FloatArray) -> _Labels:
    """Texts in the middles of circles, with these centres (m, 2) and radii (m,), in which there is nothing else."""
    widths = text_widths(texts)
    height = np.minimum(MAX_MARK_HEIGHT_MM, 2 * MARK_SHARE * radii / np.hypot(widths, 1.0))
    foot = centres - np.stack([np.zeros(len(texts)), height / 2], axis=1)
    along = np.tile([1.0, 0.0], (len(texts), 1))
    return _Labels(texts, np.arange(len(texts)), foot, along, height)


def _edge_labels(
    marks: Sequence[str], outlines: Ragged, edge_texts: Sequence[str], shapes: np.ndarray, radii: FloatArray
) -> _Labels:
    """Texts along edges, upright when the edge is below. A text that does not lie inside the panel is made smaller, and
    omitted when it becomes unreadable, except for the arrow."""
    panel, start = outlines.row, outlines.values
    end = outlines.rolled(np.ones(len(outlines), dtype=np.int64)).values
    texts = [ARROW + t if edge == 0 else t for edge, t in zip(outlines.place.tolist(), edge_texts, strict=True)]
    nonempty = np.flatnonzero([text != "" for text in texts])
    texts, panel, start, end = [texts[k] for k in nonempty], panel[nonempty], start[nonempty], end[nonempty]
    lengths = np.linalg.norm(end - start, axis=1)
    along = (end - start) / lengths[:, None]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    widths = text_widths(texts)
    height = np.minimum(
        MAX_EDGE_MARK_HEIGHT_MM, np.minimum(EDGE_MARK_SHARE * radii[panel], MAX_EDGE_SHARE * lengths / widths)
    )

    def labels(chosen: IntArray) -> _Labels:
        gap = height[chosen] * EDGE_GAP_SHARE / EDGE_MARK_SHARE
        foot = (start + end)[chosen] / 2 + inward[chosen] * gap[:, None]
        return _Labels([texts[k] for k in chosen], panel[chosen], foot, along[chosen], height[chosen])

    _make_smaller(height, labels, marks, panel, shapes)
    arrow = np.array([text[0] == ARROW for text in texts])
    return labels(np.flatnonzero(arrow | (height >= LEAST_READABLE_HEIGHT_MM)))


def _corner_labels(marks: Sequence[str], outlines: Ragged, shapes: np.ndarray, corner_mm: float) -> _Labels:
    """The mark and, after it, an arrow along the first edge, beside that edge and as near to its start as they lie
    inside the panel."""
    texts = [mark + ARROW for mark in marks]
    first = outlines.starts[:-1]
    start, end, before = outlines.values[first], outlines.values[first + 1], outlines.values[outlines.starts[1:] - 1]
    along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    back = before - start
    lean = (back * along).sum(axis=1) / (back * inward).sum(axis=1)  # of the edge before, per height above the first
    gap, widths = CORNER_GAP_SHARE * corner_mm, text_widths(texts)
    height = (corner_mm - 2 * gap) / widths

    def labels(chosen: IntArray) -> _Labels:
        beside = gap * np.hypot(1.0, lean[chosen]) + np.maximum(lean[chosen], 0.0) * (gap + height[chosen])
        middle = beside + height[chosen] * widths[chosen] / 2
        foot = start[chosen] + along[chosen] * middle[:, None] + inward[chosen] * gap
        return _Labels([texts[k] for k in chosen], chosen, foot, along[chosen], height[chosen])

    every = np.arange(len(texts))
    _make_smaller(height, labels, marks, every, shapes)
    return labels(every)


def _make_smaller(
    height: FloatArray,
    labels: Callable[[IntArray], _Labels],
    marks: Sequence[str],
    panel: IntArray,
    shapes: np.ndarray,
) -> None:
    """Halve the heights of the labels (m,) that do not lie inside their panels (m,), until they do."""
    outside = np.arange(len(height))
    shapely.prepare(shapes)  # a panel with thousands of corners is queried for each of its edges
    while len(outside):
        if height[outside].min() < LEAST_READABLE_HEIGHT_MM * 1e-3:
            named = ", ".join(marks[k] for k in np.unique(panel[outside])[:10])
            raise DetailingError(
                f"panels {named}: no mark fits inside; give an outline that runs counter-clockwise and is not a sliver"
            )
        boxes = labels(outside).boxes()
        inside = shapely.contains_properly(shapes[panel[outside]], shapely.polygons(boxes))
        outside = outside[~inside]
        height[outside] /= 2


def _closed(outlines: Ragged) -> Curves:
    """Each with its first point at its end, too."""
    values = np.insert(outlines.values, outlines.starts[1:], outlines.values[outlines.starts[:-1]], axis=0)
    return Curves(values, outlines.starts + np.arange(len(outlines) + 1))
