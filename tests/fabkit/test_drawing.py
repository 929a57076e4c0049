"""What a drawing must be: nominal contours, marks inside them, no line twice."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, MultiLineString, Polygon

from fabkit.errors import DetailingError, OutputError
from fabkit.parts import Assembly, Part
from fabkit.production.drawing import CUT, MARK, SHEET, Drawing, panel_drawings, sheet_drawings
from fabkit.production.nesting.nests import Sheet
from fabkit.production.nesting.sheet_nesting import nest_panels
from fabkit.production.strokes import ARROW, GLYPHS, text_strokes, text_widths
from geometry.arrays import FloatArray
from tests.fabkit.assemblies import assembled
from tests.fabkit.plates import outlines, plate, plates

SQUARE = np.array([[0.0, 0.0], [1000.0, 0.0], [1000.0, 1000.0], [0.0, 1000.0]])


def assembly(panels: Iterable[Part]) -> Assembly:
    return assembled("test", panels=panels)


def segments(drawing: Drawing) -> list[tuple[tuple[float, ...], ...]]:
    """The straight lines of all layers, each with its ends in order, to a thousandth of a millimetre."""
    pairs = [pair for curves in drawing.layers.values() for c in curves for pair in pairwise(c)]
    return [tuple(sorted(tuple(np.round(point, 3) + 0.0) for point in pair)) for pair in pairs]


def strokes_of(text: str) -> list[FloatArray]:
    return list(text_strokes([text])[0])


@settings(deadline=None, max_examples=40)
@given(st.lists(outlines(), min_size=1, max_size=12))
def test_sheets_show_each_panel_once_with_its_marks_inside(some: list[FloatArray]) -> None:
    panels = plates(some)
    nest = nest_panels(panels, Sheet(3000.0, 2000.0), gap_mm=5, border_mm=10)
    drawings = sheet_drawings(nest, panels)
    assert [drawing.name for drawing in drawings] == [f"sheet-{k + 1:03d}" for k in range(nest.n_sheets)]
    areas = []
    for drawing in drawings:
        (stock,) = drawing.layers[SHEET]
        assert Polygon(stock).bounds == (0, 0, 3000, 2000)
        cut = [Polygon(curve) for curve in drawing.layers[CUT]]
        areas += [shape.area for shape in cut]
        assert all((curve[0] == curve[-1]).all() for curve in drawing.layers[CUT])
        assert len(segments(drawing)) == len(set(segments(drawing)))
        n_strokes = [0] * len(cut)
        for stroke in drawing.layers[MARK]:
            inside = [shape.contains_properly(LineString(stroke)) for shape in cut]
            assert sum(inside) == 1
            n_strokes[inside.index(True)] += 1
        # a letter, three digits and an arrow each
        assert min(n_strokes) >= 5 + 1
    np.testing.assert_allclose(sorted(areas), sorted(panel.details.area_mm2 for panel in panels), rtol=1e-9)


@settings(deadline=None, max_examples=40)
@given(outlines(least=20.0), st.booleans())
def test_one_panel_shows_its_neighbours_where_there_is_room(outline: FloatArray, alone: bool) -> None:
    before = plates([outline])[0].solid.vertices[: len(outline), :2]
    n = len(outline)
    ring = [plate(f"P{k + 2:03d}", SQUARE, element=k + 1) for k in range(n)]
    panel = plate("P001", before, neighbours=[-1] * n if alone else list(range(1, n + 1)))
    drawing = panel_drawings(assembly([panel, *ring]))[0]
    shape = Polygon(before)
    assert drawing.name == "P001"
    assert set(drawing.layers) == {CUT, MARK}
    assert all(shape.contains_properly(LineString(stroke)) for stroke in drawing.layers[MARK])
    assert len(segments(drawing)) == len(set(segments(drawing)))
    least = len(strokes_of("P001")) + len(strokes_of(ARROW))
    if alone:
        assert len(drawing.layers[MARK]) == least
    else:
        assert len(drawing.layers[MARK]) >= least + len(strokes_of("P002"))


def test_marks_on_a_square_stand_apart_and_read_along_the_edges() -> None:
    panels = [plate("P001", SQUARE, neighbours=[1, 2, 3, 4])]
    panels += [plate(f"P{k + 1:03d}", SQUARE, element=k) for k in range(1, 5)]
    strokes = list(panel_drawings(assembly(panels))[0].layers[MARK])
    boxes = []
    for text in ("P001", ARROW + "P002", "P003", "P004", "P005"):
        count = len(strokes_of(text))
        boxes.append(MultiLineString([stroke.tolist() for stroke in strokes[:count]]))
        del strokes[:count]
    assert strokes == []
    for one, other in combinations(boxes, 2):
        assert one.envelope.disjoint(other.envelope)
    middle = np.array([box.envelope.centroid.coords[0] for box in boxes])
    assert middle[0] == pytest.approx([500, 500], abs=1e-9)
    for box, edge in zip(middle[1:], [[500, 0], [1000, 500], [500, 1000], [0, 500]], strict=True):
        assert np.linalg.norm(box - edge) < 50
    _, y = boxes[0].envelope.exterior.xy
    assert max(y) - min(y) == pytest.approx(80)
    # the arrow points along the first edge: its tip is where its head's three points come together
    shaft, head = list(panel_drawings(assembly(panels))[0].layers[MARK])[len(strokes_of("P001")) :][:2]
    assert shaft[1, 0] > shaft[0, 0]
    assert head[1] == pytest.approx(shaft[1])


def test_a_shared_drawing_names_only_common_neighbours() -> None:
    def shown(*neighbours: list[int]) -> int:
        panels = [plate("P001", SQUARE, element=k, neighbours=row) for k, row in enumerate(neighbours)]
        panels += [plate("P00" + "I" * k, SQUARE, element=10 + k) for k in range(1, 4)]
        drawings = panel_drawings(assembly(panels))
        assert [drawing.name for drawing in drawings] == ["P001", "P00I", "P00II", "P00III"]
        return len(drawings[0].layers[MARK])

    none = shown([-1, -1, -1, -1])
    i = len(strokes_of("P00I"))
    assert shown([11, -1, -1, -1]) == none + i
    assert shown([11, 12, -1, -1], [11, 12, -1, -1]) == none + i + len(strokes_of("P00II"))
    assert shown([11, 12, -1, -1], [11, 13, -1, -1]) == none + i
    assert shown([11, 12, -1, -1], [13, 11, -1, -1]) == none
    assert shown([99, -1, -1, -1]) == none  # left out


def test_labels_too_small_to_read_are_left_away_but_not_the_mark() -> None:
    tiny = plate("P001", SQUARE / 100, neighbours=[1, 1, 1, 1])
    large = plate("P002", SQUARE, element=1)
    strokes = panel_drawings(assembly([tiny, large]))[0].layers[MARK]
    assert len(strokes) == len(strokes_of("P001")) + len(strokes_of(ARROW + "P002"))


def test_a_clockwise_outline_is_refused() -> None:
    with pytest.raises(DetailingError, match="P001: no mark fits inside"):
        panel_drawings(assembly([plate("P001", SQUARE[::-1])]))


def test_no_panels_need_no_drawings() -> None:
    nest = nest_panels(plates([]), Sheet(3000.0, 2000.0), gap_mm=5, border_mm=10)
    assert sheet_drawings(nest, plates([])) == ()
    assert panel_drawings(assembly([])) == ()


def test_characters_differ_and_draw_no_line_twice() -> None:
    assert len(set(GLYPHS.values())) == len(GLYPHS)
    for character in GLYPHS:
        strokes = strokes_of(character)
        lines = [frozenset(map(tuple, pair)) for s in strokes for pair in pairwise(s.tolist())]
        assert len(lines) == len(set(lines)), character
        points = np.concatenate(strokes)
        assert points.min() >= 0
        assert points[:, 1].max() <= 1
        assert points[:, 0].max() <= text_widths([character])[0] + 1e-12  # rounding


def test_texts_run_on() -> None:
    """The second character starts where the first ends, and a space."""
    pair, single = strokes_of("P1"), strokes_of("P")
    assert len(pair) == len(single) + len(strokes_of("1"))
    moved = pair[len(single)] - strokes_of("1")[0]
    np.testing.assert_allclose(moved, [[text_widths(["P"])[0] + 2 / 6, 0]] * len(moved), atol=1e-12)


def test_an_unknown_character_is_named() -> None:
    with pytest.raises(OutputError, match="'P_1' cannot be drawn: the alphabet has no '_'"):
        strokes_of("P_1")


@settings(deadline=None, max_examples=40)
@given(st.lists(outlines(), min_size=1, max_size=4))
def test_labels_in_a_corner_are_open_strokes_beside_the_first_edge(some: list[FloatArray]) -> None:
    panels = plates(some)
    for drawing, outline in zip(panel_drawings(assembly(panels), labels="corner"), some, strict=True):
        strokes = list(drawing.layers[MARK])
        assert strokes
        shape = Polygon(drawing.layers[CUT][0])
        for stroke in strokes:
            assert shape.contains_properly(LineString(stroke))
            assert not (stroke[0] == stroke[-1]).all()
            assert stroke[:, 1].max() <= 20  # above the first edge, which lies on the x axis
        width = np.ptp(np.concatenate(strokes)[:, 0])
        assert width <= 20
        assert len(outline) >= 3
    assert all(not len(drawing.layers[MARK]) for drawing in panel_drawings(assembly(panels), labels="none"))


def test_every_stroke_of_the_alphabet_is_open() -> None:
    curves, _ = text_strokes([*GLYPHS])
    assert not curves.is_closed.any()
