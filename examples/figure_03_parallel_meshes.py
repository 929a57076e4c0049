"""Two meshes are parallel if they have the same combinatorics and corresponding edges are parallel [Pottmann2007, 2.2].

M is a canopy of planar hexagons: the image of a hexagonal paraboloid under a projective map, which preserves planes. M'
is the parallel mesh nearest to a copy of M with a contracted middle, so that it has a peak.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, GOLD, INK, SAGE, Note, Panel, View, balls, draw_page, faces, tubes
from geometry import Mesh, ParallelSpace
from geometry.arrays import FloatArray
from geometry.mesh import shapes
from geometry.mesh.polygons import face_centroids
from geometry.parallel import edge_factors, parallelity

FACES = {CLAY: (1.0, -4.0), GOLD: (-4.0, -1.5), BLUE: (3.5, -3.0), SAGE: (2.5, 3.5)}
"""Colours of faces to be compared, and their approximate positions in the plan of M."""

STARS = [(-3.0, -4.5), (0.0, -2.0), (4.5, 0.5)]
"""Approximate positions in plan of the vertices whose edges are to be compared."""


@cache
def meshes() -> tuple[Mesh, Mesh]:
    """M and M'."""
    paraboloid = shapes.hexagonal_paraboloid(10, 8)
    lowered = paraboloid.vertices * [1, 1, -0.12]
    mesh = shapes.cap(paraboloid.with_vertices(lowered / (1 + 0.03 * lowered[:, :1])), -2.9)
    spokes = mesh.vertices - mesh.vertices[mesh.vertices[:, 2].argmax()]
    radii = np.linalg.norm(spokes, axis=1, keepdims=True)
    contracted = spokes * (0.4 + 0.9 * radii / radii.max())
    return mesh, ParallelSpace(mesh).project(mesh.with_vertices(contracted))


def main() -> dict[str, float]:
    mesh, other = meshes()
    factors = edge_factors(mesh, other)
    return {
        "faces": mesh.n_faces,
        "dimension of P(M)": ParallelSpace(mesh).dimension,
        "largest sine between corresponding edges": float((parallelity(mesh, other) / other.edge_lengths).max()),
        "least edge factor": float(factors.min()),
        "largest edge factor": float(factors.max()),
    }


def nearest(points: FloatArray, places: Iterable[tuple[float, float]]) -> list[int]:
    """For each position in plan, the nearest of points (n, 3)."""
    return [int(np.linalg.norm(points[:, :2] - place, axis=1).argmin()) for place in places]


def draw(path: Path) -> None:
    first, c = meshes()[0], meshes()[0].combinatorics
    chosen = nearest(face_centroids(first.vertices, c), FACES.values())
    special = {colour: [face] for colour, face in zip(FACES, chosen, strict=True)}
    stars = c.edges[np.isin(c.edges, nearest(first.vertices, STARS)).any(axis=1)]
    panels = []
    for mesh, left in zip(meshes(), (30, 730), strict=True):
        ends = mesh.vertices[stars]
        marked = [*tubes(ends, 0.07, INK), *balls(ends.reshape(-1, 3), 0.11, INK)]
        panels.append(Panel([*faces(mesh, special=special, width=1.0), *marked], View(-62, 36), (left, 20, 640, 400)))
    names = [Note(250, 430, r"$\mathcal{M}$", 32), Note(950, 430, r"$\mathcal{M}'$", 32)]
    draw_page(path, 1400, 470, panels, names)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_03.png")
    print(main())
