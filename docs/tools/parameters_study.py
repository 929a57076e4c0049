"""What a study of the page of `parameters.py` is: parameters, and the meshes M and S that they lead to.

The parameters of a study are turned independently, so it has as many meshes as there are combinations of their values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from geometry.gauss import Pair

__all__ = ["Parameter", "Study"]


@dataclass(frozen=True, eq=False)
class Parameter:
    """A slider, or a row of buttons where the values are texts. shown: how a value is written; start: its place."""

    name: str
    sentence: str
    values: tuple[Any, ...]
    shown: str = "{}"
    start: int = 0


@dataclass(frozen=True, eq=False)
class Study:
    """make: from a value of each parameter to M and S. mean: H of every face where it is known. beam: the height of the
    beams that are drawn, in the unit of M. view: azimuth and elevation from which it is first seen, in radians."""

    family: str
    title: str
    sentence: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Pair]
    beam: float
    mean: float | None = None
    view: tuple[float, float] = (-1.0, 0.45)
