"""All the parts of one structure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, TypeVar

import numpy as np

from fabkit.errors import DetailingError
from fabkit.parts.kind import Details, Kind, in_layer
from fabkit.parts.parts import Part, Parts
from fabkit.parts.zones import Zones
from geometry.arrays import FloatArray, IntArray, floats

__all__ = ["LEFT_OUT_COLOUR", "Assembly", "LeftOut", "Surroundings"]

LEFT_OUT_COLOUR = (0.84, 0.10, 0.12)
"""Colour of parts that are left out: sRGB red, green and blue, 0 to 1."""

D = TypeVar("D", bound=Details)


@dataclass(frozen=True)
class LeftOut:
    """A part that was not made. kind: name of its kind; element: mesh edge, vertex or face, counted from 0; reason: the
    reason in words.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> sizes = {"beams": {"least_length_mm": 1400}, "skip_unbuildable": True}
    >>> roof = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, **sizes)).assembly
    >>> len(roof.left_out) > 0, roof.left_out[0].kind
    (True, 'beam')
    """

    kind: str
    element: int
    reason: str


@dataclass(frozen=True, eq=False)
class Assembly:
    """The parts, one group for each kind, and the parts that had to be left out.

    The parts are placed near zero, where coordinates are most accurate. origin_mm (3,): position of this zero in the
    coordinates of the mesh file, in mm. So a point of a part has the coordinates
    `part.placement.to_world(point) + origin_mm` there. zones: in which it is put up, none by default.

    Raises DetailingError where two kinds share the letter of their marks, their name or that of their group.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> roof = built.assembly
    >>> len(roof["beams"]), roof["nodes"].mark_names, sum(1 for part in roof.parts())
    (30, ('N001', 'N002', 'N003'), 60)
    """

    name: str
    groups: tuple[Parts[Any], ...]
    left_out: tuple[LeftOut, ...] = ()
    origin_mm: FloatArray = field(default_factory=lambda: np.zeros(3))
    zones: Zones = field(default_factory=Zones)

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin_mm", floats(self.origin_mm))
        for one, other in combinations([group.kind for group in self.groups], 2):
            for what, first, second in (
                ("group", one.group, other.group),
                ("name", one.name, other.name),
                ("letter of marks", one.letter, other.letter),
            ):
                if first.casefold() == second.casefold():
                    raise DetailingError(
                        f"{one.group} and {other.group} have the same {what}, {first!r}, so their parts could not be "
                        "told apart; give each kind its own"
                    )

    def __repr__(self) -> str:
        groups = ", ".join(f"{len(parts)} {parts.kind.group}" for parts in self.groups)
        return f"Assembly({self.name}: {groups or 'no parts'})"

    def __getitem__(self, group: str) -> Parts[Any]:
        """The parts of a group by its name: beams, nodes, panels. Raises KeyError where there is none."""
        return {each.kind.group: each for each in self.groups}[group]

    def of(self, kind: Kind[Parts[D]]) -> Parts[D]:
        """The parts of a kind, none where it has no group."""
        for each in self.groups:
            if each.kind is kind:
                return each
        return Parts.of(kind)

    def of_layers(self, kind: Kind[Parts[D]]) -> tuple[Parts[D], ...]:
        """The parts of a kind in each layer of beams: those of the first one, as by `of`, then those of the others."""
        others = (each for each in self.groups if each.kind.layer and each.kind.name == each.kind.named(kind.name))
        return (self.of(kind), *others)

    def beside(self, parts: Parts[Any], kind: Kind[Parts[D]]) -> Parts[D]:
        """The parts of a kind in the same layer of beams as the given parts, as by `of`."""
        return self.of(in_layer(kind, parts.kind.layer))

    def with_group(self, parts: Parts[Any]) -> Assembly:
        """The assembly with these parts in place of the group of their kind, or after the other groups if it has
        none."""
        groups = {each.kind.group: each for each in self.groups} | {parts.kind.group: parts}
        return replace(self, groups=tuple(groups.values()))

    def parts(self) -> Iterator[Part]:
        """All parts, group by group."""
        for group in self.groups:
            yield from group


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The context of the parts of one kind: the assembly with their neighbours, and the sheets on which parts are
    nested.

    sheets: by the name of a nested group, the number (n,) of each part's sheet, counted from 1. panel_file: path of the
    drawing of a panel, with {} in place of its mark.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.kinds import NODE
    >>> from fabkit.parts import Surroundings
    >>> NODE.labels(built.assembly["nodes"], Surroundings(built.assembly))[0]
    'S355; vertex 0, 3 beams'
    """

    assembly: Assembly
    sheets: Mapping[str, IntArray] = field(default_factory=dict)
    panel_file: str = "panels/{}.dxf"
