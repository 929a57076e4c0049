"""A bracket of one's own under nodes of a roof, cut to their shape in build123d.

A round seat holds the underside of a node block and has a hole for an M12 rod. Where the block is, the seat is cut
away, so that it fits each node as it is. Needs `pip install "fabkit[build123d]"`.
"""

from __future__ import annotations

from pathlib import Path

from build123d import Cylinder, Location, export_step

from fabkit import Project, design
from fabkit.formats import to_build123d

ROOF = Path(__file__).with_name("roof.obj")
RADIUS_MM, BELOW_MM, ABOVE_MM, HOLE_MM = 75.0, 25.0, 15.0, 13.0
"""Of the seat; how far it reaches below the underside of the node and up around it; diameter of the hole."""


def main(out: Path = Path("brackets"), marks: tuple[str, ...] = ("N001", "N002", "N003")) -> dict[str, float]:
    """Write a STEP file for each of these marks; the volume of each bracket in mm3."""
    roof = design(Project(mesh=ROOF, unit="m", nesting={"mode": "off"}))
    out.mkdir(exist_ok=True)
    volumes = {}
    for node in roof.assembly["nodes"]:
        if node.mark not in marks or node.mark in volumes:
            continue  # equal nodes share a mark, and one bracket fits them all
        block = to_build123d(node)  # in its own frame: the node axis is z, outwards
        underside = block.bounding_box().min.Z
        seat = Cylinder(RADIUS_MM, BELOW_MM + ABOVE_MM).moved(Location((0, 0, underside + (ABOVE_MM - BELOW_MM) / 2)))
        hole = Cylinder(HOLE_MM / 2, 2 * BELOW_MM).moved(Location((0, 0, underside - BELOW_MM)))
        bracket = (seat - block) - hole
        export_step(bracket, str(out / f"{node.mark}-bracket.step"))
        volumes[node.mark] = float(bracket.volume)
    return volumes


if __name__ == "__main__":
    for mark, volume in main().items():
        print(f"{mark}: {volume * 7.85e-6:.2f} kg of steel")
