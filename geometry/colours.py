"""Numbers as colours: the scale that picture and mesh files share, and which elements of a mesh the numbers belong to.

One-sided numbers run through viridis, numbers of both signs from blue through white at zero to red.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError
from geometry.mesh import Mesh, MeshLike, as_mesh

__all__ = ["ColourScale", "ElementColours", "Elements", "element_colours"]

Elements: TypeAlias = Literal["faces", "vertices", "edges"]
"""The kind of elements that the numbers of a picture belong to."""

_VIRIDIS = (
    "440154 481a6c 472f7d 414487 39568c 31688e 2a788e 23888e 1f988b 22a884 35b779 54c568 7ad151 a5db36 d2e21b fde725"
)
"""Every 17th of the 256 colours of viridis by Nathaniel J. Smith, Stefan van der Walt and Eric Firing, who placed it in
the public domain (CC0)."""

_BLUE_TO_RED = "236292 5786ad 88aac7 bccedf f7f3ef ecc1b0 d5937a ba6647 9d3807"
"""From a blue to a red of equal lightness, each in equal steps of Oklab lightness from white; made for this project."""

_GREY = 0.72
"""Red, green and blue, between 0 and 1, of elements whose number is NaN."""

ONE_SIDED_TOLERANCE = 1e-6
"""Largest number of one sign over the largest of the other sign for all numbers to count as one-sided: rounding makes
small numbers of the wrong sign."""


@dataclass(frozen=True)
class ColourScale:
    """Colours of the numbers from low to high: viridis, or blue to red with white at zero where low < 0 < high.

    Numbers outside take the colour of the nearer end; NaN is grey.

    >>> scale = ColourScale.of([-0.5, 0.0, 2.0])
    >>> scale.low, scale.high, scale.name
    (-2.0, 2.0, 'blue to red')
    >>> (scale.colours([-2.0, 0.0]) * 255).round().tolist()
    [[35.0, 98.0, 146.0], [247.0, 243.0, 239.0]]
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low <= self.high):
            raise GeometryError(
                f"a colour scale from {self.low:g} to {self.high:g}: give two finite numbers, the smaller one first"
            )

    @classmethod
    def of(cls, values: Any, value_range: tuple[float, float] | None = None) -> ColourScale:
        """The scale of the given range, or else of the finite values: from the least to the largest, and as far below
        zero as above where they have both signs.

        Raises GeometryError where no value is finite, or the range does not ascend.
        """
        if value_range is not None:
            low, high = value_range
            return cls(float(low), float(high))
        finite = np.asarray(values, dtype=float)
        finite = finite[np.isfinite(finite)]
        if not len(finite):
            raise GeometryError("none of the values is a finite number, so they have no range: give value_range")
        low, high = float(finite.min()), float(finite.max())
        largest = max(-low, high)
        if min(-low, high) > ONE_SIDED_TOLERANCE * largest:
            return cls(-largest, largest)
        if low < 0 < high:
            low, high = (0.0, high) if high > -low else (low, 0.0)
        return cls(low, high)

    @property
    def name(self) -> str:
        return "blue to red" if self.low < 0 < self.high else "viridis"

    def colours(self, values: Any) -> FloatArray:
        """(n, 3) red, green and blue between 0 and 1 of values (n,)."""
        values = np.asarray(values, dtype=float)
        if self.low < 0 < self.high:
            largest = max(-self.low, self.high)
            places, colours = np.clip(values, self.low, self.high) / largest / 2 + 0.5, _table(_BLUE_TO_RED)
        else:
            spread = self.high - self.low
            places, colours = (values - self.low) / spread if spread else values * 0 + 0.5, _table(_VIRIDIS)
        rows = np.linspace(0, 1, len(colours))
        found = np.stack([np.interp(places, rows, channel) for channel in colours.T], axis=-1)
        return floats(np.where(np.isnan(values)[..., None], _GREY, found))


def _table(words: str) -> FloatArray:
    """(n, 3) colours between 0 and 1 of hexadecimal words."""
    return np.array([list(bytes.fromhex(word)) for word in words.split()]) / 255


