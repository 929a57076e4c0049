"""From a surface to beams: conjugate networks, Gauss image, support structure [Pottmann2007, 4.3, Fig. 14].

The surface is a roof over two hills. Affine maps keep lines conjugate, so that the principal lines of an image of the
surface, mapped back, are a network of conjugate curves: of the surface itself (a), with heights doubled (b), with
heights halved (c). Dots are singular points; network (c) has none, and its lines cross nearly at right angles. Quads
laid along it are nearly planar; planarising, while their vertices glide on the surface, makes them the mesh M. The
Gauss image S (d) folds over where M is saddle-shaped (warm), and leads to a support structure with beams of nearly one
height and nodes without torsion (e).
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import (
    BLUE,
    CLAY,
    INK,
    LINEN,
    STEEL,
    Note,
    Panel,
    Shapes,
    View,
    balls,
    bars,
    draw_page,
    faces,
    mixed,
    sphere,
    tubes,
)
from geometry import LaidMesh, Mesh, RemeshedSurface, SupportStructure, Surface, approximate_pair, lay_quads, remesh
from geometry.curvature import face_curvatures
from geometry.surface import refined

MAPS = {"a": np.eye(3), "b": np.diag([1, 1, 2]), "c": np.diag([1, 1, 0.5])}
CHOSEN = "c"
N_FACES = 600
DISTANCE = 0.05


@cache
def surface() -> Surface:
    """Over a plan with curved sides and a waist."""
    u, v = np.meshgrid(np.linspace(-1, 1, 53), np.linspace(-1, 1, 33), indexing="ij")
    x, y = 1.8 * u * (1.06 - 0.12 * v**2), v * (1.02 + 0.08 * u + 0.06 * np.cos(3 * u) - 0.12 * u**2)
    high = 0.7 * np.exp(-((x + 0.8) ** 2) / 1.3 - y**2 / 1.6)
    low = 0.5 * np.exp(-((x - 1) ** 2) - (y - 0.2) ** 2 / 1.6)
    z = high + low - 0.08 * x**2 - 0.22 * y**2
    return Surface(Mesh.from_grid(np.stack([x, y, z], axis=2)))


@cache
def planar() -> RemeshedSurface:
    return remesh(surface(), n_faces=N_FACES, affine=MAPS[CHOSEN])


@cache
def network(letter: str) -> LaidMesh:
    return planar().laid if letter == CHOSEN else lay_quads(surface(), n_faces=N_FACES, affine=MAPS[letter])


@cache
def support() -> SupportStructure:
    return SupportStructure(approximate_pair(planar().mesh), DISTANCE)


def main() -> dict[str, float]:
    found: dict[str, float] = {}
    for letter in MAPS:
        laid = network(letter)
        angle = np.degrees(laid.network.crossing_angles[0])
        found[f"singular points of ({letter})"] = len(laid.singularities)
        found[f"crossing angle in degrees that 5 % of ({letter}) are below"] = float(angle)
    result, heights = planar(), support().heights
    quality, length = result.laid.quality, result.mesh.mean_edge_length
    return found | {
        "faces of M": result.mesh.n_faces,
        "share of quads": quality.quad_share,
        "largest planarity as laid": float(quality.planarity.max()),
        "largest planarity of M": float(result.mesh.planarity.max()),
        "95 % of the moves in edge lengths": float(np.quantile(result.planarised.moves, 0.95)),
        "95 % of the distances from the surface in edge lengths": float(
            np.quantile(result.surface_distances, 0.95) / length
        ),
        "5 % of the beam heights over d": float(np.quantile(heights, 0.05)),
        "95 % of the beam heights over d": float(np.quantile(heights, 0.95)),
        "95 % of the leans of node axes in degrees": float(np.degrees(np.quantile(support().pair.leans, 0.95))),
        "largest twist in degrees": float(np.degrees(support().twists.max())),
    }


def lines(laid: LaidMesh) -> Shapes:
    """The two families of polylines on the surface, its boundary, and the singular points."""
    fine = refined(surface())
    shapes = faces(fine.triangulated, LINEN, width=0.0)
    for family, colour in zip(laid.polylines, (BLUE, CLAY), strict=True):
        ends = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in family])
        shapes += tubes(laid.mesh.vertices[ends], 0.008, colour, sides=8)
    c = fine.triangulated.combinatorics
    shapes += tubes(fine.triangulated.vertices[c.edges[c.is_boundary_edge]], 0.012, INK, sides=8)
    return [*shapes, *balls(laid.mesh.vertices[laid.singularities], 0.045, INK)]


def draw(path: Path) -> None:
    structure = support()
    mesh, s = structure.mesh, structure.gauss_image
    saddles = np.flatnonzero(face_curvatures(structure.pair).gaussian < 0)
    special = {mixed([CLAY], np.ones(1)): saddles}
    view = View(-72, 38)
    beams = bars(structure.quads, structure.width_directions * 0.009, STEEL, width=0.4)
    panels = [Panel(lines(network(letter)), view, (15 + 465 * k, 10, 445, 270)) for k, letter in enumerate(MAPS)]
    panels += [
        Panel([*sphere(0.96, LINEN), *faces(s, special=special, width=0.6)], view, (20, 350, 400, 400)),
        Panel([*faces(mesh, width=0.0), *beams], view, (460, 320, 920, 460)),
    ]
    letters = [(235, 300, "(a)"), (700, 300, "(b)"), (1165, 300, "(c)"), (220, 790, "(d)"), (920, 790, "(e)")]
    names = [(400, 380, r"$\mathcal{S}$", 32), (1300, 400, r"$\mathcal{M}$", 32)]
    draw_page(path, 1400, 820, panels, [*(Note(*each) for each in letters), *(Note(*each) for each in names)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_14.png")
    print(main())
