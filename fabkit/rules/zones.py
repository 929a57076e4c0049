"""Zones in which a structure is put up one after the other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated

from pydantic import AfterValidator, ConfigDict, Field
from pydantic.dataclasses import dataclass

from fabkit.rules.lengths import Level
from fabkit.wording import echo, one_line

__all__ = ["ZoneRules", "problem_of_zones"]

LONGEST_ZONE_NAME = 40
"""Largest number of letters of the name of a zone: more would make the widest column of every list."""

_RUNS = re.compile(r"(?:^|;)[-=+@\uff1d\uff0b\uff0d\uff20]")


def _name(text: str) -> str:
    one_line(text)
    if not text.strip():
        raise ValueError("a zone needs a name, such as 'North'")
    if text != text.strip():
        raise ValueError("a name begins and ends with a letter, a digit or a sign, not with a blank")
    if _RUNS.search(text):
        raise ValueError(
            "a spreadsheet would run what begins with =, +, - or @, here or after a semicolon: begin with a "
            "letter or a digit"
        )
    if len(text) > LONGEST_ZONE_NAME:
        raise ValueError(f"a name of a zone has at most {LONGEST_ZONE_NAME} letters, and this one has {len(text)}")
    return text


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class ZoneRules:
    """A zone: some of the faces, with all that belongs to them.

    faces: these faces, counted from 0. below_mm: all faces whose middle, the mean of their corners, is below this
    height, z at the coordinates of the mesh file in mm, as far as no zone names them and none before has them. Both are
    added. A zone without either, of which there is one at most, has all faces that are in no other one.

    >>> from fabkit.rules import ZoneRules
    >>> ZoneRules("North", faces=[0, 3]).chooses, ZoneRules("Others").chooses
    (True, False)
    """

    name: Annotated[str, AfterValidator(_name)]
    faces: tuple[Annotated[int, Field(ge=0)], ...] | None = None
    below_mm: Level | None = None

    @property
    def chooses(self) -> bool:
        """Whether it says which faces it has."""
        return self.faces is not None or self.below_mm is not None


def problem_of_zones(zones: Sequence[ZoneRules]) -> str:
    """Why these zones cannot be told apart, in a sentence; empty if they can."""
    first: dict[str, int] = {}
    owner: dict[int, str] = {}
    for number, zone in enumerate(zones):
        if zone.name.casefold() in first:
            return (
                f"zones {first[zone.name.casefold()]} and {number} (counted from 0) have the same name, "
                f"{echo(zone.name)}: give each its own"
            )
        first[zone.name.casefold()] = number
        for face in zone.faces or ():
            if owner.setdefault(face, zone.name) != zone.name:
                return (
                    f"face {face} (counted from 0) is in zones {echo(owner[face])} and {echo(zone.name)}: take it "
                    "out of one of the two"
                )
    rest = [zone.name for zone in zones if not zone.chooses]
    if len(rest) > 1:
        return (
            f"zones {echo(rest[0])} and {echo(rest[1])} both say nothing of their faces, and one alone can have all "
            "others: give one of them faces, or below_mm"
        )
    return ""
