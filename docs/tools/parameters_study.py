"""A study on the page of `parameters.py`: parameters, and the meshes M and S for their values.

The parameters of a study are independent, so it has as many meshes as there are combinations of their values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from geometry.gauss import Pair

__all__ = ["Parameter", "Study"]


@dataclass(frozen=True, eq=False)
class Parameter:
    """A slider, or a row of buttons for texts. shown: format of a value; start: index of the first value."""

    name: str
    sentence: str
    values: tuple[Any, ...]
    shown: str = "{}"
    start: int = 0


@dataclass(frozen=True, eq=False)
class Study:
    """make: from a value of each parameter to M and S. mean: H of every face where it is known. beam: height of the
    beams shown, in the unit of M. view: azimuth and elevation of the first view, in radians."""

    family: str
    title: str
    sentence: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Pair]
    beam: float
    mean: float | None = None
    view: tuple[float, float] = (-1.0, 0.45)
