"""Sheet after sheet, of one size or several: filled with rectangles, then closer by an engine."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fabkit.production.nesting.guillotine import Guillotine
from fabkit.production.nesting.irregular import Engine, suits_engines
from fabkit.production.nesting.nests import Placement, placed
from geometry.arrays import FloatArray, IntArray, integers

__all__ = ["Filler", "Filling"]

POOL_SHEETS = 3
"""Area of the panels that an engine chooses from, over the usable area of the largest sheet: enough to combine, few
enough to be quick."""

Filling = tuple[int, list[Placement]]
"""The number of a size of sheets, and what lies on one of them."""


@dataclass(frozen=True, eq=False)
class Filler:
    """Fills sheets. guillotines: one for each size, over the same outlines; areas (m,): of these in mm2."""

    guillotines: Sequence[Guillotine]
    areas: FloatArray

    def quick(self, pool: IntArray, taken: Sequence[Filling] = ()) -> tuple[list[Filling], IntArray]:
        """Sheets for the outlines in the pool, one after the other, of the size that is used best while there are any
        of it; and the outlines for which there are no more. taken: sheets that are used already."""
        left = self._left(taken)
        remaining = [guillotine.remaining(pool) for guillotine in self.guillotines]
        place = dict(zip(pool.tolist(), range(len(pool)), strict=True))
        done: list[Filling] = []
        while len(place):
            found = [
                (k, guillotine.fill_from(pool, remaining[k]))
                for k, guillotine in enumerate(self.guillotines)
                if left[k] > 0
            ]
            best = self._fullest(found)
            if best is None:
                break
            left[best[0]] -= 1
            for each in best[1]:
                row = place.pop(each.panel)
                for rectangles in remaining:
                    rectangles.take(row)
            done.append(best)
        return done, integers(list(place))

    def improved(
        self,
        quick: list[Filling],
        missing: IntArray,
        engine: Engine,
        seconds: float,
        progress: Callable[[float, str], None] | None,
    ) -> list[Filling]:
        """Release the panels of the quick sheets, beginning with the emptiest, and let the engine fill one sheet after
        the other from them, of the size that is used best, until all panels are placed again or the time is up. Returns
        the best of all nests found on the way, `quick` included; it, if none has the missing panels."""
        start = time.monotonic()
        inside = max(float(np.prod(guillotine.stock.inside)) for guillotine in self.guillotines)
        waiting = sorted(quick, key=lambda filling: -self.area(filling))
        suitable = suits_engines(self.guillotines[0].outlines)
        done: list[Filling] = []
        pool, best = missing, quick
        best_score = self._score(quick) if not len(missing) else (np.inf, np.inf)
        while waiting or len(pool):
            while waiting and self.areas[pool].sum() < POOL_SHEETS * inside:
                pool = np.union1d(pool, [place.panel for place in waiting.pop()[1]])
            left = self._left([*done, *waiting])
            sizes = [k for k, count in enumerate(left) if count > 0]
            filling = self._fullest([(k, self.guillotines[k].fill(pool)) for k in sizes])
            if filling is None or len(filling[1]) < len(pool):
                if seconds - (time.monotonic() - start) < engine.min_seconds:
                    break
                n_left = (len(waiting) + self.areas[pool].sum() / inside) * len(sizes)
                found = [] if filling is None else [filling]
                for size in sizes:
                    seconds_left = seconds - (time.monotonic() - start)
                    if seconds_left >= engine.min_seconds:
                        share = max(engine.min_seconds, seconds_left / n_left)
                        found.append((size, self._by_engine(engine, size, pool[suitable[pool]], share)))
                filling = self._fullest(found)
            if filling is None:
                break
            done.append(filling)
            pool = np.setdiff1d(pool, [place.panel for place in filling[1]])
            rest, without = self.quick(pool, [*done, *waiting])
            state = [*done, *waiting, *rest]
            if not len(without) and (score := self._score(state)) < best_score:
                best, best_score = state, score
            if progress is not None:
                fraction = min(1.0, (time.monotonic() - start) / seconds)
                progress(fraction, f"{engine.name}: {len(best)} sheets; {len(quick)} when cut from edge to edge")
        return best

    def area(self, filling: Filling) -> float:
        """Area of the panels on a sheet in mm2."""
        return float(self.areas[[place.panel for place in filling[1]]].sum())

    def _by_engine(self, engine: Engine, size: int, pool: IntArray, seconds: float) -> list[Placement]:
        guillotine = self.guillotines[size]
        chosen = pool[guillotine.fits[pool]]
        if not len(chosen):
            return []
        found = engine.fill(guillotine.outlines[chosen], guillotine.stock, seconds)
        return [replace(place, panel=int(chosen[place.panel])) for place in found]

    def _left(self, taken: Sequence[Filling]) -> list[float]:
        """How many sheets there are of each size besides those that are taken."""
        counts = [guillotine.stock.sheet.count for guillotine in self.guillotines]
        used = [sum(size == k for size, _ in taken) for k in range(len(counts))]
        return [np.inf if count is None else count - own for count, own in zip(counts, used, strict=True)]

    def _fullest(self, found: Sequence[Filling]) -> Filling | None:
        """The filling that uses most of its sheet, the first of equal ones; None where nothing lies on any."""
        some = [filling for filling in found if filling[1]]
        return max(some, key=lambda filling: self.area(filling) / self._sheet_area(filling), default=None)

    def _sheet_area(self, filling: Filling) -> float:
        return self.guillotines[filling[0]].stock.sheet.area_mm2

    def _score(self, fillings: Sequence[Filling]) -> tuple[float, float]:
        """Area of all sheets, then the share of the emptiest sheet that is used if the rest is cut off by one straight
        cut."""
        size, last = min(fillings, key=self.area)
        outlines, sheet = self.guillotines[size].outlines, self.guillotines[size].stock.sheet
        own = outlines[np.array([place.panel for place in last])]
        ends = placed(own.values, own.row, last).max(axis=0)
        share = float(min(ends[0] / sheet.length_mm, ends[1] / sheet.width_mm))
        return sum(self._sheet_area(filling) for filling in fillings), share