@dataclass(frozen=True, eq=False)
class ElementColours:
    """Colours (n, 3) from 0 to 1 of all faces, vertices or edges; the values (n,) that they show, and their scale."""

    on: Elements
    rgb: FloatArray
    values: FloatArray | None = None
    scale: ColourScale | None = None

    @property
    def eight_bits(self) -> IntArray:
        """(n, 3) from 0 to 255."""
        return integers(np.rint(self.rgb * 255))

    @property
    def comment(self) -> str:
        """What the colours show, for the head of a file."""
        if self.scale is None:
            return ""
        return f"colours show values from {self.scale.low:.6g} to {self.scale.high:.6g}, {self.scale.name}"


def element_colours(
    mesh: MeshLike,
    values: Any = None,
    colours: Any = None,
    *,
    on: Elements | None = None,
    value_range: tuple[float, float] | None = None,
    choices: tuple[Elements, ...] = ("faces", "vertices"),
) -> ElementColours | None:
    """The colours of the elements of a mesh from values (n,), or as given (n, 3); None where there are neither.

    colours: integers from 0 to 255, or other numbers from 0 to 1. on: the kind of elements, needed only where n fits
    more than one kind.

    Raises GeometryError where both are given, n fits no elements or several, or the colours are outside their range.

    >>> from geometry.mesh import shapes
    >>> element_colours(shapes.grid(2, 3), [1, 2, 3, 4, 5, 6]).on
    'faces'
    """
    mesh = as_mesh(mesh)
    if values is None and colours is None:
        return None
    if values is not None and colours is not None:
        raise GeometryError("values and colours are both given: leave out one of them, as values make the colours")
    if values is not None:
        numbers = _numbers(values, "values", "(n,), a number for each element")
        if numbers.ndim != 1:
            raise GeometryError(f"values have shape {numbers.shape}: give (n,), a number for each element")
        scale = ColourScale.of(numbers, value_range)
        on = _elements(mesh, len(numbers), "values", on, choices)
        return ElementColours(on, scale.colours(numbers), numbers, scale)
    if value_range is not None:
        raise GeometryError("value_range is the range of values, and colours are given: leave it out")
    given = _numbers(colours, "colours", "(n, 3), red, green and blue for each element")
    if given.ndim != 2 or given.shape[1] != 3:
        raise GeometryError(f"colours have shape {given.shape}: give (n, 3), red, green and blue for each element")
    bound = 255 if np.issubdtype(np.asarray(colours).dtype, np.integer) else 1
    wrong = np.flatnonzero(~((given >= 0) & (given <= bound)).all(axis=1))
    if len(wrong):
        raise GeometryError(
            f"colour {wrong[0]} (counted from 0) is {given[wrong[0]].tolist()}: give integers from 0 to 255, or other "
            "numbers from 0 to 1",
            elements=wrong.tolist(),
        )
    return ElementColours(_elements(mesh, len(given), "colours", on, choices), floats(given / bound))


def _numbers(given: Any, name: str, shape: str) -> FloatArray:
    try:
        return floats(given)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"the {name} are not all numbers: give an array {shape}") from error


def _elements(mesh: Mesh, count: int, name: str, on: Elements | None, choices: tuple[Elements, ...]) -> Elements:
    """The kind of elements to which `count` values belong."""
    counts: dict[Elements, int] = {choice: getattr(mesh, f"n_{choice}") for choice in choices}
    has = ", ".join(f"{n} {choice}" for choice, n in counts.items())
    if on is not None and on not in counts:
        raise GeometryError(f"on={on!r}: give one of {', '.join(map(repr, counts))}")
    if on is not None and counts[on] != count:
        raise GeometryError(f"there are {count} {name} on {on}, but the mesh has {has}", value=count, bound=counts[on])
    fitting = [choice for choice, n in counts.items() if n == count]
    if not fitting:
        raise GeometryError(f"there are {count} {name}, but the mesh has {has}: give one for each", value=count)
    if on is None and len(fitting) > 1:
        raise GeometryError(
            f"the mesh has {has}, so {count} {name} may belong to {' or '.join(fitting)}: say on={fitting[0]!r} or "
            f"on={fitting[1]!r}"
        )
    return on or fitting[0]
