"""Draw the roof of the README: `python -m docs.tools.roof_picture`."""

from __future__ import annotations

from pathlib import Path

from docs.tools.drawing import BLUE, CLAY, Panel, Shapes, View, draw_page, polygons
from docs.tools.placed_parts import placed_triangles
from fabkit import Project, design
from fabkit.parts import Assembly

__all__ = ["draw_roof"]

ROOT = Path(__file__).parents[2]
COLOURS = {"beams": "#6d7a86", "nodes": CLAY, "panels": BLUE}
GLASS_OPACITY = 0.25
"""Part of the light that the panels in the picture keep back."""


def shapes(assembly: Assembly) -> Shapes:
    """All parts in their places, panels translucent."""
    drawn = []
    for name, colour in COLOURS.items():
        parts = assembly[name]
        opacity = GLASS_OPACITY if name == "panels" else 1.0
        for _, corners, normals in placed_triangles(parts):
            drawn.append(
                polygons(corners.reshape(-1, 3, 3), colour, normals=normals.reshape(-1, 3, 3), opacity=opacity)
            )
    return drawn


def draw_roof(path: Path = ROOT / "docs" / "roof.png") -> None:
    roof = design(Project(mesh=ROOT / "examples" / "roof.obj", unit="m", nesting={"mode": "off"})).assembly
    draw_page(path, 1400, 640, [Panel(shapes(roof), View(-60.0, 32.0), (20, 20, 1360, 600))])


if __name__ == "__main__":
    draw_roof()
