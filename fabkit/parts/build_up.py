"""Build-ups of glass as the trade writes them, from outside to inside: 8/16Ar/44.2.

A number is a pane of float glass, or, between two panes, a gap with its gas (Ar, Kr, or none for air). 44.2 is a
laminate: two plies of 4 mm and 2 foils of PVB of 0.38 mm each between them. T marks toughened glass (EN 12150), HS
heat-strengthened glass (EN 1863), HST toughened and heat-soaked glass (EN 14179), after the pane: 8T, 66.4HS.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from fabkit.errors import ProjectError
from fabkit.parts.material import Material

__all__ = ["BuildUp", "Pane", "plate_of_glass"]

FOIL_MM = 0.38
"""Thickness in mm of one foil of PVB in a laminate, as in 33.1 or 44.2."""

FOIL_DENSITY_KG_M3 = 1070.0
"""Density in kg/m3 of the PVB between the plies of a laminate."""

FLOAT_GLASS_MM = (2, 3, 4, 5, 6, 8, 10, 12, 15, 19, 25)
"""Nominal thicknesses in mm of float glass (EN 572-8)."""

LAMINATED_PLIES_MM = (2, 3, 4, 5, 6, 8, 10, 12, 15, 19)
"""Nominal thicknesses in mm of the plies of a laminate: with these its digits can be read in one way only."""

WHOLE_PLIES_MM = 0.005
"""Largest difference in mm of a thickness without its foils from whole millimetres of glass, of a laminate whose
thickness is given to two decimals."""

MOST_FOILS = 8
"""Largest number of foils between two plies: 3.04 mm of PVB."""

GAP_RANGE_MM = (6, 27)
"""Least and largest gap between two panes in mm, for which spacers are made."""

MOST_PANES = 4
"""Largest number of panes of a build-up: quadruple glazing."""

MARKS = {"": "", "T": "T", "ESG": "T", "HS": "HS", "TVG": "HS", "HST": "HST", "ESG-H": "HST"}
GASES = {"": "", "AR": "Ar", "ARGON": "Ar", "KR": "Kr", "KRYPTON": "Kr", "AIR": "", "LUFT": ""}

_PANE = re.compile(r"(?:VSG )?(?:(ESG-H|ESG|TVG) )?(\d{1,8})(?:\.(\d{1,4}))? ?(T|HST|HS|ESG-H|ESG|TVG)?")
_GAP = re.compile(r"(\d{1,4}) ?([A-Z]{0,8})")


@dataclass(frozen=True)
class Pane:
    """One pane: a ply of glass, or several with foils between them.

    plies_mm: from outside to inside. foils: their number between each two plies. mark: T, HS, HST or none.

    >>> from fabkit.parts import BuildUp
    >>> pane = BuildUp.of("44.2").panes[0]
    >>> pane.name, pane.plies_mm, pane.foils, pane.thickness_mm
    ('44.2', (4, 4), (2,), 8.76)
    """

    plies_mm: tuple[int, ...]
    foils: tuple[int, ...] = ()
    mark: str = ""

    @property
    def thickness_mm(self) -> float:
        return round(sum(self.plies_mm) + FOIL_MM * sum(self.foils), 2)

    @property
    def is_symmetric(self) -> bool:
        """Whether it is the same pane turned over."""
        return self.plies_mm == self.plies_mm[::-1] and self.foils == self.foils[::-1]

    def mass_kg_m2(self, density_kg_m3: float) -> float:
        """Mass of a square metre; density_kg_m3: of the glass."""
        return (sum(self.plies_mm) * density_kg_m3 + FOIL_MM * sum(self.foils) * FOIL_DENSITY_KG_M3) * 1e-3

    def material(self, glass: Material) -> Material:
        """The pane as a material of one density: glass, if it is a single ply without a mark.

        >>> from fabkit.parts import BuildUp, Material
        >>> material = BuildUp.of("44.2").panes[0].material(Material("glass", 2500))
        >>> material.name, round(material.density_kg_m3)
        ('glass 44.2', 2376)
        """
        if not self.foils:
            return Material(f"{glass.name} {self.mark}".strip(), glass.density_kg_m3)
        density = self.mass_kg_m2(glass.density_kg_m3) / self.thickness_mm * 1e3
        return Material(f"{glass.name} {self.name}", density)

    @property
    def name(self) -> str:
        digits = "".join(map(str, self.plies_mm))
        return f"{digits}{'.' if self.foils else ''}{''.join(map(str, self.foils))}{self.mark}"


@dataclass(frozen=True)
class BuildUp:
    """Panes from outside to inside with gaps between them; gaps: width in mm and gas of each.

    >>> from fabkit.parts import BuildUp
    >>> unit = BuildUp.of("8/16Ar/44.2")
    >>> unit.name, unit.thickness_mm, [pane.name for pane in unit.panes], unit.gaps
    ('8/16Ar/44.2', 32.76, ['8', '44.2'], ((16, 'Ar'),))
    >>> round(unit.mass_kg_m2(2500), 2), unit.levels_mm
    (40.81, (24.76, 0.0))
    """

    panes: tuple[Pane, ...]
    gaps: tuple[tuple[int, str], ...] = ()

    @classmethod
    def of(cls, text: str) -> BuildUp:
        """The build-up that is written so. Raises ProjectError for what is none, with the nearest one.

        >>> from fabkit.parts import BuildUp
        >>> BuildUp.of("ESG 8 / 16 Ar / VSG 66.4").name, BuildUp.of("6-12-6").name
        ('8T/16Ar/66.4', '6/12/6')
        >>> BuildUp.of("8/16Ar/44.9")  # doctest: +ELLIPSIS
        Traceback (most recent call last):
            ...
        fabkit.errors.ProjectError: '8/16Ar/44.9' is no build-up of glass: 44.9 has 9 foils...; write 8/16Ar/44.8
        """
        elements = _elements(text)
        problems, nearest = [], []
        for place, element in enumerate(elements):
            problem, better = (_pane, _gap)[place % 2](element)
            nearest.append(better)
            problems += [problem] if problem else []
        if len(elements) % 2 == 0:
            ends_with_gap = not problems
            problems.append("it needs a pane at either end, and a gap between two panes")
            nearest = [*nearest, nearest[0]] if ends_with_gap else _with_gaps(elements)
        if len(elements) > 2 * MOST_PANES - 1:
            problems.append(f"it has more than {MOST_PANES} panes")
            nearest = nearest[: 2 * MOST_PANES - 1]
        if problems:
            raise ProjectError(
                f"{text.strip()[:40]!r} is no build-up of glass: {problems[0]}; write {'/'.join(nearest)}"
            )
        return cls(tuple(map(_read_pane, elements[::2])), tuple(map(_read_gap, elements[1::2])))

    @property
    def name(self) -> str:
        words = [self.panes[0].name]
        for (width, gas), pane in zip(self.gaps, self.panes[1:], strict=True):
            words += [f"{width}{gas}", pane.name]
        return "/".join(words)

    def __str__(self) -> str:
        return self.name

    @property
    def thickness_mm(self) -> float:
        """Of all of it, gaps included."""
        return round(sum(pane.thickness_mm for pane in self.panes) + sum(width for width, _ in self.gaps), 2)

    @cached_property
    def levels_mm(self) -> tuple[float, ...]:
        """Height of the lower side of each pane above that of the innermost one."""
        levels, level = [], self.thickness_mm
        for pane, (width, _) in zip(self.panes, (*self.gaps, (0, "")), strict=True):
            levels.append(round(level - pane.thickness_mm, 2))
            level = levels[-1] - width
        return tuple(levels)

    def mass_kg_m2(self, density_kg_m3: float) -> float:
        """Mass of a square metre; density_kg_m3: of the glass."""
        return sum(pane.mass_kg_m2(density_kg_m3) for pane in self.panes)


def plate_of_glass(thickness_mm: float, glass: Material) -> Material:
    """The material of a plate of glass of which only the thickness is known: a laminate, if plies of whole millimetres
    have this thickness only with foils between them.

    >>> from fabkit.parts import Material
    >>> laminate = plate_of_glass(8.76, Material("glass", 2500))
    >>> laminate.name, round(laminate.density_kg_m3), plate_of_glass(8.0, Material("glass", 2500)).name
    ('laminated glass', 2376, 'glass')
    """
    for foils in range(1, MOST_FOILS + 1):
        plies = thickness_mm - FOIL_MM * foils
        if plies >= 2 * min(LAMINATED_PLIES_MM) and abs(plies - round(plies)) < WHOLE_PLIES_MM:
            mass = plies * glass.density_kg_m3 + FOIL_MM * foils * FOIL_DENSITY_KG_M3
            return Material(f"laminated {glass.name}", mass / thickness_mm)
    return glass


def _elements(text: str) -> list[str]:
    """The words between strokes, in capitals; hyphens may stand for strokes, but for that of ESG-H."""
    plain = re.sub(r"\s+", " ", text[:80].upper()).replace("ESG-H", "ESG_H").replace("-", "/").replace("ESG_H", "ESG-H")
    return [word.strip() for word in plain.split("/")]


def _read_pane(word: str) -> Pane:
    found = _PANE.fullmatch(word)
    assert found is not None  # _pane found nothing wrong
    before, digits, foils, after = found.groups()
    mark = MARKS[before or after or ""]
    if foils is None:
        return Pane((int(digits),), (), mark)
    plies = _plies(digits)
    counts = tuple(map(int, foils))
    return Pane(tuple(plies), counts, mark)


def _read_gap(word: str) -> tuple[int, str]:
    found = _GAP.fullmatch(word)
    assert found is not None  # _gap found nothing wrong
    return int(found[1]), GASES[found[2]]


def _pane(word: str) -> tuple[str, str]:
    """What is wrong with a pane, empty if nothing is; and the nearest right one."""
    found = _PANE.fullmatch(word)
    if not found:
        return f"{word or 'nothing'} stands where a pane is needed, such as 8, 8T or 44.2", _plain(word, "44.2")
    before, digits, foils, after = found.groups()
    mark = MARKS[before or after or ""]
    if foils is None:
        return _single_ply(digits, mark)
    plies, counts = _plies(digits), [min(max(int(count), 1), MOST_FOILS) for count in foils]
    right = [_nearest(ply, LAMINATED_PLIES_MM) for ply in plies]
    if len(right) == 1:
        right *= 2
    counts = (counts * len(right))[: len(right) - 1] if len(counts) != len(right) - 1 else counts
    better = f"{''.join(map(str, right))}.{''.join(map(str, counts))}{mark}"
    if (wrong := [ply for ply in plies if ply not in LAMINATED_PLIES_MM]) or len(plies) < 2:
        of = wrong[0] if wrong else plies[0]
        return f"{digits}.{foils} has {'a ply' if wrong else 'only one ply,'} of {of} mm", better
    if len(foils) != len(plies) - 1:
        needed = "one number" if len(plies) == 2 else f"{len(plies) - 1} numbers"
        return f"{digits}.{foils} has {len(plies)} plies, so {needed} of foils after the dot would do", better
    if (count := next((int(count) for count in foils if not 1 <= int(count) <= MOST_FOILS), None)) is not None:
        return f"{digits}.{foils} has {count} foils between two plies, and there are 1 to {MOST_FOILS}", better
    return "", better


def _single_ply(digits: str, mark: str) -> tuple[str, str]:
    if int(digits) in FLOAT_GLASS_MM and not digits.startswith("0"):
        return "", f"{digits}{mark}"
    plies = _plies(digits)
    if len(plies) > 1 and all(ply in LAMINATED_PLIES_MM for ply in plies):
        return f"{digits} is a laminate without its number of foils", f"{digits}.{'2' * (len(plies) - 1)}{mark}"
    known = ", ".join(map(str, FLOAT_GLASS_MM))
    better = _nearest(int(digits), FLOAT_GLASS_MM)
    return f"there is no float glass of {int(digits)} mm, only of {known} mm", f"{better}{mark}"


def _gap(word: str) -> tuple[str, str]:
    """What is wrong with a gap, empty if nothing is; and the nearest right one."""
    found = _GAP.fullmatch(word)
    if not found:
        return f"{word or 'nothing'} stands where a gap is needed, such as 16Ar", _plain(word, "16Ar")
    width, gas = int(found[1]), GASES.get(found[2])
    low, high = GAP_RANGE_MM
    better = f"{min(max(width, low), high)}{'Ar' if gas is None else gas}"
    if gas is None:
        return f"{found[2]} is no gas: those known are Ar, Kr, and none for air", better
    if not low <= width <= high:
        return f"a gap of {width} mm is not made, only those of {low} to {high} mm", better
    return "", better


def _with_gaps(elements: list[str]) -> list[str]:
    """The panes among these words, with a gap after each but the last."""
    panes = [better for problem, better in map(_pane, elements) if not problem] or ["44.2"]
    return [word for pane in panes[:MOST_PANES] for word in (pane, "16Ar")][:-1]


def _plain(word: str, usual: str) -> str:
    """The usual element, with the number of this word if it has one that will do."""
    number = re.match(r"\d{1,4}", word)
    read: Callable[[str], tuple[str, str]] = _gap if usual.endswith("Ar") else _pane
    return read(number[0])[1] if number else usual


def _plies(digits: str) -> list[int]:
    """Thicknesses of plies: those of two digits begin with 1."""
    return [int(ply) for ply in re.findall(r"1\d|\d", digits)]


def _nearest(thickness: int, known: tuple[int, ...]) -> int:
    return min(known, key=lambda each: (abs(each - thickness), -each))
