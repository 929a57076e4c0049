"""The parameters of beams, nodes, sheets and second layers; those of all parts together are `DetailingRules`.

By default, hollow sections of S355 are welded to trimmed node blocks, under one pane of laminated glass 44.2.
Values are checked when a rule is made; pydantic's ValidationError names the key and the bound.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

from pydantic import AfterValidator, ConfigDict, model_validator
from pydantic.dataclasses import dataclass

from fabkit.parts import Material, Section
from fabkit.rules.connections import ConnectionRules
from fabkit.rules.fins import FinRules
from fabkit.rules.layers import LayerRules, problem_of_layers
from fabkit.rules.lengths import Level, Positive
from fabkit.rules.sheets import SheetRules
from fabkit.rules.supports import SupportRules
from fabkit.rules.zones import ZoneRules, problem_of_zones
from fabkit.wording import echo, one_line

__all__ = [
    "BeamRules",
    "DetailingRules",
    "HeightReference",
    "NodeEnd",
    "NodeRules",
    "SecondLayerRules",
    "Setbacks",
]

BESIDE_HAND_HOLE_MM = 190.0
"""Minimum length in mm of a bolted beam between its two cuts, without its hand hole: 300 in all with a hole of 110, so
that it is nearly as far from the ends as it is long."""

HeightReference = Literal["outer", "centre", "inner", "glass"]
Setbacks = Literal["auto", "least", "equal"]
NodeEnd = Literal["enclosing", "trimmed"]
SectionName = Annotated[str, AfterValidator(lambda text: Section.of(text).name)]

DENSITIES_KG_M3 = {"S355": 7850.0, "steel": 7850.0, "glass": 2500.0}
"""Densities in kg/m3 of materials by name: steel as in EN 1991-1-1, Table A.4, glass as in Table A.5 and EN 572-1."""

Densities = Annotated[
    dict[Annotated[str, AfterValidator(one_line)], Positive], AfterValidator(lambda given: DENSITIES_KG_M3 | given)
]
"""Densities by the name of the material, beside those that are known."""

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True, config=_STRICT)
class BeamRules:
    """Bars of constant section, symmetric about the central plane of their edge.

    section: as the trade writes it, see `Section`; by default rhs 120x60x5, a size of EN 10210-2 and EN 10219-2, and of
    S355 (EN 10025-2, S355J2H as a hollow section). width_mm, height_mm: instead of a section, those of a solid bar,
    where one is given the other is 50 wide, or 120 high. boundary_section: of the bars on the boundary, if they have
    another one.
    reference: the side of the bar that lies on the mesh; "glass": the outer faces of the panels lie on the mesh, and
    the outer sides of the bars on a parallel mesh below. least_length_mm: minimum length of a bar between its two cuts.

    >>> from fabkit.rules import BeamRules
    >>> BeamRules(section="RHS 120 x 60 x 5").profile.name, BeamRules(width_mm=40).profile.name
    ('rhs 120x60x5', 'flat 120x40')
    """

    width_mm: Positive | None = None
    height_mm: Positive | None = None
    section: SectionName | None = None
    boundary_section: SectionName | None = None
    reference: HeightReference = "outer"
    least_length_mm: Positive = 20.0
    material: str = "S355"

    @model_validator(mode="after")
    def _one_section(self) -> BeamRules:
        sizes = [key for key in ("width_mm", "height_mm") if getattr(self, key) is not None]
        if self.section is not None and sizes:
            raise ValueError(
                f"section is {echo(self.section)} and {' and '.join(sizes)} given too, which are those of a solid bar: "
                "take out one of the two"
            )
        return self

    @property
    def profile(self) -> Section:
        """The section of all beams, but for those on the boundary where these have one of their own."""
        if self.width_mm is None and self.height_mm is None:
            return Section.of(self.section or "rhs 120x60x5")
        return Section("flat", (self.height_mm or 120.0, self.width_mm or 50.0))

    @property
    def sections(self) -> tuple[Section, ...]:
        """The section of all beams, and after it that of those on the boundary if it is another one."""
        own = Section.of(self.boundary_section) if self.boundary_section is not None else self.profile
        return (self.profile,) if own == self.profile else (self.profile, own)


@dataclass(frozen=True, config=_STRICT)
class NodeRules:
    """Prisms along the node axes. clearance_mm: added to the minimum distance of the facets from the axis, 5 mm by
    default; only for beams in contact with the block, since others have a slot between them.

    setbacks: "least" gives each beam the minimum setback; "equal" gives all beams of a node the largest of these;
    "auto" uses equal setbacks where these bring the beams' ends to one level, as in edge offset meshes, and where the
    facets of beams that are joined would be stepped by more than 10 mm, and the minimum ones elsewhere. top:
    "enclosing" blocks end in a plane perpendicular to the axis above all beams; "trimmed" ones in a plane that follows
    the tops of the beams, lowered as far as the panels need it when they lie as low as the beams permit. bottom: the
    same of the inner side; a "trimmed" one follows the bottoms of the beams and encloses them. Hubs enclose the webs of
    their beams in either case.

    >>> from fabkit.rules import NodeRules
    >>> NodeRules(top="enclosing", clearance_mm=8.0).clearance
    8.0
    """

    clearance_mm: Positive | None = None
    setbacks: Setbacks = "auto"
    top: NodeEnd = "trimmed"
    bottom: NodeEnd = "enclosing"
    material: str = "S355"

    @property
    def clearance(self) -> float:
        """What is added to the minimum distance of the facets from the axis in mm, where beams are in contact."""
        return 5.0 if self.clearance_mm is None else self.clearance_mm


@dataclass(frozen=True, config=_STRICT)
class SecondLayerRules:
    """A second layer of beams and nodes, on the parallel mesh M + d S, and struts along the node axes between both.

    distance_mm: d, negative on the inner side of M. section, connection, material: of its beams and nodes, by default
    those of the first layer. reference: the side of its bars that lies on the mesh. strut: section of the struts, round
    or chs; least_strut_mm: minimum length of a strut between its two cuts.

    >>> from fabkit.rules import SecondLayerRules
    >>> inside, outside = SecondLayerRules(distance_mm=-900), SecondLayerRules(distance_mm=500, strut="round 40")
    >>> inside.name, outside.name, inside.strut
    ('lower', 'upper', 'chs 60.3x4')
    """

    distance_mm: Level
    section: SectionName | None = None
    reference: Literal["outer", "centre", "inner"] = "outer"
    connection: ConnectionRules | None = None
    strut: SectionName = "chs 60.3x4"
    least_strut_mm: Positive = 20.0
    material: str | None = None

    @model_validator(mode="after")
    def _possible(self) -> SecondLayerRules:
        if self.distance_mm == 0:
            raise ValueError("distance_mm is 0, where the first layer is: make it negative for a layer inside")
        if not Section.of(self.strut).is_round:
            raise ValueError(
                f"strut is {echo(self.strut)}, and struts are round: write one like chs 60.3x4 or round 40"
            )
        return self

    @property
    def name(self) -> str:
        """The word with which the names of its parts begin."""
        return "lower" if self.distance_mm < 0 else "upper"


@dataclass(frozen=True, config=_STRICT)
class DetailingRules:
    """All parameters of the shop. layers: of panels, from outside to inside. densities_kg_m3: by the name of the
    material. second_layer, fins, supports: None where there are none. zones: in the
    order in which they are put up.

    >>> from fabkit.rules import BeamRules, DetailingRules, LayerRules
    >>> rules = DetailingRules(beams=BeamRules(section="rhs 100x50x5"), layers=(LayerRules(thickness_mm=10.0),))
    >>> rules.beams.profile.name, rules.material("S355").density_kg_m3
    ('rhs 100x50x5', 7850.0)
    """

    beams: BeamRules = field(default_factory=BeamRules)
    connection: ConnectionRules = field(default_factory=ConnectionRules)
    nodes: NodeRules = field(default_factory=NodeRules)
    layers: tuple[LayerRules, ...] = field(default_factory=lambda: (LayerRules(),))
    sheets: SheetRules = field(default_factory=SheetRules)
    second_layer: SecondLayerRules | None = None
    fins: FinRules | None = None
    supports: SupportRules | None = None
    zones: tuple[ZoneRules, ...] = ()
    densities_kg_m3: Densities = field(default_factory=lambda: dict(DENSITIES_KG_M3))

    @property
    def least_length_mm(self) -> float:
        """Minimum length of a beam between its two cuts; one that is bolted has a hand hole."""
        least, hole = self.beams.least_length_mm, self.connection.hand_hole_length_mm
        return max(least, hole + BESIDE_HAND_HOLE_MM) if self.connection.kind == "bolted" else least

    def material(self, name: str) -> Material:
        """The material with this name."""
        return Material(name, self.densities_kg_m3[name])

    @model_validator(mode="after")
    def _connection_fits(self) -> DetailingRules:
        problems, own = map(self.connection.problems_with, self.beams.sections), self.second_layer
        problem = next(filter(None, problems), "")
        if own is not None and not problem:
            section = self.beams.profile if own.section is None else Section.of(own.section)
            problem = (own.connection or self.connection).problems_with(section)
            problem = problem and f"in the second layer, {problem}"
        problem = problem or problem_of_layers(self.layers, is_below_glass=self.beams.reference == "glass")
        is_trimmed = "trimmed" in (self.nodes.top, self.nodes.bottom)
        if self.connection.axial_bore_mm > 0 and self.connection.kind != "hub" and is_trimmed:
            problem = (
                f"connection.axial_bore_mm is {self.connection.axial_bore_mm:g} mm, and blocks that are trimmed cannot "
                "be bored along their axes: set nodes.top and nodes.bottom to 'enclosing', or leave the bore out"
            )
        if self.nodes.bottom == "trimmed" and (self.second_layer or self.supports):
            problem = (
                "nodes.bottom is 'trimmed', but struts and stubs stand on bottoms that are square to the axes: set "
                "nodes.bottom = 'enclosing'"
            )
        if self.connection.kind != "contact" and self.nodes.clearance_mm is not None:
            problem = (
                f"nodes.clearance_mm (--clearance) is {self.nodes.clearance_mm:g} mm, which only beams in contact with "
                f"their blocks have, and these are {self.connection.kind}: set connection.slot_mm instead"
            )
        problem = problem or problem_of_zones(self.zones)
        if problem:
            raise ValueError(problem)
        return self

    @model_validator(mode="after")
    def _densities_known(self) -> DetailingRules:
        layers = {f"layers.{number}": layer for number, layer in enumerate(self.layers)}
        for kind, rules in (vars(self) | layers).items():
            material = getattr(rules, "material", None)
            if material is not None and material not in self.densities_kg_m3:
                known = ", ".join(echo(name) for name in sorted(self.densities_kg_m3))
                raise ValueError(
                    f"{kind}.material is {echo(material)}, but densities_kg_m3 has only {known}; name one of these, or "
                    "add its density there"
                )
        return self
