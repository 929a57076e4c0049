"""A bracket under the nodes of a roof, and the slot for it in the node blocks, in CadQuery.

The bracket is a plate with a tenon that is set into the underside of a node block, and a hole for a shackle below it.
It is the same for all nodes; each node block gets a slot. Needs `pip install "fabkit[cadquery]"`.
"""

from __future__ import annotations

from pathlib import Path

import cadquery as cq

from fabkit import Project, design
from fabkit.formats import to_cadquery

ROOF = Path(__file__).with_name("roof.obj")
THICKNESS_MM, WIDTH_MM, HEIGHT_MM, HOLE_MM = 10.0, 44.0, 70.0, 22.0
TENON_WIDTH_MM, TENON_DEPTH_MM, CLEARANCE_MM = 30.0, 25.0, 0.5


def tenon(clearance: float) -> cq.Workplane:
    """Above z = 0, which is the underside of the block."""
    outline = cq.Workplane().rect(THICKNESS_MM + 2 * clearance, TENON_WIDTH_MM + 2 * clearance)
    return outline.extrude(TENON_DEPTH_MM + clearance)


def bracket() -> cq.Workplane:
    plate = cq.Workplane().rect(THICKNESS_MM, WIDTH_MM).extrude(-HEIGHT_MM)
    hole = cq.Workplane("YZ").center(0, -0.7 * HEIGHT_MM).circle(HOLE_MM / 2).extrude(THICKNESS_MM, both=True)
    return plate.union(tenon(0.0)).cut(hole)


def main(out: Path = Path("brackets"), marks: tuple[str, ...] = ("N001", "N002", "N003")) -> dict[str, float]:
    """Write the bracket and the blocks of these marks with their slots; the volume cut from each block in mm3."""
    roof = design(Project(mesh=ROOF, unit="m", nesting={"mode": "off"}))
    out.mkdir(exist_ok=True)
    cq.exporters.export(bracket(), str(out / "bracket.step"))
    removed = {}
    for node in roof.assembly["nodes"]:
        if node.mark in marks and node.mark not in removed:  # equal nodes share a mark and are identical
            block = to_cadquery(node)  # in its own frame: z is the node axis, outwards, and x along the first beam
            slot = tenon(CLEARANCE_MM).translate((0, 0, block.val().BoundingBox().zmin))
            slotted = block.cut(slot)
            cq.exporters.export(slotted, str(out / f"{node.mark}-slotted.step"))
            removed[node.mark] = float(block.val().Volume() - slotted.val().Volume())
    return removed


if __name__ == "__main__":
    print(main())
