"""What must always hold for an assembly: sound solids, beams flush on their nodes, no volume shared.

Everything is found from the placed solids and the names of the mesh elements, not from what detailing knew when it
made them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fabkit.checking.clash import clashing_pairs
from fabkit.checking.convex import is_splittable
from fabkit.checking.fit import seats
from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Beam, Panel, Part, face_normals, volumes
from fabkit.parts.stacks import Stack, stacks
from geometry.arrays import BoolArray, FloatArray

__all__ = ["Violation", "check_fit", "in_one_sentence", "violations"]

FIT_MM = 1e-6
"""Faces planar, ends on facets, neighbours apart: five digits below any saw, four above double precision."""
SHORTEST_EDGE_MM = 1e-3
"""CAD programs merge corners that are closer; Rhino's default tolerance is 1e-3 mm."""
TWIST_DEG = 1e-6
RIGID = 1e-10
"""Largest entry of axes axes^T - 1: over 10 m that is the 1e-6 mm asked of everything else."""

ELEMENTS = {"beam": "edge", "node": "vertex", "panel": "face"}


@dataclass(frozen=True)
class Violation:
    """One thing that does not hold. finding: parts, value and bound; cure: what to do.

    parts: kind and mesh element of each part concerned, which may be missing from the assembly.
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
    twist_deg: float = TWIST_DEG,
) -> None:
    """Raises DetailingError, with what `in_one_sentence` says, unless everything holds that `violations` looks at."""
    found = violations(assembly, fit_mm=fit_mm, shortest_edge_mm=shortest_edge_mm, twist_deg=twist_deg)
    if found:
        raise DetailingError(in_one_sentence(found))


def in_one_sentence(found: Sequence[Violation]) -> str:
    """The first findings that have the cure of the very first, how many more there are, the cure, and how many others
    there are besides. At least one violation is needed."""
    cure = found[0].cure
    alike = [violation.finding for violation in found if violation.cure == cure]
    told = alike[:3]
    if len(alike) > len(told):
        told.append(f"and {len(alike) - len(told)} more like this")
    others = len(found) - len(alike)
    besides = f" ({others} other finding{'s' if others > 1 else ''} besides)" if others else ""
    return f"{'; '.join(told)} (elements counted from 0): {cure}{besides}"


def violations(
    assembly: Assembly,
    *,
    fit_mm: float = FIT_MM,
    shortest_edge_mm: float = SHORTEST_EDGE_MM,
    twist_deg: float = TWIST_DEG,
    have_marks: bool = True,
) -> tuple[Violation, ...]:
    """Everything that does not hold, none if all is well; lengths in mm, angles in degrees. have_marks: whether parts
    are called by their marks; where these are still to be shared out, by their mesh elements alone.

    - Each mesh element has at most one part of a kind.
    - Each part is placed by a rigid motion; its solid has positive volume, faces planar to `fit_mm`, no edge shorter
      than `shortest_edge_mm`, and an outline that does not cross itself. What fails here is not looked at further.
    - No beam turns about its axis by more than `twist_deg`.
    - Each beam has a node at both ends, and each node has the beams it names.
    - Each end face of a beam lies on a facet of its node that looks towards it, and inside it, to `fit_mm`.
    - No two parts reach into each other by more than `fit_mm`.
    """
    name = _by_mark if have_marks else _by_element
    parts = list(assembly.parts())
    every = stacks(parts)
    unsound = list(_unsound(parts, every, fit_mm, shortest_edge_mm, name))
    broken = {part for violation in unsound for part in violation.parts}
    is_sound = np.array([(part.kind, part.element) not in broken for part in parts], dtype=bool)
    sound = [stack[is_sound[stack.parts]] for stack in every]
    return (
        *_twice(parts),
        *unsound,
        *_twisted(assembly, twist_deg, name),
        *_unlinked(assembly, name),
        *_unseated(assembly, broken, fit_mm, name),
        *_clashing(assembly, parts, [stack for stack in sound if len(stack.parts)], fit_mm, name),
    )


Name = Callable[[Part], str]
"""What a part is called in a sentence."""


def _by_mark(part: Part) -> str:
    return f"{part.kind} {part.mark} ({ELEMENTS[part.kind]} {part.element})"


def _by_element(part: Part) -> str:
    return f"the {part.kind} {'at' if part.kind == 'node' else 'on'} {ELEMENTS[part.kind]} {part.element}"


def _concerned(*parts: Part) -> tuple[tuple[str, int], ...]:
    return tuple((part.kind, part.element) for part in parts)


def _twice(parts: Iterable[Part]) -> Iterator[Violation]:
    counts = Counter(_concerned(*parts))
    for (kind, element), count in counts.items():
        if count > 1:
            finding = f"{ELEMENTS[kind]} {element} has {count} {kind}s, allowed 1"
            yield Violation(finding, "make each part once", ((kind, element),))


@dataclass(frozen=True, eq=False)
class _Rule:
    """Values (P,), which of them hold (P,), what to say of one that does not, and the cure."""

    values: FloatArray
    holds: BoolArray
    words: str
    cure: str


def _unsound(
    parts: list[Part], every: list[Stack], fit_mm: float, shortest_edge_mm: float, name: Name
) -> Iterator[Violation]:
    """One violation at most for each part: the first rule it breaks."""
    for stack in every:
        passed = np.ones(len(stack.parts), dtype=bool)
        with np.errstate(invalid="ignore", divide="ignore"):  # what is not a number does not hold
            rules = _solid_rules(parts, stack, fit_mm, shortest_edge_mm)
        for rule in rules:
            for k in np.flatnonzero(passed & ~rule.holds).tolist():
                part = parts[stack.parts[k]]
                yield Violation(f"{name(part)} {rule.words.format(rule.values[k])}", rule.cure, _concerned(part))
            passed &= rule.holds


def _solid_rules(parts: list[Part], stack: Stack, fit_mm: float, shortest_edge_mm: float) -> list[_Rule]:
    """A rule means something for those solids only for which the rules before it hold."""
    axes = np.array([parts[k].placement.axes for k in stack.parts])
    skew = np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    volume = volumes(stack.vertices, stack.topology)
    tail, head = stack.topology.edges.T
    shortest = np.linalg.norm(stack.vertices[:, head] - stack.vertices[:, tail], axis=-1).min(axis=1)
    bulge = _bulges(stack)
    measured = (skew <= RIGID) & (volume > 0) & (shortest >= shortest_edge_mm) & (bulge <= fit_mm)
    splittable = measured.copy()
    splittable[measured] = is_splittable(stack[measured])
    return [
        _Rule(
            skew,
            skew <= RIGID,
            f"has axes that are {{:.3g}} from orthonormal, allowed {RIGID:g}",
            "give each part's placement unit axes at right angles",
        ),
        _Rule(
            volume,
            volume > 0,
            "has a volume of {:.6g} mm3, which must be positive",
            "it is inside out or empty: lengthen its edges, or narrow section, setbacks and joints, or leave it out",
        ),
        _Rule(
            shortest,
            shortest >= shortest_edge_mm,
            f"has an edge of {{:.3g}} mm, allowed {shortest_edge_mm:g} mm and more",
            "change the clearance or the joint a little, so that its corners part",
        ),
        _Rule(
            bulge,
            bulge <= fit_mm,
            f"has a face that leaves its plane by {{:.3g}} mm, allowed {fit_mm:g} mm",
            "planarise the mesh first",
        ),
        _Rule(
            volume,
            splittable,
            "is neither convex nor a prism whose outline does not cross itself",
            "widen the angles between its edges, or leave it out",
        ),
    ]


def _bulges(stack: Stack) -> FloatArray:
    """(P,) largest distance of a corner from the middle plane of its face."""
    t = stack.topology
    starts = t.loop_starts[t.face_starts[:-1]]
    normals = face_normals(stack.vertices, t)[:, t.corner_face]
    here = stack.vertices[:, t.corners]
    levels = np.einsum("pck,pck->pc", normals, here - here[:, starts][:, t.corner_face])
    spread = np.maximum.reduceat(levels, starts, axis=1) - np.minimum.reduceat(levels, starts, axis=1)
    bulges: FloatArray = spread.max(axis=1) / 2
    return bulges


def _twisted(assembly: Assembly, twist_deg: float, name: Name) -> Iterator[Violation]:
    for beam in assembly.beams:
        if not abs(beam.twist_deg) <= twist_deg:
            finding = f"{name(beam)} is twisted by {beam.twist_deg:.3g} degrees, allowed {twist_deg:g}"
            yield Violation(finding, "make mesh and Gauss image parallel first", _concerned(beam))


def _unlinked(assembly: Assembly, name: Name) -> Iterator[Violation]:
    cure = "make both or leave out both"
    beams = {beam.element: beam for beam in assembly.beams}
    nodes = {node.element: node for node in assembly.nodes}
    for beam in assembly.beams:
        for end, vertex in zip("AB", beam.nodes, strict=True):
            node = nodes.get(vertex)
            if node is None:
                finding = f"{name(beam)} ends (end {end}) at vertex {vertex}, which has no node"
                yield Violation(finding, cure, (*_concerned(beam), ("node", vertex)))
            elif beam.element not in node.beams:
                finding = f"{name(beam)} ends (end {end}) at {name(node)}, which has no facet for it"
                yield Violation(finding, cure, _concerned(beam, node))
    for node in assembly.nodes:
        for edge in node.beams:
            if edge not in beams or node.element not in beams[edge].nodes:
                finding = f"{name(node)} has a facet for edge {edge}, from which no beam comes"
                yield Violation(finding, cure, (*_concerned(node), ("beam", edge)))


def _unseated(assembly: Assembly, broken: set[tuple[str, int]], fit_mm: float, name: Name) -> Iterator[Violation]:
    beams = [beam for beam in assembly.beams if ("beam", beam.element) not in broken]
    nodes = [node for node in assembly.nodes if ("node", node.element) not in broken]
    found = seats(beams, nodes)
    for k in np.flatnonzero(~(np.maximum(found.off_mm, found.over_mm) <= fit_mm)).tolist():
        beam, node, end = beams[found.beams[k]], nodes[found.nodes[k]], "AB"[found.ends[k]]
        off, over = found.off_mm[k], found.over_mm[k]
        if off > fit_mm:
            finding = f"{name(beam)} at its end {end} is {off:.3g} mm off the facet of {name(node)}"
            cure = "cut beams and node blocks with the same setbacks and axes"
        else:
            finding = f"{name(beam)} at its end {end} sticks out {over:.3g} mm over the facet of {name(node)}"
            cure = "make the facets at least as wide and high as the beams' ends"
        yield Violation(f"{finding}, allowed {fit_mm:g} mm", cure, _concerned(beam, node))


def _clashing(
    assembly: Assembly, parts: list[Part], sound: list[Stack], fit_mm: float, name: Name
) -> Iterator[Violation]:
    pairs, depths = clashing_pairs(sound, depth_mm=fit_mm)
    corners = _Corners.of(assembly) if len(pairs) else None
    for (i, j), depth in zip(pairs.tolist(), depths.tolist(), strict=True):
        first, second = parts[i], parts[j]
        finding = f"{name(first)} and {name(second)} share volume, {depth:.3g} mm deep, allowed {fit_mm:g} mm"
        yield Violation(
            finding, NEARBY if corners and corners.meet(first, second) else APART, _concerned(first, second)
        )


NEARBY = "widen clearance, seat or joint, or leave one of them out with --skip-unbuildable"
APART = (
    "they share no corner of the mesh, which runs through itself or folds back there: move it apart, or leave one of "
    "them out with --skip-unbuildable"
)


@dataclass(frozen=True, eq=False)
class _Corners:
    """of_edge: the vertices at which a beam on an edge ends, as far as beams and nodes tell."""

    of_edge: dict[int, set[int]]

    @classmethod
    def of(cls, assembly: Assembly) -> _Corners:
        ends = {beam.element: set(beam.nodes) for beam in assembly.beams}
        for node in assembly.nodes:
            for edge in node.beams:
                ends.setdefault(edge, set()).add(node.element)
        return cls(ends)

    def meet(self, first: Part, second: Part) -> bool:
        """Whether the elements of two parts have a vertex in common."""
        return not self._vertices(first).isdisjoint(self._vertices(second))

    def _vertices(self, part: Part) -> set[int]:
        if isinstance(part, Panel):
            return set().union(*(self.of_edge.get(edge, set()) for edge in part.beams))
        return set(part.nodes) if isinstance(part, Beam) else {part.element}
