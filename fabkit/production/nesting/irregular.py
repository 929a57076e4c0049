"""Nesting engines that place the outlines themselves close together, one sheet at a time.

packingsolver (Python 3.12 and later) chooses the panels itself, as a knapsack problem whose profits are areas. spyrrow
(Python 3.11) packs given panels into a strip of minimum length, so it is given as much area as it managed to place on
earlier sheets.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import ClassVar, Protocol

import numpy as np
import shapely

from fabkit.errors import NestingError
from fabkit.parts import Ragged
from fabkit.production.nesting.guillotine import rectangles
from fabkit.production.nesting.nests import Placement, Stock, outline_areas, polygons, turned
from geometry.arrays import BoolArray, FloatArray

__all__ = ["Engine", "PackingSolver", "Spyrrow", "installed_engine", "suits_engines"]


LEAST_ROUNDNESS, LEAST_OUTLINE_EDGE_MM, LARGEST_OUTLINE_TURN_DEG = 0.01, 1.0, 175.0
"""Bounds of the outlines given to an engine: radius of the largest inner circle over the diagonal of the box; length of
an edge in mm; turn of the outline at a corner in degrees. The engines offset outlines and look for circles inside them,
and fail on slivers and sharp spikes; real panels have neither."""


def suits_engines(outlines: Ragged) -> BoolArray:
    """(m,) whether outlines, rows of (k, 2) in mm, may be given to an engine."""
    shapes = polygons(outlines)
    radii = shapely.length(shapely.maximum_inscribed_circle(shapes))
    boxes = shapely.bounds(shapes)
    round_enough = radii >= LEAST_ROUNDNESS * np.hypot(*(boxes[:, 2:] - boxes[:, :2]).T)
    result: BoolArray = round_enough & np.array([_is_blunt(outline) for outline in outlines])
    return result


def _is_blunt(outline: FloatArray) -> bool:
    """Whether an outline (k, 2) in mm has no sharp spike, slit or tiny edge."""
    edges = np.roll(outline, -1, axis=0) - outline
    directions = np.arctan2(edges[:, 1], edges[:, 0])
    turns = (directions - np.roll(directions, 1) + np.pi) % (2 * np.pi) - np.pi
    long_enough = np.linalg.norm(edges, axis=1).min() >= LEAST_OUTLINE_EDGE_MM
    return bool(long_enough and np.abs(turns).max() <= np.deg2rad(LARGEST_OUTLINE_TURN_DEG))


class Engine(Protocol):
    """A nesting program. min_seconds: shortest time limit in s with which it is worth a call."""

    name: str
    min_seconds: float

    def fill(self, outlines: Ragged, stock: Stock, seconds: float) -> list[Placement]:
        """One sheet, number 0, filled with some of the outlines, rows of (k, 2) in mm. There is at least one outline;
        all are suitable and fit onto a sheet. `Placement.panel` is an index into the outlines given here."""


def installed_engine() -> Engine:
    """The better of the installed engines. Raises NestingError where there is none."""
    if find_spec("packingsolver"):
        return PackingSolver()
    if find_spec("spyrrow"):
        return Spyrrow()
    raise NestingError(
        "no engine for the best nest is installed: install packingsolver (Python 3.12 and later) or spyrrow, "
        "or choose the quick nest"
    )


class PackingSolver:
    """One knapsack of packingsolver's irregular problem; exact to rounding."""

    name = "packingsolver"
    min_seconds = 0.3
    #: Ranges of angles in degrees, not mirrored.
    turns: ClassVar = {
        "free": [(0.0, 360.0, False)],
        "half": [(0.0, 0.0, False), (180.0, 180.0, False)],
        "fixed": [(0.0, 0.0, False)],
    }

    def fill(self, outlines: Ragged, stock: Stock, seconds: float) -> list[Placement]:
        import packingsolver.irregular as irregular

        builder = irregular.InstanceBuilder()
        builder.set_objective(irregular.Objective.Knapsack)
        builder.set_item_item_minimum_spacing(stock.gap_mm)
        sheet = irregular.build_rectangle(0.0, stock.sheet.length_mm, 0.0, stock.sheet.width_mm)
        builder.add_bin_type(sheet, copies=1, item_bin_minimum_spacing=stock.border_mm)
        for outline in outlines:
            shape = irregular.build_shape([(x, y) for x, y in outline.tolist()])
            builder.add_item_type(shape, allowed_rotations=PackingSolver.turns[stock.rotation])
        parameters = irregular.OptimizeParameters()
        parameters.time_limit = seconds
        parameters.verbosity_level = 0
        parameters.messages_to_stdout = False
        solution = irregular.optimize(builder.build(), parameters).solution
        items = solution.bin(0).items if solution.number_of_bins() else []
        return [Placement(i.item_type_id, 0, i.angle, (i.bl_corner.x, i.bl_corner.y)) for i in items]


class Spyrrow:
    """One strip of spyrrow, as wide as the sheet; panels that end outside the sheet's length are removed.

    density: area of panels over area of sheet to try; it follows the densities of earlier strips.
    """

    name = "spyrrow"
    min_seconds = 1.0

    #: Angles in degrees.
    turns: ClassVar = {"free": None, "half": [0.0, 180.0], "fixed": [0.0]}
    #: spyrrow computes in single precision: 6000 mm are good to 0.0005 mm.
    margin_mm = 0.01
    #: Share of the width that stays free, as a panel that exactly fits across the strip may not be placed at all.
    slack = 0.001

    def __init__(self) -> None:
        self.density = 0.85

    def fill(self, outlines: Ragged, stock: Stock, seconds: float) -> list[Placement]:
        import spyrrow

        length, width = stock.inside
        chosen = self._choose(outlines, stock)
        if not chosen:
            return []
        # spyrrow keeps the distance from the strip's edges too, so the strip is higher by twice the gap.
        gap = stock.gap_mm + self.margin_mm
        centred = [outlines[index] - outlines[index].mean(axis=0) for index in chosen]
        items = [
            spyrrow.Item(str(number), [(x, y) for x, y in outline.tolist()], 1, self.turns[stock.rotation])
            for number, outline in enumerate(centred)
        ]
        config = spyrrow.StripPackingConfig(
            total_computation_time=None,
            exploration_time=max(1, round(0.8 * seconds)),
            compression_time=round(0.2 * seconds),
            min_items_separation=gap,
            seed=0,
        )
        solution = spyrrow.StripPackingInstance("sheet", width + 2 * gap, items).solve(config)
        self.density = float(np.clip(solution.density, 0.5, 0.98))
        filling = []
        for item in solution.placed_items:
            index = chosen[int(item.id)]
            corner = np.array(item.translation) + stock.border_mm - gap
            offset = corner - turned(outlines[index].mean(axis=0), item.rotation)
            if (turned(outlines[index], item.rotation) + offset)[:, 0].max() <= length + stock.border_mm:
                filling.append(Placement(index, 0, item.rotation, (float(offset[0]), float(offset[1]))))
        return filling

    def _choose(self, outlines: Ragged, stock: Stock) -> list[int]:
        """Indices of the outlines to pack, large ones first, up to the area that the density allows."""
        length, width = stock.inside
        area_left = self.density * length * width
        areas = outline_areas(outlines)
        _, sizes = rectangles(outlines, stock)
        chosen = []
        for index in np.argsort(-areas, kind="stable").tolist():
            if areas[index] <= area_left and sizes[index, 1] <= (1 - self.slack) * width:
                chosen.append(index)
                area_left -= areas[index]
        return chosen
