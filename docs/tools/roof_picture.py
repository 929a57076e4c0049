"""Draw the roof of the README: `python -m docs.tools.roof_picture`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, Panel, Shapes, View, draw_page, polygons
from fabkit import Project, design
from fabkit.formats.shown.triangles import facets
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
        for batch in facets(parts.solids, parts.mark_names):
            own = np.flatnonzero(np.isin(parts.shape, batch.solids))
            row = np.searchsorted(batch.solids, parts.shape[own])
            triangles = batch.triangles[row][..., None]
            points = batch.points[row] @ parts.axes[own] + parts.origins[own][:, None]
            normals = batch.normals[row] @ parts.axes[own]
            corners, upright = (
                np.take_along_axis(each[:, None], triangles, axis=2).reshape(-1, 3, 3) for each in (points, normals)
            )
            drawn.append(polygons(corners, colour, normals=upright, opacity=opacity))
    return drawn


def draw_roof(path: Path = ROOT / "docs" / "roof.png") -> None:
    roof = design(Project(mesh=ROOT / "examples" / "roof.obj", unit="m", nesting={"mode": "off"})).assembly
    draw_page(path, 1400, 640, [Panel(shapes(roof), View(-60.0, 32.0), (20, 20, 1360, 600))])


if __name__ == "__main__":
    draw_roof()
