"""Exact meshes by name, with what is known about each. Faces run counter-clockwise seen from outside."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.errors import MeshError
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh

__all__ = [
    "box",
    "cube",
    "dodecahedron",
    "dome",
    "grid",
    "icosahedron",
    "octahedron",
    "regular_prism",
    "rotational_mesh",
    "tetrahedron",
    "translation_surface",
]


def grid(nx: int, ny: int) -> Mesh:
    """A disc of nx by ny unit squares in the plane z = 0, normal +z; vertex (i, j) has number i (ny + 1) + j."""
    x, y = np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0), indexing="ij")
    return Mesh(np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3), _quads(nx, ny))


def translation_surface(first: Any, second: Any) -> Mesh:
    """The sums p_i + q_j of two polylines (m, 3) and (n, 3): a disc of exact parallelograms, hence planar.

    Vertex (i, j) has number i n + j. Seen from outside, the second polyline is to the left of the first.
    """
    p, q = floats(first), floats(second)
    return Mesh((p[:, None, :] + q[None, :, :]).reshape(-1, 3), _quads(len(p) - 1, len(q) - 1))


def rotational_mesh(profile: Any, n: int, *, closed: bool = True) -> Mesh:
    """A profile (m, 2) of radii and heights, turned n times about the z axis: isosceles trapezoids.

    Planar, circular and conical. Vertex (i, j) has number i m + j: meridian i, point j of the profile. With `closed`
    the meridians stand 2 pi / n apart, all around: an annulus; otherwise the n of them are
    spread evenly over half a turn: a disc. A profile that runs upwards is seen from outside, away from the axis.

    Raises MeshError where a radius is not positive or n is less than 3 (closed) or 2.
    """
    radii, heights = floats(profile).T
    if n < 2 + closed or not (radii > 0).all():
        raise MeshError(f"a rotational mesh needs positive radii and at least {2 + closed} meridians, not {n}")
    angles = np.arange(n) * (2 * np.pi / n if closed else np.pi / (n - 1))
    rings = [radii * np.cos(angles)[:, None], radii * np.sin(angles)[:, None], np.tile(heights, (n, 1))]
    return Mesh(np.stack(rings, axis=2).reshape(-1, 3), _quads(n if closed else n - 1, len(radii) - 1, wrap=closed))


def dome(n: int, rings: int) -> Mesh:
    """A rotational mesh inscribed in the unit sphere, from 10 to 80 degrees of latitude, open at the top.

    An annulus of n x rings planar trapezoids; all vertices at distance 1 from the origin, so it is its own Gauss
    image of the vertex type: circular.
    """
    latitudes = np.radians(np.linspace(10.0, 80.0, rings + 1))
    return rotational_mesh(np.stack([np.cos(latitudes), np.sin(latitudes)], axis=1), n)


def regular_prism(n: int) -> Mesh:
    """A closed prism over a regular n-gon with vertices on the circle of radius 1, from z = -1 to z = 1.

    Simple (all vertices have valence 3), circular and conical; volume n sin(2 pi / n).
    """
    angles = 2 * np.pi / n * np.arange(n)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    vertices = np.concatenate([np.insert(ring, 2, -1.0, axis=1), np.insert(ring, 2, 1.0, axis=1)])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return Mesh.from_faces(vertices, [*sides, list(range(n))[::-1], list(range(n, 2 * n))])


def box(length: float, width: float, height: float) -> Mesh:
    """A closed box about the origin with edges along x, y, z: 8 vertices, 6 rectangles; circular and conical."""
    return cube().with_vertices(cube().vertices * (np.array([length, width, height]) / 2))


# --- Platonic solids about the origin; each says its edge length and the mid-radius, at which it touches all edges


def tetrahedron() -> Mesh:
    """Vertices (+-1, +-1, +-1) with an even number of minus signs; edge 2 sqrt(2), mid-radius 1, volume 8/3."""
    corners = _CUBE[_CUBE.prod(axis=1) > 0]
    return _convex(corners, -corners)


def cube() -> Mesh:
    """Vertices (+-1, +-1, +-1); edge 2, in-radius 1, mid-radius sqrt(2), volume 8."""
    return _convex(_CUBE, _AXES)


def octahedron() -> Mesh:
    """Vertices +-e_k; edge sqrt(2), mid-radius 1/sqrt(2), volume 4/3."""
    return _convex(_AXES, _CUBE)


def icosahedron() -> Mesh:
    """Vertices (0, +-1, +-g) and cyclically, g the golden ratio; edge 2, mid-radius g, volume (10/3) (3 + sqrt(5))."""
    return _convex(_ICOSAHEDRON, _DODECAHEDRON)


def dodecahedron() -> Mesh:
    """Vertices (+-1, +-1, +-1), (0, +-g, +-1/g) and cyclically, g the golden ratio; edge 2/g, mid-radius g."""
    return _convex(_DODECAHEDRON, _ICOSAHEDRON)


def _cyclic(a: float, b: float) -> FloatArray:
    """(12, 3) the points (0, +-a, +-b) and those with their coordinates moved on."""
    points = np.array([(0.0, i * a, j * b) for i, j in product((-1, 1), repeat=2)])
    return np.concatenate([np.roll(points, shift, axis=1) for shift in range(3)])


_GOLDEN = (1 + 5**0.5) / 2
_CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
_AXES = np.concatenate([-np.eye(3), np.eye(3)])
_ICOSAHEDRON = _cyclic(1.0, _GOLDEN)
_DODECAHEDRON = np.concatenate([_CUBE, _cyclic(_GOLDEN, 1 / _GOLDEN)])


def _convex(vertices: FloatArray, normals: FloatArray) -> Mesh:
    """The convex polyhedron with these vertices and outer face normals."""
    faces = []
    for normal in normals:
        heights = vertices @ normal
        face = np.flatnonzero(heights > heights.max() - 1e-9)  # rounding; other vertices are lower by 0.5 and more
        spokes = vertices[face] - vertices[face].mean(axis=0)
        angles = np.arctan2(np.cross(spokes[0], spokes) @ normal / np.linalg.norm(normal), spokes @ spokes[0])
        faces.append(face[np.argsort(angles)].tolist())
    return Mesh.from_faces(vertices, faces)


def _quads(nx: int, ny: int, *, wrap: bool = False) -> Combinatorics:
    """Quads (i, j), (i+1, j), (i+1, j+1), (i, j+1) of vertices numbered i (ny + 1) + j; wrap: i counts modulo nx."""
    n_columns = nx if wrap else nx + 1
    i, j = np.divmod(np.arange(nx * ny), ny)
    here, there = i * (ny + 1) + j, (i + 1) % n_columns * (ny + 1) + j
    corners = np.stack([here, there, there + 1, here + 1], axis=1)
    return Combinatorics(n_columns * (ny + 1), corners.ravel(), np.arange(0, corners.size + 1, 4))
