"""Nesting of panels on stock sheets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from numbers import Real
from typing import Literal

import numpy as np
import shapely

from fabkit.errors import NestingError
from fabkit.kinds import PanelDetails, panel_outlines
from fabkit.parts import Parts, Ragged
from fabkit.production.nesting.filling import Filler, Filling
from fabkit.production.nesting.guillotine import Guillotine
from fabkit.production.nesting.irregular import Engine, installed_engine
from fabkit.production.nesting.nests import (
    Nest,
    Rotation,
    Sheet,
    Stock,
    check_nest,
    outline_areas,
    polygons,
    stock_numbers,
)
from geometry.arrays import IntArray
from geometry.errors import described

__all__ = ["nest_panels", "too_large"]


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

    sheet: one size, or several, each with as many sheets as its count says for each stock; sheet after sheet the size
    is taken that is used best. rotation: "free", "half" for panels that may be turned by half a turn only, "fixed" for
    those that may not be turned: the x axes of their own frames, edge 1, then lie along the sheet, as its grain does.

    mode "quick": the smallest rectangles of the panels, cut from edge to edge; deterministic. mode "best": starts from
    the quick nest and spends up to about `seconds` on placing the outlines themselves closer together with
    packingsolver or spyrrow, whichever is installed. It never needs more area of sheets than quick, and may do where
    the sheets do not suffice for quick; `Nest.engine` names the program that found the nest; the result depends on the
    speed of the computer. progress is called with the fraction done and a sentence. All gaps and borders of the result
    have been checked.

    Raises NestingError where a panel fits on no sheet, an outline crosses itself, the sheet, gap or border is invalid,
    or no engine is installed for best; and where the sheets that there are do not suffice.

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
    _check_stocks(stocks)
    engine = installed_engine() if mode == "best" else None
    if not len(panels):
        return Nest((), gap_mm, border_mm, (), "none", 0.0, rotation)
    outlines = panel_outlines(panels)
    _check_panels(panels, outlines)
    guillotines = [Guillotine.of(outlines, stock) for stock in stocks]
    _check_sizes(panels, guillotines)
    areas = outline_areas(outlines)
    filler, fillings = Filler(guillotines, areas), list[Filling]()
    name, numbers = "guillotine", stock_numbers(panels)
    for number in range(int(numbers.max()) + 1):
        alike = np.flatnonzero(numbers == number)
        share = seconds * float(areas[alike].sum() / areas.sum())
        own, is_better = _fill(filler, alike, panels, engine, share, progress)
        name = engine.name if engine is not None and is_better else name
        fillings += sorted(own, key=lambda filling: -filler.area(filling))
    placements = [replace(place, sheet=k) for k, (_, filling) in enumerate(fillings) for place in filling]
    placements.sort(key=lambda place: place.panel)
    used = tuple(sizes[size] for size, _ in fillings)
    nest = Nest(used, gap_mm, border_mm, tuple(placements), name, float(areas.sum()), rotation)
    check_nest(nest, panels)
    return nest


def _fill(
    filler: Filler,
    pool: IntArray,
    panels: Parts[PanelDetails],
    engine: Engine | None,
    seconds: float,
    progress: Callable[[float, str], None] | None,
) -> tuple[list[Filling], bool]:
    """Sheets for the panels in the pool, and whether an engine found them. Raises NestingError where there are too
    few."""
    quick, missing = filler.quick(pool)
    found = quick if engine is None else filler.improved(quick, missing, engine, seconds, progress)
    if found is quick and len(missing):
        marks = ", ".join(dict.fromkeys(panels.marks[k] for k in missing[:10].tolist()))
        raise NestingError(
            f"the sheets do not suffice: after {len(quick)} of them {len(missing)} panels are left, such as {marks}, "
            "and none of the sizes of which there are more holds any of them; give more sheets, or leave out the count "
            "of a size"
        )
    return found, found is not quick


def _sizes(sheet: Sheet | Sequence[Sheet]) -> tuple[Sheet, ...]:
    """The sizes, or a single one. Raises NestingError for anything else."""
    sizes = tuple(sheet) if isinstance(sheet, Sequence) else (sheet,)
    if all(isinstance(size, Sheet) for size in sizes):
        return sizes
    raise NestingError(f"the sheet is {described(sheet)}: write Sheet(length_mm=3210, width_mm=2250)")


def _check_stocks(stocks: Sequence[Stock]) -> None:
    if not stocks:
        raise NestingError("there is no size of sheets: give one, such as Sheet(length_mm=3210, width_mm=2250)")
    for stock in stocks:
        _check_stock(stock)
    sizes = [(stock.sheet.length_mm, stock.sheet.width_mm) for stock in stocks]
    if twice := [size for size in sizes if sizes.count(size) > 1]:
        raise NestingError(
            f"sheets of {twice[0][0]:g} x {twice[0][1]:g} mm are given twice: give this size once, with the sum of the "
            "counts"
        )


def _check_stock(stock: Stock) -> None:
    sizes = (stock.sheet.length_mm, stock.sheet.width_mm, stock.gap_mm, stock.border_mm)
    if not all(isinstance(size, Real) for size in sizes):
        raise NestingError(f"length and width of the sheet, gap and border are {sizes}: give numbers, in mm")
    if not (np.isfinite(stock.gap_mm) and stock.gap_mm >= 0):
        raise NestingError(f"panels cannot have a gap of {stock.gap_mm:g} mm between them; give one of 0 or more")
    length, width = stock.inside
    if not (np.isfinite([length, width, stock.border_mm]).all() and min(length, width) > 0 and stock.border_mm >= 0):
        raise NestingError(
            f"a sheet of {stock.sheet.length_mm:g} x {stock.sheet.width_mm:g} mm with a border of "
            f"{stock.border_mm:g} mm has no room for panels; give positive sizes, and a border of 0 or more, below "
            "half the sheet's width"
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
    """A sentence for each panel whose rectangle does not fit on a sheet of any size, by the index of the panel. Raises
    NestingError where a sheet or the border is invalid.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import Sheet, too_large
    >>> sorted(too_large(built.assembly["panels"], Sheet(3210, 1400), border_mm=15))
    [0, 2, 4, 6, 8, 10]
    """
    stocks = [Stock(size, 0.0, border_mm, rotation) for size in _sizes(sheet)]
    _check_stocks(stocks)
    outlines = panel_outlines(panels)
    return _too_large(panels, [Guillotine.of(outlines, stock) for stock in stocks])


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
