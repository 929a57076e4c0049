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
from fabkit.production.nesting.guillotine import Guillotine
from fabkit.production.nesting.irregular import Engine, installed_engine, suits_engines
from fabkit.production.nesting.nests import (
    Nest,
    Placement,
    Rotation,
    Sheet,
    Stock,
    check_nest,
    moved,
    outline_areas,
    polygons,
    stock_numbers,
)
from geometry.arrays import FloatArray, IntArray
from geometry.errors import described

__all__ = ["nest_panels", "too_large"]

POOL_SHEETS = 3
"""Area of the panels that an engine chooses from, over the usable area of a sheet: enough to combine, few enough to be
quick."""


def nest_panels(
    panels: Parts[PanelDetails],
    sheet: Sheet | Sequence[Sheet],
    *,
    gap_mm: float,
    border_mm: float,
    rotation: Rotation = "free",
    mode: Literal["quick", "best"] = "quick",
    seconds: float = 60.0,
    progress: Callable[[float, str], None] | None = None,
) -> Nest:
    """Lay all panels on as few sheets as can be found, turned but never mirrored. Panels that differ in thickness or
    material lie on different sheets.

    sheet: one size, or several, each with as many sheets as its count says; then sheet after sheet the size is taken
    that is used best. rotation: "free", "half" for panels that may be turned by half a turn only, "fixed" for those
    that may not be turned: the x axes of their own frames, edge 1, then lie along the sheet, as its grain does.

    mode "quick": the smallest rectangles of the panels, cut from edge to edge; deterministic. mode "best": starts from
    the quick nest and spends up to about `seconds` on placing the outlines themselves closer together with
    packingsolver or spyrrow, whichever is installed. It is never worse than quick; `Nest.engine` names the program
    that found the nest; the result depends on the speed of the computer. progress is called with the fraction done and
    a sentence. All gaps and borders of the result have been checked.

    Raises NestingError where a panel fits on no sheet, an outline crosses itself, the sheet, gap or border is invalid,
    or no engine is installed for best; where the sheets that there are do not suffice; and for best with several sizes.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import Sheet, nest_panels
    >>> nest = nest_panels(built.assembly["panels"], Sheet(3210, 2250), gap_mm=10, border_mm=15)
    >>> nest.n_sheets, nest.engine
    (9, 'guillotine')
    """
    sizes = _sizes(sheet)
    stocks = [Stock(size, gap_mm, border_mm, rotation) for size in sizes]
    _check_stocks(stocks, mode)
    engine = installed_engine() if mode == "best" else None
    if not len(panels):
        return Nest((), gap_mm, border_mm, (), "none", 0.0, rotation)
    outlines = panel_outlines(panels)
    _check_panels(panels, outlines)
    guillotines = [Guillotine.of(outlines, stock) for stock in stocks]
    _check_sizes(panels, guillotines)
    areas = outline_areas(outlines)
    fillings: list[tuple[Sheet, list[Placement]]] = []
    name, numbers = "guillotine", stock_numbers(panels)
    for number in range(int(numbers.max()) + 1):
        alike = np.flatnonzero(numbers == number)
        if len(sizes) > 1 or sizes[0].count is not None:
            own = _mixed(guillotines, alike, areas, panels)
        else:
            quick = guillotines[0].sheets(alike)
            if engine is not None:
                share = seconds * float(areas[alike].sum() / areas.sum())
                improved = _improved(guillotines[0], engine, quick, areas, share, progress)
                quick, name = (quick, name) if improved is quick else (improved, engine.name)
            own = [(sizes[0], filling) for filling in quick]
        fillings += sorted(own, key=lambda filled: -_area(filled[1], areas))
    placements = [replace(place, sheet=k) for k, (_, filling) in enumerate(fillings) for place in filling]
    placements.sort(key=lambda place: place.panel)
    used = tuple(size for size, _ in fillings)
    nest = Nest(used, gap_mm, border_mm, tuple(placements), name, float(areas.sum()), rotation)
    check_nest(nest, panels)
    return nest


