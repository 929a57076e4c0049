"""Triangulated surfaces with known principal lines, to lay meshes on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.files import read_mesh
from geometry.mesh import Combinatorics, Mesh, shapes
from geometry.surface import Surface

ROOFS = Path(__file__).parents[2].parent / "shared" / "data" / "directional"


def roof(name: str) -> Surface:
    """A free-form roof in metres, moved near to zero."""
    return Surface(read_mesh(ROOFS / f"{name}.off").mesh.near_zero()[0])


def triangle_mesh(points: FloatArray, triangles: IntArray) -> Mesh:
    return Mesh(points, Combinatorics(len(points), triangles.ravel(), 3 * np.arange(len(triangles) + 1)))


def chart(n: int, m: int, point: Callable[[FloatArray, FloatArray], FloatArray], *, rings: str = "") -> Surface:
    """point(u, v) for u, v in [0, 1], n by m squares cut by diagonals this way and that; rings: "u", "uv" closed."""
    k, j = (n if "u" in rings else n + 1), (m if "v" in rings else m + 1)
    u, v = np.meshgrid(np.arange(k) / n, np.arange(j) / m, indexing="ij")
    i, h = np.indices((n, m)).reshape(2, -1)
    a, b, c, d = (((i + s) % k) * j + (h + t) % j for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)))
    even = ((i + h) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    points = np.stack(point(u.ravel(), v.ravel()), axis=1)
    return Surface(triangle_mesh(points, np.concatenate([first, second])))


def disc(n: int, height: Callable[[FloatArray, FloatArray], FloatArray]) -> Surface:
    """Over the unit disc, in n rings of 6, 12, ... triangles' corners."""
    ring = np.repeat(np.arange(n + 1), np.maximum(6 * np.arange(n + 1), 1))
    starts = np.append(0, np.cumsum(np.maximum(6 * np.arange(n + 1), 1)))
    place = np.arange(len(ring)) - starts[ring]
    angle = 2 * np.pi * place / np.maximum(6 * ring, 1)
    x, y = ring / n * np.cos(angle), ring / n * np.sin(angle)
    k = np.repeat(np.arange(1, n + 1), 6 * np.arange(1, n + 1))
    p = place[1:]
    sector, step = p // k, p % k
    inner = starts[k - 1] + np.where(k > 1, (sector * (k - 1) + step) % np.maximum(6 * (k - 1), 1), 0)
    here, after = starts[k] + p, starts[k] + (p + 1) % (6 * k)
    outwards = np.stack([here, after, inner], axis=1)
    outer = step < k - 1
    next_inner = starts[k - 1] + (sector * (k - 1) + step + 1) % np.maximum(6 * (k - 1), 1)
    inwards = np.stack([after, next_inner, inner], axis=1)[outer]
    return Surface(triangle_mesh(np.stack([x, y, height(x, y)], axis=1), np.concatenate([outwards, inwards])))


def ball(halvings: int, axes: tuple[float, float, float]) -> Surface:
    """An ellipsoid, of an icosahedron whose triangles are cut into four some times."""
    mesh = shapes.icosahedron()
    for _ in range(halvings):
        c = mesh.combinatorics
        middle = c.n_vertices + c.corner_edge.reshape(-1, 3)
        a, b, d = c.corners.reshape(-1, 3).T
        p, q, r = middle.T
        cut = [np.stack(parts, axis=1) for parts in ((a, p, r), (p, b, q), (r, q, d), (p, q, r))]
        points = np.concatenate([mesh.vertices, mesh.vertices[c.edges].sum(axis=1)])
        mesh = triangle_mesh(points / np.linalg.norm(points, axis=1, keepdims=True), np.concatenate(cut))
    return Surface(mesh.with_vertices(mesh.vertices / np.linalg.norm(mesh.vertices[0]) * axes))


def off_conjugate(mesh: Mesh, axes: tuple[float, float, float]) -> FloatArray:
    """|II(u, v)| over the root of II(u, u) II(v, v), 0 for conjugate u and v: the middle lines of quads near an
    ellipsoid whose vertices all have valence 4, inside. II is a multiple of diag(axes)^-2."""
    c = mesh.combinatorics
    regular = ~c.is_boundary_vertex & (c.vertex_degrees == 4)
    quads = c.corners[np.flatnonzero(c.face_sizes[c.corner_face] == 4)].reshape(-1, 4)
    first, second, third, fourth = np.moveaxis(mesh.vertices[quads[regular[quads].all(axis=1)]] / axes, 1, 0)
    u, v = second + third - first - fourth, third + fourth - first - second
    return np.asarray(np.abs((u * v).sum(axis=1)) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1))


def jagged_hole(n: int = 36, m: int = 24) -> Surface:
    """A vault out of which the triangles in a turned rectangle were cut, so that the rim of the hole zigzags."""
    mesh = chart(n, m, lambda u, v: (3 * u, 2 * v, -0.4 * (3 * u - 1.5) ** 2 - 0.3 * (2 * v - 1) ** 2)).mesh
    triangles = mesh.combinatorics.corners.reshape(-1, 3)
    x, y = (mesh.vertices[triangles].mean(axis=1)[:, :2] - [1.5, 1.0]).T
    along, across = np.cos(0.4) * x + np.sin(0.4) * y, np.cos(0.4) * y - np.sin(0.4) * x
    is_cut = (np.abs(along - 0.1) < 0.5) & (np.abs(across) < 0.3)
    used, numbers = np.unique(triangles[~is_cut], return_inverse=True)
    return Surface(triangle_mesh(mesh.vertices[used], numbers.reshape(-1, 3)))


def waves() -> Surface:
    """Bulges and saddles, whose lines of curvature meet parts of the boundary obliquely."""

    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        return 3 * u - 1.5, 2 * v - 1, 0.5 * np.sin(1.7 * (3 * u - 1.5)) * np.sin(1.7 * (2 * v - 1))

    return chart(30, 20, point)


def torus(n: int = 90, m: int = 36) -> Surface:
    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        u, v = 2 * np.pi * u, 2 * np.pi * v
        return (3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)

    return chart(n, m, point, rings="uv")


def cylinder(turn: float = np.pi, *, rings: str = "", n: int = 60, m: int = 40) -> Surface:
    return chart(n, m, lambda u, v: (np.cos(turn * u), np.sin(turn * u), 2.5 * v), rings=rings)


def monkey_saddle(n: int = 32) -> Surface:
    return disc(n, lambda x, y: 0.1 * (x**3 - 3 * x * y**2))


def sphere_cap(n: int = 32) -> Surface:
    return disc(n, lambda x, y: np.sqrt(2 - x**2 - y**2))


def plate(n: int = 36) -> Surface:
    """Flat inside half the radius, and a surface of revolution around."""
    return disc(n, lambda x, y: 3 * np.maximum(np.hypot(x, y) - 0.5, 0) ** 3)


KNOWN: dict[str, tuple[Callable[[], Surface], dict[int, int]]] = {
    "ellipsoid": (lambda: ball(4, (3.0, 2.0, 1.2)), {3: 8}),
    "torus": (torus, {}),
    "monkey saddle": (monkey_saddle, {5: 2}),
    "cylinder": (cylinder, {}),
    "sphere cap": (sphere_cap, {}),
    "plate": (plate, {3: 4}),
}
"""Surfaces, and the valences other than 4 that a mesh along principal lines has inside."""
