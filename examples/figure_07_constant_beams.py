"""Beams of constant height where the distance of M and M' is not constant [Pottmann2007, Fig. 7].

The polylines of M are oblique to each other, so the heights of its support structure vary strongly. Beams of one
height, aligned on the outside, then end at different depths on the node axes, which is visible only from the inside.
Nodes still have no torsion.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, GLASS, GOLD, STEEL, Note, Panel, View, bars, draw_page, polygons, tubes
from geometry import SupportStructure, approximate_pair
from geometry.arrays import FloatArray
from geometry.mesh import shapes

HEIGHT, HALF_WIDTH = 0.5, 0.06


@cache
def support() -> SupportStructure:
    x, y = np.linspace(-2, 2, 5), np.linspace(-1.5, 1.5, 4)
    along = np.stack([x, 0.25 * x, -0.25 * x**2], axis=1)
    across = np.stack([0.7 * y, 0.85 * y, -0.3 * y**2], axis=1)
    plain = shapes.translation_surface(along, across)
    mesh = plain.with_vertices(plain.vertices / (1 + 0.05 * plain.vertices[:, :1]))
    return SupportStructure(approximate_pair(mesh, normals=mesh.vertex_normals), HEIGHT)


def inner_ends() -> FloatArray:
    """(E, 2) where beams of constant height end on the node axes: distances from M, over the height."""
    structure = support()
    axes = structure.axes[structure.mesh.combinatorics.edges]
    return np.asarray(1 / np.einsum("enk,ek->en", axes, structure.height_directions))


def depths() -> tuple[FloatArray, FloatArray]:
    """(N,) least and largest depth at which the beams of a node end on its axis, over their height."""
    structure = support()
    ends, vertices = inner_ends().ravel(), structure.mesh.combinatorics.edges.ravel()
    least, largest = np.full(structure.mesh.n_vertices, np.inf), np.full(structure.mesh.n_vertices, -np.inf)
    np.minimum.at(least, vertices, ends)
    np.maximum.at(largest, vertices, ends)
    return least, largest


def main() -> dict[str, float]:
    structure = support()
    least, largest = depths()
    return {
        "least height over d": float(structure.heights.min()),
        "largest height over d": float(structure.heights.max()),
        "largest misalignment over the beam height": float((largest - least).max()),
        "largest twist in degrees": float(np.degrees(structure.twists.max())),
    }


def draw(path: Path) -> None:
    structure = support()
    c, m, a = structure.mesh.combinatorics, structure.mesh.vertices, structure.axes
    least, largest = depths()
    middle = np.where(c.is_boundary_vertex, 0.0, largest - least).argmax()
    shown = np.unique(c.corner_edge[np.isin(c.corner_face, c.corner_face[c.corners == middle])])
    edges, nodes = c.edges[shown], np.unique(c.edges[shown])
    outer = m[edges]
    inner = outer - HEIGHT * inner_ends()[shown, :, None] * a[edges]
    plates = np.stack([outer[:, 0], outer[:, 1], inner[:, 1], inner[:, 0]], axis=1)
    across = structure.width_directions[shown] * HALF_WIDTH
    beams = bars(plates, across, STEEL, first=GLASS, third=GOLD, width=0.8)
    bottoms = m - HEIGHT * least[:, None] * a
    cores = tubes(np.stack([m + 0.015 * a, bottoms], axis=1)[nodes], 1.7 * HALF_WIDTH, STEEL, cap_width=0.8)
    axes = tubes(np.stack([m + 0.15 * a, m - 0.8 * a], axis=1)[nodes], 0.012, CLAY)
    azimuth, elevation = np.degrees([np.arctan2(a[middle, 1], a[middle, 0]), np.arcsin(a[middle, 2])])
    outside, inside = View(azimuth - 30, elevation - 25), View(azimuth + 150, 30 - elevation)
    draw_page(
        path,
        1400,
        430,
        [
            Panel([*beams, *cores], outside, (20, 20, 440, 360)),
            Panel([polygons(plates, BLUE, width=0.8), *axes], inside, (480, 20, 440, 360)),
            Panel([*beams, *cores], inside, (940, 20, 440, 360)),
        ],
        [Note(240, 410, "(a)"), Note(700, 410, "(b)"), Note(1160, 410, "(c)")],
    )


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_07.png")
    print(main())
