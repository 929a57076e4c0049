"""The colours of parts by kind, one table for every format."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["LEFT_OUT_COLOUR", "PALETTE"]

PALETTE: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "beam": (0.36, 0.42, 0.47),
        "node": (0.80, 0.42, 0.16),
        "panel": (0.55, 0.75, 0.85),
    }
)
"""sRGB red, green and blue, 0 to 1, by `Part.kind`."""

LEFT_OUT_COLOUR = (0.84, 0.10, 0.12)
