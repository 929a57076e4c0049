"""Meshes with planar faces of every topology, and P(M) the paper's way, to judge by."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.mesh import Mesh, shapes

__all__ = ["ANNULUS", "MESHES", "TORUS", "by_equation_2", "meshes", "projected", "together", "without"]


def by_equation_2(mesh: Mesh) -> FloatArray:
    """(3N, d) an orthonormal basis of P(M): the null space of (m_i - m_j) x (s_i - s_j) = 0 [Pottmann2007, (2)]."""
    rows = np.zeros((mesh.n_edges, 3, mesh.n_vertices, 3))
    for edge, (i, j) in enumerate(mesh.combinatorics.edges):
        x, y, z = mesh.vertices[i] - mesh.vertices[j]
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / np.linalg.norm([x, y, z])
        rows[edge, :, i], rows[edge, :, j] = cross, -cross
    matrix = rows.reshape(3 * mesh.n_edges, -1)
    matrix = matrix[:, np.repeat(mesh.combinatorics.is_used, 3)]
    _, values, directions = np.linalg.svd(matrix)
    rank = int((values > 1e-9).sum())  # rounding is at 1e-15, the least others of the meshes here at 1e-4
    basis = np.zeros((3 * mesh.n_vertices, matrix.shape[1] - rank))
    basis[np.repeat(mesh.combinatorics.is_used, 3)] = directions[rank:].T
    return basis


def together(*meshes: Mesh) -> Mesh:
    """The disjoint union."""
    starts = np.cumsum([0, *(mesh.n_vertices for mesh in meshes)])
    faces = [
        [int(v + start) for v in f]
        for mesh, start in zip(meshes, starts, strict=False)
        for f in mesh.combinatorics.faces
    ]
    return Mesh.from_faces(np.concatenate([mesh.vertices for mesh in meshes]), faces)


def without(mesh: Mesh, *faces: int) -> Mesh:
    """With holes; vertices that are left over stay, unused."""
    return Mesh.from_faces(mesh.vertices, [f for k, f in enumerate(mesh.combinatorics.faces) if k not in faces])


def split(mesh: Mesh, *faces: int) -> Mesh:
    """With faces cut into triangles from their first corner."""
    parts = []
    for k, f in enumerate(mesh.combinatorics.faces):
        parts += [[f[0], f[n], f[n + 1]] for n in range(1, len(f) - 1)] if k in faces else [f]
    return Mesh.from_faces(mesh.vertices, parts)


def subdivided(mesh: Mesh, *edges: int) -> Mesh:
    """With a vertex of valence 2 more on some edges, on the straight line."""
    pairs = [mesh.combinatorics.edges[edge].tolist() for edge in edges]
    middle = {frozenset(pair): mesh.n_vertices + k for k, pair in enumerate(pairs)}
    faces = []
    for f in mesh.combinatorics.faces:
        following = [*f[1:], f[0]]
        new = [[v, middle.get(frozenset((v, w)))] for v, w in zip(f, following, strict=True)]
        faces.append([v for pair in new for v in pair if v is not None])
    points = [0.3 * mesh.vertices[i] + 0.7 * mesh.vertices[j] for i, j in pairs]
    return Mesh.from_faces(np.concatenate([mesh.vertices, points]), faces)


def voxels(filled: FloatArray) -> Mesh:
    """The boundary of a solid of unit cubes, filled (nx, ny, nz): many coplanar faces."""
    padded = np.pad(np.asarray(filled, dtype=bool), 1)
    quads = []
    for axis in range(3):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for side in (0, 1):
            outside = np.roll(padded, 1 - 2 * side, axis)
            corner = np.argwhere(padded & ~outside) + side * np.eye(3)[axis]
            ring = [0 * u, u, u + v, v] if side else [0 * u, v, u + v, u]
            quads.append(np.stack([corner + step for step in ring], axis=1))
    points, names = np.unique(np.concatenate(quads).reshape(-1, 3), axis=0, return_inverse=True)
    return Mesh.from_faces(points, names.reshape(-1, 4).tolist())


PLATE = np.ones((5, 3, 1))
PLATE[1, 1], PLATE[3, 1] = 0, 0

ANNULUS = shapes.dome(7, 3)
TORUS = shapes.torus(np.array([[2.0, -1.0], [3.5, -0.5], [3.0, 1.0], [2.2, 0.8]]), 5)
MESHES = {
    "disc": shapes.grid(3, 4),
    "annulus": ANNULUS,
    "several boundaries": without(shapes.grid(5, 5), 6, 8, 18),
    "boundaries on the sphere": without(shapes.dodecahedron(), 0, 3, 7),
    "sphere": shapes.regular_prism(7),
    "torus": TORUS,
    "torus with holes": without(TORUS, 0, 7),
    "genus 2": voxels(PLATE),
    "genus 2, coplanar faces few": shapes.double_ring(),
    "hexagons": shapes.hexagonal_paraboloid(3, 3),
    "triangles": split(ANNULUS, *range(ANNULUS.n_faces)),
    "closed triangles": shapes.icosahedron(),
    "triangles among larger faces": split(ANNULUS, 0, 1, 5, 9, 10, 11),
    "more equations than unknowns": split(shapes.grid(4, 4), *range(13)),
    "triangles on a torus": split(TORUS, *range(TORUS.n_faces - 2)),
    "valence 2 at the boundary": subdivided(shapes.grid(2, 2), 0, 3, 7),
    "valence 2 inside": subdivided(shapes.box(1, 2, 3), 0, 5, 6),
    "a triangle without height": Mesh.from_faces(
        [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0.7, 0, 0]], [[0, 1, 2, 3], [1, 0, 4]]
    ),
    "faces that meet in a vertex": without(shapes.grid(2, 2), 1, 2),
    "a hole closed by a vertex": without(shapes.grid(3, 3), 4, 8),
    "parts": together(shapes.box(1, 1, 1), shapes.grid(2, 3), TORUS),
    "unused vertices": together(without(shapes.grid(2, 2), 3), shapes.tetrahedron()),
}
meshes = st.sampled_from(sorted(MESHES)).map(MESHES.__getitem__)


def projected(mesh: Mesh, seed: int) -> Mesh:
    """A projective image: planar faces stay planar, and straight edges straight; what was parallel no longer is."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    reach = np.linalg.norm(mesh.vertices, axis=1).max()
    away = rng.normal(size=3)
    away *= 0.3 / np.linalg.norm(away) / reach
    return mesh.with_vertices(mesh.vertices @ turn / (1 + mesh.vertices @ away)[:, None])
