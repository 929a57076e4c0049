"""From a support structure to an assembly of beams, node blocks and panels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from fabkit.checking import Violation, panels_crossing_support_planes, violations, violations_sentence
from fabkit.detailing.beam_layers import fit_beams, layer_parts, on_parallel_mesh
from fabkit.detailing.beams import BeamShapes, dihedral_angles
from fabkit.detailing.ends import Ends
from fabkit.detailing.panel_layers.panels import make_panels
from fabkit.detailing.panel_levels import PanelLevels, on_mesh, panel_levels, seats_of, underside_reason, unfit_panels
from fabkit.detailing.secondary import Secondary
from fabkit.detailing.zones import zones_of_mesh
from fabkit.errors import DetailingError
from fabkit.fitness import FitnessRules
from fabkit.fitness.shape import tilt
from fabkit.kinds import BASE_PLATE, PANEL, STRUT, STUB, PanelDetails
from fabkit.parts import Assembly, LeftOut, Parts, Zones
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh
from geometry.shading import MostShade

__all__ = ["Detailed", "detail"]

SAME_DEPTH_MM = 1e-6
"""Largest difference in mm between two depths of the beams below the outer faces of the panels that count as one: a
solid may be off as much from what touches it."""

MAX_FULL_REASONS = 3
"""Largest number of unbuildable parts that an error describes with a sentence each; the others are only named."""


@dataclass(frozen=True, eq=False)
class Detailed:
    """The assembly, and what determines the level of its panels.

    underside_mm: height of the panels' lower sides above the mesh; underside_reason: what determines it, in words.
    needed_mm (N,): height of the block at each vertex above the faces whose panels lie over it, 0 without a block.
    shade: how the direction of the fins was found, None where it was given.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import detail
    >>> detailed = detail(built.structure, built.project.rules, name="roof")
    >>> round(detailed.underside_mm, 1), detailed.underside_reason.split(";")[0].split(" stands")[0]
    (25.7, 'the beam on edge 3')
    """

    assembly: Assembly
    underside_mm: float
    needed_mm: FloatArray
    underside_reason: str
    shade: MostShade | None = None


def detail(
    structure: SupportStructure,
    rules: DetailingRules,
    *,
    name: str,
    skip_unbuildable: bool = False,
    meshes: Mapping[int, Mesh] | None = None,
) -> Detailed:
    """Make the parts and check that they fit.

    structure: in millimetres. Raises DetailingError naming all parts that cannot be built or do not fit. With
    skip_unbuildable they are left out instead, and the assembly lists them in `left_out`; the panels of a face are then
    left out in all layers. meshes: in mm, parallel to that of the structure, of layers that have their own, by the
    numbers of these layers.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import detail
    >>> detailed = detail(built.structure, built.project.rules, name="roof")
    >>> {parts.kind.group: len(parts) for parts in detailed.assembly.groups}
    {'beams': 30, 'nodes': 18, 'panels': 12}
    """
    plan = _Plan(structure, rules, skip_unbuildable, meshes or {})
    while True:
        detailed = plan.make(name)
        plan.check_something_left()
        found = plan.panels_crossing_support_planes(detailed.assembly) + violations(detailed.assembly, have_marks=False)
        if not found:
            return detailed
        plan.leave_out_violating(found, detailed.assembly)


@dataclass
class _Plan:
    """The beams (E,) and panels (F,) to be made; those that cannot be built are removed, if they may be left out.

    structure: on whose mesh the beams stand, `depth` below the given one.
    """

    given: SupportStructure
    rules: DetailingRules
    skip_unbuildable: bool
    meshes: Mapping[int, Mesh]
    structure: SupportStructure = field(init=False)
    depth: float = field(init=False, default=0.0)
    beams: BoolArray = field(init=False)
    panels: BoolArray = field(init=False)
    secondary: Secondary = field(init=False)
    zones: Zones = field(init=False)
    left_out: list[LeftOut] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        self.structure = self.given
        self._check_outwards()
        self.beams = np.ones(self.structure.mesh.n_edges, dtype=bool)
        self.panels = np.ones(self.structure.mesh.n_faces, dtype=bool)
        self.secondary = Secondary.of(self.given, self.rules)
        self.zones = zones_of_mesh(self.given.mesh, self.rules.zones)

    def make(self, name: str) -> Detailed:
        while True:
            ends, beams = self._fit_beams()
            levels = self._fit_panels(ends)
            if abs(levels.depth - self.depth) <= SAME_DEPTH_MM:
                break
            self.depth = levels.depth
            self.structure = on_parallel_mesh(self.given, -levels.depth)
        panels = self._panels(levels)
        first = layer_parts(self.structure, self.beams, ends, beams, levels.nodes, self.rules)
        blocks = self.structure, ends, levels.nodes
        others = self.secondary.parts(blocks, self.beams, panels, self.rules, self._leave_out)
        groups = (*first[:2], panels, *first[2:], *others)
        assembly = Assembly(name, groups, tuple(self.left_out) + self._nodes_without_beams(ends), zones=self.zones)
        underside = float(levels.underside[self.panels].min(initial=np.inf))
        reason, fins = underside_reason(self.structure, levels, self.rules), self.secondary.fins
        return Detailed(assembly, underside, levels.needed, reason, None if fins is None else fins.shade)

    def _panels(self, levels: PanelLevels) -> Parts[PanelDetails]:
        densities = self.rules.densities_kg_m3
        materials = [layer.pane_materials(densities[layer.material]) for layer in self.rules.layers]
        seats = seats_of(self.structure, levels, self.beams, self.rules)
        dihedrals = np.degrees(dihedral_angles(self.structure.mesh))
        return make_panels(levels.layers, self.panels, materials, seats, levels.resting, dihedrals)

    # --- beams and nodes

    def _fit_beams(self) -> tuple[Ends, BeamShapes]:
        return fit_beams(self.structure, self.beams, self.rules, partial(self._leave_out, "beam", self.beams))

    def _nodes_without_beams(self, ends: Ends) -> tuple[LeftOut, ...]:
        without_beams = np.flatnonzero((np.diff(ends.ring_starts) == 0) & self.structure.mesh.combinatorics.is_used)
        return tuple(
            LeftOut("node", vertex, f"all beams of the node at vertex {vertex} (counted from 0) are left out")
            for vertex in without_beams.tolist()
        )

    def _fit_panels(self, ends: Ends) -> PanelLevels:
        while True:
            levels = panel_levels(self.structure, ends, self.beams, self.panels, self.rules, self.meshes)
            unfit = unfit_panels(levels, self.beams, self.panels, self.rules)
            if not unfit:
                return levels
            self._leave_out("panel", self.panels, unfit)

    # --- what cannot be made

    def panels_crossing_support_planes(self, assembly: Assembly) -> tuple[Violation, ...]:
        panels = assembly.of(PANEL)
        crossing = [
            panels.elements[own][panels_crossing_support_planes(layer, panels.take(own))]
            for own, layer in self._by_structure(panels)
        ]
        faces = np.unique(np.concatenate(crossing))
        cure = "change the mesh there, or lower the panels"
        return tuple(
            Violation(
                f"the outline of the panel on face {face} crosses the support planes of the face",
                cure,
                (("panel", face),),
            )
            for face in faces.tolist()
        )

    def _by_structure(self, panels: Parts[PanelDetails]) -> list[tuple[IntArray, SupportStructure]]:
        """The panels by the structure whose support planes bound them."""
        of_layer = {number: on_mesh(self.structure, mesh) for number, mesh in self.meshes.items()}
        layer = panels.details.layer
        rest = np.flatnonzero(~np.isin(layer, list(of_layer)))
        return [(rest, self.structure), *((np.flatnonzero(layer == n), each) for n, each in of_layer.items())]

    def leave_out_violating(self, found: tuple[Violation, ...], assembly: Assembly) -> None:
        """Leave out the secondary parts of each violation; if it concerns none its panels, or else its beams. Raises
        DetailingError if nothing may be left out."""
        element_of = {group.kind.name: group.kind.element for group in assembly.groups}
        beams: dict[int, str] = {}
        panels: dict[int, str] = {}
        others: dict[str, dict[int, str]] = {}
        for violation in found:
            if kind := self.secondary.concerned(violation):
                own = [element for name, element in violation.parts if name == kind]
                place = f"{kind} {'at' if element_of[kind] == 'vertex' else 'on'} {element_of[kind]}"
                others.setdefault(kind, {}).update({e: _because(place, e, violation) for e in own})
                continue
            at = {what: [e for k, e in violation.parts if element_of[k] == what] for what in ("face", "edge", "vertex")}
            if at["face"]:
                panels |= {face: _because("panel on face", face, violation) for face in at["face"]}
            else:
                edges = at["edge"] or self._beams_at(at["vertex"])
                beams |= {edge: _because("beam on edge", edge, violation) for edge in edges}
        if not self.skip_unbuildable or not (beams or panels or others):
            raise DetailingError(violations_sentence(found))
        for kind, reasons in others.items():
            self._leave_out(kind, self.secondary.made[kind], reasons)
        if panels:
            self._leave_out("panel", self.panels, panels)
        if beams:
            self._leave_out("beam", self.beams, beams)

    def check_something_left(self) -> None:
        for kind, made in (("beam", self.beams), ("panel", self.panels)):
            if not made.any():
                reasons = [left.reason for left in self.left_out if left.kind == kind]
                raise DetailingError(
                    f"none of the {len(made)} {kind}s can be built; the reason for the first "
                    f"is: {reasons[0]}; change the mesh or the sizes"
                )

    def _beams_at(self, nodes: Iterable[int]) -> list[int]:
        touching = np.isin(self.structure.mesh.combinatorics.edges, list(nodes)).any(axis=1)
        return list(np.flatnonzero(touching & self.beams).tolist())

    def _leave_out(self, kind: str, made: BoolArray, reasons: dict[int, str]) -> None:
        if not self.skip_unbuildable:
            shown = list(dict.fromkeys(reasons.values()))[:MAX_FULL_REASONS]
            if len(reasons) > MAX_FULL_REASONS:
                others = ", ".join(self._place(kind, element) for element in list(reasons)[MAX_FULL_REASONS:])
                shown.append(f"the same applies to {others}")
            raise DetailingError(
                f"{len(reasons)} {kind}{'s' if len(reasons) > 1 else ''} cannot be built: {'; '.join(shown)}. Change "
                "the mesh there (counted from 0) or the sizes, or leave these parts out with --skip-unbuildable"
            )
        made[list(reasons)] = False
        self.left_out += [LeftOut(kind, element, reason) for element, reason in sorted(reasons.items())]

    def _place(self, kind: str, element: int) -> str:
        if kind == "panel":
            return f"face {element}"
        if kind in (STRUT.name, STUB.name, BASE_PLATE.name):
            return f"vertex {element}"
        i, j = self.structure.mesh.combinatorics.edges[element].tolist()
        return f"edge {element} (vertices {i} and {j})"

    def _check_outwards(self) -> None:
        found = tilt(self.structure, FitnessRules())
        if found and found.level == "refused":
            raise DetailingError(f"{found.sentence}; {found.cure}")


def _because(place: str, element: int, violation: Violation) -> str:
    """The part and the finding, without its cure: the part is left out already."""
    return f"the {place} {element}, because {violation.finding} (counted from 0)"
