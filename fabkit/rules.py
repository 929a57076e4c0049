"""The parameters of the shop; all default dimensions are here.

Values are checked when a rule is made; pydantic's ValidationError names the key and the bound.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.wording import echo

__all__ = ["BeamRules", "DetailingRules", "HeightReference", "NodeRules", "PanelRules", "Setbacks", "SheetRules"]

LARGEST_LENGTH_MM = 1e9
"""Largest length in mm that a project may state: a thousand kilometres, far below the
lengths whose products overflow."""

Positive = Annotated[float, Field(gt=0, le=LARGEST_LENGTH_MM, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST_LENGTH_MM, allow_inf_nan=False)]
HeightReference = Literal["outer", "centre", "inner"]
Setbacks = Literal["auto", "least", "equal"]

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True, config=_STRICT)
class BeamRules:
    """Solid rectangular bars, symmetric about the central plane of their edge.

    reference: the side of the bar that lies on the mesh. least_length_mm: minimum length of a bar between its two cuts.
    """

    width_mm: Positive = 50.0
    height_mm: Positive = 120.0
    reference: HeightReference = "outer"
    least_length_mm: Positive = 20.0
    material: str = "steel"


@dataclass(frozen=True, config=_STRICT)
class NodeRules:
    """Prisms along the node axes. clearance_mm: added to the minimum distance of the facets from the axis.

    setbacks: "least" gives each beam the minimum setback at which it does not touch its neighbours; "equal" gives all
    beams of a node the largest of these; "auto" uses equal setbacks where these bring the beams' ends to one level, as
    in edge offset meshes, and the minimum ones elsewhere.
    """

    clearance_mm: Positive = 5.0
    setbacks: Setbacks = "auto"
    material: str = "steel"


@dataclass(frozen=True, config=_STRICT)
class PanelRules:
    """One layer of plates with square edges.

    joint_mm: gap between two panels. seat_mm: free height between the panels and the highest node block under them.
    underside_mm: height of the panels' lower side above the mesh; by default the minimum that clears beams and nodes,
    plus the seat. least_edge_mm: minimum length of an edge of a panel.
    """

    thickness_mm: Positive = 10.0
    joint_mm: NotNegative = 10.0
    seat_mm: NotNegative = 5.0
    underside_mm: Annotated[float, Field(ge=-LARGEST_LENGTH_MM, le=LARGEST_LENGTH_MM, allow_inf_nan=False)] | None = (
        None
    )
    least_edge_mm: Positive = 1.0
    material: str = "glass"


@dataclass(frozen=True, config=_STRICT)
class SheetRules:
    """Stock sheets: gap_mm between panels, border_mm to the sheet's edge."""

    length_mm: Positive = 6000.0
    width_mm: Positive = 3210.0
    gap_mm: NotNegative = 10.0
    border_mm: NotNegative = 10.0


@dataclass(frozen=True, config=_STRICT)
class DetailingRules:
    """All parameters of the shop. densities_kg_m3: by the name of the material."""

    beams: BeamRules = field(default_factory=BeamRules)
    nodes: NodeRules = field(default_factory=NodeRules)
    panels: PanelRules = field(default_factory=PanelRules)
    sheets: SheetRules = field(default_factory=SheetRules)
    densities_kg_m3: dict[str, Positive] = field(default_factory=lambda: {"steel": 7850.0, "glass": 2500.0})

    @model_validator(mode="after")
    def _densities_known(self) -> DetailingRules:
        for kind, rules in vars(self).items():
            material = getattr(rules, "material", None)
            if material is not None and material not in self.densities_kg_m3:
                known = ", ".join(echo(name) for name in sorted(self.densities_kg_m3))
                raise ValueError(f"{kind}.material is {echo(material)}, but densities_kg_m3 has only {known}")
        return self
