"""Open Koebe polyhedra in closed form, from tilings of the plane by tangential polygons.

The tiles are dual to a tiling with edges of length 1 and regular faces: circles of radius 1/2 about its vertices touch
each other and lie in the tiles; circles about its faces, through the middles of the edges, cut them at right angles.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial import Delaunay

from geometry.arrays import FloatArray
from geometry.mesh import Mesh
from geometry.spheres.stereographic import circle_planes, poles

__all__ = ["KINDS", "tiling_polyhedron"]

KINDS = {"quads": 4, "hexagons": 6, "pentagons": 5}
LARGEST_TILE = 0.71
"""Circumradius of a square, the largest regular face here; the hull of the points has larger ones."""


def _points(kind: str, n: int) -> FloatArray:
    """(k, 2) vertices of the square, the triangular and the snub square tiling."""
    grid = np.stack(np.meshgrid(np.arange(-n, n + 1.0), np.arange(-n, n + 1.0)), axis=2).reshape(-1, 2)
    if kind == "quads":
        return grid
    if kind == "hexagons":
        return grid @ np.array([[1.0, 0.0], [0.5, 0.75**0.5]])
    angles = np.radians(60 + 90 * np.arange(4))
    squares = np.stack([np.cos(angles), np.sin(angles)], axis=1) / 2**0.5
    return np.asarray(((2 + 3**0.5) ** 0.5 * grid[:, None] + squares).reshape(-1, 2))


@cache
def tiling_polyhedron(kind: str, *, reach: float = 3.2, scale: float = 0.25, turn: float = 0.0) -> Mesh:
    """The tiles within a reach of the origin, turned, scaled and put on the sphere about its north pole."""
    centres = _points(kind, int(2 * reach) + 2)
    triangulation = Delaunay(centres)
    corners = centres[triangulation.simplices]
    rows = 2 * (corners[:, 1:] - corners[:, :1])
    middles = np.linalg.solve(rows, (np.square(corners[:, 1:]) - np.square(corners[:, :1])).sum(axis=2)[..., None])[
        ..., 0
    ]
    radii = np.linalg.norm(middles - corners[:, 0], axis=1)
    _, first, vertex = np.unique(np.rint(1e6 * middles), axis=0, return_index=True, return_inverse=True)
    faces = []
    for tile in np.flatnonzero(np.linalg.norm(centres, axis=1) <= reach):
        around = np.unique(vertex.ravel()[(triangulation.simplices == tile).any(axis=1)])
        spokes = middles[first[around]] - centres[tile]
        faces.append(around[np.argsort(np.arctan2(spokes[:, 1], spokes[:, 0]))])
    used, numbers = np.unique(np.concatenate(faces), return_inverse=True)
    assert radii[first[used]].max() < LARGEST_TILE
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    plan, across = scale * middles[first[used]] @ rotation, scale * np.sqrt(radii[first[used]] ** 2 - 0.25)
    lifted = poles(*circle_planes(plan, across)) * [1, 1, -1]
    return Mesh.from_faces(lifted, np.split(numbers, np.cumsum([len(face) for face in faces])[:-1]))
