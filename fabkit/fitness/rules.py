"""From where on something is told, and from where on it is refused, if nothing else is said."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

__all__ = ["FitnessRules"]

Bound = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Angle = Annotated[float, Field(gt=0, le=90)]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class FitnessRules:
    """Bounds of the judgement; `inf` cannot be said, what is to be accepted is allowed by its name.

    moves_told, moves_refused: of 95 % of the vertices while faces are made planar, in mean edge lengths. A tenth of an
    edge is what one sees; with three tenths neighbours have come nearer by more than half of their distance.
    turns_told_deg: of a face's normal meanwhile; half of the 90 degrees at which a face has folded over.
    lean_told_deg: of node axes from the normals, at 95 % of the nodes; lean_refused_deg: in the median. At 30 degrees
    a block is cut back by more than half of its height on each side.
    heights_told: of the distance between the two parallel meshes over the nominal one, how far 2.5 % and 97.5 % of the
    beams are apart. At a tenth the parallel mesh misses beams of 120 mm by a centimetre. Never refused: the beams have
    their section all the same, and how far they miss each other at nodes is told of each node.
    outwards_told_deg: of a beam from the normals of its faces, 90 being impossible; at 60 degrees a panel is cut back
    by 1.7 times its height over the mesh.
    mitres_told_deg, mitres_named_deg: of the cuts at the ends of beams. Most saws for profiles turn to 45 degrees one
    way; the few that go further end at 60.
    blocks_told: height of a node block over that of its beams; at 2, half of it carries no beam.
    lift_told: by how many beam heights the highest node lifts all panels further than 95 % of the nodes ask.
    """

    moves_told: Bound = 0.1
    moves_refused: Bound = 0.3
    turns_told_deg: Angle = 45.0
    lean_told_deg: Angle = 15.0
    lean_refused_deg: Angle = 30.0
    heights_told: Bound = 0.1
    outwards_told_deg: Angle = 60.0
    mitres_told_deg: Angle = 45.0
    mitres_named_deg: Angle = 60.0
    blocks_told: Bound = 2.0
    lift_told: Bound = 0.25

    @model_validator(mode="after")
    def _told_before_refused(self) -> FitnessRules:
        for name, last in (("moves", "refused"), ("lean", "refused"), ("mitres", "named")):
            unit = "_deg" if name in ("lean", "mitres") else ""
            told, then = f"{name}_told{unit}", f"{name}_{last}{unit}"
            if getattr(self, told) > getattr(self, then):
                raise ValueError(
                    f"{told} is {getattr(self, told):g}, but {then} is {getattr(self, then):g}: what is {last} is told "
                    f"too, so {told} may not be larger"
                )
        return self
