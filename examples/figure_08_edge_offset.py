"""A mesh with an edge offset: a parallel mesh S touches the unit sphere with its edges [Pottmann2007, Prop. 2, Fig. 8].

S is the upper part of an Archimedean solid, a Koebe polyhedron; its faces intersect the sphere in circles that touch
each other. Every mesh parallel to S has edge offsets: M is the one nearest to an elongated shell, and M' = M + d S.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import CLAY, GOLD, INK, LINEN, Note, Panel, Shapes, View, bars, draw_page, faces, sphere, tubes
from geometry import Mesh, ParallelSpace, SupportStructure
from geometry.gauss import Pair, edge_distances, face_distances
from geometry.mesh import shapes, solids
from geometry.parallel import parallelity

DISTANCE = 0.22


@cache
def koebe() -> Mesh:
    solid = solids.truncated_icosidodecahedron()
    return shapes.cap(solid * (1 / edge_distances(solid).mean()), 0.05)


@cache
def support() -> SupportStructure:
    s = koebe()
    x, y, z = s.vertices.T
    shell = np.stack([2.1 * x + 0.25 * x**2, 1.25 * y * (1 + 0.2 * x), 1.1 * z + 0.15 * x], axis=1)
    return SupportStructure(Pair(ParallelSpace(s).project(s.with_vertices(shell)), s), DISTANCE)


def main() -> dict[str, float]:
    structure = support()
    between = structure.offset_mesh - structure.mesh
    apart = edge_distances(between, structure.mesh.edge_directions) / DISTANCE
    depths = face_distances(koebe())
    return {
        "faces": structure.mesh.n_faces,
        "largest deviation of an edge of S from distance 1": float(np.abs(structure.heights - 1).max()),
        "largest deviation of edges of M and M' from distance d, over d": float(np.abs(apart - 1).max()),
        "largest sine between corresponding edges": float(
            (parallelity(structure.mesh, koebe()) / koebe().edge_lengths).max()
        ),
        "least distance of a face of S": float(depths.min()),
        "largest distance of a face of S": float(depths.max()),
    }


def circles() -> Shapes:
    """Where the faces of S cut the unit sphere."""
    s = koebe()
    n, distance = s.face_normals, face_distances(s)
    x = np.cross(n, [0.3, 0.5, 0.8])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    angles = np.linspace(0, 2 * np.pi, 49)[:, None, None]
    ring = np.cos(angles) * x + np.sin(angles) * np.cross(n, x)
    points = distance[:, None] * n + np.sqrt(1 - distance**2)[:, None] * ring
    return tubes(np.stack([points[:-1], points[1:]], axis=2).reshape(-1, 2, 3), 0.011, CLAY, sides=6)


def draw(path: Path) -> None:
    structure = support()
    edges = structure.mesh.combinatorics.edges
    fins = bars(structure.quads, structure.width_directions * 0.008, GOLD, width=0.4)
    ball = [*faces(koebe()), *tubes(koebe().vertices[edges], 0.008, INK), *sphere(1.0, LINEN), *circles()]
    view = View(-70, 28)
    panels = [
        Panel([*faces(structure.mesh, width=1.2), *fins], view, (20, 20, 800, 460)),
        Panel(ball, view, (880, 20, 500, 460)),
    ]
    names = [(330, 330, r"$\mathcal{M}$"), (110, 60, r"$\mathcal{M}'$"), (930, 60, r"$\mathcal{S}$")]
    draw_page(path, 1400, 500, panels, [Note(*name, 32) for name in names])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_08.png")
    print(main())
