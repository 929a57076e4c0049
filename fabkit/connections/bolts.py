"""Sizes of bolts, and what the holes and tools for them need."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from fabkit.errors import ProjectError

__all__ = ["BOLT_SIZES", "BoltGroup", "BoltSize"]

ENGAGEMENT_RATIO = 1.25
"""Length of thread in the node over the diameter of the bolt, for a bolt of class 8.8 in structural steel
(EN 1993-1-8 has no rule for blind threads; VDI 2230 finds about 1.2)."""

BOLT_LENGTH_STEP_MM = 5.0
"""Lengths of hexagon head bolts in ISO 4017 are multiples of this, in mm."""


@dataclass(frozen=True)
class BoltSize:
    """A hexagon head bolt with thread up to the head (ISO 4017), in mm.

    clearance_mm: diameter of the hole in a plate (EN 1090-2, table 11). head_flats_mm, head_height_mm: width across
    flats and height of the head. tool_radius_mm, tool_length_mm: of the socket with its drive, over the head.
    spacing_mm: least distance of two bolts for the tool.

    >>> from fabkit.connections import BOLT_SIZES
    >>> m20 = BOLT_SIZES["M20"]
    >>> m20.clearance_mm, m20.bore_depth_mm, m20.length(grip_mm=15), round(m20.head_diameter_mm, 1)
    (22.0, 39.0, 40.0, 34.6)
    """

    name: str
    diameter_mm: float
    pitch_mm: float
    clearance_mm: float
    head_flats_mm: float
    head_height_mm: float
    tool_radius_mm: float
    tool_length_mm: float
    spacing_mm: float

    @property
    def core_mm(self) -> float:
        """Diameter of the drill for the thread (ISO 724)."""
        return self.diameter_mm - 1.0825 * self.pitch_mm

    @property
    def head_diameter_mm(self) -> float:
        """Over the corners of the head."""
        return self.head_flats_mm / math.cos(math.pi / 6)

    @property
    def bore_depth_mm(self) -> float:
        """Depth of the blind threaded bore with the tip of the drill, in whole mm."""
        thread = ENGAGEMENT_RATIO * self.diameter_mm + 1.5 * self.pitch_mm
        return float(math.ceil(1.15 * thread + 0.3 * self.core_mm))

    def length(self, grip_mm: float) -> float:
        """The shortest length sold whose thread engages enough behind `grip_mm` of plate and gap."""
        needed = grip_mm + ENGAGEMENT_RATIO * self.diameter_mm
        return BOLT_LENGTH_STEP_MM * math.ceil(needed / BOLT_LENGTH_STEP_MM - 1e-9)


BOLT_SIZES = {
    size.name: size
    for size in (
        BoltSize("M12", 12.0, 1.75, 13.0, 18.0, 7.5, 15.0, 65.0, 40.0),
        BoltSize("M16", 16.0, 2.0, 18.0, 24.0, 10.0, 19.0, 75.0, 50.0),
        BoltSize("M20", 20.0, 2.5, 22.0, 30.0, 12.5, 23.0, 85.0, 60.0),
        BoltSize("M24", 24.0, 3.0, 26.0, 36.0, 15.0, 27.0, 95.0, 70.0),
        BoltSize("M30", 30.0, 3.5, 33.0, 46.0, 18.7, 34.0, 110.0, 85.0),
    )
}


@dataclass(frozen=True)
class BoltGroup:
    """The bolts of one beam end: one in the middle, or two above each other.

    Raises ProjectError for text that is none.

    >>> from fabkit.connections import BoltGroup
    >>> BoltGroup.of("2 x m16").name, BoltGroup.of("2xM16").offsets_mm, BoltGroup.of("1xM20").offsets_mm
    ('2xM16', (-25.0, 25.0), (0.0,))
    """

    count: int
    size: BoltSize

    @classmethod
    def of(cls, text: str) -> BoltGroup:
        found = re.fullmatch(r"\s*(\d{1,3})\s*[x*]\s*(m\d{1,3})\s*", text.lower()[:200])
        if not found or found[2].upper() not in BOLT_SIZES or int(found[1]) not in (1, 2):
            raise ProjectError(
                f"{text[:40]!r} are no bolts of a beam end: write 1x or 2x and one of {', '.join(BOLT_SIZES)}, "
                "like 1xM20"
            )
        return cls(int(found[1]), BOLT_SIZES[found[2].upper()])

    @property
    def name(self) -> str:
        return f"{self.count}x{self.size.name}"

    @property
    def offsets_mm(self) -> tuple[float, ...]:
        """Levels of the bolts above the middle of the end plate."""
        return (0.0,) if self.count == 1 else (-self.size.spacing_mm / 2, self.size.spacing_mm / 2)
