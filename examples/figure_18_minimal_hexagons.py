"""A minimal mesh of hexagons with edge offsets [Pottmann2007, Fig. 18].

S is a Koebe polyhedron of hexagons around an axis. M is parallel to it and has mean curvature zero with respect to S:
the mixed area of each face and its image vanishes. Edges in planes through the axis run against those of S (red), the
zigzags in the same direction. The diagram shows a part of S in Mercator projection.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import CLAY, INK, Note, Panel, Shapes, View, draw_page, faces, tubes
from geometry import Mesh, Pair, edge_distances, face_curvatures, parallelity
from geometry.curvature import minimal_of_revolution
from geometry.edge_offset.rotational import BandTiling, rotational_koebe
from geometry.mesh.intersections.meeting_faces import intersecting_faces, self_crossing_faces

AROUND, ROWS = 18, 7


@cache
def koebe() -> Mesh:
    return rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, AROUND, ROWS)


@cache
def minimal() -> Pair:
    return minimal_of_revolution(koebe())


def main() -> dict[str, float]:
    m, s = minimal().mesh, koebe()
    curvatures = face_curvatures(minimal())
    return {
        "faces": m.n_faces,
        "edges": m.n_edges,
        "reversed edges": int(minimal().reversed_edges.sum()),
        "largest mean curvature, times the waist radius": float(np.abs(curvatures.mean).max()),
        "largest Gaussian curvature, times its square": float(curvatures.gaussian.max()),
        "largest deviation of an edge of S from distance 1": float(np.abs(edge_distances(s) - 1).max()),
        "largest sine between corresponding edges": float((parallelity(m, s) / s.edge_lengths).max()),
        "faces of M that cross themselves or others": len(self_crossing_faces(m)) + len(intersecting_faces(m)),
    }


def signed(mesh: Mesh, radius: float) -> Shapes:
    """The edges of a mesh: red where M and S run against each other."""
    ends, against = mesh.vertices[mesh.combinatorics.edges], minimal().reversed_edges
    return [*tubes(ends[~against], radius * 0.6, INK, sides=8), *tubes(ends[against], radius, CLAY, sides=8)]


def diagram() -> Shapes:
    """Some faces of S with longitude and Mercator latitude for x and y."""
    s = koebe()
    longitude = np.arctan2(s.vertices[:, 1], s.vertices[:, 0])
    height = np.arctanh(s.vertices[:, 2] / np.linalg.norm(s.vertices, axis=1))
    c = s.combinatorics
    centres = np.add.reduceat(np.abs(longitude)[c.corners], c.face_starts[:-1]) / c.face_sizes
    rows = np.abs(np.add.reduceat(height[c.corners], c.face_starts[:-1]) / c.face_sizes)
    shown = np.flatnonzero((centres < 3.6 * np.pi / AROUND) & (rows < 0.75))
    edges = np.unique(c.corner_edge[np.isin(c.corner_face, shown)])
    flat = np.stack([longitude, height, 0 * height], axis=1)
    ends, against = flat[c.edges[edges]], minimal().reversed_edges[edges]
    return [*tubes(ends[~against], 0.012, INK), *tubes(ends[against], 0.02, CLAY)]


def draw(path: Path) -> None:
    m, s = minimal().mesh, koebe()
    size = float(np.abs(m.vertices).max())
    view = View(-85, 24)
    panels = [
        Panel([*faces(s, width=0.0), *signed(s, 0.012)], view, (20, 60, 400, 400)),
        Panel([*faces(m, width=0.0), *signed(m, 0.010 * size)], view, (450, 20, 560, 470)),
        Panel(diagram(), View(-90, 90), (1060, 110, 310, 300)),
    ]
    draw_page(path, 1400, 560, panels, [Note(220, 525, r"$\mathcal{S}$", 30), Note(730, 525, r"$\mathcal{M}$", 30)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_18.png")
    print(main())
