"""From a mesh made by subdivision to a support structure with little change [Pottmann2007, 4.2 and Fig. 13].

The polylines of the mesh intersect at angles far from 90 degrees. To make it conical, for exact face offsets, the
vertices must move far, because polylines of conical meshes are nearly orthogonal. To make its faces planar, they hardly
move. The planar mesh has approximate offsets, which are sufficient for a support structure without torsion.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb

from docs.tools.drawing import CLAY, GLASS, GOLD, STEEL, Note, Panel, Shapes, View, bars, draw_page, faces, tubes
from geometry import Mesh, SupportStructure, approximate_pair, planarise
from geometry.arrays import FloatArray
from geometry.mesh import shapes
from geometry.mesh.polygons import face_sums
from geometry.meshing import Guides, make_conical

DISTANCE = 0.2

FAIRNESS = 100.0
"""Keeps the conical mesh smooth; with less it moves less, and crumples. The planar one hardly depends on it."""

WARMEST = 2.0
"""Deviation in mean edge lengths that is shown in full colour."""


def refined(points: FloatArray) -> FloatArray:
    """A grid of points (m, n, 3), once subdivided by the rule of cubic B-splines, which keeps the corners."""
    for axis in (0, 1):
        p = np.moveaxis(points, axis, 0)
        inner = (p[:-2] + 6 * p[1:-1] + p[2:]) / 8
        old = np.concatenate([p[:1], inner, p[-1:]])
        new = np.empty((2 * len(p) - 1, *p.shape[1:]))
        new[::2], new[1::2] = old, (p[:-1] + p[1:]) / 2
        points = np.moveaxis(new, 0, axis)
    return points


@cache
def subdivided() -> Mesh:
    u, v = np.meshgrid(np.linspace(-2, 2, 5), np.linspace(-2, 2, 5), indexing="ij")
    height = 0.75 * np.cos(0.9 * u - 0.5) + 0.7 * np.cos(0.95 * v + 0.4) + 0.008 * u * v
    control = np.stack([1.25 * u + 0.7 * v, 0.95 * v, height], axis=2)
    points = refined(refined(control))
    return shapes.grid(len(points) - 1, points.shape[1] - 1).with_vertices(points.reshape(-1, 3))


@cache
def planar() -> Mesh:
    return planarise(subdivided(), Guides(fairness=FAIRNESS)).mesh


@cache
def conical() -> Mesh:
    return make_conical(subdivided(), Guides(fairness=FAIRNESS)).mesh


@cache
def support() -> SupportStructure:
    return SupportStructure(approximate_pair(planar()), DISTANCE)


def moved(mesh: Mesh) -> FloatArray:
    """(N,) distance of each vertex from its place in the subdivided mesh, over the mean edge length."""
    start = subdivided()
    return np.asarray(np.linalg.norm(mesh.vertices - start.vertices, axis=1) / start.mean_edge_length)


def main() -> dict[str, float]:
    c, t = subdivided().combinatorics, subdivided().vertices
    here = t[c.corners]
    ahead, back = t[c.corners[c.next_corner]] - here, t[c.corners[c.previous_corner]] - here
    angles = np.degrees(np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=1), (ahead * back).sum(axis=1)))
    return {
        "faces": c.n_faces,
        "sharpest angle in degrees": float(angles.min()),
        "mean deviation, conical, in edge lengths": float(moved(conical()).mean()),
        "mean deviation, planar, in edge lengths": float(moved(planar()).mean()),
        "largest deviation, conical, in edge lengths": float(moved(conical()).max()),
        "largest deviation, planar, in edge lengths": float(moved(planar()).max()),
        "least beam height over d": float(support().heights.min()),
        "largest beam height over d": float(support().heights.max()),
        "largest twist in degrees": float(np.degrees(support().twists.max())),
    }


def tinted(mesh: Mesh) -> Shapes:
    """The warmer, the further the corners of a face moved; the boundary of the subdivided mesh as a line."""
    c = mesh.combinatorics
    share = np.minimum(face_sums(c, moved(mesh)[c.corners]) / c.face_sizes / WARMEST, 1)[:, None]
    colours = (1 - share) * np.array(to_rgb(GLASS)) + share * np.array(to_rgb(GOLD))
    outline = subdivided().vertices[c.edges[c.is_boundary_edge]]
    return [*faces(mesh, colours), *tubes(outline, 0.02, CLAY)]


def draw(path: Path) -> None:
    structure = support()
    beams = bars(structure.quads, structure.width_directions * 0.035, STEEL, width=0.4)
    boxes = [(20, 10, 660, 350), (720, 10, 660, 350), (20, 410, 660, 350), (720, 410, 660, 350)]
    pictures = [faces(subdivided()), tinted(conical()), tinted(planar()), beams]
    panels = [Panel(picture, View(-110, 42), box) for picture, box in zip(pictures, boxes, strict=True)]
    letters = [Note(left + 330, top + 372, f"({name})") for name, (left, top, _, _) in zip("abcd", boxes, strict=True)]
    draw_page(path, 1400, 800, panels, letters)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_13.png")
    print(main())
