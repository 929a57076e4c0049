"""Draw a dome with glass outside and timber inside, cut away on one side: `python -m docs.tools.layers_picture`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from docs.tools.drawing import BLUE, CLAY, Panel, Shapes, View, draw_page, polygons
from docs.tools.placed_parts import placed_triangles
from fabkit import Project, design
from fabkit.parts import Assembly, Parts
from geometry.arrays import BoolArray
from geometry.mesh.shapes import rotational_mesh

__all__ = ["draw_layers"]

PICTURE = Path(__file__).parents[1] / "howto" / "layers.png"
LAYERS: list[dict[str, Any]] = [
    {"build_up": "8/16Ar/44.2", "edges": "mitred", "joint_mm": 20},
    {"thickness_mm": 25, "material": "timber", "z_mm": -300, "joint_mm": 12, "rim_step_mm": 60},
]
STEEL, GLASS, INNER, TIMBER = "#6d7a86", BLUE, "#1f4e79", "#c8a06a"


def drawn(parts: Parts[Any], chosen: BoolArray, colour: str, opacity: float = 1.0) -> Shapes:
    """The chosen parts (n,) in their places."""
    found: Shapes = []
    for own, corners, normals in placed_triangles(parts):
        shown = chosen[own]
        found.append(
            polygons(
                corners[shown].reshape(-1, 3, 3), colour, normals=normals[shown].reshape(-1, 3, 3), opacity=opacity
            )
        )
    return found


def layers_of(assembly: Assembly, glass: BoolArray, timber: BoolArray) -> Shapes:
    """The panels of both layers on the faces chosen (F,)."""
    panels = assembly["panels"]
    own, faces = panels.details, panels.elements
    outer, inner = (own.layer == 0) & (own.pane == 0), (own.layer == 0) & (own.pane == 1)
    return [
        *drawn(panels, (own.layer == 1) & timber[faces], TIMBER),
        *drawn(panels, inner & glass[faces], INNER, 0.45),
        *drawn(panels, outer & glass[faces], GLASS, 0.35),
    ]


def draw_layers(path: Path = PICTURE) -> None:
    angles = np.radians(np.linspace(48, 14, 6))
    mesh = rotational_mesh(np.stack([np.sin(angles), np.cos(angles)], axis=1), 16)
    densities = {"timber": 470.0}
    project = Project(mesh=mesh, mean_edge_mm=1500, layers=LAYERS, densities_kg_m3=densities, nesting={"mode": "off"})
    built = design(project)
    made, c = built.assembly, mesh.combinatorics
    middles = np.add.reduceat(mesh.vertices[c.corners], c.face_starts[:-1]) / c.face_sizes[:, None]
    azimuth = np.degrees(np.arctan2(middles[:, 1], middles[:, 0])) % 360
    beams, nodes = made["beams"], made["nodes"]
    whole = np.ones(len(beams), dtype=bool), np.ones(len(nodes), dtype=bool)
    steel = [*drawn(beams, whole[0], STEEL), *drawn(nodes, whole[1], CLAY)]
    glass, timber = azimuth < 300, (azimuth < 255) | (azimuth > 275)
    panels = [Panel([*steel, *layers_of(made, glass, timber)], View(-70.0, 30.0), (10, 10, 1180, 680))]
    draw_page(path, 1200, 700, panels)


if __name__ == "__main__":
    draw_layers()
