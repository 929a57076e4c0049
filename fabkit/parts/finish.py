"""What is done to a pane or plate besides cutting it: edge work, coating; and the build-up that it is part of.

Edge work has the names of EN 12150-1. Surfaces of glass are counted through all plies from outside to inside, as
glazing practice does: #1 is outside, #2 the inner face of the outermost ply; in 8/16Ar/44.2 the room side is #6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["CoatedSide", "EdgeWork", "Finish"]

EdgeWork = Literal["none", "arrissed", "ground", "smooth ground", "polished"]
CoatedSide = Literal["", "outside", "inside", "interlayer"]


@dataclass(frozen=True)
class Finish:
    """The finish of one pane or plate.

    build_up: of the glass that it is a pane of, such as "glass 8/16Ar/44.2"; empty for a plate that is none. edge_work:
    of all its edges. coating: number of its coated surface, counted from outside through all plies of the layer; 0
    without one. coated_side: where this surface is on the pane itself: its outside, its inside, or an interlayer.
    has_equal_faces: whether the pane turned over is the same pane, which a coating or plies of different thickness
    prevent.

    >>> from fabkit.parts import Finish
    >>> Finish("glass 8/16Ar/8", "polished", coating=2, coated_side="inside", has_equal_faces=False).words
    'in glass 8/16Ar/8, edges polished, coating #2'
    """

    build_up: str = ""
    edge_work: EdgeWork = "none"
    coating: int = 0
    coated_side: CoatedSide = ""
    has_equal_faces: bool = True

    @property
    def words(self) -> str:
        """All of it in a few words, in which pieces with one mark agree; empty for a plate that is only cut."""
        of_several = "/" in self.build_up
        found = (
            f"in {self.build_up}" if of_several else "",
            "" if self.edge_work == "none" else f"edges {self.edge_work}",
            f"coating #{self.coating}" if self.coating else "",
        )
        return ", ".join(filter(None, found))

    @property
    def coated(self) -> str:
        """Which side is coated, as it stands in the name of the material; empty without a coating."""
        where = {"interlayer": "at an interlayer"}.get(self.coated_side, self.coated_side)
        return f"coated {where}" if where else ""
