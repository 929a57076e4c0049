"""The checks that every assembly must pass: valid solids, beams flush on their nodes, no clashes.

Everything is found from the placed solids and the numbers of their mesh elements, independently of detailing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fabkit.checking.access import tool_volumes
from fabkit.checking.bore_distances import drilling_faults
from fabkit.checking.clash import clashing_pairs
from fabkit.checking.fit import end_fits
from fabkit.checking.links import ElementVertices, unlinked_ends, unlinked_facets
from fabkit.checking.positions import Positions
from fabkit.checking.solid_rules import solid_rules
from fabkit.errors import DetailingError
from fabkit.kinds import BEAM, BOLT, NODE, PANEL, BeamDetails, NodeDetails
from fabkit.parts import Assembly, Part, Parts, SolidArray

__all__ = ["Violation", "check_fit", "violations", "violations_sentence"]

FIT_MM = 1e-6
"""Largest deviation of faces from planar, of ends from facets, and depth of overlap, in mm. Five digits below the
accuracy of any saw, four above double precision."""
SHORTEST_EDGE_MM = 1e-3
"""Minimum length of an edge of a solid, in mm. CAD programs merge corners that are closer; Rhino's default is 1e-3
mm."""
UNCOVERED_TOLERANCE_PERCENT = 1e-4
"""Largest difference between how much of a beam's end is found outside its facet and what the node says of it, in % of
its area. On ends of 100 mm it is a strip of 1e-4 mm, above rounding of clipped polygons."""
LARGEST_TWIST_DEG = 1e-6
"""Largest twist of a beam, in degrees."""


@dataclass(frozen=True)
class Violation:
    """A check that failed. finding: parts, value and bound; cure: what to do.

    parts: kind and mesh element of each part concerned; the part itself may be missing from the assembly.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.checking import violations
    >>> [violation.sentence for violation in violations(built.assembly)]
    []
    >>> violations(built.assembly, shortest_edge_mm=60)[0].parts
    (('beam', 0),)
    """

    finding: str
    cure: str
    parts: tuple[tuple[str, int], ...]

    @property
    def sentence(self) -> str:
        return f"{self.finding} (elements counted from 0); {self.cure}"


def check_fit(
    assembly: Assembly,
    *,
    fit_mm: float = FIT_MM,
    shortest_edge_mm: float = SHORTEST_EDGE_MM,
    twist_deg: float = LARGEST_TWIST_DEG,
) -> None:
    """Raise DetailingError, with the text of `violations_sentence`, if `violations` finds any.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.checking import check_fit
    >>> check_fit(built.assembly)
    >>> check_fit(built.assembly, shortest_edge_mm=60)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    fabkit.errors.DetailingError: beam B001 (edge 0) has an edge of 50 mm, allowed 60 mm and more...
    """
    found = violations(assembly, fit_mm=fit_mm, shortest_edge_mm=shortest_edge_mm, twist_deg=twist_deg)
    if found:
        raise DetailingError(violations_sentence(found))


def violations_sentence(found: Sequence[Violation]) -> str:
    """A sentence with up to three findings that share the cure of the first one, the number of further ones, the cure,
    and the number of findings with other cures. At least one violation is needed.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.checking import violations, violations_sentence
    >>> sentence = violations_sentence(violations(built.assembly, shortest_edge_mm=60)[:1])
    >>> sentence.split(" (elements")[0]
    'beam B001 (edge 0) has an edge of 50 mm, allowed 60 mm and more'
    """
    cure = found[0].cure
    alike = [violation.finding for violation in found if violation.cure == cure]
    shown = alike[:3]
    if len(alike) > len(shown):
        shown.append(f"and {len(alike) - len(shown)} more like this")
    others = len(found) - len(alike)
    further = f" (and {others} other finding{'s' if others > 1 else ''})" if others else ""
    return f"{'; '.join(shown)} (elements counted from 0): {cure}{further}"


def violations(
    assembly: Assembly,
    *,
    fit_mm: float = FIT_MM,
    shortest_edge_mm: float = SHORTEST_EDGE_MM,
    twist_deg: float = LARGEST_TWIST_DEG,
    have_marks: bool = True,
) -> tuple[Violation, ...]:
    """All checks that fail, in words; empty if there are none. Lengths are in mm, angles in degrees. have_marks:
    whether parts have marks already, by which they are then named; if not, they are named by their mesh elements alone.

    - Each mesh element has at most one part of a kind, and each face one panel in each pane of a layer.
    - Each part is placed by a rigid motion; its solid has positive volume, faces planar to `fit_mm`, no edge shorter
      than `shortest_edge_mm`, and an outline that does not cross itself. A part that fails here is not checked further.
    - No beam is twisted about its axis by more than `twist_deg`.
    - Each beam has a node at both ends, and each facet of a node has its beam.
    - Each end face of a beam lies, moved by its gap, on a facet of its node that faces it, to `fit_mm`, and inside that
      facet but for the share that the node says is uncovered.
    - Bores keep edge distances, pitches and walls; sockets over the heads of bolts have room.
    - No two parts overlap by more than `fit_mm`.

    The solids are checked as they are. Where parts share the solid of their mark, as in `Built.assembly`, ends are off
    their facets and parts overlap by about what their marks hide (`Parts.hidden_mm`), and each violation says so:
    whether a design fits is asked of `Built.nominal`, as `design` did.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.checking import violations
    >>> violations(built.nominal)
    ()
    >>> len(violations(built.nominal, shortest_edge_mm=11)) > 0
    True
    """
    name = _by_mark if have_marks else _by_element
    positions = Positions(assembly)
    every = positions.placed()
    invalid = list(_invalid_solids(positions, every, fit_mm, shortest_edge_mm, name))
    is_valid = np.ones(len(positions), dtype=bool)
    is_valid[[position for position, _ in invalid]] = False
    valid, fitting = every, assembly
    if invalid:
        valid, fitting = [batch[is_valid[batch.parts]] for batch in every], positions.where(is_valid)
    shared = _of_shared_solids(assembly, fit_mm)
    return (
        *_twice(assembly),
        *(violation for _, violation in invalid),
        *_twisted(assembly, twist_deg, name),
        *(found for beams, nodes in _layers(assembly) for found in _unlinked(beams, nodes, name)),
        *map(shared, (found for own in _layers(fitting) for found in _misfitting_ends(*own, fit_mm, name))),
        *_badly_drilled(positions, valid, name),
        *map(shared, _clashing(positions, [batch for batch in valid if len(batch.parts)], fit_mm, name)),
    )


Name = Callable[[Part], str]
"""A function that gives the name of a part in a sentence."""


def _of_shared_solids(assembly: Assembly, fit_mm: float) -> Callable[[Violation], Violation]:
    """What adds to the cure of a violation of neighbours that parts share solids, if some do so by more than fit_mm."""
    hidden = max((float(parts.hidden_mm[:, 0].max(initial=0.0)) for parts in assembly.groups), default=0.0)
    if hidden <= fit_mm:
        return lambda violation: violation
    shared = f"parts have the solids of their marks here, {hidden:.2g} mm off at most: check Built.nominal instead, or"
    return lambda violation: replace(violation, cure=f"{shared} {violation.cure}")


def _by_mark(part: Part) -> str:
    return f"{part.kind.name} {part.mark} ({part.kind.element} {part.element})"


def _by_element(part: Part) -> str:
    kind = part.kind
    others = ((name, getattr(part.details, name)) for name in kind.apart_by)
    own = "".join(f" in {name} {number}" for name, number in others if number)
    return f"the {kind.name} {'at' if kind.element == 'vertex' else 'on'} {kind.element} {part.element}{own}"


def _concerned(*parts: Part) -> tuple[tuple[str, int], ...]:
    return tuple((part.kind.name, part.element) for part in parts)


def _layers(assembly: Assembly) -> list[tuple[Parts[BeamDetails], Parts[NodeDetails]]]:
    """The beams of each layer, and their nodes."""
    return [(beams, assembly.beside(beams, NODE)) for beams in assembly.of_layers(BEAM)]


def _twice(assembly: Assembly) -> Iterator[Violation]:
    for group in (each for each in assembly.groups if each.kind.one_per_element or each.kind.apart_by):
        keys = np.stack([group.elements, *(getattr(group.details, name) for name in group.kind.apart_by)], axis=1)
        found, counts = np.unique(keys, axis=0, return_counts=True)
        for (element, *others), count in zip(found[counts > 1].tolist(), counts[counts > 1].tolist(), strict=True):
            place = "".join(f" in {name} {k}" for name, k in zip(group.kind.apart_by, others, strict=True) if k)
            finding = f"{group.kind.element} {element} has {count} {group.kind.group}{place}, allowed 1"
            yield Violation(finding, "make each part once", ((group.kind.name, element),))


def _invalid_solids(
    positions: Positions,
    every: list[SolidArray],
    fit_mm: float,
    shortest_edge_mm: float,
    name: Name,
) -> Iterator[tuple[int, Violation]]:
    """At most one violation for each part, the first rule that it breaks, with the position of the part."""
    axes = np.concatenate([np.zeros((0, 3, 3)), *(group.axes for group in positions.assembly.groups)])
    for batch in (few for whole in every for few in whole.in_batches()):
        passed = np.ones(len(batch.parts), dtype=bool)
        with np.errstate(invalid="ignore", divide="ignore"):  # a value that is not a number fails the check
            rules = solid_rules(axes[batch.parts], batch, fit_mm, shortest_edge_mm)
        for rule in rules:
            for k in np.flatnonzero(passed & ~rule.holds).tolist():
                position = int(batch.parts[k])
                finding = f"{name(positions[position])} {rule.words.format(rule.values[k])}"
                yield position, Violation(finding, rule.cure, _concerned(positions[position]))
            passed &= rule.holds


def _twisted(assembly: Assembly, twist_deg: float, name: Name) -> Iterator[Violation]:
    for beams in assembly.of_layers(BEAM):
        twists = beams.details.twist_deg
        for k in np.flatnonzero(~(np.abs(twists) <= twist_deg)).tolist():
            finding = f"{name(beams[k])} is twisted by {twists[k]:.3g} degrees, allowed {twist_deg:g}"
            yield Violation(finding, "make mesh and Gauss image parallel first", _concerned(beams[k]))


def _unlinked(beams: Parts[BeamDetails], nodes: Parts[NodeDetails], name: Name) -> Iterator[Violation]:
    cure = "make both or leave out both"
    for k, end, at in unlinked_ends(beams, nodes):
        beam, vertex = beams[k], int(beams.details.nodes[k, end])
        if at < 0:
            finding = f"{name(beam)} ends (end {'AB'[end]}) at vertex {vertex}, which has no node"
            yield Violation(finding, cure, (*_concerned(beam), (nodes.kind.name, vertex)))
        else:
            finding = f"{name(beam)} ends (end {'AB'[end]}) at {name(nodes[at])}, which has no facet for it"
            yield Violation(finding, cure, _concerned(beam, nodes[at]))
    for k, edge in unlinked_facets(beams, nodes):
        finding = f"{name(nodes[k])} has a facet for edge {edge}, at which no beam ends"
        yield Violation(finding, cure, (*_concerned(nodes[k]), (beams.kind.name, edge)))


def _misfitting_ends(
    beams: Parts[BeamDetails], nodes: Parts[NodeDetails], fit_mm: float, name: Name
) -> Iterator[Violation]:
    found = end_fits(beams, nodes)
    declared = nodes.details.uncovered_at(beams.elements[found.beams], found.nodes)
    uncovered = np.abs(found.uncovered_percent - declared)
    fits = (found.overhang_mm <= fit_mm) | (uncovered <= UNCOVERED_TOLERANCE_PERCENT) & (declared > 0)
    for k in np.flatnonzero(~((found.plane_gap_mm <= fit_mm) & fits)).tolist():
        beam, node, end = beams[int(found.beams[k])], nodes[int(found.nodes[k])], "AB"[found.ends[k]]
        off, over = found.plane_gap_mm[k], found.overhang_mm[k]
        if off > fit_mm:
            finding = f"{name(beam)} at its end {end} is {off:.3g} mm off the facet of {name(node)}"
            cure = "cut beams and node blocks with the same setbacks and axes"
        else:
            finding = f"{name(beam)} at its end {end} sticks out {over:.3g} mm over the facet of {name(node)}"
            cure = "make the facets at least as wide and high as the beams' ends"
        yield Violation(f"{finding}, allowed {fit_mm:g} mm", cure, _concerned(beam, node))


def _badly_drilled(positions: Positions, valid: list[SolidArray], name: Name) -> Iterator[Violation]:
    for batch in valid:
        for row, words, cure in drilling_faults(batch):
            part = positions[int(batch.parts[row])]
            yield Violation(f"{name(part)} {words}", cure, _concerned(part))


def _clashing(positions: Positions, valid: list[SolidArray], fit_mm: float, name: Name) -> Iterator[Violation]:
    tools, bolts = tool_volumes(positions.assembly, len(positions)), positions.of_layers(BOLT)
    pairs, depths = clashing_pairs([*valid, tools] if len(tools.parts) else valid, depth_mm=fit_mm)
    of_tools = (pairs >= len(positions)).sum(axis=1)
    for (i, j), depth in zip(pairs[of_tools == 1].tolist(), depths[of_tools == 1].tolist(), strict=True):
        bolt = int(bolts[j - len(positions)])
        if i != bolt:
            finding = f"the socket for {name(positions[bolt])} would be {depth:.3g} mm inside {name(positions[i])}"
            cure = "take smaller bolts, a larger section or another kind of connection"
            yield Violation(finding, cure, _concerned(positions[bolt], positions[i]))
    pairs, depths = pairs[of_tools == 0], depths[of_tools == 0]
    if not len(pairs):
        return
    vertices = ElementVertices(positions.assembly)
    for (i, j), depth in zip(pairs.tolist(), depths.tolist(), strict=True):
        first, second = positions[i], positions[j]
        finding = f"{name(first)} and {name(second)} share volume, {depth:.3g} mm deep, allowed {fit_mm:g} mm"
        yield Violation(finding, _cure(first, second, vertices), _concerned(first, second))


def _cure(first: Part, second: Part, vertices: ElementVertices) -> str:
    kinds = {part.kind.name: part.kind for part in (second, first)}
    cures = list(dict.fromkeys(kind.cure for kind in kinds.values() if kind.cure))
    if cures:
        return ", or ".join(cures + [CURE_OF_LAYERS] * (PANEL.name in kinds))
    known = (BEAM, NODE, PANEL)
    own = [part.kind.name for part in (first, second) if not part.kind.layer and part.kind not in known]
    if own:
        return f"change the origins, the axes or the size of each {own[0]}"
    are_distant = vertices.of(first).isdisjoint(vertices.of(second))
    if are_distant:
        return CURE_OF_DISTANT_PARTS
    return CURE_OF_PANELS if PANEL.name in kinds else CURE_OF_NEIGHBOURS


CURE_OF_LAYERS = "give that layer of panels another z_mm or a wider joint_mm ([[layers]])"
CURE_OF_PANELS = (
    "increase the slot between beams ([connection] slot_mm, or --clearance where they are in contact), the seat or the "
    f"joint, {CURE_OF_LAYERS}, or leave one of the parts out with --skip-unbuildable"
)
CURE_OF_NEIGHBOURS = (
    "increase the slot between beams ([connection] slot_mm, or --clearance where they are in contact), or leave one of "
    "the parts out with --skip-unbuildable"
)
CURE_OF_DISTANT_PARTS = (
    "they share no vertex of the mesh, which intersects itself or folds back there: separate the mesh there, or leave "
    "one of the parts out with --skip-unbuildable"
)
