"""Combinatorics of random convex polyhedra: what Steinitz's theorem calls planar, simple, 3-connected graphs."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from geometry.mesh import Combinatorics
from geometry.mesh.tilings import dual

KINDS = ("triangles", "simple", "mixed", "dual of mixed")


def random_polyhedron(rng: np.random.Generator, n: int, kind: str) -> Combinatorics:
    """Of the hull of n random points on a sphere; its dual; this with a third of its faces stellated; its dual."""
    triangles = random_triangulation(rng, n)
    if kind == "triangles":
        return triangles
    simple = dual(triangles)
    if kind == "simple":
        return simple
    mixed = stellated(simple, rng.random(simple.n_faces) < 1 / 3)
    return mixed if kind == "mixed" else dual(mixed)


def random_triangulation(rng: np.random.Generator, n: int) -> Combinatorics:
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inwards = np.einsum("fi,fi->f", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inwards] = faces[inwards, ::-1]
    return Combinatorics(n, faces.ravel(), np.arange(0, faces.size + 1, 3))


def stellated(combinatorics: Combinatorics, chosen: np.ndarray) -> Combinatorics:
    """Each chosen face becomes triangles to a vertex of its own."""
    faces, n = [], combinatorics.n_vertices
    for face, is_chosen in zip(combinatorics.faces, chosen, strict=True):
        if is_chosen:
            faces += [[face[k - 1], face[k], n] for k in range(len(face))]
            n += 1
        else:
            faces.append(face)
    return Combinatorics.from_faces(n, faces)
