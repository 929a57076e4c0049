"""Positions of the sun: given as vectors, or from a place and times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.errors import GeometryError

__all__ = ["Suns", "suns_at"]

SEA_LEVEL_MILLIBAR = 1013.25
"""Air pressure for refraction; without refraction it is 0."""

TERRESTRIAL_TIME_OFFSET_SECONDS = 69.0
"""Terrestrial minus universal time: 64 s in 2000, 69 s in 2020, slowly growing; 5 s more turn the sun by 1e-6
radians."""

NORTH_COSINE_TOLERANCE = 1e-9
"""Cosine of the angle between north and up, up to which it counts as a right angle."""


@dataclass(frozen=True, eq=False)
class Suns:
    """Parallel light from some directions, each with a weight.

    directions (k, 3): towards the sun, of any length, made unit; weights (k,): hours or irradiance that each sun stands
    for, above 0; one number for all, by default 1. up (3,): the vertical, by default z.

    Raises GeometryError where shapes do not fit, a number is not finite or a weight not above 0, and for a sun that
    does not stand above the horizon.

    >>> Suns([[1, 0, 1], [0, 0, 2]], weights=[1, 3]).directions.round(3)
    array([[0.707, 0.   , 0.707],
           [0.   , 0.   , 1.   ]])
    """

    __repr__ = short_repr

    directions: FloatArray
    weights: FloatArray = field(default_factory=lambda: floats(1.0))
    up: FloatArray = field(default_factory=lambda: floats([0.0, 0.0, 1.0]))

    def __post_init__(self) -> None:
        directions = floats(self.directions)
        if directions.ndim != 2 or directions.shape[1] != 3 or not len(directions):
            raise GeometryError(
                f"directions to the sun have shape {directions.shape}, they must be (k, 3), k at least 1"
            )
        weights = floats(self.weights)
        if weights.shape not in ((), (len(directions),)):
            raise GeometryError(f"{len(directions)} suns need as many weights, not an array of shape {weights.shape}")
        object.__setattr__(self, "directions", _unit(directions, "the direction of sun"))
        object.__setattr__(self, "up", _unit(floats(self.up)[None], "upright vector")[0])
        object.__setattr__(self, "weights", floats(np.broadcast_to(weights, len(directions))))
        self._check_weights()
        self._check_horizon()

    def _check_weights(self) -> None:
        wrong = np.flatnonzero(~(np.isfinite(self.weights) & (self.weights > 0)))
        if len(wrong):
            raise GeometryError(
                f"sun {wrong[0]} has the weight {self.weights[wrong[0]]:g}: weights must be above 0; leave the sun out",
                elements=wrong.tolist(),
                value=float(self.weights[wrong[0]]),
                bound=0.0,
            )

    def _check_horizon(self) -> None:
        heights = np.arcsin(np.clip(self.directions @ self.up, -1, 1))
        low = np.flatnonzero(heights <= 0)
        if len(low):
            raise GeometryError(
                f"sun {low[0]} is {np.degrees(-heights[low[0]]):.1f} degrees below the horizon: leave it out"
                + (f"; so are {len(low) - 1} more" if len(low) > 1 else ""),
                elements=low.tolist(),
                value=float(heights[low[0]]),
                bound=0.0,
            )


def suns_at(
    latitude: float,
    longitude: float,
    times: Sequence[datetime],
    *,
    weights: Any = 1.0,
    north: Any = (0.0, 1.0, 0.0),
    up: Any = (0.0, 0.0, 1.0),
    refraction: bool = False,
) -> Suns:
    """The suns seen from a place at some times, which must have a time zone.

    latitude and longitude in radians, north and east positive; north and up (3,): the orientation of the mesh.
    Positions by [Reda2004], good to 5e-6 radians; refraction of the air lifts a sun at the horizon by .01 radians.

    Needs the extra `sun`: `pip install fabkit[sun]`. Raises GeometryError without it, for a place that is none, no
    times or a time without zone, north and up that are not at right angles, and a sun below the horizon.

    >>> import numpy as np
    >>> from datetime import timezone
    >>> noon = datetime(2027, 6, 21, 11, tzinfo=timezone.utc)
    >>> suns = suns_at(np.radians(48.2), np.radians(16.4), [noon])
    >>> np.degrees(np.arcsin(suns.directions[0, 2])).round(1).item()  # above the horizon
    65.2
    """
    try:
        from sunposition import sunposition
    except ImportError as error:
        raise GeometryError("sun positions need the package sunposition: pip install 'fabkit[sun]'") from error
    _check_place(latitude, longitude)
    _check_times(times)
    azimuths, zeniths, *_ = sunposition(
        [time.astimezone(UTC) for time in times],
        np.degrees(latitude),
        np.degrees(longitude),
        0.0,
        pressure=SEA_LEVEL_MILLIBAR if refraction else 0.0,
        delta_t=TERRESTRIAL_TIME_OFFSET_SECONDS,
        radians=True,
        jit=False,
    )
    n, u = _unit(np.stack([floats(north), floats(up)]), "north and up: vector")
    if not abs(n @ u) <= NORTH_COSINE_TOLERANCE:
        raise GeometryError(
            f"north is {np.degrees(np.arccos(n @ u)):.6f} degrees off the vertical, it must be level: give a north "
            "that is perpendicular to up",
            value=float(n @ u),
            bound=NORTH_COSINE_TOLERANCE,
        )
    level = np.sin(zeniths)
    east_north_up = np.stack([level * np.sin(azimuths), level * np.cos(azimuths), np.cos(zeniths)], axis=1)
    return Suns(east_north_up @ np.stack([np.cross(n, u), n, u]), weights, u)


def _check_place(latitude: float, longitude: float) -> None:
    """Raise GeometryError for a place that is none."""
    for name, value, bound in (("latitude", latitude, np.pi / 2), ("longitude", longitude, np.pi)):
        if not abs(value) <= bound:
            raise GeometryError(
                f"the {name} is {value:g}, it must be within {bound:.4f} either way: give it in radians",
                value=float(value),
                bound=float(bound),
            )


def _check_times(times: Sequence[datetime]) -> None:
    """Raise GeometryError for no times, and for one without a time zone."""
    if not len(times):
        raise GeometryError("no times are given, so there are no suns: give at least one")
    for number, time in enumerate(times):
        if time.utcoffset() is None:
            raise GeometryError(
                f"time {number}, {time.isoformat()}, has no time zone: add one, as in tzinfo=timezone.utc",
                elements=[number],
            )


def _unit(vectors: FloatArray, what: str) -> FloatArray:
    """Vectors (k, 3) made unit. Raises GeometryError, calling vector j `what` j, where one is zero or not finite."""
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(vectors, axis=1)
    wrong = np.flatnonzero(~(np.isfinite(lengths) & (lengths > 0)))
    if len(wrong):
        raise GeometryError(
            f"{what} {wrong[0]} is {vectors[wrong[0]].tolist()}, it must be finite and not zero",
            elements=wrong.tolist(),
        )
    return floats(vectors / lengths[:, None])
