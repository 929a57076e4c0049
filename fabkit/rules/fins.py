"""What a shop decides about fins."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.rules.lengths import Level, NotNegative, Positive

__all__ = ["FinRules"]

Number = Annotated[float, Field(allow_inf_nan=False)]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class FinRules:
    """Plates along the edges, between the meshes M + d1 (S + x) and M + d2 (S + x), which are parallel to M
    [Pottmann2007, 4.4].

    from_mm, to_mm: d1 and d2, negative on the inner side of M. direction: x, by default zero. suns: instead of it,
    positions of the sun, for which x is sought that casts most shade on the panels: pairs of azimuth, clockwise from
    the y axis, and altitude above the xy-plane, in degrees; or vectors towards the sun. longest_direction: largest
    length of the x that is sought.

    gap_mm: minimum clear distance of neighbouring fins at a node. clearance_mm: minimum distance to the panels of the
    two faces at the edge. least_length_mm: minimum length of a fin between its two cuts.

    >>> from fabkit.rules import FinRules
    >>> rules = FinRules(from_mm=60, to_mm=300, suns=[(180, 45), (270, 30)])
    >>> [[round(part, 2) + 0.0 for part in sun] for sun in rules.sun_vectors]
    [[0.0, -0.71, 0.71], [-0.87, 0.0, 0.5]]
    """

    from_mm: Level
    to_mm: Level
    thickness_mm: Positive = 8.0
    direction: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    suns: tuple[tuple[Number, ...], ...] = ()
    longest_direction: Annotated[float, Field(gt=0, lt=1, allow_inf_nan=False)] = 0.99
    gap_mm: Positive = 10.0
    clearance_mm: NotNegative = 10.0
    least_length_mm: Positive = 20.0
    material: str = "S355"

    @model_validator(mode="after")
    def _has_height(self) -> FinRules:
        if not self.from_mm < self.to_mm:
            raise ValueError(
                f"fins from {self.from_mm:g} to {self.to_mm:g} mm have no height: make to_mm larger than from_mm"
            )
        return self

    @model_validator(mode="after")
    def _suns_shine(self) -> FinRules:
        if self.suns and any(self.direction):
            raise ValueError("direction and suns are both given: take one of them, as suns decide the direction")
        for number, sun in enumerate(self.suns):
            if len(sun) not in (2, 3):
                raise ValueError(
                    f"sun {number} has {len(sun)} numbers: write [azimuth, altitude] in degrees, or a vector [x, y, z]"
                )
        for number, (sun, vector) in enumerate(zip(self.suns, self.sun_vectors, strict=True)):
            if not vector[2] > 0 or (len(sun) == 2 and sun[1] > 90):
                raise ValueError(f"sun {number}, {list(sun)}, is not above the horizon: leave it out, or turn it up")
        return self

    @property
    def sun_vectors(self) -> tuple[tuple[float, float, float], ...]:
        """Vectors towards the suns."""
        return tuple(_vector(sun) for sun in self.suns)


def _vector(sun: tuple[float, ...]) -> tuple[float, float, float]:
    if len(sun) == 3:
        return sun[0], sun[1], sun[2]
    azimuth, altitude = map(math.radians, sun)
    level = math.cos(altitude)
    return math.sin(azimuth) * level, math.cos(azimuth) * level, math.sin(altitude)
