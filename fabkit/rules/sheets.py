"""The stock sheets from which panels are cut, and what each process of cutting needs between them."""

from __future__ import annotations

from math import isnan, nan
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.rules.lengths import NotNegative, Positive

__all__ = ["CuttingProcess", "SheetRules", "SheetSize"]

CuttingProcess = Literal["glass", "laser", "plasma", "waterjet", "saw"]

GAP_AND_BORDER_MM: dict[CuttingProcess, tuple[float, float]] = {
    "glass": (20.0, 25.0),
    "laser": (10.0, 10.0),
    "plasma": (10.0, 20.0),
    "waterjet": (2.4, 2.4),
    "saw": (4.4, 20.0),
}
"""Default gap between panels and border of sheets in mm by process. glass: room to break laminated glass along each
cut, and what is trimmed off each edge. laser: the web between two cuts as wide as the sheet is thick (SMS Laser, design
rules), up to 10. plasma: the starting point for plate (Primecut help, plate gap settings), and as much again at the
edge of the sheet (Autodesk Fabrication help, general nesting). waterjet: two kerfs of up to 1.2, so that cuts do not
overlap (CutOptim help, reference values). laser and waterjet have the same at the edge (Autodesk Fabrication help).
saw: kerf of industrial panel saws, up to 4.4 (OptimalLayout, saw blade kerf), and the usual trim (Magi-Cut help,
crosscut trim)."""

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True, config=_STRICT)
class SheetSize:
    """A size of stock sheets. count: how many there are of each thickness and material, None for any number.

    >>> from fabkit.rules import SheetSize
    >>> SheetSize(3210, 2250).count is None
    True
    """

    length_mm: Positive
    width_mm: Positive
    count: Annotated[int, Field(ge=0)] | None = None


@dataclass(frozen=True, config=_STRICT)
class SheetRules:
    """Stock sheets, by default a jumbo of float glass (EN 572-2).

    process: how panels are cut. gap_mm: between panels, kerf included; border_mm: to the edge of the sheet; by default
    what the process needs. rotation: "free"; "half" for panels that may be turned by half a turn only, "fixed" for
    those that may not: edge 1 then lies along the sheet, as its grain does. sizes: in the place of length_mm and
    width_mm, each with a count if there are so many only.

    >>> from fabkit.rules import SheetRules
    >>> sawn = SheetRules(process="saw", border_mm=10)
    >>> sawn.gap_mm, sawn.border_mm, SheetRules().gap_mm
    (4.4, 10.0, 20.0)
    """

    length_mm: Positive = 6000.0
    width_mm: Positive = 3210.0
    process: CuttingProcess = "glass"
    gap_mm: NotNegative = nan
    border_mm: NotNegative = nan
    rotation: Literal["free", "half", "fixed"] = "free"
    sizes: tuple[SheetSize, ...] = ()

    @model_validator(mode="after")
    def _complete(self) -> SheetRules:
        if self.sizes and (self.length_mm, self.width_mm) != (6000.0, 3210.0):
            raise ValueError("sheets have both sizes and a length or width of their own: give one of them")
        for key, usual in zip(("gap_mm", "border_mm"), GAP_AND_BORDER_MM[self.process], strict=True):
            if isnan(getattr(self, key)):
                object.__setattr__(self, key, usual)
        return self
