"""Nodes with an axis, and one without [Pottmann2007, Prop. 1 and Fig. 4].

The geometric support structure (a) lies between M and a parallel mesh M': the central planes of all beams at a vertex
m_i meet in its node axis A_i (b). A triangle mesh has no parallel meshes except scaled copies: here (c) each central
plane bisects the angle of the two faces at its edge, and the beams of a node are twisted even about the best axis.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, STEEL, Label, Note, Panel, Shapes, View, bars, draw_page, polygons, tubes
from geometry import SupportStructure, approximate_pair
from geometry.arrays import FloatArray
from geometry.mesh import shapes

HEIGHT, HALF_WIDTH, RADIUS = 0.34, 0.045, 0.085


@cache
def support() -> SupportStructure:
    """Over a small vault that widens to one side."""
    x, y = np.linspace(-2, 2, 5), np.linspace(-1.5, 1.5, 4)
    along = np.stack([x, 0 * x, -0.10 * x**2], axis=1)
    across = np.stack([0.15 * y, y, -0.16 * y**2 + 0.04 * y**3], axis=1)
    plain = shapes.translation_surface(along, across)
    mesh = plain.with_vertices(plain.vertices / (1 + 0.07 * plain.vertices[:, :1]))
    return SupportStructure(approximate_pair(mesh, normals=mesh.vertex_normals), HEIGHT)


def node_with_axis() -> tuple[FloatArray, FloatArray]:
    """Unit directions along the beams of a vertex (n, 3), and across their central planes (n, 3)."""
    structure, vertex = support(), 9
    edges = structure.mesh.combinatorics.edges
    here = np.flatnonzero((edges == vertex).any(axis=1))
    outwards = np.where(edges[here, :1] == vertex, 1.0, -1.0)
    return structure.mesh.edge_directions[here] * outwards, structure.width_directions[here] * outwards


def node_with_torsion() -> tuple[FloatArray, FloatArray]:
    """The same for the middle of six triangles on a wavy surface."""
    angles = np.radians([0, 52, 118, 176, 243, 301])
    height = 0.26 * np.cos(2 * angles + 0.6) - 0.18 + 0.08 * np.sin(3 * angles)
    ring = np.stack([np.cos(angles), np.sin(angles), height], axis=1)
    along = ring / np.linalg.norm(ring, axis=1, keepdims=True)
    normals = np.cross(along, np.roll(along, -1, axis=0))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    across = np.cross(along, normals + np.roll(normals, 1, axis=0))
    return along, across / np.linalg.norm(across, axis=1, keepdims=True)


def best_axis(across: FloatArray) -> FloatArray:
    """The direction that is nearest to all central planes."""
    axis = np.linalg.eigh(across.T @ across)[1][:, 0]
    return np.asarray(axis * np.sign(axis[2]))


def main() -> dict[str, float]:
    nodes = [across for _, across in (node_with_axis(), node_with_torsion())]
    torsion = [float(np.degrees(np.arcsin(np.abs(across @ best_axis(across)).max()))) for across in nodes]
    return {
        "largest twist of a beam over M in degrees": float(np.degrees(support().twists.max())),
        "torsion of the node with axis in degrees": torsion[0],
        "torsion of the node of a triangle mesh in degrees": torsion[1],
    }


def close_up(along: FloatArray, across: FloatArray) -> Shapes:
    """Beams cut off near the node; central planes a little larger; lines in these as near to the axis as can be."""
    axis, up = best_axis(across), np.cross(across, along)
    lines = axis - (across @ axis)[:, None] * across
    lines /= np.einsum("ni,ni->n", lines, up)[:, None]

    def quads(start: float, end: float, low: float, high: float) -> FloatArray:
        near, far = along * start, along * end
        return np.stack([near + low * lines, far + low * up, far + high * up, near + high * lines], axis=1)

    planes = polygons(quads(0.0, 1.12, -0.46, 0.10), BLUE, opacity=0.35, width=0.5, ink=BLUE)
    ends = np.stack([-0.62 * lines, 0.26 * lines], axis=1)
    return [*bars(quads(0.3, 1.0, -0.36, 0.0), across * 0.05, STEEL, width=0.7), planes, *tubes(ends, 0.011, CLAY)]


def patch() -> Shapes:
    """One half of M with its beams and nodes, the other half with the geometric support structure alone."""
    structure = support()
    m, quads, edges = structure.mesh.vertices, structure.quads, structure.mesh.combinatorics.edges
    axes = structure.offset_mesh.vertices - m
    nodes = m[:, 0] > -0.1
    built = nodes[edges].all(axis=1)
    along = structure.mesh.edge_directions[built, None] * RADIUS
    beams = quads[built] + np.concatenate([along, -along, -along, along], axis=1)
    cores = np.stack([m - 0.06 * axes, m + 1.06 * axes], axis=1)[nodes]
    return [
        *bars(beams, structure.width_directions[built] * HALF_WIDTH, STEEL, width=0.7),
        *tubes(cores, RADIUS, STEEL, cap_width=0.7),
        polygons(quads[~built], BLUE, opacity=0.4, width=1.0),
        *tubes(np.stack([m - 0.7 * axes, m + 1.7 * axes], axis=1), 0.013, CLAY),
    ]


def draw(path: Path) -> None:
    m, outer = support().mesh.vertices, support().offset_mesh.vertices
    top = outer[0] * 1.7 - m[0] * 0.7
    labels = [Label(m[0], r"$\mathbf{m}_i$", (-2, -24)), Label(outer[0], r"$\mathbf{m}_i'$", (-24, -8))]
    labels += [Label(top, "$A_i$", (6, 16), CLAY), Label((m[0] + m[4]) / 2, r"$\mathcal{M}$", (30, -26), size=26)]
    labels += [Label((outer[2] + outer[3]) / 2, r"$\mathcal{M}'$", (-26, 22), size=26)]
    panels = [Panel(patch(), View(-66, 35), (45, 20, 620, 400), labels)]
    panels += [Panel(close_up(*node_with_axis()), View(-58, 32), (700, 20, 330, 400))]
    panels += [Panel(close_up(*node_with_torsion()), View(-88, 34), (1050, 20, 330, 400))]
    draw_page(path, 1400, 470, panels, [Note(340, 445, "(a)"), Note(865, 445, "(b)"), Note(1215, 445, "(c)")])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_04.png")
    print(main())
