"""A bracket under the nodes of a roof, and the slot for it in the node blocks, in build123d.

The bracket is a plate with a tenon that is set into the underside of a node block, and a hole for a shackle below it.
It is the same for all nodes; each node block gets a slot. Needs `pip install "fabkit[build123d]"`.
"""

from __future__ import annotations

from pathlib import Path

from build123d import Box, Cylinder, Location, Part, export_step

from fabkit import Project, design
from fabkit.formats import to_build123d

ROOF = Path(__file__).with_name("roof.obj")
THICKNESS_MM, WIDTH_MM, HEIGHT_MM, HOLE_MM = 10.0, 44.0, 70.0, 22.0
TENON_WIDTH_MM, TENON_DEPTH_MM, CLEARANCE_MM = 30.0, 25.0, 0.5


def tenon(clearance: float) -> Part:
    """Above z = 0, which is the underside of the block."""
    depth = TENON_DEPTH_MM + clearance
    box = Box(THICKNESS_MM + 2 * clearance, TENON_WIDTH_MM + 2 * clearance, depth)
    return box.moved(Location((0, 0, depth / 2)))


def bracket() -> Part:
    plate = Box(THICKNESS_MM, WIDTH_MM, HEIGHT_MM).moved(Location((0, 0, -HEIGHT_MM / 2)))
    hole = Cylinder(HOLE_MM / 2, 2 * THICKNESS_MM).moved(Location((0, 0, -0.7 * HEIGHT_MM), (0, 90, 0)))
    return (plate + tenon(0.0)) - hole


def main(out: Path = Path("brackets"), marks: tuple[str, ...] = ("N001", "N002", "N003")) -> dict[str, float]:
    """Write the bracket and the blocks of these marks with their slots; the volume cut from each block in mm3."""
    roof = design(Project(mesh=ROOF, unit="m", nesting={"mode": "off"}))
    out.mkdir(exist_ok=True)
    export_step(bracket(), str(out / "bracket.step"))
    removed = {}
    for node in roof.assembly["nodes"]:
        if node.mark in marks and node.mark not in removed:  # nodes that share a mark are made alike
            block = to_build123d(node)  # in its own frame: z is the node axis, outwards, and x along the first beam
            slot = tenon(CLEARANCE_MM).moved(Location((0, 0, block.bounding_box().min.Z)))
            slotted = block - slot
            export_step(slotted, str(out / f"{node.mark}-slotted.step"))
            removed[node.mark] = float(block.volume - slotted.volume)
    return removed


if __name__ == "__main__":
    print(main())
