"""Points of a smooth surface through the vertices of triangles: curved point-normal triangles."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Combinatorics, Mesh
from geometry.surface.surface import Surface

__all__ = ["on_curved_triangles", "refined"]


def on_curved_triangles(mesh: Mesh, normals: FloatArray, triangles: IntArray, weights: FloatArray) -> FloatArray:
    """(n, 3) points at barycentric coordinates (n, 3) in triangles (n,) of a mesh with unit normals (N, 3).

    The cubic triangles of [Vlachos2001]: they are continuous across edges. For edges of length h on a smooth surface of
    curvature k, their error is of the order h^4, while flat triangles are off by k h^2 / 8.

    >>> import numpy as np
    >>> from geometry.mesh import solids
    >>> from geometry.surface import on_curved_triangles
    >>> ball = solids.icosahedron() * (1 / np.linalg.norm(solids.icosahedron().vertices[0]))
    >>> centre = on_curved_triangles(ball, ball.vertices, np.array([0]), np.full((1, 3), 1 / 3))
    >>> np.linalg.norm(centre).round(3).item()  # on a sphere of radius 1; in the flat triangle it is at 0.795
    0.941
    """
    corners = mesh.combinatorics.corners.reshape(-1, 3)[triangles]
    p, n = mesh.vertices[corners], normals[corners]
    w = weights[:, :, None]
    following = np.roll(p, -1, axis=1)
    across = following - p  # from corner k to k + 1
    ahead = np.einsum("nki,nki->nk", across, n)[:, :, None] * n
    back = np.einsum("nki,nki->nk", across, np.roll(n, -1, axis=1))[:, :, None] * np.roll(n, -1, axis=1)
    near = (2 * p + following - ahead) / 3
    far = (2 * following + p + back) / 3
    middle = (near.sum(axis=1) + far.sum(axis=1)) / 4 - p.sum(axis=1) / 6
    w_next = np.roll(w, -1, axis=1)
    edges = 3 * (w**2 * w_next * near + w * w_next**2 * far)
    return np.asarray((w**3 * p + edges).sum(axis=1) + 6 * w.prod(axis=1) * middle)


def refined(surface: Surface, pieces: int = 3) -> Surface:
    """The surface of the curved triangles, each edge divided into a number of pieces; an exact surface is returned as
    it is.

    >>> from geometry import Surface, refined
    >>> from geometry.mesh import solids
    >>> refined(Surface(solids.icosahedron()), 3)
    Surface(92 vertices, 180 faces, 270 edges)
    """
    if surface.is_exact:
        return surface
    mesh = surface.triangulated
    c, k = mesh.combinatorics, pieces
    steps = np.array([(k - i - j, i, j) for i in range(k + 1) for j in range(k + 1 - i)])
    numbers = np.empty((c.n_faces, len(steps)), dtype=np.int64)
    for number, step in enumerate(steps):
        ends = np.flatnonzero(step)
        if len(ends) == 1:
            numbers[:, number] = c.corners[3 * np.arange(c.n_faces) + ends[0]]
        elif len(ends) == 2:
            # the corner at the beginning of the side that contains the point
            corner = 3 * np.arange(c.n_faces) + np.flatnonzero(np.roll(step, 1) == 0)[0]
            step_along_edge = step[(corner[0] + 1) % 3]
            step_along_edge = np.where(c.runs_along_edge[corner], step_along_edge, k - step_along_edge)
            numbers[:, number] = c.n_vertices + c.corner_edge[corner] * (k - 1) + step_along_edge - 1
        else:
            inner = (steps[:number] > 0).all(axis=1).sum()
            n_inner = (k - 1) * (k - 2) // 2
            numbers[:, number] = c.n_vertices + c.n_edges * (k - 1) + np.arange(c.n_faces) * n_inner + inner
    number_of = {tuple(step): number for number, step in enumerate(steps.tolist())}
    cut = []
    for a, i, j in steps.tolist():
        if a > 0:
            cut.append([number_of[a, i, j], number_of[a - 1, i + 1, j], number_of[a - 1, i, j + 1]])
        if a > 1:
            cut.append([number_of[a - 1, i + 1, j], number_of[a - 2, i + 1, j + 1], number_of[a - 1, i, j + 1]])
    weights = np.tile(steps / k, (c.n_faces, 1))
    points = on_curved_triangles(mesh, mesh.vertex_normals, np.repeat(np.arange(c.n_faces), len(steps)), weights)
    vertices = np.empty((int(numbers.max()) + 1, 3))
    vertices[numbers.ravel()] = points
    corners = numbers[:, np.array(cut)].ravel()
    return Surface(Mesh(vertices, Combinatorics(len(vertices), corners, 3 * np.arange(len(corners) // 3 + 1))))
