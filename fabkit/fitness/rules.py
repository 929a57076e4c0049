"""Bounds from which a finding is noted, and from which it is refused."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

__all__ = ["FitnessRules"]

Bound = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Angle = Annotated[float, Field(gt=0, le=90)]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class FitnessRules:
    """Bounds of the criteria. A bound cannot be infinite: a finding that should not stop a build is accepted by name.

    moves_noted, moves_refused: displacement of 95 % of the vertices while faces are made planar, in mean edge lengths.
    A tenth of an edge is visible; at three tenths neighbours may have approached by more than half their distance.
    folding_noted_deg: rotation of a face's normal by planarising; half of the 90 degrees at which a face has folded
    over. lean_noted_deg: angle between node axes and normals, at the 95 % percentile of the nodes; lean_refused_deg:
    their median. At 30 degrees a node block is cut back by more than half of its height on each side. heights_noted:
    difference between the 2.5 % and 97.5 % percentiles of the distance of the two parallel meshes at the beams, over
    the nominal height. At a tenth the parallel mesh deviates from beams of 120 mm by about a centimetre. Never refused:
    the beams keep their section, and their misalignment is listed for each node. tilt_noted_deg: angle between a beam
    and the normals of its faces, 90 being impossible; at 60 degrees a panel is cut back by 1.7 times its height above
    the mesh. mitres_noted_deg, mitres_listed_deg: angles off square of the cuts at the ends of beams; from the second
    bound on, beams are listed by mark. Most saws for profiles turn to 45 degrees one way; the few that go further end
    at 60. block_heights_noted: height of a node block over that of its beams; at 2, half of the block carries no beam.
    slots_noted_deg: angle between two beams that are welded to a node; below 60 degrees the neighbour is in the way of
    a torch held at 45 degrees between beam and facet. uncovered_noted_percent: how much of the end of a beam stands
    above its facet; a tenth is the outer wall of a hollow section and some more.
    underside_noted: by how many beam heights the highest node raises all panels above what 95 % of the nodes need.
    corners_noted_deg, corners_listed_deg: angles at the corners of panels; makers of glass cut back the tips of those
    below 45 degrees, and those below 30 break off, so that they are listed by mark. short_edges_noted_mm: edges of
    panels; what is shorter is too small for most machines that grind edges or make insulating glass.
    panel_masses_noted_kg: mass of a panel with all its panes; common vacuum lifters carry as much.
    going_in_noted_mm: gap at either end of a beam without which it does not go in from outside between two nodes that
    stand; 2 mm are ground off, or bridged by a weld.

    >>> from fabkit import Project
    >>> from fabkit.fitness import FitnessRules
    >>> strict = FitnessRules(lean_noted_deg=5, lean_refused_deg=10)
    >>> Project(mesh="roof.obj", unit="m", fitness=strict).fitness.lean_refused_deg
    10.0
    """

    moves_noted: Bound = 0.1
    moves_refused: Bound = 0.3
    folding_noted_deg: Angle = 45.0
    lean_noted_deg: Angle = 15.0
    lean_refused_deg: Angle = 30.0
    heights_noted: Bound = 0.1
    tilt_noted_deg: Angle = 60.0
    mitres_noted_deg: Angle = 45.0
    mitres_listed_deg: Angle = 60.0
    block_heights_noted: Bound = 2.0
    slots_noted_deg: Angle = 60.0
    uncovered_noted_percent: Bound = 10.0
    underside_noted: Bound = 0.25
    corners_noted_deg: Angle = 45.0
    corners_listed_deg: Angle = 30.0
    short_edges_noted_mm: Bound = 150.0
    panel_masses_noted_kg: Bound = 500.0
    going_in_noted_mm: Bound = 2.0

    @model_validator(mode="after")
    def _noted_before_refused(self) -> FitnessRules:
        for name, last in (("moves", "refused"), ("lean", "refused"), ("mitres", "listed")):
            unit = "_deg" if name in ("lean", "mitres") else ""
            noted, then = f"{name}_noted{unit}", f"{name}_{last}{unit}"
            if getattr(self, noted) > getattr(self, then):
                raise ValueError(
                    f"{noted} is {getattr(self, noted):g}, but {then} is {getattr(self, then):g}: what is {last} is "
                    f"also noted, so {noted} must not be larger"
                )
        return self
