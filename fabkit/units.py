"""Units of input files; inside fabkit all lengths are in millimetres."""

from __future__ import annotations

from typing import Literal

__all__ = ["MM_PER_UNIT", "Unit"]

Unit = Literal["mm", "cm", "m", "in", "ft"]

MM_PER_UNIT: dict[Unit, float] = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
"""Millimetres in each unit."""
