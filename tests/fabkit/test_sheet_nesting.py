"""Every nest holds each panel once, inside its sheet, apart from the others; and no nest is worse than it says."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from importlib.util import find_spec
from itertools import combinations
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, affinity

from fabkit import Project
from fabkit.errors import NestingError, ProjectError
from fabkit.kinds import PANEL, PanelDetails, panel_outlines
from fabkit.parts import Parts, Ragged
from fabkit.production.nesting import irregular, sheet_nesting
from fabkit.production.nesting.guillotine import smallest_rectangles
from fabkit.production.nesting.nests import NEST_TOLERANCE_MM, Nest, Placement, Sheet, Stock, check_nest
from fabkit.production.nesting.sheet_nesting import nest_panels, too_large
from fabkit.rules import SheetRules
from geometry.arrays import FloatArray
from geometry.mesh.shapes import dome
from tests.fabkit.plates import outlines, plate, plates

SHEET = Sheet(3000.0, 2000.0)
ENGINES = [
    pytest.param(engine, marks=pytest.mark.skipif(find_spec(engine.name) is None, reason=f"no {engine.name}"))
    for engine in (irregular.PackingSolver, irregular.Spyrrow)
]
gaps = st.sampled_from([0.0, 3.0, 10.0])
borders = st.sampled_from([0.0, 15.0])


def placed(nest: Nest, panels: Parts[PanelDetails]) -> list[list[Polygon]]:
    """The outlines on each sheet, placed by shapely."""
    sheets: list[list[Polygon]] = [[] for _ in range(nest.n_sheets)]
    for place in nest.placements:
        turned = affinity.rotate(Polygon(panel_outlines(panels)[place.panel]), place.angle_deg, origin=(0, 0))
        sheets[place.sheet].append(affinity.translate(turned, *place.offset_mm))
    return sheets


def assert_sound(nest: Nest, panels: Parts[PanelDetails]) -> None:
    assert sorted(place.panel for place in nest.placements) == list(range(len(panels)))
    assert {place.sheet for place in nest.placements} == set(range(nest.n_sheets))
    for sheet, shapes in zip(nest.sheets, placed(nest, panels), strict=True):
        for shape in shapes:
            x, y, x_end, y_end = shape.bounds
            room = min(x, y, sheet.length_mm - x_end, sheet.width_mm - y_end)
            assert room >= nest.border_mm - NEST_TOLERANCE_MM
        for one, other in combinations(shapes, 2):
            assert one.distance(other) >= nest.gap_mm - NEST_TOLERANCE_MM
            # touching in a line of rounding's width is no overlap
            assert one.intersection(other).area <= NEST_TOLERANCE_MM * one.length


def cut_apart(boxes: FloatArray) -> bool:
    """Whether cuts from edge to edge separate all the boxes (n, 2 corners, 2)."""
    if len(boxes) < 2:
        return True
    for axis in (0, 1):
        boxes = boxes[np.argsort(boxes[:, 0, axis], kind="stable")]
        ends = np.maximum.accumulate(boxes[:, 1, axis])[:-1]
        cuts = np.flatnonzero(ends <= boxes[1:, 0, axis] + NEST_TOLERANCE_MM)
        if len(cuts):
            return cut_apart(boxes[: cuts[0] + 1]) and cut_apart(boxes[cuts[0] + 1 :])
    return False


@settings(deadline=None, max_examples=40)
@given(st.lists(outlines(), max_size=25), gaps, borders)
def test_quick_nests_are_valid_and_cut_from_edge_to_edge(some: list[FloatArray], gap: float, border: float) -> None:
    panels = plates(some)
    nest = nest_panels(panels, SHEET, gap_mm=gap, border_mm=border)
    assert_sound(nest, panels)
    assert nest == nest_panels(panels, SHEET, gap_mm=gap, border_mm=border)
    for shapes in placed(nest, panels):
        assert cut_apart(np.array([shape.bounds for shape in shapes]).reshape(-1, 2, 2))


@pytest.mark.parametrize("engine", ENGINES)
@settings(deadline=None, max_examples=3)
@given(some=st.lists(outlines(), min_size=12, max_size=20), gap=gaps, border=borders)
def test_best_nests_are_valid_and_never_worse(
    engine: type[irregular.Engine], some: list[FloatArray], gap: float, border: float
) -> None:
    panels = plates(some)
    quick = nest_panels(panels, SHEET, gap_mm=gap, border_mm=border)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sheet_nesting, "installed_engine", engine)
        best = nest_panels(panels, SHEET, gap_mm=gap, border_mm=border, mode="best", seconds=1.2)
    assert_sound(best, panels)
    assert best.n_sheets <= quick.n_sheets
    assert best.engine in ("guillotine", engine.name)


@pytest.mark.parametrize("engine", ENGINES)
def test_engines_lay_triangles_closer_than_their_rectangles(
    engine: type[irregular.Engine], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sheet_nesting, "installed_engine", engine)
    panels = plates([np.array([[0, 0], [900, 0], [300, 800]])] * 16)
    reports: list[tuple[float, str]] = []
    start = time.monotonic()
    quick = nest_panels(panels, SHEET, gap_mm=5, border_mm=10)
    best = nest_panels(panels, SHEET, gap_mm=5, border_mm=10, mode="best", seconds=2.0,
                       progress=lambda fraction, text: reports.append((fraction, text)))  # fmt: skip
    assert_sound(best, panels)
    assert best.n_sheets < quick.n_sheets
    assert best.engine == engine.name
    assert best.utilisation > quick.utilisation
    fractions = [fraction for fraction, _ in reports]
    assert fractions == sorted(fractions)
    assert all(0 <= fraction <= 1 for fraction in fractions)
    assert engine.name in reports[-1][1]
    assert time.monotonic() - start < 6.0  # the budget, and as much again for a busy machine


SQUARE = np.array([[0, 0], [500, 0], [500, 500], [0, 500.0]])
SLIVER = np.array([[0, 0], [2900, 0], [2900, 0.5], [0, 0.5]])
NEEDLE = np.array([[0, 0], [500, 0], [500, 500], [499, 5000 / 499], [0, 10.0]])
NICK = np.array([[0, 0], [500, 0], [500, 500], [0.3, 500], [0, 499.7]])


def test_slivers_needles_and_nicks_are_kept_from_the_engines() -> None:
    strip = np.array([[0, 0], [2500, 0], [2500, 60.0], [0, 60]])
    some = [SQUARE, strip, SLIVER, NEEDLE, NICK]
    assert irregular.suits_engines(Ragged.of(some, shape=(2,))).tolist() == [True, True, False, False, False]


@pytest.mark.parametrize("engine", ENGINES)
def test_panels_unsuitable_for_engines_are_nested_all_the_same(
    engine: type[irregular.Engine], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sheet_nesting, "installed_engine", engine)
    panels = plates([SLIVER, NEEDLE, NICK] + [SQUARE] * 30)
    assert_sound(nest_panels(panels, SHEET, gap_mm=0, border_mm=10, mode="best", seconds=1.2), panels)


class Idle:
    """An engine that takes its time and finds what it is given to find."""

    name = "idle"

    def __init__(self, found: list[Placement], min_seconds: float = 0.0) -> None:
        self.found, self.min_seconds = found, min_seconds

    def fill(self, outlines: Ragged, stock: Stock, seconds: float) -> list[Placement]:
        time.sleep(self.min_seconds)
        return self.found


def random_plates(seed: int, n: int) -> Parts[PanelDetails]:
    """Quads of all sizes."""
    rng = np.random.default_rng(seed)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    return plates([square * rng.uniform(200, 1200, 2) + rng.normal(0, 40, (4, 2)) for _ in range(n)])


@pytest.mark.parametrize("seed", range(8))
def test_an_engine_that_finds_nothing_makes_nothing_worse(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sheet_nesting, "installed_engine", lambda: Idle([]))
    panels = random_plates(seed, 40)
    quick = nest_panels(panels, SHEET, gap_mm=5, border_mm=10)
    best = nest_panels(panels, SHEET, gap_mm=5, border_mm=10, mode="best", seconds=5.0)
    assert best.n_sheets <= quick.n_sheets


def test_the_budget_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sheet_nesting, "installed_engine", lambda: Idle([], min_seconds=0.2))
    panels = random_plates(0, 200)
    start = time.monotonic()
    nest_panels(panels, SHEET, gap_mm=5, border_mm=10, mode="best", seconds=0.5)
    # a call for each sheet would take more than 3 s
    assert time.monotonic() - start < 2.5


def test_an_engine_that_lays_panels_over_each_other_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    everything_in_one_place = [Placement(k, 0, 0.0, (10.0, 10.0)) for k in range(40)]
    monkeypatch.setattr(sheet_nesting, "installed_engine", lambda: Idle(everything_in_one_place))
    panels = plates([np.array([[0, 0], [900, 0], [300, 800]])] * 40)
    with pytest.raises(NestingError, match="P001 and P002"):
        nest_panels(panels, SHEET, gap_mm=5, border_mm=10, mode="best", seconds=5.0)


def test_best_without_an_engine_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(irregular, "find_spec", lambda name: None)
    with pytest.raises(NestingError, match=r"install packingsolver .* or spyrrow"):
        nest_panels(plates([]), SHEET, gap_mm=5, border_mm=10, mode="best")


@given(outlines())
def test_no_turn_has_a_smaller_rectangle(outline: FloatArray) -> None:
    angles, sizes = smallest_rectangles(Ragged.of([outline], shape=(2,)), (1e5, 1e5))
    shape = Polygon(outline)
    x, y, x_end, y_end = affinity.rotate(shape, angles[0], origin=(0, 0)).bounds
    np.testing.assert_allclose(sizes[0], [x_end - x, y_end - y], rtol=1e-9)  # rounding
    for angle in range(0, 90, 3):
        x, y, x_end, y_end = affinity.rotate(shape, angle).bounds
        assert sizes[0].prod() <= (x_end - x) * (y_end - y) * (1 + 1e-9)


def test_of_two_rectangles_the_one_that_fits_is_taken() -> None:
    # The smallest rectangle lies along the long edge and is longer than the sheet.
    outline = np.array([[0.0, 0.0], [3100.0, 0.0], [3100.0, 100.0], [1200.0, 700.0]])
    _, sizes = smallest_rectangles(Ragged.of([outline], shape=(2,)), (1e5, 1e5))
    assert sizes[0, 0] > 3050
    _, sizes = smallest_rectangles(Ragged.of([outline], shape=(2,)), (3050.0, 2000.0))
    assert sizes[0, 0] <= 3050


def test_panels_that_fit_exactly_fit() -> None:
    across = np.deg2rad(37.0)
    turn = np.array([[np.cos(across), np.sin(across)], [-np.sin(across), np.cos(across)]])
    whole = np.array([[0, 0], [2970.0, 0], [2970.0, 1970.0], [0, 1970.0]])
    half = np.array([[0, 0], [1480.0, 0], [1480.0, 1970.0], [0, 1970.0]])
    panels = plates([whole @ turn, half @ turn, half])
    nest = nest_panels(panels, SHEET, gap_mm=10, border_mm=15)
    assert_sound(nest, panels)
    assert nest.n_sheets == 2
    assert nest.utilisation == pytest.approx((2970 + 2 * 1480) * 1970 / (2 * 6e6), rel=1e-12)


def test_too_large_panels_are_named() -> None:
    small, large = np.array([[0, 0], [500, 0], [0, 500.0]]), np.array([[0, 0], [3100, 0], [3100, 200.0], [0, 200]])
    panels = Parts.of(PANEL, [plate("P001", small), plate("P002", large), plate("P003", large)])
    message = r"panel P002 .* 3100\.0 x 200\.0 mm, and the sheet offers 2970 x 1970 mm; panel P003 .* Use larger sheets"
    with pytest.raises(NestingError, match=message):
        nest_panels(panels, SHEET, gap_mm=10, border_mm=15)


def test_no_panels_need_no_sheets() -> None:
    nest = nest_panels(plates([]), SHEET, gap_mm=10, border_mm=15)
    assert (nest.n_sheets, nest.utilisation) == (0, 0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gap_mm": -1.0}, "a gap of -1 mm"),
        ({"border_mm": 1000.0}, "a border of 1000 mm"),
        ({"gap_mm": float("nan")}, "a gap of nan mm"),
        ({"sheet": Sheet(0.0, 2000.0)}, "0 x 2000 mm"),
    ],
)
def test_invalid_stock_is_refused(change: dict[str, object], message: str) -> None:
    request = {"sheet": SHEET, "gap_mm": 10.0, "border_mm": 15.0, **change}
    with pytest.raises(NestingError, match=message):
        nest_panels(plates([np.eye(3)[:, :2] * 100]), **request)  # type: ignore[arg-type]


def test_sheets_without_room_within_their_borders_are_refused_before_panels_are_called_too_large() -> None:
    with pytest.raises(NestingError, match="a border of 1000 mm has no room for panels"):
        too_large(plates([SQUARE]), SHEET, border_mm=1000.0)


def test_invalid_panels_are_refused() -> None:
    bow = plate("P002", SQUARE[[0, 2, 1, 3]])
    with pytest.raises(NestingError, match=r"cross themselves .* panels P002"):
        nest_panels(Parts.of(PANEL, [plate("P001", SQUARE), bow]), SHEET, gap_mm=10, border_mm=15)


def test_panels_of_different_stock_lie_on_different_sheets() -> None:
    """Four squares of 6 and 8 mm, by turns, would fit on one sheet."""
    some = [plate(f"P00{k}", SQUARE, thickness=6.0 + 2 * (k % 2)) for k in range(4)]
    panels = Parts.of(PANEL, some)
    nest = nest_panels(panels, SHEET, gap_mm=10, border_mm=15)
    assert [place.sheet for place in nest.placements] == [0, 1, 0, 1]
    mixed = tuple(replace(place, sheet=0) for place in nest.placements)
    with pytest.raises(NestingError, match="sheet 1 has panels that differ in thickness or material: P000, P001"):
        check_nest(replace(nest, placements=mixed), panels)


@settings(deadline=None, max_examples=30)
@given(st.lists(outlines(), min_size=2, max_size=12), st.data())
def test_the_check_finds_a_panel_that_was_moved(some: list[FloatArray], data: st.DataObject) -> None:
    panels = plates(some)
    nest = nest_panels(panels, SHEET, gap_mm=10, border_mm=15)
    moved = data.draw(st.integers(0, len(panels) - 1))
    shift = data.draw(st.tuples(st.floats(-3000, 3000), st.floats(-3000, 3000)))
    place = nest.placements[moved]
    offset = (place.offset_mm[0] + shift[0], place.offset_mm[1] + shift[1])
    wrong = replace(nest, placements=tuple(
        replace(p, offset_mm=offset) if p is place else p for p in nest.placements
    ))  # fmt: skip
    try:
        assert_sound(wrong, panels)
    except AssertionError:
        with pytest.raises(NestingError, match=panels[moved].mark):
            check_nest(wrong, panels)
    else:
        check_nest(wrong, panels)


def test_the_check_says_by_how_much() -> None:
    panels = Parts.of(PANEL, [plate("P001", SQUARE), plate("P002", SQUARE)])

    def nest(x: float) -> Nest:
        places = (Placement(0, 0, 0.0, (15.0, 15.0)), Placement(1, 0, 0.0, (x, 15.0)))
        return Nest((SHEET,), 10.0, 15.0, places, "by hand", 500000.0)

    check_nest(nest(525.0), panels)
    with pytest.raises(NestingError, match=re.escape("P001 and P002 are 9.990000 mm apart")):
        check_nest(nest(524.99), panels)
    with pytest.raises(NestingError, match=re.escape("panel P002 is 14.900000 mm from an edge of sheet 1")):
        check_nest(nest(2485.1), panels)
    twice = replace(nest(525.0), placements=nest(525.0).placements[:1] * 2)
    with pytest.raises(NestingError, match="each panel must be placed once"):
        check_nest(twice, panels)


@given(st.floats(0.001, 400))
def test_overlap_is_found_where_no_gap_is_asked_for(depth: float) -> None:
    panels = Parts.of(PANEL, [plate("P001", SQUARE), plate("P002", SQUARE)])
    places = [Placement(0, 0, 0.0, (0.0, 0.0)), Placement(1, 0, 0.0, (500.0 - depth, 0.0))]
    touching = [places[0], Placement(1, 0, 0.0, (500.0, 0.0))]
    check_nest(Nest((SHEET,), 0.0, 0.0, tuple(touching), "by hand", 500000.0), panels)
    with pytest.raises(NestingError, match="negative: mean depth of overlap"):
        check_nest(Nest((SHEET,), 0.0, 0.0, tuple(places), "by hand", 500000.0), panels)


def test_moved_outlines_of_equal_panels_are_not_shared() -> None:
    """A nest stores placements: equal panels are placed each for itself."""
    panels = plates([np.array([[0, 0], [1400, 0], [1400, 900], [0, 900.0]])] * 4)
    nest = nest_panels(panels, SHEET, gap_mm=10, border_mm=15)
    assert nest.n_sheets == 1
    assert len({place.offset_mm for place in nest.placements}) == 4


@pytest.mark.parametrize("rotation", ["half", "fixed"])
@given(some=st.lists(outlines(), min_size=1, max_size=15), gap=gaps, border=borders)
def test_panels_with_a_grain_are_not_turned(
    rotation: Literal["half", "fixed"], some: list[FloatArray], gap: float, border: float
) -> None:
    panels = plates(some)
    try:
        nest = nest_panels(panels, SHEET, gap_mm=gap, border_mm=border, rotation=rotation)
    except NestingError:
        extents = panel_outlines(panels)
        sizes = extents.reduced(np.maximum) - extents.reduced(np.minimum)
        assert (sizes > [SHEET.length_mm - 2 * border, SHEET.width_mm - 2 * border]).any()
        return
    assert_sound(nest, panels)
    assert {place.angle_deg % (180.0 if rotation == "half" else 360.0) for place in nest.placements} <= {0.0}
    turned = replace(nest, placements=(replace(nest.placements[0], angle_deg=90.0), *nest.placements[1:]))
    with pytest.raises(NestingError, match="forbids"):
        check_nest(turned, panels)


def test_sheets_of_several_sizes_are_used_up_to_their_counts() -> None:
    """Squares of 500 mm: a small sheet holds one and is full, a large one six at two thirds."""
    panels = Parts.of(PANEL, [plate(f"P{k:03d}", SQUARE) for k in range(9)])
    small, large = Sheet(500.0, 500.0, count=3), Sheet(1600.0, 1400.0, count=2)
    nest = nest_panels(panels, [large, small], gap_mm=0.0, border_mm=0.0)
    assert_sound(nest, panels)
    assert sorted((sheet.length_mm for sheet in nest.sheets), reverse=True) == [1600.0, 500.0, 500.0, 500.0]
    with pytest.raises(NestingError, match="after 4 of them 1 panels are left, such as P"):
        nest_panels(
            Parts.of(PANEL, [plate(f"P{k:03d}", SQUARE) for k in range(10)]),
            [replace(large, count=1), small],
            gap_mm=0.0,
            border_mm=0.0,
        )
    with pytest.raises(NestingError, match="largest of 2 sheets offers 400 x 300 mm"):
        nest_panels(panels, [Sheet(300.0, 300.0), Sheet(400.0, 300.0)], gap_mm=0.0, border_mm=0.0)
    with pytest.raises(NestingError, match="500 x 500 mm are given twice"):
        nest_panels(panels, [small, replace(small, count=2)], gap_mm=0.0, border_mm=0.0)
    fewer = tuple(replace(sheet, count=2) if sheet.length_mm == 500 else sheet for sheet in nest.sheets)
    with pytest.raises(NestingError, match=r"has 3 sheets of 500 x 500 mm .* and there are 2"):
        check_nest(replace(nest, sheets=fewer), panels)
    with pytest.raises(NestingError, match="no size of sheets"):
        nest_panels(panels, [], gap_mm=0.0, border_mm=0.0)


@pytest.mark.parametrize(
    ("given", "gap", "border"),
    [
        ({}, 20, 25),
        ({"process": "saw"}, 4.4, 20),
        ({"process": "plasma", "gap_mm": 12}, 12, 20),
        ({"process": "waterjet", "border_mm": 0}, 2.4, 0),
    ],
)
def test_the_process_gives_gap_and_border_where_they_are_not_given(
    given: dict[str, Any], gap: float, border: float
) -> None:
    rules = SheetRules(**given)
    assert (rules.gap_mm, rules.border_mm) == (gap, border)


def test_a_saw_does_not_cut_best_nests() -> None:
    with pytest.raises(ProjectError, match=r"nesting.mode is 'best'.* sheets.process is 'saw'"):
        Project(mesh=dome(4, 1), unit="m", nesting={"mode": "best"}, sheets={"process": "saw"})
    with pytest.raises(ProjectError, match=r"sheets.process is 'scissors'.*'glass', 'laser'"):
        Project(mesh=dome(4, 1), unit="m", sheets={"process": "scissors"})
    with pytest.raises(ProjectError, match=r"sheets.gap_mm is nan"):
        Project(mesh=dome(4, 1), unit="m", sheets={"gap_mm": float("nan")})


@pytest.mark.parametrize("engine", ENGINES)
@settings(deadline=None, max_examples=2)
@given(some=st.lists(outlines(), min_size=8, max_size=14), counts=st.tuples(st.integers(0, 3), st.integers(0, 3)))
def test_best_nests_of_several_sizes_keep_the_counts_and_need_no_more_area(
    engine: type[irregular.Engine], some: list[FloatArray], counts: tuple[int, int]
) -> None:
    panels = plates([outline * 0.7 for outline in some])
    sizes = [Sheet(2000.0, 1300.0, counts[0]), Sheet(1500.0, 1400.0, counts[1]), SHEET]
    quick = nest_panels(panels, sizes, gap_mm=3.0, border_mm=10.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sheet_nesting, "installed_engine", engine)
        best = nest_panels(panels, sizes, gap_mm=3.0, border_mm=10.0, mode="best", seconds=1.0)
    assert_sound(best, panels)
    assert all(best.sheets.count(size) <= size.count for size in sizes if size.count is not None)
    area = [sum(sheet.length_mm * sheet.width_mm for sheet in nest.sheets) for nest in (quick, best)]
    assert area[1] <= area[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_an_engine_may_do_where_sheets_do_not_suffice_for_rectangles(
    engine: type[irregular.Engine], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sheet_nesting, "installed_engine", engine)
    panels = plates([np.array([[0, 0], [900, 0], [300, 800]])] * 11)
    sizes = [Sheet(2000.0, 1900.0, 2), Sheet(1000.0, 800.0)]  # a large one holds four rectangles, a small one none
    with pytest.raises(NestingError, match="the sheets do not suffice"):
        nest_panels(panels, sizes, gap_mm=5, border_mm=10)
    best = nest_panels(panels, sizes, gap_mm=5, border_mm=10, mode="best", seconds=3.0)
    assert_sound(best, panels)
    assert best.engine == engine.name
    assert best.sheets == (sizes[0],) * 2


@pytest.mark.parametrize("engine", ENGINES)
def test_engines_keep_the_grain(engine: type[irregular.Engine]) -> None:
    panels = Parts.of(PANEL, [plate(f"P{k:03d}", 500 * outlines_of_kite()) for k in range(6)])
    found = engine().fill(panel_outlines(panels), Stock(SHEET, 10.0, 15.0, "half"), 1.5)
    assert found
    assert {round(place.angle_deg % 180.0, 6) for place in found} <= {0.0}


def outlines_of_kite() -> FloatArray:
    return np.array([[0.0, 0.0], [1.6, 0.1], [1.3, 0.8], [0.2, 1.0]])
