"""The parameters of the shop; all default dimensions are here.

Values are checked when a rule is made; pydantic's ValidationError names the key and the bound.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.connections import LEAST_EDGE_RATIO, LEAST_PITCH_RATIO, BoltGroup
from fabkit.fin_rules import FinRules
from fabkit.layer_rules import LayerRules, problem_of_layers
from fabkit.lengths import Level, NotNegative, Positive
from fabkit.parts import Material, Section
from fabkit.wording import echo

__all__ = [
    "CONNECTION_KINDS",
    "BeamRules",
    "ConnectionKind",
    "ConnectionRules",
    "DetailingRules",
    "HeightReference",
    "NodeRules",
    "NodeTop",
    "SecondLayerRules",
    "Setbacks",
    "SheetRules",
]

LEAST_HAND_HOLE_LENGTH_MM = 300.0
"""Minimum length in mm of a bolted beam between its two cuts: a hand hole, and as much again to its ends as it takes
up."""

HeightReference = Literal["outer", "centre", "inner", "glass"]
Setbacks = Literal["auto", "least", "equal"]
NodeTop = Literal["enclosing", "trimmed"]
ConnectionKind = Literal["welded", "bolted", "hub", "contact"]
CONNECTION_KINDS: tuple[ConnectionKind, ...] = get_args(ConnectionKind)
SectionName = Annotated[str, AfterValidator(lambda text: Section.of(text).name)]
BoltsName = Annotated[str, AfterValidator(lambda text: BoltGroup.of(text).name)]

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True, config=_STRICT)
class BeamRules:
    """Bars of one section, symmetric about the central plane of their edge.

    section: as the trade writes it, see `Section`. width_mm, height_mm: instead of a section, those of a solid bar.
    reference: the side of the bar that lies on the mesh; "glass": the outer faces of the panels lie on the mesh, and
    the outer sides of the bars on a parallel mesh below. least_length_mm: minimum length of a bar between its two cuts.

    >>> from fabkit.rules import BeamRules
    >>> BeamRules(section="RHS 120 x 60 x 5").profile.name, BeamRules(width_mm=40).profile.name
    ('rhs 120x60x5', 'flat 120x40')
    """

    width_mm: Positive | None = None
    height_mm: Positive | None = None
    section: SectionName | None = None
    reference: HeightReference = "outer"
    least_length_mm: Positive = 20.0
    material: str = "steel"

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
        """The section of all beams."""
        if self.section is not None:
            return Section.of(self.section)
        return Section("flat", (self.height_mm or 120.0, self.width_mm or 50.0))


@dataclass(frozen=True, config=_STRICT)
class ConnectionRules:
    """How beams meet their nodes.

    bolts: of each end of a beam, see `BoltGroup`; a single one has a dowel of dowel_mm beside it. They hold an end
    plate of plate_mm, and are put in through hand holes of hand_hole_height_mm by hand_hole_length_mm in the sides of
    the beam. tube_wall_mm, cap_mm: thickness of the tube of a hub, and of the caps at its ends. axial_bore_mm: diameter
    of a bore along the axis of each node block or hub, 0 for none.

    kind: "welded" to the node block, "bolted" to it, welded to a "hub", a round tube, or in "contact" with the block
    only. slot_mm: minimum clear distance between two neighbouring beams at the node, by default 25 where they are
    welded (room for the torch) and 10 where they are bolted (room for tolerances); beams in contact have none, but
    `NodeRules.clearance_mm`. ledge_mm: what the facet of a block shows at least on either side of a beam that is
    welded to it, for the seam. gap_mm: clear distance between the end of a beam and the facet: the root gap of a weld,
    or the room to move a beam into its place. least_angle_deg: smallest angle between two beams about the node axis
    that can be joined. longest_setback_mm: largest distance of a facet from the axis, which is also at most 35 % of the
    edge. Beams in contact have no such limits.

    >>> from fabkit.rules import ConnectionRules
    >>> ConnectionRules(kind="welded").slot, ConnectionRules(kind="bolted", slot_mm=15).slot
    (25.0, 15.0)
    """

    kind: ConnectionKind = "contact"
    slot_mm: Positive | None = None
    ledge_mm: NotNegative = 8.0
    gap_mm: NotNegative = 0.0
    bolts: BoltsName = "1xM20"
    plate_mm: Positive = 15.0
    dowel_mm: Positive = 10.0
    hand_hole_height_mm: Positive = 70.0
    hand_hole_length_mm: Positive = 110.0
    tube_wall_mm: Positive = 8.0
    cap_mm: Positive = 5.0
    axial_bore_mm: NotNegative = 0.0
    least_angle_deg: Annotated[float, Field(gt=0, le=90, allow_inf_nan=False)] = 30.0
    longest_setback_mm: Positive = 150.0

    @model_validator(mode="after")
    def _slot_of_a_kind(self) -> ConnectionRules:
        if self.kind == "contact" and self.slot_mm is not None:
            raise ValueError(
                "slot_mm is given, but beams in contact have no slot: take another kind of connection, or "
                "[nodes] clearance_mm (--clearance)"
            )
        return self

    @property
    def slot(self) -> float:
        """Minimum clear distance between neighbouring beams in mm, 0 for beams in contact."""
        if self.slot_mm is not None:
            return self.slot_mm
        return {"welded": 25.0, "hub": 25.0, "bolted": 10.0, "contact": 0.0}[self.kind]

    @property
    def group(self) -> BoltGroup:
        """The bolts of a beam end."""
        return BoltGroup.of(self.bolts)

    @property
    def end_distance_mm(self) -> float:
        """Distance of the end of a beam from its facet: the gap, and the end plate of a bolted beam."""
        return self.gap_mm + (self.plate_mm if self.kind == "bolted" else 0.0)

    @property
    def has_dowel(self) -> bool:
        """Whether a dowel keeps the beam from turning about a single bolt."""
        return self.kind == "bolted" and self.group.count == 1

    def dowel_offset_mm(self, height_mm: float) -> float:
        """Level of the dowel above the middle of an end plate of this height: as far out as edges allow."""
        return height_mm / 2 - 1.5 * self.dowel_mm

    def problems_with(self, section: Section) -> str:
        """Why beams of this section cannot be joined so, in a sentence; empty if they can."""
        if self.kind == "hub" and section.shape not in ("flat", "tee"):
            return f"beams on hubs are flats or tees, and the section is {section.name}: write one like tee 120x80x10x8"
        if self.kind != "bolted":
            return ""
        wall = section.wall_mm
        if section.shape != "rhs" or wall is None:
            return (
                f"bolts are put in from inside a rectangular hollow section, and the section is {section.name}: write "
                "one like rhs 120x60x5, or take another kind of connection"
            )
        for what, found, needed in self._needs_of_bolts(section, wall):
            if found < needed:
                return (
                    f"bolts {self.bolts} do not fit the section {section.name}: {needed:.1f} mm are needed from "
                    f"{what}, and there are {found:.1f} mm; take a larger section, smaller bolts, or another "
                    "kind of connection"
                )
        return ""

    def _needs_of_bolts(self, section: Section, wall: float) -> list[tuple[str, float, float]]:
        """What is measured, its size, and the least one."""
        size, highest = self.group.size, max(self.group.offsets_mm)
        half_height, half_width = section.height_mm / 2, section.width_mm / 2
        edge, inside = LEAST_EDGE_RATIO * size.clearance_mm, max(wall, section.radius_mm)
        between = "radius to radius of a side" if inside > wall else "wall to wall inside"
        needs = [
            ("a bolt to the edge of its end plate", min(half_width, half_height - highest), edge),
            ("a bolt to the side inside, for the socket", half_width - wall, size.tool_radius_mm),
            ("a bolt to the top inside, for the socket", half_height - wall - highest, size.tool_radius_mm),
            (f"{between}, for the hand hole", section.height_mm - 2 * inside, self.hand_hole_height_mm),
        ]
        if self.has_dowel:
            apart = LEAST_PITCH_RATIO * (size.clearance_mm + self.dowel_mm) / 2
            needs.append(("the bolt to its dowel", self.dowel_offset_mm(section.height_mm), apart))
        return needs


@dataclass(frozen=True, config=_STRICT)
class NodeRules:
    """Prisms along the node axes. clearance_mm: added to the minimum distance of the facets from the axis where beams
    are in contact with the block.

    setbacks: "least" gives each beam the minimum setback; "equal" gives all beams of a node the largest of these;
    "auto" uses equal setbacks where these bring the beams' ends to one level, as in edge offset meshes, and where the
    facets of beams that are joined would be stepped by more than 10 mm, and the minimum ones elsewhere. top:
    "enclosing" blocks end in a plane perpendicular to the axis above all beams; "trimmed" ones in a plane that follows
    the tops of the beams, lowered as far as the panels need it when they lie as low as the beams permit. Hubs enclose
    the webs of their beams in either case.
    """

    clearance_mm: Positive = 5.0
    setbacks: Setbacks = "auto"
    top: NodeTop = "enclosing"
    material: str = "steel"


@dataclass(frozen=True, config=_STRICT)
class SheetRules:
    """Stock sheets: gap_mm between panels, border_mm to the sheet's edge."""

    length_mm: Positive = 6000.0
    width_mm: Positive = 3210.0
    gap_mm: NotNegative = 10.0
    border_mm: NotNegative = 10.0


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
    material. second_layer, fins: None where there are none."""

    beams: BeamRules = field(default_factory=BeamRules)
    connection: ConnectionRules = field(default_factory=ConnectionRules)
    nodes: NodeRules = field(default_factory=NodeRules)
    layers: tuple[LayerRules, ...] = field(default_factory=lambda: (LayerRules(),))
    sheets: SheetRules = field(default_factory=SheetRules)
    second_layer: SecondLayerRules | None = None
    fins: FinRules | None = None
    densities_kg_m3: dict[str, Positive] = field(default_factory=lambda: {"steel": 7850.0, "glass": 2500.0})

    @property
    def least_length_mm(self) -> float:
        """Minimum length of a beam between its two cuts; one that is bolted has a hand hole."""
        least = self.beams.least_length_mm
        return max(least, LEAST_HAND_HOLE_LENGTH_MM) if self.connection.kind == "bolted" else least

    def material(self, name: str) -> Material:
        """The material with this name."""
        return Material(name, self.densities_kg_m3[name])

    @model_validator(mode="after")
    def _connection_fits(self) -> DetailingRules:
        problem, own = self.connection.problems_with(self.beams.profile), self.second_layer
        if own is not None and not problem:
            section = self.beams.profile if own.section is None else Section.of(own.section)
            problem = (own.connection or self.connection).problems_with(section)
            problem = problem and f"in the second layer, {problem}"
        problem = problem or problem_of_layers(self.layers, is_below_glass=self.beams.reference == "glass")
        if self.connection.axial_bore_mm > 0 and self.connection.kind != "hub" and self.nodes.top == "trimmed":
            problem = (
                f"connection.axial_bore_mm is {self.connection.axial_bore_mm:g} mm, and blocks whose tops are trimmed "
                "cannot be bored along their axes: set nodes.top = 'enclosing', or leave the bore out"
            )
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
                raise ValueError(f"{kind}.material is {echo(material)}, but densities_kg_m3 has only {known}")
        return self
