"""A minimal mesh of quads, and the parallel diagonals of its faces and their images [Pottmann2007, (8), Fig. 17].

S consists of horizontal polylines and of meridian polylines in planes through an axis; it is near the unit sphere, but
need not have rotational symmetry. M is parallel to it, with meridians that run against those of S. A face of M has mean
curvature zero with respect to S if and only if its diagonals are parallel to those of its image: 13 to 2*4*, and 24 to
1*3*.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, GOLD, Label, Note, Panel, Shapes, View, draw_page, faces, polygons, tubes
from geometry import Mesh, Pair, face_curvatures, parallelity
from geometry.arrays import FloatArray
from geometry.curvature import minimal_of_revolution
from geometry.mesh import shapes
from geometry.mesh.intersections.meeting_faces import intersecting_faces, self_crossing_faces

AROUND, ROWS = 28, 11
VIEW = View(-25, 20)


@cache
def gauss_image() -> Mesh:
    """A sphere that is wider in one direction, with three bulges around."""
    turn = np.radians(np.linspace(-52, 62, ROWS + 1))
    ball = shapes.rotational_mesh(np.stack([np.cos(turn), np.sin(turn)], axis=1), AROUND)
    azimuth = np.arctan2(ball.vertices[:, 1], ball.vertices[:, 0])
    radius = 1 + 0.08 * np.cos(3 * azimuth + 0.4)
    return ball.with_vertices(ball.vertices * np.stack([1.12 * radius, 0.92 * radius, np.ones_like(radius)], axis=1))


@cache
def minimal() -> Pair:
    return minimal_of_revolution(gauss_image())


def diagonals(mesh: Mesh) -> FloatArray:
    """(F, 2, 3) from corner 1 to 3 and from 2 to 4 of each face, over their lengths."""
    corners = mesh.vertices[mesh.combinatorics.corners].reshape(-1, 4, 3)
    across = corners[:, 2:] - corners[:, :2]
    return np.asarray(across / np.linalg.norm(across, axis=2, keepdims=True))


def main() -> dict[str, float]:
    m, s = minimal().mesh, gauss_image()
    sines = np.linalg.norm(np.cross(diagonals(m), diagonals(s)[:, ::-1]), axis=2)
    curvatures = face_curvatures(minimal())
    radii = np.linalg.norm(s.vertices, axis=1)
    return {
        "faces": m.n_faces,
        "reversed edges": int(minimal().reversed_edges.sum()),
        "largest mean curvature, times the waist radius": float(np.abs(curvatures.mean).max()),
        "largest Gaussian curvature, times its square": float(curvatures.gaussian.max()),
        "largest sine between 13 and 2*4*": float(sines[:, 0].max()),
        "largest sine between 24 and 1*3*": float(sines[:, 1].max()),
        "largest sine between corresponding edges": float((parallelity(m, s) / s.edge_lengths).max()),
        "least radius of S": float(radii.min()),
        "largest radius of S": float(radii.max()),
        "faces of M that cross themselves or others": len(self_crossing_faces(m)) + len(intersecting_faces(m)),
    }


def shown() -> int:
    """A face that is well visible in M and in S."""
    azimuth, elevation = np.radians([VIEW.azimuth - 22, 22])
    towards = [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    return int((gauss_image().face_normals @ towards).argmax())


def pair() -> tuple[Shapes, list[Label]]:
    """A face of M over its image of equal size, both as seen from their outside, and their diagonals."""
    drawn: Shapes = []
    labels = []
    normal = gauss_image().face_normals[shown()]
    right = np.cross([0.0, 0.0, 1.0], normal)
    right /= np.linalg.norm(right)
    up = np.cross(normal, right)
    for mesh, height, star in ((minimal().mesh, 0.85, ""), (gauss_image(), -0.85, "*")):
        corners = mesh.vertices[mesh.combinatorics.face(shown())]
        corners = (corners - corners.mean(axis=0)) @ np.stack([right, up, normal], axis=1)
        corners *= 1.0 / np.linalg.norm(corners, axis=1).max()
        at = corners + np.array([0.0, height, 0.0])
        first, second = (CLAY, BLUE) if not star else (BLUE, CLAY)
        drawn += [polygons(at[None], "#f3e3bd", width=1.5)]
        drawn += tubes(at[None, [0, 2]] + [0, 0, 0.03], 0.016, first)
        drawn += tubes(at[None, [1, 3]] + [0, 0, 0.02], 0.016, second)
        for k in range(4):
            out = corners[k, :2] / np.linalg.norm(corners[k, :2]) * 20
            labels.append(Label(at[k], f"${k + 1}^{{{star}}}$", (float(out[0]), float(out[1])), size=24))
    return drawn, labels


def draw(path: Path) -> None:
    special = {GOLD: [shown()]}
    drawn, labels = pair()
    panels = [
        Panel(faces(minimal().mesh, width=1.0, special=special), VIEW, (20, 20, 560, 460)),
        Panel(drawn, View(-90, 90), (640, 40, 250, 420), labels),
        Panel(faces(gauss_image(), width=1.0, special=special), VIEW, (960, 60, 420, 380)),
    ]
    names = [Note(300, 525, r"$\mathcal{M}$", 30), Note(1170, 525, r"$\mathcal{S}$", 30)]
    draw_page(path, 1400, 560, panels, names)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_17.png")
    print(main())
