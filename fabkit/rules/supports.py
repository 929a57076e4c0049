"""What a shop decides about supports."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.connections import LEAST_EDGE_RATIO
from fabkit.parts import Section
from fabkit.rules.lengths import Level, Positive

__all__ = ["SupportRules"]

STUB_SHAPES = ("chs", "rhs", "round")
"""Sections that a stub may have: closed ones, which carry what comes from any side."""

Count = Annotated[int, Field(ge=0)]


def _loop(given: Any) -> Any:
    if given == "rim" or given is None or (isinstance(given, int) and not isinstance(given, bool) and given >= 0):
        return given
    raise ValueError("a boundary loop is a number, counted from 0, or 'rim' for all of them")


Loop = Annotated[int | Literal["rim"] | None, BeforeValidator(_loop)]
SectionName = Annotated[str, AfterValidator(lambda text: Section.of(text).name)]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class SupportRules:
    """Nodes on a stub with a base plate. Reactions, and whether the sizes suffice for them, are the engineer's.

    vertices: of these nodes, counted from 0. below_mm: all nodes below this height, z at the coordinates of the mesh
    file in mm. loop: all nodes on this boundary loop, counted from 0, or on any with "rim". What they choose is added.

    stub: its section; length_mm: along the node axis, from the bottom of the node to the plate. plate_mm: side of the
    square plate; plate_thickness_mm; hole_mm: diameter of its four holes, hole_edge_mm: from their axes to both edges.
    The plate is level where the node axis is within 60 degrees of the vertical, and square to the axis elsewhere.

    >>> from fabkit.rules import SupportRules
    >>> SupportRules(loop=0).stub, SupportRules(vertices=[3, 7], stub="RHS 80 x 80 x 6").stub
    ('chs 48.3x5', 'rhs 80x80x6')
    """

    vertices: tuple[Count, ...] = ()
    below_mm: Level | None = None
    loop: Loop = None
    stub: SectionName = "chs 48.3x5"
    length_mm: Positive = 150.0
    plate_mm: Positive = 200.0
    plate_thickness_mm: Positive = 15.0
    hole_mm: Positive = 18.0
    hole_edge_mm: Positive = 40.0
    material: str = "S355"

    @model_validator(mode="after")
    def _chooses(self) -> SupportRules:
        if not self.vertices and self.below_mm is None and self.loop is None:
            raise ValueError("supports are nowhere: choose nodes by vertices = [0, 8], below_mm = 100 or loop = 'rim'")
        return self

    @model_validator(mode="after")
    def _possible(self) -> SupportRules:
        section = Section.of(self.stub)
        if section.shape not in STUB_SHAPES:
            raise ValueError(f"stub is {self.stub}, and stubs are closed: write one like chs 76.1x5 or rhs 80x80x6")
        to_edge, beside = LEAST_EDGE_RATIO * self.hole_mm, section.width_mm / 2 + self.hole_mm / 2
        from_middle = self.plate_mm / 2 - self.hole_edge_mm
        if self.hole_edge_mm < to_edge:
            raise ValueError(
                f"hole_edge_mm is {self.hole_edge_mm:g} mm, and the edge of a plate must be at least "
                f"{to_edge:.1f} mm from the axis of a hole of {self.hole_mm:g} mm"
            )
        if from_middle < beside:
            raise ValueError(
                f"holes {from_middle:g} mm beside the middle of the plate are under the stub {self.stub}, and at least "
                f"{beside:.1f} mm are needed: make plate_mm larger, or hole_edge_mm smaller"
            )
        return self
