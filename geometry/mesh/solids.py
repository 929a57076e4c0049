"""The Platonic and the Archimedean solids about the origin, in closed form.

The docstring of each gives its edge length and its mid-radius, the radius of the sphere that touches all edges: divided
by it, the solid is a Koebe polyhedron. All are circular; those with three faces at each vertex are conical too.
g is the golden ratio (1 + sqrt(5)) / 2.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

from geometry.arrays import FloatArray
from geometry.mesh.mesh import Mesh

__all__ = [
    "cube",
    "cuboctahedron",
    "dodecahedron",
    "icosahedron",
    "icosidodecahedron",
    "octahedron",
    "rhombicosidodecahedron",
    "rhombicuboctahedron",
    "snub_cube",
    "snub_dodecahedron",
    "tetrahedron",
    "truncated_cube",
    "truncated_cuboctahedron",
    "truncated_dodecahedron",
    "truncated_icosahedron",
    "truncated_icosidodecahedron",
    "truncated_octahedron",
    "truncated_tetrahedron",
]

_G = (1 + 5**0.5) / 2
"""The golden ratio, g in the docstrings: the positive root of g^2 = g + 1."""

_ROOT = 2**0.5
"""The square root of 2."""

# --- Platonic


def tetrahedron() -> Mesh:
    """Vertices (+-1, +-1, +-1) with an even number of minus signs; edge 2 sqrt(2), mid-radius 1, volume 8/3.

    >>> from geometry.mesh.solids import tetrahedron
    >>> tetrahedron()
    Mesh(4 vertices, 4 faces, 6 edges)
    """
    return _convex(_signed((1.0, 1.0, 1.0), product_of_signs=1))


def cube() -> Mesh:
    """Vertices (+-1, +-1, +-1); edge 2, in-radius 1, mid-radius sqrt(2), volume 8.

    >>> from geometry.mesh.solids import cube
    >>> cube()
    Mesh(8 vertices, 6 faces, 12 edges)
    """
    return _convex(_signed((1.0, 1.0, 1.0)))


def octahedron() -> Mesh:
    """Vertices +-e_k; edge sqrt(2), mid-radius 1/sqrt(2), volume 4/3.

    >>> from geometry.mesh.solids import octahedron
    >>> octahedron()
    Mesh(6 vertices, 8 faces, 12 edges)
    """
    return _convex(_cyclic(_signed((1.0, 0.0, 0.0))))


def icosahedron() -> Mesh:
    """Vertices (0, +-1, +-g) and cyclically; edge 2, mid-radius g, volume (10/3) (3 + sqrt(5)).

    >>> from geometry.mesh.solids import icosahedron
    >>> icosahedron()
    Mesh(12 vertices, 20 faces, 30 edges)
    """
    return _convex(_cyclic(_signed((0.0, 1.0, _G))))


def dodecahedron() -> Mesh:
    """Vertices (+-1, +-1, +-1), (0, +-g, +-1/g) and cyclically; edge 2/g, mid-radius g.

    >>> from geometry.mesh.solids import dodecahedron
    >>> dodecahedron()
    Mesh(20 vertices, 12 faces, 30 edges)
    """
    return _convex(_cyclic(_signed((1.0, 1.0, 1.0), (0.0, _G, 1 / _G))))


# --- Archimedean


def truncated_tetrahedron() -> Mesh:
    """4 triangles, 4 hexagons; edge 2 sqrt(2), mid-radius 3.

    >>> from geometry.mesh.solids import truncated_tetrahedron
    >>> truncated_tetrahedron()
    Mesh(12 vertices, 8 faces, 18 edges)
    """
    return _convex(_cyclic(_signed((3.0, 1.0, 1.0), product_of_signs=1)))


def cuboctahedron() -> Mesh:
    """8 triangles, 6 squares; edge sqrt(2), mid-radius sqrt(3/2).

    >>> from geometry.mesh.solids import cuboctahedron
    >>> cuboctahedron()
    Mesh(12 vertices, 14 faces, 24 edges)
    """
    return _convex(_cyclic(_signed((1.0, 1.0, 0.0))))


def truncated_cube() -> Mesh:
    """8 triangles, 6 octagons; edge 2 (sqrt(2) - 1), mid-radius sqrt(2).

    >>> from geometry.mesh.solids import truncated_cube
    >>> truncated_cube()
    Mesh(24 vertices, 14 faces, 36 edges)
    """
    return _convex(_cyclic(_signed((_ROOT - 1, 1.0, 1.0))))


def truncated_octahedron() -> Mesh:
    """6 squares, 8 hexagons; edge sqrt(2), mid-radius 3 / sqrt(2).

    >>> from geometry.mesh.solids import truncated_octahedron
    >>> truncated_octahedron()
    Mesh(24 vertices, 14 faces, 36 edges)
    """
    return _convex(_permuted(_signed((0.0, 1.0, 2.0))))


def rhombicuboctahedron() -> Mesh:
    """8 triangles, 18 squares; edge 2, mid-radius sqrt(4 + 2 sqrt(2)).

    >>> from geometry.mesh.solids import rhombicuboctahedron
    >>> rhombicuboctahedron()
    Mesh(24 vertices, 26 faces, 48 edges)
    """
    return _convex(_cyclic(_signed((1.0, 1.0, 1 + _ROOT))))


def truncated_cuboctahedron() -> Mesh:
    """12 squares, 8 hexagons, 6 octagons; edge 2, mid-radius sqrt(12 + 6 sqrt(2)).

    >>> from geometry.mesh.solids import truncated_cuboctahedron
    >>> truncated_cuboctahedron()
    Mesh(48 vertices, 26 faces, 72 edges)
    """
    return _convex(_permuted(_signed((1.0, 1 + _ROOT, 1 + 2 * _ROOT))))


def snub_cube() -> Mesh:
    """32 triangles, 6 squares, no mirror; edge a = sqrt(2 + 4 t - 2 t^2), mid-radius a / (2 sqrt(2 - t)).

    t = 1.839286755214161, the tribonacci constant: t^3 = t^2 + t + 1.

    >>> from geometry.mesh.solids import snub_cube
    >>> snub_cube()
    Mesh(24 vertices, 38 faces, 60 edges)
    """
    t = (1 + (19 - 3 * 33**0.5) ** (1 / 3) + (19 + 3 * 33**0.5) ** (1 / 3)) / 3
    point = (1.0, 1 / t, t)
    even, odd = _signed(point, product_of_signs=-1), _signed(point[::-1], product_of_signs=1)
    return _convex(_cyclic(np.concatenate([even, odd])))


def icosidodecahedron() -> Mesh:
    """20 triangles, 12 pentagons; edge 2, mid-radius sqrt(5 + 2 sqrt(5)).

    >>> from geometry.mesh.solids import icosidodecahedron
    >>> icosidodecahedron()
    Mesh(30 vertices, 32 faces, 60 edges)
    """
    return _convex(_cyclic(_signed((0.0, 0.0, 2 * _G), (1.0, _G, _G**2))))


def truncated_dodecahedron() -> Mesh:
    """20 triangles, 12 decagons; edge 2/g, mid-radius g + 2.

    >>> from geometry.mesh.solids import truncated_dodecahedron
    >>> truncated_dodecahedron()
    Mesh(60 vertices, 32 faces, 90 edges)
    """
    points = _signed((0.0, 1 / _G, 2 + _G), (1 / _G, _G, 2 * _G), (_G, 2.0, _G + 1))
    return _convex(_cyclic(points))


def truncated_icosahedron() -> Mesh:
    """12 pentagons, 20 hexagons: the football; edge 2, mid-radius 3 g.

    >>> from geometry.mesh.solids import truncated_icosahedron
    >>> truncated_icosahedron()
    Mesh(60 vertices, 32 faces, 90 edges)
    """
    return _convex(_cyclic(_signed((0.0, 1.0, 3 * _G), (1.0, 2 + _G, 2 * _G), (_G, 2.0, 2 * _G + 1))))


def rhombicosidodecahedron() -> Mesh:
    """20 triangles, 30 squares, 12 pentagons; edge 2, mid-radius sqrt(10 + 4 sqrt(5)).

    >>> from geometry.mesh.solids import rhombicosidodecahedron
    >>> rhombicosidodecahedron()
    Mesh(60 vertices, 62 faces, 120 edges)
    """
    return _convex(_cyclic(_signed((1.0, 1.0, _G**3), (_G**2, _G, 2 * _G), (2 + _G, 0.0, _G**2))))


def truncated_icosidodecahedron() -> Mesh:
    """30 squares, 20 hexagons, 12 decagons; edge 2/g, mid-radius sqrt(30 + 12 sqrt(5)) / g.

    >>> from geometry.mesh.solids import truncated_icosidodecahedron
    >>> truncated_icosidodecahedron()
    Mesh(120 vertices, 62 faces, 180 edges)
    """
    points = _signed(
        (1 / _G, 1 / _G, 3 + _G),
        (2 / _G, _G, 1 + 2 * _G),
        (1 / _G, _G**2, 3 * _G - 1),
        (2 * _G - 1, 2.0, 2 + _G),
        (_G, 3.0, 2 * _G),
    )
    return _convex(_cyclic(points))


def snub_dodecahedron() -> Mesh:
    """80 triangles, 12 pentagons, no mirror; edge a = 6.04373808413276, mid-radius a / (2 sqrt(1 - x)).

    x = 0.943151259243882 is the real root of x^3 + 2 x^2 = g^2.

    >>> from geometry.mesh.solids import snub_dodecahedron
    >>> snub_dodecahedron()
    Mesh(60 vertices, 92 faces, 150 edges)
    """
    root = (_G / 2 + (_G - 5 / 27) ** 0.5 / 2) ** (1 / 3) + (_G / 2 - (_G - 5 / 27) ** 0.5 / 2) ** (1 / 3)
    a, b = root - 1 / root, root * _G + _G**2 + _G / root  # root^3 - 2 root = g
    points = _signed(
        (2 * a, 2.0, 2 * b),
        (a + b / _G + _G, -a * _G + b + 1 / _G, a / _G + b * _G - 1),
        (-a / _G + b * _G + 1, -a + b / _G - _G, a * _G + b - 1 / _G),
        (-a / _G + b * _G - 1, a - b / _G - _G, a * _G + b + 1 / _G),
        (a + b / _G - _G, a * _G - b + 1 / _G, a / _G + b * _G + 1),
        product_of_signs=-1,
    )
    return _convex(_cyclic(points))


# --- points


def _signed(*points: tuple[float, float, float], product_of_signs: int | None = None) -> FloatArray:
    """(n, 3) the points with their coordinates times +-1, with all signs or only those with a given product."""
    signs = np.array([s for s in product((-1.0, 1.0), repeat=3) if product_of_signs in (None, np.prod(s))])
    signed: FloatArray = (signs[:, None, :] * np.array(points)).reshape(-1, 3) + 0.0  # no negative zeros
    return signed


def _cyclic(points: FloatArray) -> FloatArray:
    """(3n, 3) the points with their coordinates in the three cyclic orders."""
    return np.concatenate([np.roll(points, shift, axis=1) for shift in range(3)])


def _permuted(points: FloatArray) -> FloatArray:
    """(6n, 3) the points with their coordinates in every order."""
    return _cyclic(np.concatenate([points, points[:, ::-1]]))


def _convex(points: FloatArray) -> Mesh:
    """The convex polyhedron with these vertices, which may be given more than once."""
    vertices = points[np.sort(np.unique(points, axis=0, return_index=True)[1])]
    planes = ConvexHull(vertices).equations  # one for each triangle of the triangulated hull
    below = vertices @ planes[:, :3].T + planes[:, 3]
    faces = []
    for on_face in np.unique(
        below.T > -1e-9, axis=0
    ):  # a tolerance for rounding; other vertices are lower by at least 0.05
        face = np.flatnonzero(on_face)
        spokes = vertices[face] - vertices[face].mean(axis=0)
        outwards = vertices[face].mean(axis=0)
        angles = np.arctan2(np.cross(spokes[0], spokes) @ outwards / np.linalg.norm(outwards), spokes @ spokes[0])
        faces.append(face[np.argsort(angles % (2 * np.pi))].tolist())
    return Mesh.from_faces(vertices, faces)
