"""Draw a dome in three zones, coloured by zone: `python -m docs.tools.zones_picture`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from docs.tools.drawing import Note, Panel, Shapes, View, draw_page, polygons
from docs.tools.placed_parts import placed_triangles
from fabkit import Project, design
from fabkit.parts import Assembly
from geometry.mesh.shapes import rotational_mesh

__all__ = ["draw_zones"]

PICTURE = Path(__file__).parents[1] / "howto" / "zones.png"
COLOURS = ((0.20, 0.45, 0.69), (0.88, 0.55, 0.20), (0.33, 0.62, 0.40))


def by_zone(assembly: Assembly) -> Shapes:
    """All parts in the colours of their zones, panels paler."""
    drawn: Shapes = []
    for parts in assembly.groups:
        zones = assembly.zones.of(parts)
        for chosen, corners, upright in placed_triangles(parts):
            for k, zone in enumerate(zones[chosen].tolist()):
                colour = np.array(COLOURS[zone])
                pale = 0.45 * colour + 0.55 if parts.kind.form == "plate" else colour
                drawn.append(polygons(corners[k], pale, normals=upright[k]))
    return drawn


def draw_zones(path: Path = PICTURE) -> None:
    angles = np.radians(np.linspace(50, 14, 6))
    mesh = rotational_mesh(np.stack([np.sin(angles), np.cos(angles)], axis=1), 16)
    c = mesh.combinatorics
    middles = np.array([mesh.vertices[face].mean(axis=0) for face in c.faces])
    scale = 1500 / mesh.mean_edge_length
    west = np.flatnonzero(middles[:, 0] < 0).tolist()
    zones = [
        {"name": "West", "faces": west},
        {"name": "East, low", "below_mm": float(np.median(middles[:, 2])) * scale},
        {"name": "East"},
    ]
    lowest = np.flatnonzero(mesh.vertices[:, 2] < mesh.vertices[:, 2].min() + 1e-6).tolist()
    supports = {"vertices": lowest, "length_mm": 260}
    own = {"supports": supports, "zones": zones, "nesting": {"mode": "off"}}
    made = design(Project(mesh=mesh, mean_edge_mm=1500, **own)).assembly
    panels = [Panel(by_zone(made), View(-60.0, 24.0), (10, 50, 980, 580))]
    notes = [Note(500, 24, "West (blue), then East, low (orange), then East (green)")]
    draw_page(path, 1000, 650, panels, notes)


if __name__ == "__main__":
    draw_zones()
