"""The second layer of beams and nodes, on a parallel mesh, and the struts between both layers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fabkit.detailing.beam_layers import fit_beams, layer_parts, on_parallel_mesh
from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes, node_shapes
from fabkit.detailing.struts import StrutPlaces, make_struts, strut_places
from fabkit.errors import DetailingError
from fabkit.parts import Parts, Section
from fabkit.rules import BeamRules, DetailingRules, SecondLayerRules
from geometry.arrays import BoolArray
from geometry.gauss import SupportStructure

__all__ = ["SecondLayer", "rules_of_second_layer"]


def rules_of_second_layer(rules: DetailingRules, own: SecondLayerRules) -> DetailingRules:
    """The rules of the beams and nodes of the second layer; it carries no panels, so blocks enclose the beams."""
    beams = BeamRules(
        section=own.section or rules.beams.profile.name,
        boundary_section=None if own.section else rules.beams.boundary_section,
        reference=own.reference,
        least_length_mm=rules.beams.least_length_mm,
        material=own.material or rules.beams.material,
    )
    connection = own.connection or rules.connection
    nodes = replace(rules.nodes, top="enclosing", material=own.material or rules.nodes.material)
    if connection.kind != "contact":
        nodes = replace(nodes, clearance_mm=None)
    return replace(rules, beams=beams, nodes=nodes, connection=connection, second_layer=None, fins=None)


@dataclass(frozen=True, eq=False)
class SecondLayer:
    """What the second layer is made of. structure: of its parallel mesh, in mm; rules: of its own beams and nodes; own:
    what the project says of it."""

    structure: SupportStructure
    rules: DetailingRules
    own: SecondLayerRules

    @classmethod
    def of(cls, structure: SupportStructure, rules: DetailingRules) -> SecondLayer | None:
        """The one that the rules ask for, if any. Raises DetailingError where an edge of its mesh collapses."""
        own = rules.second_layer
        if own is None:
            return None
        low, high = structure.pair.distance_range
        if not low < own.distance_mm < high:
            factors = structure.pair.edge_factors
            edge = int(factors.argmax() if own.distance_mm < 0 else factors.argmin())
            raise DetailingError(
                f"at second_layer.distance_mm = {own.distance_mm:g} the second layer has turned inside out: edge "
                f"{edge} (counted from 0) has no length at {low if own.distance_mm < 0 else high:.1f} mm; keep it "
                "nearer to the first layer"
            )
        made = on_parallel_mesh(structure, own.distance_mm)
        own_rules = rules_of_second_layer(rules, own)
        return cls(replace(made, distance=own_rules.beams.profile.height_mm), own_rules, own)

    def parts(
        self,
        first: tuple[SupportStructure, Ends, NodeShapes],
        beams: BoolArray,
        struts: BoolArray,
        leave_out: Callable[[dict[int, str]], None],
    ) -> tuple[tuple[Parts[Any], ...], tuple[SupportStructure, Ends, NodeShapes]]:
        """Beams, nodes, and what the connection adds, on the edges of `beams` (E,), from which leave_out removes what
        cannot be made, with the struts at the vertices `struts` (N,) with blocks of both layers; and structure, ends
        and blocks of this layer. first: those of the first layer."""
        name = self.own.name

        def leave_out_here(reasons: dict[int, str]) -> None:
            leave_out({edge: f"in the {name} layer {reason}" for edge, reason in reasons.items()})

        ends, shapes = fit_beams(self.structure, beams, self.rules, leave_out_here)
        blocks = node_shapes(self.structure, ends, self.rules)
        groups = layer_parts(self.structure, beams, ends, shapes, blocks, self.rules, name)
        second = self.structure, ends, blocks
        places = strut_places(*((second, first) if self.own.distance_mm < 0 else (first, second)))
        self._check_apart(places)
        section, steel = Section.of(self.own.strut), self.rules.material(self.rules.beams.material)
        vertices = np.flatnonzero(np.isfinite(places.lengths) & struts)
        return (*groups, make_struts(self.structure, places, vertices, section, steel)), second

    def _check_apart(self, places: StrutPlaces) -> None:
        """Raise DetailingError where blocks of both layers leave too little room for a strut."""
        own = self.own
        shortest = places.shortest(Section.of(own.strut).width_mm / 2)
        short = np.flatnonzero(shortest < own.least_strut_mm)
        if not len(short):
            return
        more = (own.least_strut_mm - shortest[short]) / self.structure.pair.vertex_distances[short]
        worst = int(short[more.argmax()])
        least = np.ceil(10 * (abs(own.distance_mm) + more.max())) / 10 * np.sign(own.distance_mm)
        raise DetailingError(
            f"the two layers are too near to each other: the strut at vertex {worst} (counted from 0) would be "
            f"{shortest[worst]:.1f} mm long between its two node blocks, and at least {own.least_strut_mm:g} mm are "
            f"needed; set second_layer.distance_mm to {least:g} or further from 0"
        )
