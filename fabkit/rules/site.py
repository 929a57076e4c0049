"""Where the structure stands on its site: one rigid transformation, from the coordinates of the mesh file."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.parts import Frame

__all__ = ["SiteRules"]

RIGID_TOLERANCE = 1e-6
"""Largest deviation of axes that are given from orthonormal ones, which replace them: six decimals round by half of it,
0.1 mm over 100 m."""
LARGEST_COORDINATE_MM = 1e11
"""Largest coordinate in mm of a point of a site: more than any map has, on which double numbers are 0.01 mm apart."""

Coordinate = Annotated[float, Field(ge=-LARGEST_COORDINATE_MM, le=LARGEST_COORDINATE_MM, allow_inf_nan=False)]
Point = tuple[Coordinate, Coordinate, Coordinate]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class SiteRules:
    """The transformation from the coordinates of the mesh file, in mm, to those of the site.

    origin_mm: where zero of the mesh file lies on the site. turn_deg: by how much the file is turned about the vertical
    axis, counter-clockwise seen from above; or axes: the directions of its x, y and z axes on the site.

    >>> from fabkit.rules import SiteRules
    >>> SiteRules(origin_mm=(1000, 2000, 0), turn_deg=90).frame.to_world(np.array([10.0, 0, 5])).round(6).tolist()
    [1000.0, 2010.0, 5.0]
    """

    origin_mm: Point = (0.0, 0.0, 0.0)
    turn_deg: Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)] | None = None
    axes: tuple[Point, Point, Point] | None = None

    @model_validator(mode="after")
    def _rigid(self) -> SiteRules:
        if self.axes is None:
            return self
        if self.turn_deg is not None:
            raise ValueError("turn_deg and axes both say how the site is turned: take out one of the two")
        axes = np.array(self.axes)
        off = float(np.abs(axes @ axes.T - np.eye(3)).max())
        if not off <= RIGID_TOLERANCE:
            raise ValueError(
                f"axes are not perpendicular unit vectors: their products are off by {off:.2g}, allowed "
                f"{RIGID_TOLERANCE:g}, so that lengths would change; give directions with seven decimals, or turn_deg"
            )
        if np.linalg.det(axes) < 0:
            raise ValueError("axes are left-handed, which would mirror the structure: reverse one of them")
        return self

    @property
    def frame(self) -> Frame:
        """The frame of the mesh file, in the coordinates of the site."""
        origin = np.array(self.origin_mm)
        if self.axes is not None:
            left, _, right = np.linalg.svd(np.array(self.axes))
            return Frame(origin, left @ right)
        turn = np.radians(self.turn_deg or 0.0)
        cosine, sine = np.cos(turn), np.sin(turn)
        return Frame(origin, np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]))
