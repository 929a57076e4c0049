"""From a support structure to an assembly of beams, node blocks and panels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fabkit.checking import Violation, panels_crossing_support_planes, violations, violations_sentence
from fabkit.detailing.beams import BeamShapes, beam_shapes, make_beams
from fabkit.detailing.bolted import bolted_nodes, fasteners
from fabkit.detailing.drilling import bored_along_axis
from fabkit.detailing.ends import Ends, beam_ends
from fabkit.detailing.hubs import caps, on_tubes
from fabkit.detailing.joining import not_joinable
from fabkit.detailing.nodes import make_nodes
from fabkit.detailing.panel_levels import PanelLevels, on_mesh, panel_levels, seats_of, underside_reason, unfit_panels
from fabkit.detailing.panels import make_panels
from fabkit.errors import DetailingError
from fabkit.fitness import FitnessRules
from fabkit.fitness.shape import tilt
from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import Assembly, LeftOut, Material, Parts
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import Pair, SupportStructure
from geometry.mesh import Mesh

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

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import detail
    >>> detailed = detail(built.structure, built.project.rules, name="roof")
    >>> round(detailed.underside_mm, 1), detailed.underside_reason.split(";")[0].split(" stands")[0]
    (24.3, 'the node block at vertex 1')
    """

    assembly: Assembly
    underside_mm: float
    needed_mm: FloatArray
    underside_reason: str


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
    left_out: list[LeftOut] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        self.structure = self.given
        self._check_outwards()
        self.beams = np.ones(self.structure.mesh.n_edges, dtype=bool)
        self.panels = np.ones(self.structure.mesh.n_faces, dtype=bool)

    def make(self, name: str) -> Detailed:
        while True:
            ends, beams = self._fit_beams()
            levels = self._fit_panels(ends)
            if abs(levels.depth - self.depth) <= SAME_DEPTH_MM:
                break
            self.depth = levels.depth
            self.structure = _lowered(self.given, levels.depth)
        with_beams = np.flatnonzero(np.diff(ends.ring_starts) > 0)
        edges = np.flatnonzero(self.beams)
        groups: tuple[Parts[Any], ...] = (
            make_beams(self.structure, ends, beams, edges, self.rules, self._material("beams")),
            make_nodes(self.structure, ends, levels.nodes, with_beams, self.rules.beams, self._material("nodes")),
            self._panels(levels),
        )
        groups = self._joined(ends, groups)
        assembly = Assembly(name, groups, tuple(self.left_out) + self._nodes_without_beams(ends))
        underside = float(levels.underside[self.panels].min(initial=np.inf))
        return Detailed(assembly, underside, levels.needed, underside_reason(self.structure, levels, self.rules))

    def _panels(self, levels: PanelLevels) -> Parts[PanelDetails]:
        densities = self.rules.densities_kg_m3
        materials = [layer.pane_materials(densities[layer.material]) for layer in self.rules.layers]
        seats = seats_of(self.structure, levels, self.beams, self.rules)
        return make_panels(levels.layers, self.panels, materials, seats, levels.resting)

    def _joined(self, ends: Ends, groups: tuple[Parts[Any], ...]) -> tuple[Parts[Any], ...]:
        """The beams, nodes and panels, the nodes as the connection needs them, and the parts that it adds."""
        (beams, nodes, panels), kind = groups, self.rules.connection.kind
        axial = self.rules.connection.axial_bore_mm
        if axial > 0 and kind != "hub":
            nodes = replace(nodes, solids=bored_along_axis(nodes.solids, axial))
        if kind == "bolted":
            added = fasteners(self.structure, ends, self.rules, self._material("nodes"))
            return (beams, bolted_nodes(nodes, ends, self.rules), panels, *added)
        if kind == "hub":
            tubes = on_tubes(nodes, ends, self.rules)
            return beams, tubes, panels, caps(tubes, self.rules.connection, self._material("nodes"))
        return beams, nodes, panels

    # --- beams and nodes

    def _fit_beams(self) -> tuple[Ends, BeamShapes]:
        min_length = self.rules.least_length_mm
        while True:
            ends = beam_ends(self.structure, self.beams, self.rules)
            if reasons := not_joinable(self.structure.mesh, ends, self.rules):
                self._leave_out("beam", self.beams, reasons)
                continue
            shapes = beam_shapes(self.structure, ends, self.rules.beams)
            short = np.flatnonzero(self.beams & ~(shapes.short_point >= min_length))
            if not len(short):
                return ends, shapes
            reasons = {int(edge): self._too_short(int(edge), ends, shapes) for edge in short}
            self._leave_out("beam", self.beams, reasons)

    def _too_short(self, edge: int, ends: Ends, shapes: BeamShapes) -> str:
        i, j = self.structure.mesh.combinatorics.edges[edge].tolist()
        setbacks = ends.setback[2 * edge : 2 * edge + 2]
        worst = 2 * edge + int(setbacks.argmax())
        preceding = int(np.flatnonzero(ends.following == worst)[0])
        angle = np.degrees(np.nanmin(ends.gap[[worst, preceding]]))
        return (
            f"the beam on edge {edge} from vertex {i} to vertex {j} is too short: the edge is "
            f"{self.structure.mesh.edge_lengths[edge]:.1f} mm long and the setbacks are {setbacks[0]:.1f} and "
            f"{setbacks[1]:.1f} mm, which leaves {shapes.short_point[edge]:.1f} mm between the cuts; at least "
            f"{self.rules.least_length_mm:g} mm are needed (beams at vertex {ends.vertex[worst]} are "
            f"{angle:.1f} degrees apart; counted from 0)"
        )

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
        """Leave out the panels of each violation, or its beams if it concerns no panel. Raises DetailingError if
        nothing may be left out."""
        element_of = {group.kind.name: group.kind.element for group in assembly.groups}
        beams: dict[int, str] = {}
        panels: dict[int, str] = {}
        for violation in found:
            at = {what: [e for k, e in violation.parts if element_of[k] == what] for what in ("face", "edge", "vertex")}
            if at["face"]:
                panels |= {face: _because("panel on face", face, violation) for face in at["face"]}
            else:
                edges = at["edge"] or self._beams_at(at["vertex"])
                beams |= {edge: _because("beam on edge", edge, violation) for edge in edges}
        if not self.skip_unbuildable or not (beams or panels):
            raise DetailingError(violations_sentence(found))
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
        i, j = self.structure.mesh.combinatorics.edges[element].tolist()
        return f"edge {element} (vertices {i} and {j})"

    def _check_outwards(self) -> None:
        found = tilt(self.structure, FitnessRules())
        if found and found.level == "refused":
            raise DetailingError(f"{found.sentence}; {found.cure}")

    def _material(self, kind: str) -> Material:
        name: str = getattr(self.rules, kind).material
        return Material(name, self.rules.densities_kg_m3[name])


def _lowered(structure: SupportStructure, depth: float) -> SupportStructure:
    """The structure of the mesh that lies `depth` mm below, along S."""
    pair = structure.pair
    return SupportStructure(Pair(pair.offset_mesh(-depth), pair.gauss_image), structure.distance)


def _because(place: str, element: int, violation: Violation) -> str:
    """The part and the finding, without its cure: the part is left out already."""
    return f"the {place} {element}, because {violation.finding} (counted from 0)"
