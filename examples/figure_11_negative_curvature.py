"""An edge offset mesh of negative curvature [Pottmann2007, (3), Fig. 11].

S is a Koebe polyhedron with pentagonal faces. M is the fairest mesh parallel to S whose edges keep or reverse the
orientation of those of S (red: reversed) and are no shorter than these. The diagram shows the general pattern: an edge
is reversed if it is closer to perpendicular than to parallel to a direction, one diagonal of the grid. The outermost
faces, whose shape is poorly determined, are left out of both meshes.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import CLAY, GLASS, INK, LINEN, Note, Panel, Shapes, View, draw_page, faces, tubes
from geometry import Mesh, Pair, edge_distances, edge_factors, face_curvatures, parallelity
from geometry.arrays import BoolArray, IntArray
from geometry.edge_offset.koebe_polyhedra import koebe
from geometry.edge_offset.signed_meshes import edge_offset_mesh, saddle_signs
from geometry.mesh.intersections.meeting_faces import intersecting_faces, self_crossing_faces
from geometry.mesh.tilings import pentagon_patch

COUNT, COVERAGE = 10, 0.5
ALONG, POLE = (1.0, 1.0, 0.0), (0.0, 0.0, -1.0)
DISTANCE = 0.1


def signs(s: Mesh) -> IntArray:
    return saddle_signs(s, ALONG, pole=POLE)


@cache
def pair() -> Pair:
    """M, S."""
    s = koebe(pentagon_patch(COUNT, COUNT), coverage=COVERAGE).mesh
    m = edge_offset_mesh(s, signs=signs(s), lengths=(s.edge_lengths, np.inf))
    return Pair(m, s).part(s.combinatorics.inner_faces)


def main() -> dict[str, float]:
    m, s = pair().mesh, pair().gauss_image
    apart = edge_distances(pair().offset_mesh(DISTANCE) - m, m.edge_directions) / DISTANCE
    return {
        "faces": m.n_faces,
        "edges": m.n_edges,
        "reversed edges": int(pair().reversed_edges.sum()),
        "largest Gaussian curvature": float(face_curvatures(pair()).gaussian.max()),
        "largest deviation of an edge of S from distance 1": float(np.abs(edge_distances(s) - 1).max()),
        "largest deviation of edges of M and M + d S from distance d, over d": float(np.abs(apart - 1).max()),
        "largest sine between corresponding edges": float((parallelity(m, s) / s.edge_lengths).max()),
        "least absolute edge factor": float(np.abs(edge_factors(s, m)).min()),
        "largest absolute edge factor": float(np.abs(edge_factors(s, m)).max()),
        "faces of M that cross themselves or others": len(self_crossing_faces(m)) + len(intersecting_faces(m)),
    }


def edges(mesh: Mesh, against: BoolArray, radius: float) -> Shapes:
    ends = mesh.vertices[mesh.combinatorics.edges]
    return [*tubes(ends[~against], radius * 0.7, INK, sides=8), *tubes(ends[against], radius, CLAY, sides=8)]


def diagram() -> Shapes:
    """The pattern of a small, nearly flat patch as seen from above."""
    whole = koebe(pentagon_patch(6, 6), coverage=0.001).mesh
    s = whole.part(whole.combinatorics.inner_faces)
    flat = s.vertices * [1, 1, 0]
    return edges(s.with_vertices(flat / np.abs(flat).max()), signs(s) < 0, 0.022)


def draw(path: Path) -> None:
    m, s, against = pair().mesh, pair().gauss_image, pair().reversed_edges
    size = float(np.abs(m.vertices).max())
    panels = [
        Panel(
            [*faces(m, LINEN, back=GLASS, width=0.0), *edges(m, against, 0.007 * size)],
            View(-60, 32),
            (20, 10, 860, 560),
        ),
        Panel([*faces(s, width=0.0), *edges(s, against, 0.012)], View(-60, 32), (960, 30, 400, 240)),
        Panel(diagram(), View(-45, 90), (1010, 300, 290, 270)),
    ]
    draw_page(path, 1400, 580, panels, [Note(740, 150, r"$\mathcal{M}$", 30), Note(985, 50, r"$\mathcal{S}$", 30)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_11.png")
    print(main())
