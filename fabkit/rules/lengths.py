"""Types of the lengths in mm that a project may state."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

__all__ = ["LARGEST_LENGTH_MM", "Level", "NotNegative", "Positive"]

LARGEST_LENGTH_MM = 1e9
"""Largest length in mm that a project may state: a thousand kilometres, far below the
lengths whose products overflow."""

Positive = Annotated[float, Field(gt=0, le=LARGEST_LENGTH_MM, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST_LENGTH_MM, allow_inf_nan=False)]
Level = Annotated[float, Field(ge=-LARGEST_LENGTH_MM, le=LARGEST_LENGTH_MM, allow_inf_nan=False)]
