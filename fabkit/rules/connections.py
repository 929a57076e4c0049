"""What a shop decides about how beams meet their nodes."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.connections import LEAST_EDGE_RATIO, LEAST_PITCH_RATIO, TUBE_DIAMETERS_MM, BoltGroup, least_radius_for_end
from fabkit.parts import Section
from fabkit.rules.lengths import NotNegative, Positive

__all__ = ["CONNECTION_KINDS", "ConnectionKind", "ConnectionRules"]

ConnectionKind = Literal["welded", "bolted", "hub", "contact"]
CONNECTION_KINDS: tuple[ConnectionKind, ...] = get_args(ConnectionKind)
BoltsName = Annotated[str, AfterValidator(lambda text: BoltGroup.of(text).name)]

_STRICT = ConfigDict(extra="forbid")


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

    kind: ConnectionKind = "welded"
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
        if self.kind == "hub":
            return self._problem_with_tubes(section)
        if self.kind != "bolted":
            return ""
        wall = section.wall_mm
        if section.shape != "rhs" or wall is None:
            return (
                f"bolts are put in from inside a rectangular hollow section, and the section is {section.name}: write "
                "one like rhs 120x60x5, or take another kind of connection"
            )
        for what, found, needed, cure in self._needs_of_bolts(section, wall):
            if found < needed:
                return (
                    f"bolts {self.bolts} do not fit the section {section.name}: {needed:.1f} mm are needed from "
                    f"{what}, and there are {max(found, 0.0):.1f} mm; take {cure}, or another kind of connection"
                )
        return ""

    def _problem_with_tubes(self, section: Section) -> str:
        """Why no tube of the table takes the ends of beams of this section, or a bore along its axis."""
        largest = max((d / 2 for d in TUBE_DIAMETERS_MM if d / 2 <= self.longest_setback_mm), default=0.0)
        end, axial = section.web_mm, self.axial_bore_mm
        for needed, what, cure in (
            (
                least_radius_for_end(end),
                f"a plane end {end:g} mm wide",
                "take a thinner flat, or a tee like tee 120x80x10x8",
            ),
            (
                axial / 2 + self.tube_wall_mm,
                f"an axial bore of {axial:g} mm in a wall of {self.tube_wall_mm:g} mm",
                "take a smaller bore or a thinner wall",
            ),
        ):
            if needed > largest:
                return (
                    f"{what} needs a hub with a tube of at least {2 * needed:.1f} mm, and the largest one of the table "
                    f"within longest_setback_mm = {self.longest_setback_mm:g} has {2 * largest:g} mm: {cure}"
                )
        return ""

    def _needs_of_bolts(self, section: Section, wall: float) -> list[tuple[str, float, float, str]]:
        """What is measured, its size, the least one, and what to take instead."""
        size, highest = self.group.size, max(self.group.offsets_mm)
        half_height, half_width = section.height_mm / 2, section.width_mm / 2
        edge, inside = LEAST_EDGE_RATIO * size.clearance_mm, max(wall, section.radius_mm)
        between = "radius to radius of a side" if inside > wall else "wall to wall inside"
        hole = min(self.hand_hole_height_mm, self.hand_hole_length_mm)
        bolts = "a larger section, smaller bolts"
        lower = "a larger section, a lower hand hole (hand_hole_height_mm)"
        larger = "smaller bolts, a larger hand hole (hand_hole_height_mm, hand_hole_length_mm)"
        needs = [
            ("a bolt to the edge of its end plate", min(half_width, half_height - highest), edge, bolts),
            ("a bolt to the side inside, for the socket", half_width - wall, size.tool_radius_mm, bolts),
            ("a bolt to the top inside, for the socket", half_height - wall - highest, size.tool_radius_mm, bolts),
            (f"{between}, for the hand hole", section.height_mm - 2 * inside, self.hand_hole_height_mm, lower),
            ("side to side of the hand hole, for the socket", hole, 2 * size.tool_radius_mm, larger),
        ]
        if self.has_dowel:
            apart = LEAST_PITCH_RATIO * (size.clearance_mm + self.dowel_mm) / 2
            offset = self.dowel_offset_mm(section.height_mm)
            needs.append(("the bolt to its dowel", offset, apart, f"{bolts}, a thinner dowel (dowel_mm)"))
        return needs
