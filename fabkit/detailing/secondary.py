"""What is made besides beams, nodes and panels: a second layer of beams, struts, fins and supports."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fabkit.checking import Violation
from fabkit.detailing.ends import Ends
from fabkit.detailing.fins import FinPlan
from fabkit.detailing.nodes import NodeShapes
from fabkit.detailing.second_layer import SecondLayer
from fabkit.detailing.supports import make_supports, supported_vertices
from fabkit.kinds import BASE_PLATE, BEAM, FIN, STRUT, STUB, PanelDetails
from fabkit.parts import Parts
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray
from geometry.gauss import SupportStructure

__all__ = ["Secondary"]


@dataclass(frozen=True, eq=False)
class Secondary:
    """Its plans, None where there are none. made: by the name of a kind which mesh elements have a part of it; those
    that cannot be built are removed, if they may be left out. In the order in which parts are left out that share
    volume."""

    second: SecondLayer | None
    fins: FinPlan | None
    made: dict[str, BoolArray]

    @classmethod
    def of(cls, structure: SupportStructure, rules: DetailingRules) -> Secondary:
        """structure: of the mesh that is given, in mm."""
        second, fins = SecondLayer.of(structure, rules), FinPlan.of(structure, rules.fins)
        n_edges, n_vertices = structure.mesh.n_edges, structure.mesh.n_vertices
        made = {} if fins is None else {FIN.name: np.ones(n_edges, dtype=bool)}
        if second is not None:
            made[STRUT.name] = np.ones(n_vertices, dtype=bool)
        if rules.supports is not None:
            made[STUB.name] = made[BASE_PLATE.name] = supported_vertices(structure.mesh, rules.supports)
        if second is not None:
            made[f"{second.own.name} {BEAM.name}"] = np.ones(n_edges, dtype=bool)
        return cls(second, fins, made)

    def parts(
        self,
        first: tuple[SupportStructure, Ends, NodeShapes],
        beams: BoolArray,
        panels: Parts[PanelDetails],
        rules: DetailingRules,
        leave_out: Callable[[str, BoolArray, dict[int, str]], None],
    ) -> tuple[Parts[Any], ...]:
        """The groups on the edges where beams are made (E,). first: structure, ends and blocks of the first layer;
        leave_out: takes a kind, which parts of it are made, and reasons. Supports stand under the inner one of two
        layers."""
        groups: tuple[Parts[Any], ...] = ()
        inner = first
        for name, own in self.made.items():
            if name not in (STRUT.name, STUB.name, BASE_PLATE.name):
                own &= beams
        if self.second is not None:
            name = f"{self.second.own.name} {BEAM.name}"
            own = self.made[name]
            groups, second = self.second.parts(first, own, self.made[STRUT.name], partial(leave_out, name, own))
            inner = second if self.second.own.distance_mm < 0 else first
        if self.fins is not None:
            own = self.made[FIN.name]
            self.fins.check_clear_of(panels, own)
            ends, shapes, reasons = self.fins.shapes(own)
            while reasons:
                leave_out(FIN.name, own, reasons)
                ends, shapes, reasons = self.fins.shapes(own)
            groups = (*groups, self.fins.parts(own, ends, shapes, rules.material(self.fins.rules.material)))
        if rules.supports is not None:
            steel = rules.material(rules.supports.material)
            groups = (*groups, *make_supports(*inner, self.made[STUB.name], rules.supports, steel))
        return groups

    def concerned(self, violation: Violation) -> str:
        """The name of the first kind that a violation concerns, of those that are made here; empty if none."""
        concerned = {kind for kind, _ in violation.parts}
        return next((name for name in self.made if name in concerned), "")
