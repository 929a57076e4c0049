"""Assemblies of parts made one by one, and parts and assemblies with something changed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Any

from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.parts import Assembly, LeftOut, Part, Parts

__all__ = ["altered", "assembled", "by_name", "with_parts"]

KINDS = {kind.group: kind for kind in (BEAM, NODE, PANEL)}


def assembled(
    name: str,
    beams: Iterable[Part] = (),
    nodes: Iterable[Part] = (),
    panels: Iterable[Part] = (),
    left_out: tuple[LeftOut, ...] = (),
) -> Assembly:
    return Assembly(name, (Parts.of(BEAM, beams), Parts.of(NODE, nodes), Parts.of(PANEL, panels)), left_out)


def with_parts(assembly: Assembly, **groups: Iterable[Part]) -> Assembly:
    """The assembly with other parts in these groups."""
    for name, parts in groups.items():
        assembly = assembly.with_group(Parts.of(KINDS[name], parts))
    return assembly


def altered(part: Part, **changes: Any) -> Part:
    """The part with some of its fields, or of its details, changed."""
    own = {each.name for each in fields(Part)}
    details = {name: value for name, value in changes.items() if name not in own}
    others = {name: value for name, value in changes.items() if name in own}
    return replace(part, **others, details=replace(part.details, **details)) if details else replace(part, **others)


def by_name(assembly: Assembly) -> dict[str, Parts[Any]]:
    return {group.kind.group: group for group in assembly.groups}
