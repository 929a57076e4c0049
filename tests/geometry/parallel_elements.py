"""Random meshes M parallel to an S with known offsets."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.gauss.distances import edge_distances, face_distances, vertex_distances
from geometry.gauss.unit_distances import least_squares_parallel
from geometry.mesh import Mesh, solids

SOLIDS = {name: getattr(solids, name)() for name in solids.__all__}
SIMPLE = [name for name, mesh in SOLIDS.items() if (mesh.combinatorics.vertex_degrees == 3).all()]


def boosted(mesh: Mesh, seed: int) -> Mesh:
    """A projective image that maps the unit sphere to itself: points, tangent lines and planes stay what they are."""
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    speed = rng.uniform(0, 0.5)
    gamma = 1 / np.sqrt(1 - speed**2)
    along = mesh.vertices @ direction
    moved = mesh.vertices + np.outer((gamma - 1) * along + gamma * speed, direction)
    return mesh.with_vertices(moved / (gamma * (1 + speed * along))[:, None])


def opened(mesh: Mesh, seed: int) -> Mesh:
    """Without up to three of its faces; what they alone used is kept as vertices without faces."""
    rng = np.random.default_rng(seed)
    left_out = set(rng.choice(mesh.n_faces, size=int(rng.integers(4)), replace=False).tolist())
    faces = [face for k, face in enumerate(mesh.combinatorics.faces) if k not in left_out]
    return Mesh.from_faces(mesh.vertices, faces)


def element(image: Mesh, seed: int, size: float = 3.0, centre: float = 0.0) -> Mesh:
    """A random mesh of P(S): the nearest to random points about `centre` S. Edges of either orientation, none short."""
    rng = np.random.default_rng(seed)
    while True:  # up to some dozen times: one edge of a hundred is short
        points = rng.normal(size=3 * image.n_vertices) * size + centre * image.vertices.ravel()
        mesh = least_squares_parallel(image, csr_array(eye_array(len(points))), points)
        if mesh.edge_lengths.min() > 1e-2 * mesh.mean_edge_length and mesh.planarity.max() < 2e-13:
            return mesh


def solid(name: str, scale: str) -> Mesh:
    """The solid with its vertices, edges or faces at distance 1."""
    mesh = SOLIDS[name]
    sizes = {
        "vertex": vertex_distances(mesh),
        "edge": edge_distances(mesh),
        "face": face_distances(mesh),
    }
    return mesh * (1 / sizes[scale][0])


def tangent_profile(n: int, steps: int, start: float) -> FloatArray:
    """(steps + 1, 2) radii and heights: turned n times, all edges touch the unit sphere.

    Edges along the parallels touch it where (radius cos(pi / n))^2 + height^2 = 1, an ellipse in the meridian plane;
    each edge of the profile is a tangent of the unit circle, from one point of the ellipse to the next.
    """
    metric = np.array([np.cos(np.pi / n) ** 2, 1.0])
    points = [np.array([np.cos(start), np.sin(start)]) / np.sqrt(metric)]
    for _ in range(steps):
        point = points[-1]
        foot = np.arctan2(point[1], point[0]) + np.arccos(1 / np.linalg.norm(point))
        along = np.array([-np.sin(foot), np.cos(foot)])
        points.append(point - 2 * (point @ (metric * along)) / (along @ (metric * along)) * along)
    return np.array(points)
