"""A roof in layers that are all parallel: steel, glass, and fins that shade it [Pottmann2007, 4.4 and Fig. 1].

Below the glass M lie the beams, between M - d S and M. Above it stand fins between M + d1 (S + x) and M + d2 (S + x):
S + x is also parallel to M, and x is chosen for the most shade on a summer day. So fins lean towards the sun, while
beams stay upright.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import (
    CLAY,
    GLASS,
    GOLD,
    LINEN,
    STEEL,
    Note,
    Panel,
    Shapes,
    View,
    bars,
    draw_page,
    faces,
    polygons,
)
from geometry import SupportStructure, approximate_pair
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import Pair
from geometry.mesh import Mesh, shapes
from geometry.shading import Fins, MostShade, Suns, most_shade

BEAM_HEIGHT, LOWER, UPPER = 0.24, 0.1, 0.36


@cache
def roof() -> Mesh:
    """A hall whose ridge rises towards one end: a translation surface, stretched by a perspective."""
    u, v = np.linspace(-5, 5, 16), np.linspace(-1, 1, 11)
    along = np.stack([u, 0 * u, 0.28 * np.cos(0.75 * u + 0.6)], axis=1)
    across = np.stack([0.15 * v**2, 3.1 * np.sin(1.15 * v), 2.9 * np.cos(1.15 * v)], axis=1)
    mesh = shapes.translation_surface(along, across)
    return mesh.with_vertices(mesh.vertices / (1 - 0.035 * mesh.vertices[:, :1]))


@cache
def suns() -> Suns:
    """From morning to afternoon, the sun in the south, highest at noon."""
    hours = np.linspace(-0.9, 0.9, 4)
    height = np.radians(28 + 34 * np.cos(hours) ** 2)
    level = np.stack([np.sin(hours), -np.cos(hours)]) * np.cos(height)
    return Suns(np.stack([*level, np.sin(height)], axis=1))


@cache
def shaded() -> MostShade:
    return most_shade(Fins(approximate_pair(roof()), LOWER, UPPER), suns())


def main() -> dict[str, float]:
    found = shaded()
    return {
        "panels": roof().n_faces,
        "fins": len(found.after.fins.quads),
        "length of x": float(np.linalg.norm(found.shift)),
        "share of the panels in the shade, fins along S": found.before.share,
        "share of the panels in the shade, fins along S + x": found.after.share,
        "area of the fins along S": float(found.before.fins.areas.sum()),
        "area of the fins along S + x": float(found.after.fins.areas.sum()),
    }


def plates(fins: Fins, chosen: IntArray | slice, thickness: float) -> Shapes:
    """Fins as plates."""
    quads = fins.quads[chosen]
    normals = np.cross(quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return bars(quads, normals * thickness / 2, GOLD, first=CLAY, third=CLAY, width=0.4)


def ground(mesh: Mesh) -> FloatArray:
    """(1, 4, 3) a floor below a roof."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    margin = 0.06 * (high - low)
    (x0, y0, _), (x1, y1, _) = low - margin, high + margin
    return np.array([[[x0, y0, low[2]], [x1, y0, low[2]], [x1, y1, low[2]], [x0, y1, low[2]]]])


def draw(path: Path) -> None:
    fins = shaded().after.fins
    mesh, pair = roof(), shaded().before.fins.pair
    structure = SupportStructure(Pair(pair.offset_mesh(-BEAM_HEIGHT), pair.gauss_image), BEAM_HEIGHT)
    c = mesh.combinatorics
    steel = bars(structure.quads, structure.width_directions * 0.035, STEEL, width=0.4)
    glass = faces(mesh, GLASS, width=0.0, opacity=0.55)
    floor = [polygons(ground(mesh), LINEN)]
    whole = [*floor, *steel, *glass, *plates(fins, slice(None), 0.03)]
    near = np.isin(np.arange(mesh.n_faces), corner_faces())
    edges = np.unique(c.corner_edge[near[c.corner_face]])
    some = c.corners[near[c.corner_face]].reshape(-1, 4)
    detail = [
        *bars(structure.quads[edges], structure.width_directions[edges] * 0.035, STEEL, width=0.6),
        polygons(mesh.vertices[some], GLASS, back=GLASS, width=0.6, opacity=0.6),
        *plates(fins, edges, 0.03),
    ]
    panels = [
        Panel(whole, View(-62, 24), (20, 20, 900, 560)),
        Panel(detail, View(-62, 24), (960, 90, 420, 420)),
    ]
    names = [(1170, 545, "fins, glass, steel")]
    draw_page(path, 1400, 600, panels, [Note(*name, 24) for name in names])


def corner_faces() -> IntArray:
    """Six panels on the side of the sun."""
    n = 10
    return np.array([n * i + j for i in (8, 9, 10) for j in (2, 3)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_01.png")
    print(main())
