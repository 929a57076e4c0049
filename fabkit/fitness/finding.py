"""Findings: unusual properties of a mesh or its parts, with their values; noted, accepted, or refused."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fabkit.errors import FabkitError
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = [
    "CRITERIA",
    "MAX_NAMED_ELEMENTS",
    "Finding",
    "FitnessError",
    "Level",
    "check_fit_to_build",
    "named",
    "with_accepted",
    "worst_first",
]

Level = Literal["note", "accepted", "refused"]

CRITERIA: dict[str, str] = {
    "moves": "",
    "folding": "a face that turned by 90 degrees is no longer the face that was given",
    "self-crossing": "neither a plate nor a frame can have an outline that crosses itself",
    "self-intersection": "",
    "lean": "",
    "heights": "it is only noted and stops no build",
    "tilt": "a beam that does not point to the outside of its faces leaves no place for their panels",
    "mitres": "it is only noted and stops no build",
    "block-heights": "it is only noted and stops no build",
    "slots": "it is only noted; [connection] least_angle_deg says what cannot be welded",
    "uncovered": "it is only noted and stops no build",
    "underside": "it is only noted and stops no build",
    "corners": "it is only noted and stops no build",
    "short-edges": "it is only noted and stops no build",
    "panel-masses": "it is only noted and stops no build",
    "going-in": "it is only noted; these beams go in from inside, or with a larger [connection] gap_mm",
    "props": "it is only noted; these nodes are propped, or zones and supports chosen otherwise",
    "sheets": "a panel that does not fit on a sheet cannot be cut; leave it out with --skip-unbuildable",
}
"""The name of each criterion, as `--accept` takes it, and the reason why a finding cannot be accepted, empty if it
can."""

MAX_NAMED_ELEMENTS = 10
"""Largest number of elements that one sentence names; the manifest lists all of them."""


@dataclass(frozen=True)
class Finding:
    """Something unusual about a mesh or about the parts made from it.

    name: the criterion, one of `CRITERIA`. level: "note" (a build goes ahead), "refused" (a build stops) or "accepted"
    (it would be refused, but the user accepts it). value, bound: the value found, and the value from which it is noted
    or refused, both in `unit`. sentence: value and place in words; cure: what to do about it. noun, elements: the
    vertices, edges or faces concerned, the worst first, counted from 0. layer: "lower" or "upper" where it concerns
    the beams and nodes of a second layer.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> finding = built.summary.fitness[0]
    >>> finding.name, finding.level, finding.bound, finding.may_be_accepted
    ('heights', 'note', 0.1, False)
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
    layer: str = ""

    @property
    def may_be_accepted(self) -> bool:
        return not CRITERIA[self.name]

    @property
    def advice(self) -> str:
        """The cure, and the option by which the finding can be accepted as it is."""
        if self.level == "refused" and self.may_be_accepted:
            return f"{self.cure}, or accept it with --accept {self.name}"
        return self.cure


class FitnessError(FabkitError):
    """A mesh is not fit to be built. findings: all findings so far, the refused ones among them.

    >>> from fabkit import Project, design
    >>> from fabkit.fitness import FitnessError
    >>> from geometry.mesh.shapes import dome
    >>> try:
    ...     design(Project(mesh=dome(6, 2), mean_edge_mm=1500, fitness={"lean_noted_deg": 1, "lean_refused_deg": 2}))
    ... except FitnessError as error:
    ...     print([finding.name for finding in error.findings if finding.level == "refused"])
    ['lean']
    """

    def __init__(self, findings: Sequence[Finding]) -> None:
        refused = [finding for finding in findings if finding.level == "refused"]
        super().__init__("; ".join(f"unfit ({each.name}): {each.sentence}: {each.advice}" for each in refused))
        self.findings = tuple(findings)


def with_accepted(findings: Iterable[Finding], names: Collection[str]) -> tuple[Finding, ...]:
    """The findings; those with these names are accepted instead of refused, where that is possible.

    >>> from fabkit.fitness import Finding, with_accepted
    >>> lean = Finding("lean", "refused", 34.0, 30.0, "degrees", "node axes lean by 34 degrees", "lay other lines")
    >>> [finding.level for finding in with_accepted([lean], {"lean"})]
    ['accepted']
    """
    return tuple(_levelled(finding, names) for finding in findings)


def _levelled(finding: Finding, names: Collection[str]) -> Finding:
    if finding.level == "note":
        return finding
    return replace(finding, level="accepted" if finding.name in names and finding.may_be_accepted else "refused")


def check_fit_to_build(findings: Sequence[Finding]) -> None:
    """Raise FitnessError if any finding is refused, with one sentence for each refused one.

    >>> from fabkit.fitness import Finding, check_fit_to_build
    >>> lean = Finding("lean", "refused", 34.0, 30.0, "degrees", "node axes lean by 34 degrees", "lay other lines")
    >>> check_fit_to_build([lean])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    fabkit.fitness.finding.FitnessError: unfit (lean): node axes lean by 34 degrees...
    """
    if any(finding.level == "refused" for finding in findings):
        raise FitnessError(findings)


def named(names: Sequence[str], *, at_most: int = MAX_NAMED_ELEMENTS) -> str:
    """The first of the names, and the number of the others."""
    more = f" and {len(names) - at_most} more" if len(names) > at_most else ""
    return ", ".join(names[:at_most]) + more


def worst_first(badness: FloatArray, chosen: BoolArray) -> IntArray:
    """The numbers of the chosen elements, those of the largest badness first; both (n,)."""
    found = np.flatnonzero(chosen)
    order: IntArray = found[np.argsort(-badness[found], kind="stable")]
    return order
