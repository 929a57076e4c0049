"""Draw a node on its support, and a dome by the order of erection: `python -m docs.tools.erection_picture`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import colormaps

from docs.tools.connection_nodes import shapes
from docs.tools.drawing import Note, Panel, Shapes, View, draw_page, polygons
from docs.tools.placed_parts import placed_triangles
from fabkit import Project, design
from fabkit.parts import Assembly
from fabkit.production import erection_order
from geometry.arrays import IntArray
from geometry.mesh.shapes import rotational_mesh

__all__ = ["draw_erection"]

PICTURE = Path(__file__).parents[1] / "howto" / "supports-and-erection.png"
GROUPS = ("beams", "nodes", "base plates", "stubs")


def by_order(assembly: Assembly, numbers: dict[str, IntArray]) -> Shapes:
    """All parts but panels, coloured from blue for the first to yellow for the last."""
    drawn, last = [], max(int(own.max()) for own in numbers.values())
    for group, own in numbers.items():
        parts = assembly[group]
        for chosen, corners, upright in placed_triangles(parts):
            for k, number in enumerate(own[chosen].tolist()):
                colour = np.array(colormaps["viridis"](number / last)[:3])
                drawn.append(polygons(corners[k], colour, normals=upright[k]))
    return drawn


def draw_erection(path: Path = PICTURE) -> None:
    angles = np.radians(np.linspace(50, 14, 6))
    mesh = rotational_mesh(np.stack([np.sin(angles), np.cos(angles)], axis=1), 16)
    lowest = np.flatnonzero(mesh.vertices[:, 2] < mesh.vertices[:, 2].min() + 1e-6).tolist()
    supports = {"vertices": lowest, "length_mm": 260}
    made = design(Project(mesh=mesh, mean_edge_mm=1500, nesting={"mode": "off"}, supports=supports)).assembly
    erection = erection_order(made)
    panels = [
        Panel(shapes(made, lowest[0], 0.0), View(28.0, 12.0), (10, 50, 560, 580)),
        Panel(
            by_order(made, {group: erection.numbers[group] for group in GROUPS}),
            View(-60.0, 24.0),
            (580, 50, 900, 580),
        ),
    ]
    notes = [Note(290, 24, "a node on its support"), Note(1030, 24, "order of erection, from blue to yellow")]
    draw_page(path, 1500, 650, panels, notes)


if __name__ == "__main__":
    draw_erection()
