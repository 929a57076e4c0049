"""Cross-sections of bars."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Section"]


@dataclass(frozen=True)
class Section:
    """A solid rectangle: width across the central plane, height along it, both in mm.

    >>> from fabkit.parts import Section
    >>> Section(50, 120).name
    'flat 50x120'
    """

    width_mm: float
    height_mm: float

    @property
    def name(self) -> str:
        return f"flat {self.width_mm:g}x{self.height_mm:g}"
