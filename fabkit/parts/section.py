"""Cross-sections of bars as the trade writes them: height first, standing, in mm."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fabkit.errors import ProjectError
from geometry.arrays import FloatArray, floats

__all__ = ["Section"]

_SIZES = {
    "flat": ("height", "width"),
    "rhs": ("height", "width", "wall"),
    "tee": ("height", "flange width", "flange", "web"),
    "i": ("height", "flange width", "flange", "web"),
    "round": ("diameter",),
    "chs": ("diameter", "wall"),
}

_WORDS = r"(?:\s*(rounded)|\s*r\s*(\d{1,12}(?:\.\d{1,12})?))?"
"""What may follow the sizes of a rectangular hollow section: its corners, sharp without any of the two."""

_EXAMPLES = "flat 120x12, rhs 120x60x5, tee 120x80x10x8, i 120x80x10x8, round 60 or chs 60.3x4"


@dataclass(frozen=True)
class Section:
    """A cross-section, symmetric about the central plane of its edge.

    shape, sizes: "flat" (height, width), "rhs" (rectangular hollow section: height, width, wall), "tee" and "i"
    (height, flange width, thickness of the flange, of the web), "round" (diameter), "chs" (circular hollow section:
    diameter, wall), in mm. The flange of a tee is its outer side. Points of a section are (y, z): y across the central
    plane, z outwards from half of the height. radius_mm: outer radius of the corners of a rectangular hollow section, 0
    for sharp ones; inside, they have what the wall leaves of it. It is written as r10, or as `rounded` for the radius
    of cold-formed sections in EN 10219-2: 2 walls up to a wall of 6 mm, 2.5 up to 10 mm, 3 above. Raises ProjectError
    for sizes that no bar can have.

    >>> from fabkit.parts import Section
    >>> hollow = Section.of("RHS 120x60x5")
    >>> hollow.name, hollow.height_mm, hollow.width_mm, hollow.area_mm2, [len(loop) for loop in hollow.loops]
    ('rhs 120x60x5', 120.0, 60.0, 1700.0, [4, 4])
    >>> round(hollow.mass_kg_m(7850.0), 2), Section.of("tee 120x80x10x8").web_mm
    (13.34, 8.0)
    >>> Section.of("rhs 120x60x5 rounded").name, round(Section.of("rhs 120x60x5 r10").mass_kg_m(7850.0), 2)
    ('rhs 120x60x5 r10', 12.84)
    """

    shape: str
    sizes: tuple[float, ...]
    radius_mm: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sizes", tuple(float(size) for size in self.sizes))
        object.__setattr__(self, "radius_mm", float(self.radius_mm))
        if self.shape not in _SIZES:
            raise ProjectError(f"{self.name!r} is no section: write one like {_EXAMPLES}, in mm, height first")
        if len(self.sizes) != len(_SIZES[self.shape]):
            needed = _SIZES[self.shape]
            raise ProjectError(
                f"the section {self.name} has {len(self.sizes)} sizes in place of {len(needed)}: after {self.shape} "
                f"write {' x '.join(needed)} in mm, as in {_EXAMPLES}"
            )
        for what, size in zip(_SIZES[self.shape], self.sizes, strict=True):
            if not 0 < size < math.inf:
                raise ProjectError(f"the {what} of the section {self.name} is {size:g} mm: it must be above 0")
        for what, size, whole, limit in self._limits():
            if not size < limit:
                raise ProjectError(
                    f"the {what} of the section {self.name} is {size:g} mm, which leaves nothing of the {whole}: it "
                    f"must be below {limit:g} mm"
                )
        if self.radius_mm and self.shape != "rhs":
            raise ProjectError(f"only rectangular hollow sections have rounded corners, not {self.name}: leave r out")
        if not 0 <= self.radius_mm < math.inf:
            raise ProjectError(f"the radius of the section {self.name} is {self.radius_mm:g} mm: it must be 0 or more")

    def _limits(self) -> list[tuple[str, float, str, float]]:
        """What is limited, its size, what would vanish, and the limit."""
        sizes = self.sizes
        match self.shape:
            case "rhs":
                half = min(sizes[:2]) / 2
                return [("wall", sizes[2], "hollow inside", half), ("radius", self.radius_mm, "flat sides", half)]
            case "chs":
                return [("wall", sizes[1], "hollow inside", sizes[0] / 2)]
            case "tee":
                return [("flange", sizes[2], "web", sizes[0]), ("web", sizes[3], "flange beside it", sizes[1])]
            case "i":
                return [("flange", sizes[2], "web", sizes[0] / 2), ("web", sizes[3], "flange beside it", sizes[1])]
        return []

    @classmethod
    def of(cls, text: str) -> Section:
        """The section with this name. Raises ProjectError for one that is unknown or impossible.

        >>> from fabkit.parts import Section
        >>> Section.of("flat 120x12").sizes, Section.of("CHS 60.3 x 4").name
        ((120.0, 12.0), 'chs 60.3x4')
        >>> Section.of("RHS 120x60x8 rounded").radius_mm, Section.of("rhs 120x60x5 R7.5").corner_radii
        (20.0, (7.5, 2.5))
        """
        number = r"-?\d{1,12}(?:\.\d{1,12})?"
        found = re.fullmatch(
            rf"\s*([a-z]{{1,10}})\s*({number}(?:\s*[x*]\s*{number}){{0,3}}){_WORDS}\s*", text.lower()[:200]
        )
        if not found:
            raise ProjectError(f"{text[:40]!r} is no section: write one like {_EXAMPLES}, in mm, height first")
        sizes = tuple(float(size) for size in re.split(r"\s*[x*]\s*", found[2]))
        return cls(found[1], sizes, _rolled_radius(sizes[-1]) if found[3] else float(found[4] or 0.0))

    @property
    def name(self) -> str:
        sizes = "x".join(f"{size:.10g}" for size in self.sizes)
        return f"{self.shape} {sizes}{f' r{self.radius_mm:.10g}' if self.radius_mm else ''}"

    def __str__(self) -> str:
        return self.name

    # --- sizes

    @property
    def height_mm(self) -> float:
        return self.sizes[0]

    @property
    def width_mm(self) -> float:
        """Of all of it."""
        return self.sizes[0] if self.is_round else self.sizes[1]

    @property
    def web_mm(self) -> float:
        """Thickness of the web of a tee or i; of other sections the whole width."""
        return self.sizes[3] if self.shape in ("tee", "i") else self.width_mm

    @property
    def flange_mm(self) -> float:
        """Thickness of the flanges of a tee or i, 0 of other sections."""
        return self.sizes[2] if self.shape in ("tee", "i") else 0.0

    @property
    def wall_mm(self) -> float | None:
        """Of a hollow section, None of others."""
        return self.sizes[-1] if self.shape in ("rhs", "chs") else None

    @property
    def is_round(self) -> bool:
        return self.shape in ("round", "chs")

    @property
    def area_mm2(self) -> float:
        if self.is_round:
            return math.pi * sum(radius**2 * sign for radius, sign in zip(self.radii, (1, -1), strict=False))
        cut_off = sum(sign * radius**2 for radius, sign in zip(self.corner_radii, (1, -1), strict=False))
        return float(sum(_area(loop) for loop in self.loops)) - (4 - math.pi) * cut_off

    def mass_kg_m(self, density_kg_m3: float) -> float:
        """Mass of a metre."""
        return self.area_mm2 * 1e-6 * density_kg_m3

    # --- shape

    @property
    def radii(self) -> tuple[float, ...]:
        """Of round sections: the outer radius, and the inner one of a tube, in mm; of others none."""
        if not self.is_round:
            return ()
        outer = self.sizes[0] / 2
        return (outer,) if self.shape == "round" else (outer, outer - self.sizes[1])

    @property
    def corner_radii(self) -> tuple[float, ...]:
        """Of the corners of each loop, in mm; none where all are sharp."""
        return (self.radius_mm, max(0.0, self.radius_mm - self.sizes[2])) if self.radius_mm else ()

    @cached_property
    def loops(self) -> tuple[FloatArray, ...]:
        """Corners (n, 2) of the outline, counter-clockwise seen against the bar's axis, and of its hole, clockwise;
        none of round sections; rounded corners are given as sharp ones. Reversed and mirrored in y, each is itself but
        for the corner that is first."""
        if self.is_round:
            return ()
        half, top = self.width_mm / 2, self.height_mm / 2
        match self.shape:
            case "rhs":
                wall = self.sizes[2]
                return _box(half, -top, top), floats(_box(half - wall, wall - top, top - wall)[::-1])
            case "tee":
                right = [(self.web_mm / 2, -top), (self.web_mm / 2, top - self.sizes[2]), (half, top - self.sizes[2])]
                return (_mirrored([*right, (half, top)]),)
            case "i":
                web, flange = self.web_mm / 2, top - self.sizes[2]
                return (
                    _mirrored(
                        [(half, -top), (half, -flange), (web, -flange), (web, flange), (half, flange), (half, top)]
                    ),
                )
        return (_box(half, -top, top),)


def _rolled_radius(wall: float) -> float:
    return wall * (2.0 if wall <= 6 else 2.5 if wall <= 10 else 3.0)


def _box(half: float, low: float, high: float) -> FloatArray:
    return floats(np.array([[-half, low], [half, low], [half, high], [-half, high]]))


def _mirrored(right: list[tuple[float, float]]) -> FloatArray:
    """The outline whose right half has these corners, from below to above."""
    own = np.array(right)
    return floats(np.concatenate([own, own[::-1] * [-1.0, 1.0]]))


def _area(loop: FloatArray) -> float:
    following = np.roll(loop, -1, axis=0)
    return float((loop[:, 0] * following[:, 1] - loop[:, 1] * following[:, 0]).sum()) / 2
