"""A kind of part that fabkit does not have: a cap plate over each node of a dome, in all lists, models and the report.

A kind defines the name of its parts, what a shop must know of them and the columns of their cut list. With its parts in
the design, one call writes the same folder as `fabkit build`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fabkit import Project, design, write_built
from fabkit.kinds.columns import files, marks_and_counts, masses, materials, ranges
from fabkit.parts import (
    Column,
    Details,
    Kind,
    Material,
    Measure,
    Parts,
    Solids,
    Surroundings,
    prism_topology,
    prism_vertices,
)
from geometry.arrays import FloatArray
from geometry.files import write_mesh
from geometry.mesh import shapes

CORNERS, RADIUS_MM, THICKNESS_MM, GAP_MM = 8, 60.0, 5.0, 2.0
STEEL = Material("S235", density_kg_m3=7850.0)


@dataclass(frozen=True, eq=False)
class CapDetails(Details):
    """Of n caps, whose axis is z. screw_mm (n,): length of the screw that holds each cap."""

    screw_mm: FloatArray


def columns(caps: Parts[CapDetails], around: Surroundings) -> list[Column]:
    """The cut list: a row for each mark, with the least and the largest value of the parts of that mark."""
    return [
        *marks_and_counts(caps),
        Column("Screw (mm)", 0, ranges(caps.details.screw_mm, caps.mark, 0)),
        materials(caps),
        *masses(caps),
        files(caps, "parts/{}.step"),
    ]


CAP = Kind(
    name="cap",
    group="caps",
    element="vertex",  # one at each vertex of the mesh
    letter="C",  # of its marks: C001
    colour=(0.85, 0.55, 0.15),
    form="plate",
    empty_details=CapDetails(np.zeros(0)),
    columns=columns,
    measures=lambda caps: [Measure("caps", "Screw", "mm", 0, caps.details.screw_mm)],
    labels=lambda caps, around: [f"screw {length:.0f} mm" for length in caps.details.screw_mm],
)


def main(out: Path = Path("capped-dome"), mesh: Path = Path("dome.obj")) -> dict[str, float]:
    write_mesh(mesh, shapes.dome(16, 5))
    built = design(Project(mesh=mesh, mean_edge_mm=1500.0, out=out))
    nodes = built.assembly["nodes"]
    panels = built.assembly["panels"].details
    top = np.array([node.solid.vertices[:, 2].max() for node in nodes])  # above the vertex, along the node axis
    over_glass = np.maximum(top, panels.underside_mm.max() + panels.thickness_mm.max()) + GAP_MM + 20.0
    turns = 2 * np.pi * np.arange(CORNERS) / CORNERS
    plate = prism_vertices(RADIUS_MM * np.stack([np.cos(turns), np.sin(turns)], axis=1), 0.0, THICKNESS_MM)
    caps = Parts.each_its_own(
        CAP,
        nodes.elements,
        Solids.alike(np.tile(plate, (len(nodes), 1, 1)), prism_topology(CORNERS)),
        origins=nodes.origins + over_glass[:, None] * nodes.axes[:, 2],
        axes=nodes.axes,
        material=STEEL,
        details=CapDetails(np.ceil((over_glass - top + 30.0) / 5.0) * 5.0),
    )
    capped = built.with_parts(caps)
    write_built(capped)
    return {"caps": len(caps), "marks": len(capped.assembly["caps"].mark_names)}


if __name__ == "__main__":
    print(main())
