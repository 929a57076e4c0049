"""Exact meshes and their known properties. Faces run counter-clockwise seen from outside.

The Platonic solids are found here too; the Archimedean ones are in `geometry.mesh.solids`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.errors import MeshError
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh
from geometry.mesh.polygons import face_centroids
from geometry.mesh.solids import cube, dodecahedron, icosahedron, octahedron, tetrahedron

__all__ = [
    "box",
    "cap",
    "catenoid",
    "cube",
    "dodecahedron",
    "dome",
    "double_ring",
    "grid",
    "hexagonal_paraboloid",
    "icosahedron",
    "octahedron",
    "regular_prism",
    "rotational_mesh",
    "tetrahedron",
    "torus",
    "translation_surface",
]


def grid(nx: int, ny: int) -> Mesh:
    """A disc of nx by ny unit squares in the plane z = 0, normal +z; vertex (i, j) has number i (ny + 1) + j.

    >>> from geometry.mesh import shapes
    >>> shapes.grid(3, 2)
    Mesh(12 vertices, 6 faces, 17 edges)
    >>> shapes.grid(3, 2).vertices[4].tolist()
    [1.0, 1.0, 0.0]
    """
    x, y = np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0), indexing="ij")
    return Mesh.from_grid(np.stack([x, y, np.zeros_like(x)], axis=2))


def translation_surface(first: Any, second: Any) -> Mesh:
    """The sums p_i + q_j of two polylines (m, 3) and (n, 3): a disc of exact parallelograms, hence planar.

    Vertex (i, j) has number i n + j. Seen from outside, the second polyline is to the left of the first.

    >>> from geometry.mesh import shapes
    >>> shapes.translation_surface([[0, 0, 0], [1, 0, 1], [2, 0, 0]], [[0, 0, 0], [0, 1, -1], [0, 3, -1]])
    Mesh(9 vertices, 4 faces, 12 edges)
    >>> shapes.translation_surface([[0, 0, 0], [1, 0, 1]], [[0, 0, 0], [0, 1, -1]]).vertices.tolist()
    [[0.0, 0.0, 0.0], [0.0, 1.0, -1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]]
    """
    p, q = floats(first), floats(second)
    return Mesh.from_grid(p[:, None, :] + q[None, :, :])


def rotational_mesh(profile: Any, n: int, *, closed: bool = True) -> Mesh:
    """A profile (m, 2) of radii and heights, turned n times about the z axis: isosceles trapezoids.

    Planar, circular and conical. Vertex (i, j) has number i m + j: meridian i, point j of the profile. With `closed`
    the n meridians are 2 pi / n apart all around, which makes an annulus; otherwise they are evenly spread over half a
    turn, which makes a disc. For a profile that runs upwards the normals point away from the axis.

    Raises MeshError where a radius is not positive or n is less than 3 (closed) or 2.

    >>> from geometry.mesh import shapes
    >>> shapes.rotational_mesh([(4, 0), (5, 1), (5, 2)], 12)
    Mesh(36 vertices, 24 faces, 60 edges)
    >>> shapes.rotational_mesh([(4, 0), (5, 1), (5, 2)], 12, closed=False)
    Mesh(36 vertices, 22 faces, 57 edges)
    """
    return Mesh.from_grid(_turned(profile, n, closed=closed), closed=(closed, False))


def torus(profile: Any, n: int) -> Mesh:
    """A closed profile (m, 2) of radii and heights, turned n times about the z axis: genus 1.

    Planar, circular and conical; numbered as `rotational_mesh`. For a profile that runs counter-clockwise, with radii
    to the right and heights upwards, the normals point outwards. Do not repeat the first point at the end.

    Raises MeshError where a radius is not positive or n is less than 3.

    >>> from geometry.mesh import shapes
    >>> shapes.torus([(3, -1), (5, -1), (5, 1), (3, 1)], 12)
    Mesh(48 vertices, 48 faces, 96 edges)
    >>> shapes.torus([(3, -1), (5, -1), (5, 1), (3, 1)], 12).combinatorics.euler_characteristic
    0
    """
    return Mesh.from_grid(_turned(profile, n, closed=True), closed=(True, True))


def dome(n: int, rings: int) -> Mesh:
    """A rotational mesh inscribed in the unit sphere, from 10 to 80 degrees of latitude, open at the top.

    An annulus of n x rings planar trapezoids; all vertices at distance 1 from the origin, so it is its own Gauss
    image of the vertex type: circular.

    >>> from geometry.mesh import shapes
    >>> shapes.dome(16, 5)
    Mesh(96 vertices, 80 faces, 176 edges)
    >>> len(shapes.dome(16, 5).combinatorics.boundary_loops)
    2
    """
    latitudes = np.radians(np.linspace(10.0, 80.0, rings + 1))
    return rotational_mesh(np.stack([np.cos(latitudes), np.sin(latitudes)], axis=1), n)


def catenoid(n: int, rings: int) -> Mesh:
    """A discrete minimal surface of negative curvature: an annulus of n x rings planar, circular, conical trapezoids.

    Its Gauss image of the vertex type is the rotational mesh with the radii cos t and heights -sin t, for t from -60
    to 60 degrees in equal steps [Pottmann2007, Fig. 17]; the meridians reverse their orientation. Ring j has
    the radius 1 / cos t_j. The faces between rings j and j + 1 have H = 0 and K = -(cos t_j cos t_{j+1})^2.

    >>> from geometry.mesh import shapes
    >>> shapes.catenoid(12, 4)
    Mesh(60 vertices, 48 faces, 108 edges)
    """
    latitudes = np.radians(np.linspace(-60.0, 60.0, rings + 1))
    radii, heights = 1 / np.cos(latitudes), np.sin(latitudes)
    rises = np.diff(heights) * radii[1:] * radii[:-1]
    profile = np.stack([radii, np.concatenate([[0.0], np.cumsum(rises)]) - rises.sum() / 2], axis=1)
    return rotational_mesh(profile, n)


def hexagonal_paraboloid(nx: int, ny: int) -> Mesh:
    """A disc of nx by ny planar hexagons that touch the paraboloid z = (x^2 + y^2) / 2 at their centres.

    Seen from above, regular hexagons of edge 1; interior vertices have valence 3, so it is conical. All vertices lie
    on the paraboloid that is lower by 1/2. Odd rows are shifted by half a hexagon; the plan is centred at the
    origin.

    >>> from geometry.mesh import shapes
    >>> shapes.hexagonal_paraboloid(3, 2)
    Mesh(22 vertices, 6 faces, 27 edges)
    >>> bool(shapes.hexagonal_paraboloid(3, 2).planarity.max() < 1e-12)
    True
    """
    j, i = np.divmod(np.arange(nx * ny), nx)
    angles = np.pi / 6 + np.pi / 3 * np.arange(6)
    # in halves of the width sqrt(3) and of the edge 1, corners are integers: equal ones are found exactly
    centres = np.stack([2 * i + j % 2 + 1, 3 * j + 2], axis=1)
    around = np.rint(np.stack([2 * np.cos(angles) / 3**0.5, 2 * np.sin(angles)], axis=1)).astype(np.int64)
    places, corners = np.unique((centres[:, None] + around).reshape(-1, 2), axis=0, return_inverse=True)
    plan = (places - places.max(axis=0) / 2) * np.array([3**0.5 / 2, 0.5])  # the least places are 0
    vertices = np.insert(plan, 2, (np.square(plan).sum(axis=1) - 1) / 2, axis=1)
    return Mesh(vertices, Combinatorics(len(plan), corners.ravel(), np.arange(0, corners.size + 1, 6)))


def regular_prism(n: int) -> Mesh:
    """A closed prism over a regular n-gon with vertices on the circle of radius 1, from z = -1 to z = 1.

    Simple (all vertices have valence 3), circular and conical; volume n sin(2 pi / n).

    >>> from geometry.mesh import shapes
    >>> shapes.regular_prism(6)
    Mesh(12 vertices, 8 faces, 18 edges)
    >>> [len(face) for face in shapes.regular_prism(6).faces]
    [4, 4, 4, 4, 4, 4, 6, 6]
    """
    angles = 2 * np.pi / n * np.arange(n)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    vertices = np.concatenate([np.insert(ring, 2, -1.0, axis=1), np.insert(ring, 2, 1.0, axis=1)])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return Mesh.from_faces(vertices, [*sides, list(range(n))[::-1], list(range(n, 2 * n))])


def box(length: float, width: float, height: float) -> Mesh:
    """A closed box about the origin with edges along x, y, z: 8 vertices, 6 rectangles; circular and conical.

    >>> from geometry.mesh import shapes
    >>> shapes.box(3, 2, 1)
    Mesh(8 vertices, 6 faces, 12 edges)
    >>> shapes.box(3, 2, 1).vertices.max(axis=0).tolist()
    [1.5, 1.0, 0.5]
    """
    return cube().with_vertices(cube().vertices * (np.array([length, width, height]) / 2))


def double_ring() -> Mesh:
    """A closed mesh of genus 2: 28 planar quads and 26 vertices of valence 4, or 6 where three ridges meet.

    It is a figure of eight made of bars. Each bar is a roof of slope 1 above the plane z = 0, 1 wide and 1/2 high, and
    its mirror image below. Since all faces have the same slope it is conical; faces with a common edge are never
    coplanar.

    >>> from geometry.mesh import shapes
    >>> shapes.double_ring()
    Mesh(26 vertices, 28 faces, 56 edges)
    >>> shapes.double_ring().combinatorics.euler_characteristic
    -2
    """
    outline = [(0.0, 2.0), (-3.0, 1.0), (-3.0, -1.0), (0.0, -2.0), (3.0, -1.0), (3.0, 1.0)]
    ridges = np.array(outline)
    left, right = ridges[:4], ridges[[3, 4, 5, 0]]
    foot = np.concatenate([_moved_inwards(ridges, -0.5), _moved_inwards(left, 0.5), _moved_inwards(right, 0.5)])
    top, bottom = (np.insert(ridges, 2, height, axis=1) for height in (0.5, -0.5))
    ridge_of_foot = np.array([0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 3, 4, 5, 0])
    faces = []
    for loop, side in ((range(6), 1), (range(6, 10), -1), (range(10, 14), -1)):
        for a, b in zip(loop, [*loop[1:], loop[0]], strict=True):
            above = [a, b, 14 + ridge_of_foot[b], 14 + ridge_of_foot[a]][::side]
            below = [b, a, 20 + ridge_of_foot[a], 20 + ridge_of_foot[b]][::side]
            faces += [above, below]
    return Mesh.from_faces(np.concatenate([np.insert(foot, 2, 0.0, axis=1), top, bottom]), faces)


def cap(mesh: Mesh, height: float) -> Mesh:
    """The faces of a mesh whose centroids are higher than `height`, with the vertices they need.

    Of a convex solid: a disc; of `rhombicosidodecahedron` it has triangles, squares and pentagons.
    Raises MeshError where no face is higher.

    >>> from geometry.mesh import shapes, solids
    >>> shapes.cap(solids.rhombicosidodecahedron(), 2.5)
    Mesh(16 vertices, 9 faces, 24 edges)
    """
    return mesh.part(np.flatnonzero(face_centroids(mesh.vertices, mesh.combinatorics)[:, 2] > height))


# --- parts of the above


def _turned(profile: Any, n: int, *, closed: bool) -> FloatArray:
    """(n, m, 3) the points of a profile (m, 2) in n half-planes through the z axis, around or over half a turn."""
    radii, heights = floats(profile).T
    if n < 2 + closed or not (radii > 0).all():
        raise MeshError(f"a rotational mesh needs positive radii and at least {2 + closed} meridians, not {n}")
    angles = np.arange(n) * (2 * np.pi / n if closed else np.pi / (n - 1))
    rings = [radii * np.cos(angles)[:, None], radii * np.sin(angles)[:, None], np.tile(heights, (n, 1))]
    return np.stack(rings, axis=2)


def _moved_inwards(polygon: FloatArray, distance: float) -> FloatArray:
    """(k, 2) the polygon (k, 2), counter-clockwise, with all its edges moved to the left by a distance."""
    along = np.roll(polygon, -1, axis=0) - polygon
    left = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    both = left + np.roll(left, 1, axis=0)
    moved: FloatArray = polygon + 2 * distance * both / np.square(both).sum(axis=1, keepdims=True)
    return moved
