"""Nesting of panels on stock sheets."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from numbers import Real
from typing import Literal

import numpy as np
import shapely

from fabkit.errors import NestingError
from fabkit.kinds import PanelDetails, panel_outlines
from fabkit.parts import Parts, Ragged
from fabkit.production.nesting.guillotine import RECTANGLE_ROUNDING_MM, Guillotine
from fabkit.production.nesting.irregular import Engine, installed_engine, suits_engines
from fabkit.production.nesting.nests import (
    Nest,
    Placement,
    Sheet,
    Stock,
    check_nest,
    moved,
    outline_areas,
    polygons,
    stock_numbers,
)
from geometry.arrays import FloatArray
from geometry.errors import described

__all__ = ["nest_panels", "too_large"]

POOL_SHEETS = 3
"""Area of the panels that an engine chooses from, over the usable area of a sheet: enough to combine, few enough to be
quick."""


def nest_panels(
    panels: Parts[PanelDetails],
    sheet: Sheet,
    *,
    gap_mm: float,
    border_mm: float,
    mode: Literal["quick", "best"] = "quick",
    seconds: float = 60.0,
    progress: Callable[[float, str], None] | None = None,
) -> Nest:
    """Lay all panels on as few sheets as can be found, turned but never mirrored. Panels that differ in thickness or
    material lie on different sheets.

    mode "quick": the smallest rectangles of the panels, cut from edge to edge; deterministic. mode "best": starts from
    the quick nest and spends up to about `seconds` on placing the outlines themselves closer together with
    packingsolver or spyrrow, whichever is installed. It is never worse than quick; `Nest.engine` names the program
    that found the nest; the result depends on the speed of the computer. progress is called with the fraction done and
    a sentence. All gaps and borders of the result have been checked.

    Raises NestingError where a panel fits on no sheet, an outline crosses itself, the sheet, gap or border is invalid,
    or no engine is installed for best.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import Sheet, nest_panels
    >>> nest = nest_panels(built.assembly["panels"], Sheet(3210, 2250), gap_mm=10, border_mm=15)
    >>> nest.n_sheets, nest.engine
    (9, 'guillotine')
    """
    stock = Stock(sheet, gap_mm, border_mm)
    _check_stock(stock)
    engine = installed_engine() if mode == "best" else None
    if not len(panels):
        return Nest(sheet, gap_mm, border_mm, (), "none", 0.0)
    outlines = panel_outlines(panels)
    _check_panels(panels, outlines)
    guillotine = Guillotine.of(outlines, stock)
    _check_sizes(panels, guillotine)
    areas = outline_areas(outlines)
    fillings, name, stocks = [], "guillotine", stock_numbers(panels)
    for number in range(int(stocks.max()) + 1):
        alike = np.flatnonzero(stocks == number)
        own = guillotine.sheets(alike)
        if engine is not None:
            share = seconds * float(areas[alike].sum() / areas.sum())
            improved = _improved(guillotine, engine, own, areas, share, progress)
            own, name = (own, name) if improved is own else (improved, engine.name)
        fillings += sorted(own, key=lambda filling: -_area(filling, areas))
    placements = [replace(place, sheet=k) for k, filling in enumerate(fillings) for place in filling]
    placements.sort(key=lambda place: place.panel)
    nest = Nest(sheet, gap_mm, border_mm, tuple(placements), name, float(areas.sum()))
    check_nest(nest, panels)
    return nest


def _improved(
    guillotine: Guillotine,
    engine: Engine,
    quick: list[list[Placement]],
    areas: FloatArray,
    seconds: float,
    progress: Callable[[float, str], None] | None,
) -> list[list[Placement]]:
    """Release the panels of the quick sheets, beginning with the emptiest, and let the engine fill one sheet after the
    other from them, until all panels are placed again or the time is up. Returns the best of all nests found on the
    way, `quick` included."""
    start = time.monotonic()
    inside = float(np.prod(guillotine.stock.inside))
    waiting = sorted(quick, key=lambda filling: -_area(filling, areas))
    suitable = suits_engines(guillotine.outlines)
    done: list[list[Placement]] = []
    pool = np.zeros(0, dtype=np.int64)
    best, best_score = quick, _score(quick, guillotine, areas)
    while waiting or len(pool):
        while waiting and areas[pool].sum() < POOL_SHEETS * inside:
            pool = np.union1d(pool, [place.panel for place in waiting.pop()])
        filling = guillotine.fill(pool)
        if len(filling) < len(pool):
            seconds_left = seconds - (time.monotonic() - start)
            if seconds_left < engine.min_seconds:
                break
            sheets_left = len(waiting) + areas[pool].sum() / inside
            share = max(engine.min_seconds, seconds_left / sheets_left)
            chosen = pool[suitable[pool]].tolist()
            some = guillotine.outlines[np.array(chosen, dtype=np.int64)]
            found = engine.fill(some, guillotine.stock, share) if chosen else []
            found = [replace(place, panel=chosen[place.panel]) for place in found]
            filling = max(filling, found, key=lambda candidate: _area(candidate, areas))
        done.append(filling)
        pool = np.setdiff1d(pool, [place.panel for place in filling])
        state = done + waiting + guillotine.sheets(pool)
        if (score := _score(state, guillotine, areas)) < best_score:
            best, best_score = state, score
        if progress is not None:
            fraction = min(1.0, (time.monotonic() - start) / seconds)
            progress(fraction, f"{engine.name}: {len(best)} sheets; {len(quick)} when cut from edge to edge")
    return best


def _area(filling: Sequence[Placement], areas: FloatArray) -> float:
    return float(areas[[place.panel for place in filling]].sum())


def _score(fillings: list[list[Placement]], guillotine: Guillotine, areas: FloatArray) -> tuple[int, float]:
    """Number of sheets, then the share of the emptiest sheet that is used if the rest is cut off by one straight
    cut."""
    last = min(fillings, key=lambda filling: _area(filling, areas))
    ends = np.concatenate([moved(guillotine.outlines[place.panel], place) for place in last]).max(axis=0)
    sheet = guillotine.stock.sheet
    return len(fillings), float(min(ends[0] / sheet.length_mm, ends[1] / sheet.width_mm))


def _check_stock(stock: Stock) -> None:
    if not isinstance(stock.sheet, Sheet):
        raise NestingError(f"the sheet is {described(stock.sheet)}: write Sheet(length_mm=3210, width_mm=2250)")
    sizes = (stock.sheet.length_mm, stock.sheet.width_mm, stock.gap_mm, stock.border_mm)
    if not all(isinstance(size, Real) for size in sizes):
        raise NestingError(f"length and width of the sheet, gap and border are {sizes}: give numbers, in mm")
    length, width = stock.inside
    values = (length, width, stock.gap_mm, stock.border_mm)
    if not (np.isfinite(values).all() and min(length, width) > 0 and min(stock.gap_mm, stock.border_mm) >= 0):
        raise NestingError(
            f"a sheet of {stock.sheet.length_mm:g} x {stock.sheet.width_mm:g} mm with a border of "
            f"{stock.border_mm:g} mm and a gap of {stock.gap_mm:g} mm has no room for panels; give positive sizes, a "
            "gap and a border of 0 or more, and a border below half the sheet's width"
        )


def _check_panels(panels: Parts[PanelDetails], outlines: Ragged) -> None:
    """Raise NestingError for invalid outlines."""
    shapes = polygons(outlines)
    finite = np.isfinite(outlines.with_values(outlines.values.sum(axis=1)).reduced(np.add))
    valid = finite & shapely.is_valid(shapes) & (shapely.area(shapes) > 0)
    if not valid.all():
        marks = ", ".join(panels.marks[panel] for panel in np.flatnonzero(~valid)[:10])
        raise NestingError(
            f"outlines that cross themselves or have no area cannot be nested: panels {marks}; correct these outlines"
        )


def too_large(panels: Parts[PanelDetails], sheet: Sheet, *, border_mm: float) -> dict[int, str]:
    """A sentence for each panel whose smallest rectangle does not fit on a sheet, by the index of the panel.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import Sheet, too_large
    >>> sorted(too_large(built.assembly["panels"], Sheet(3210, 1400), border_mm=15))
    [0, 2, 4, 6, 8, 10]
    """
    return _too_large(panels, Guillotine.of(panel_outlines(panels), Stock(sheet, 0.0, border_mm)))


def _too_large(panels: Parts[PanelDetails], guillotine: Guillotine) -> dict[int, str]:
    inside = np.sort(guillotine.stock.inside)[::-1]
    return {
        panel: f"panel {panels[panel].mark} on face {panels.elements[panel]} does not fit on a sheet within its "
        f"borders (face counted from 0): its smallest rectangle is {guillotine.sizes[panel, 0]:.1f} x "
        f"{guillotine.sizes[panel, 1]:.1f} mm, and the sheet offers {inside[0]:g} x {inside[1]:g} mm"
        for panel in np.flatnonzero((guillotine.sizes > inside + RECTANGLE_ROUNDING_MM).any(axis=1)).tolist()
    }


def _check_sizes(panels: Parts[PanelDetails], guillotine: Guillotine) -> None:
    found = _too_large(panels, guillotine)
    if found:
        named = list(found.values())[:3]
        if len(found) > len(named):
            faces = ", ".join(str(panels.elements[panel]) for panel in list(found)[len(named) :])
            named.append(f"nor do those on faces {faces}")
        raise NestingError(
            f"{'; '.join(named)}. Use larger sheets, a smaller border or a mesh with smaller faces, leave these panels "
            "out with --skip-unbuildable, or turn nesting off"
        )
