"""A roof of beams, glass, and fins that shade it [Pottmann2007, 4.4 and Fig. 1].

Hollow sections are welded to node blocks, panels lie on them, and fins stand over the glass, between M + d1 (S + x) and
M + d2 (S + x): S + x is also parallel to M, and x is chosen for the most shade on a summer day. So fins lean towards
the sun, while beams stay upright. All is drawn from the STEP file of the build.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from docs.tools.drawing import GLASS, GOLD, LINEN, STEEL, Note, Panel, Shapes, View, draw_page, polygons
from docs.tools.step_shapes import StepShapes
from fabkit import Project, design
from fabkit.pipeline import Built
from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh, shapes
from geometry.shading import Fins, Suns

LOWER_MM, UPPER_MM = 150.0, 600.0


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


def built_with(**fins: Any) -> Built:
    """The roof with edges of 1.5 m on average, and with fins."""
    return design(
        Project(
            mesh=roof(),
            mean_edge_mm=1500,
            beams={"section": "rhs 180x60x5"},
            connection={"kind": "welded"},
            nodes={"top": "trimmed"},
            layers=[{"joint_mm": 20, "seat_mm": 12, "thickness_mm": 12}],
            fins={"from_mm": LOWER_MM, "to_mm": UPPER_MM, **fins},
            nesting={"mode": "off"},
        )
    )


@cache
def shaded() -> Built:
    """With fins that lean for the most shade."""
    return built_with(suns=suns().directions.tolist(), longest_direction=0.7)


def main() -> dict[str, float]:
    built = shaded()
    before, after = built.summary.fin_shade
    upright = Fins(built.structure.pair, LOWER_MM, UPPER_MM)
    return {
        "panels": len(built.assembly["panels"]),
        "fins": len(built.assembly["fins"]),
        "length of x": float(np.linalg.norm(built.summary.fin_direction)),
        "share of the panels in the shade, fins along S": before,
        "share of the panels in the shade, fins along S + x": after,
        "area of the fins along S in m2": float(upright.areas.sum()) / 1e6,
        "area of the fins along S + x in m2": float(built.assembly["fins"].details.area_mm2.sum()) / 1e6,
        "largest lean of a fin from its beam in degrees": float(built.assembly["fins"].details.lean_deg.max()),
        "mass of beams and nodes in tonnes": sum(float(built.assembly[g].masses_kg.sum()) for g in STEELWORK) / 1e3,
    }


STEELWORK = ("beams", "nodes")


def parts(step: StepShapes, edges: IntArray | None = None, faces: IntArray | None = None) -> Shapes:
    """What is drawn of a roof, or the parts at some edges and faces."""
    vertices = None if edges is None else np.unique(roof().combinatorics.edges[edges])
    return [
        *step.shapes("beams", STEEL, elements=edges),
        *step.shapes("nodes", STEEL, elements=vertices),
        *step.shapes("panels", GLASS, elements=faces, opacity=0.6),
        *step.shapes("fins", GOLD, elements=edges),
    ]


def ground(mesh: FloatArray) -> Shapes:
    """A floor below points (n, 3)."""
    low, high = mesh.min(axis=0), mesh.max(axis=0)
    margin = 0.06 * (high - low)
    (x0, y0, _), (x1, y1, _) = low - margin, high + margin
    return [polygons(np.array([[[x0, y0, low[2]], [x1, y0, low[2]], [x1, y1, low[2]], [x0, y1, low[2]]]]), LINEN)]


def draw(path: Path) -> None:
    step, c = StepShapes.written(shaded().assembly), roof().combinatorics
    faces = corner_faces()
    edges = np.unique(c.corner_edge[np.isin(c.corner_face, faces)])
    whole = [*ground(shaded().structure.mesh.vertices / 1000), *parts(step)]
    panels = [
        Panel(whole, View(-62, 24), (20, 20, 900, 560)),
        Panel(parts(step, edges, faces), View(-62, 24), (960, 70, 420, 440)),
    ]
    draw_page(path, 1400, 600, panels, [Note(1170, 545, "fins, glass, steel", 24)])


def corner_faces() -> IntArray:
    """Six panels on the side of the sun."""
    n = 10
    return np.array([n * i + j for i in (8, 9, 10) for j in (2, 3)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_01.png")
    print(main())
