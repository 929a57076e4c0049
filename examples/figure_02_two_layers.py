"""Layers of beams and glass on parallel meshes, with struts along the node axes [Pottmann2007, 2.1 and Fig. 2].

M carries the outer glass; the second layer of beams lies on M + d S, d = -1.1 m, so that every strut is the axis of the
two nodes that it joins, and each beam is parallel to the one above it. Inner panels lie 5 cm above it, with joints that
are wide enough for the struts, and close the space between. All is drawn from the STEP file of the build.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, GLASS, STEEL, Note, Panel, Shapes, View, draw_page
from docs.tools.step_shapes import StepShapes
from examples.figure_01_layers_and_fins import ground
from fabkit import Project, design
from fabkit.pipeline import Built
from geometry.arrays import IntArray
from geometry.mesh import Mesh, shapes

DISTANCE_MM, INNER_GLASS_MM = -1100.0, -1050.0
ROWS = 8


@cache
def canopy() -> Mesh:
    """A roof that is curved both ways, higher at one end: a translation surface, stretched by a perspective."""
    u, v = np.linspace(-1, 1, 2 * ROWS - 1), np.linspace(-1, 1, ROWS + 1)
    along = np.stack([9 * u, 0 * u, 1.9 * u**2], axis=1)
    across = np.stack([0 * v, 5.4 * v, -1.9 * v**2], axis=1)
    mesh = shapes.translation_surface(along, across)
    return mesh.with_vertices(mesh.vertices / (1 - 0.02 * mesh.vertices[:, :1]))


@cache
def built() -> Built:
    return design(
        Project(
            mesh=canopy(),
            mean_edge_mm=1800,
            beams={"section": "rhs 140x60x5"},
            connection={"kind": "welded"},
            nodes={"top": "trimmed"},
            layers=[
                {"joint_mm": 20, "seat_mm": 12, "thickness_mm": 12},
                {"distance_mm": INNER_GLASS_MM, "joint_mm": 100, "thickness_mm": 10},
            ],
            second_layer={"distance_mm": DISTANCE_MM, "section": "rhs 100x60x5", "strut": "chs 60.3x4"},
            nesting={"mode": "off"},
        )
    )


def main() -> dict[str, float]:
    parts = built().assembly
    lower, upper = parts["lower nodes"], parts["nodes"]
    apart = np.linalg.norm(upper.origins - lower.origins, axis=1)
    crossed = np.cross(parts["beams"].axes[:, 0], parts["lower beams"].axes[:, 0])
    return {
        "beams": len(parts["beams"]),
        "lower beams": len(parts["lower beams"]),
        "struts": len(parts["struts"]),
        "panels": len(parts["panels"]),
        "least distance of two nodes in mm": float(apart.min()),
        "largest distance of two nodes in mm": float(apart.max()),
        "largest sine between a beam and the one below it": float(np.abs(crossed).max()),
        "longest strut in mm": float(parts["struts"].details.length_mm.max()),
        "mass of the steel in tonnes": sum(
            float(group.masses_kg.sum()) for group in parts.groups if group.kind.group != "panels"
        )
        / 1e3,
    }


def drawn(step: StepShapes, faces: IntArray | None = None) -> Shapes:
    """All parts, or those at some faces."""
    c = canopy().combinatorics
    edges = None if faces is None else np.unique(c.corner_edge[np.isin(c.corner_face, faces)])
    vertices = None if edges is None else np.unique(c.edges[edges])
    return [
        *step.shapes("beams", STEEL, elements=edges),
        *step.shapes("lower beams", STEEL, elements=edges),
        *step.shapes("nodes", CLAY, elements=vertices),
        *step.shapes("lower nodes", CLAY, elements=vertices),
        *step.shapes("struts", BLUE, elements=vertices),
        *step.shapes("panels", GLASS, elements=faces, opacity=0.6),
    ]


def draw(path: Path) -> None:
    step = StepShapes.written(built().assembly)
    points = built().structure.pair.offset_mesh(2.2 * DISTANCE_MM).vertices / 1000
    corner = np.array([ROWS * i + j for i in (10, 11) for j in (0, 1)])
    panels = [
        Panel([*ground(points), *drawn(step)], View(-58, 14), (20, 20, 920, 560)),
        Panel(drawn(step, corner), View(-58, 14), (960, 60, 420, 460)),
    ]
    draw_page(path, 1400, 600, panels, [Note(1170, 550, "two layers of beams and of glass, struts", 24)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_02.png")
    print(main())
