"""What is unusual about a mesh, with its number; and what becomes of it: told, allowed or refused."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from fabkit.errors import FabkitError

__all__ = ["CRITERIA", "TOLD_BY_NAME", "Finding", "FitnessError", "Level", "allowed", "check_fit_to_build", "named"]

Level = Literal["told", "allowed", "refused"]

CRITERIA: dict[str, str] = {
    "moves": "",
    "folding": "a face that turned by 90 degrees is no longer the face that was given",
    "self-crossing": "no plate and no frame has an outline that crosses itself",
    "self-intersection": "",
    "lean": "",
    "heights": "it is told, and stops no build",
    "outwards": "a beam that does not point out of its faces has no place for their panels",
    "mitres": "it is told, and stops no build",
    "blocks": "it is told, and stops no build",
    "lift": "it is told, and stops no build",
    "sheets": "a panel that fits on no sheet cannot be cut; leave it out with --skip-unbuildable",
}
"""All that is judged, by the name that `--allow` accepts; and why it may not be allowed, empty where it may."""

TOLD_BY_NAME = 10
"""So many elements are named in a sentence; the manifest has them all."""


@dataclass(frozen=True)
class Finding:
    """Something that is unusual about a mesh or what is made of it.

    name: of the criterion, one of `CRITERIA`. value, bound: the number that was found, and from which on it is told
    or refused, in `unit`. sentence: number and place in words; cure: what to do about it. noun, elements: the
    vertices, edges or faces concerned, the worst first, counted from 0.
    """

    name: str
    level: Level
    value: float
    bound: float
    unit: str
    sentence: str
    cure: str
    noun: str = ""
    elements: tuple[int, ...] = ()

    @property
    def may_be_allowed(self) -> bool:
        return not CRITERIA[self.name]

    @property
    def advice(self) -> str:
        """The cure, and the option where it may be accepted as it is."""
        if self.level == "refused" and self.may_be_allowed:
            return f"{self.cure}, or accept it with --allow {self.name}"
        return self.cure


class FitnessError(FabkitError):
    """A mesh is not fit to be built from. findings: all up to here, those that are refused among them."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        refused = [finding for finding in findings if finding.level == "refused"]
        super().__init__("; ".join(f"unfit ({each.name}): {each.sentence}: {each.advice}" for each in refused))
        self.findings = tuple(findings)


def allowed(findings: Iterable[Finding], names: Collection[str]) -> tuple[Finding, ...]:
    """The findings, refused ones of these names being allowed, and allowed ones of other names refused."""
    return tuple(_levelled(finding, names) for finding in findings)


def _levelled(finding: Finding, names: Collection[str]) -> Finding:
    if finding.level == "told":
        return finding
    return replace(finding, level="allowed" if finding.name in names and finding.may_be_allowed else "refused")


def check_fit_to_build(findings: Sequence[Finding]) -> None:
    """Raise FitnessError, with all refused findings in one sentence each, where there are any."""
    if any(finding.level == "refused" for finding in findings):
        raise FitnessError(findings)


def named(names: Sequence[str], *, at_most: int = TOLD_BY_NAME) -> str:
    """The first of the names, and how many more there are."""
    more = f" and {len(names) - at_most} more" if len(names) > at_most else ""
    return ", ".join(names[:at_most]) + more