def _mixed(
    guillotines: Sequence[Guillotine], pool: IntArray, areas: FloatArray, panels: Parts[PanelDetails]
) -> list[tuple[Sheet, list[Placement]]]:
    """Sheets of several sizes: one after the other, of the size that is used best, while there are any of it."""
    left = [guillotine.stock.sheet.count for guillotine in guillotines]
    remaining = [guillotine.remaining(pool) for guillotine in guillotines]
    place = dict(zip(pool.tolist(), range(len(pool)), strict=True))
    done: list[tuple[Sheet, list[Placement]]] = []
    n_placed = 0
    while n_placed < len(pool):
        best, best_use = -1, 0.0
        filling: list[Placement] = []
        for k, guillotine in enumerate(guillotines):
            found = guillotine.fill_from(pool, remaining[k]) if left[k] != 0 else []
            use = _area(found, areas) / guillotine.stock.sheet.area_mm2 if found else 0.0
            if use > best_use:
                best, best_use, filling = k, use, found
        if best < 0:
            missing = np.setdiff1d(pool, [each.panel for _, own in done for each in own])
            marks = ", ".join(dict.fromkeys(panels.marks[k] for k in missing[:10].tolist()))
            raise NestingError(
                f"the sheets do not suffice: after {len(done)} of them {len(missing)} panels are left, such as {marks}"
                ", and none of the sizes of which there are more holds any of them; give more sheets, or leave out the "
                "count of a size"
            )
        left[best] = None if left[best] is None else left[best] - 1  # type: ignore[operator]
        for each in filling:
            for rectangles in remaining:
                rectangles.take(place[each.panel])
        n_placed += len(filling)
        done.append((guillotines[best].stock.sheet, filling))
    return done


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


def _sizes(sheet: Sheet | Sequence[Sheet]) -> tuple[Sheet, ...]:
    """The sizes, or a single one. Raises NestingError for anything else."""
    sizes = tuple(sheet) if isinstance(sheet, Sequence) else (sheet,)
    if all(isinstance(size, Sheet) for size in sizes):
        return sizes
    raise NestingError(f"the sheet is {described(sheet)}: write Sheet(length_mm=3210, width_mm=2250)")


def _check_stocks(stocks: Sequence[Stock], mode: str) -> None:
    if not stocks:
        raise NestingError("there is no size of sheets: give one, such as Sheet(length_mm=3210, width_mm=2250)")
    for stock in stocks:
        _check_stock(stock)
    if mode == "best" and (len(stocks) > 1 or stocks[0].sheet.count is not None):
        raise NestingError(
            "the best nest is found for one size of sheets, of which there is any number: give one size without a "
            "count, or choose the quick nest"
        )


def _check_stock(stock: Stock) -> None:
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
    count = stock.sheet.count
    if count is not None and (not isinstance(count, int) or count < 0):
        raise NestingError(
            f"the count of sheets is {count!r}: give a whole number of 0 or more, or None for any number"
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


def too_large(
    panels: Parts[PanelDetails], sheet: Sheet | Sequence[Sheet], *, border_mm: float, rotation: Rotation = "free"
) -> dict[int, str]:
    """A sentence for each panel whose rectangle does not fit on a sheet of any size, by the index of the panel.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import Sheet, too_large
    >>> sorted(too_large(built.assembly["panels"], Sheet(3210, 1400), border_mm=15))
    [0, 2, 4, 6, 8, 10]
    """
    sizes, outlines = _sizes(sheet), panel_outlines(panels)
    return _too_large(panels, [Guillotine.of(outlines, Stock(size, 0.0, border_mm, rotation)) for size in sizes])


def _too_large(panels: Parts[PanelDetails], guillotines: Sequence[Guillotine]) -> dict[int, str]:
    largest = max(guillotines, key=lambda guillotine: guillotine.stock.sheet.area_mm2)
    inside, is_free = largest.stock.inside, largest.stock.rotation == "free"
    if is_free:
        inside = max(inside), min(inside)
    what = "its smallest rectangle is" if is_free else "unturned it is"
    offers = "the sheet offers" if len(guillotines) == 1 else f"the largest of {len(guillotines)} sheets offers"
    return {
        panel: f"panel {panels[panel].mark} on face {panels.elements[panel]} does not fit on a sheet within its "
        f"borders (face counted from 0): {what} {largest.sizes[panel, 0]:.1f} x "
        f"{largest.sizes[panel, 1]:.1f} mm, and {offers} {inside[0]:g} x {inside[1]:g} mm"
        for panel in np.flatnonzero(~np.any([guillotine.fits for guillotine in guillotines], axis=0)).tolist()
    }


def _check_sizes(panels: Parts[PanelDetails], guillotines: Sequence[Guillotine]) -> None:
    found = _too_large(panels, guillotines)
    if found:
        named = list(found.values())[:3]
        if len(found) > len(named):
            faces = ", ".join(str(panels.elements[panel]) for panel in list(found)[len(named) :])
            named.append(f"nor do those on faces {faces}")
        raise NestingError(
            f"{'; '.join(named)}. Use larger sheets, a smaller border or a mesh with smaller faces, leave these panels "
            "out with --skip-unbuildable, or turn nesting off"
        )
