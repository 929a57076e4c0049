"""Areas and planes of the faces of a mesh, all faces at once.

A vector area points to the side from which its face runs counter-clockwise.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh.combinatorics import Combinatorics

__all__ = [
    "best_planes",
    "face_centroids",
    "face_mean_edge_lengths",
    "face_sums",
    "mixed_areas",
    "perpendicular_pair",
    "vector_areas",
]


def face_sums(combinatorics: Combinatorics, per_corner: FloatArray) -> FloatArray:
    """(F, ...) sum over the corners of each face of values (C, ...)."""
    return np.add.reduceat(per_corner, combinatorics.face_starts[:-1], axis=0)


def face_centroids(vertices: FloatArray, combinatorics: Combinatorics) -> FloatArray:
    """(F, 3) mean of the corners of each face."""
    return face_sums(combinatorics, vertices[combinatorics.corners]) / combinatorics.face_sizes[:, None]


def vector_areas(vertices: FloatArray, combinatorics: Combinatorics) -> FloatArray:
    """(F, 3) half the sum of p_i x p_{i+1} around each face; its length is the area of a planar face."""
    centres = face_centroids(vertices, combinatorics)
    here = vertices[combinatorics.corners] - centres[combinatorics.corner_face]
    return face_sums(combinatorics, np.cross(here, here[combinatorics.next_corner])) / 2


def mixed_areas(
    vertices_p: FloatArray, vertices_q: FloatArray, combinatorics: Combinatorics, normals: FloatArray
) -> FloatArray:
    """(F,) mixed area of the faces P of one mesh and the parallel faces Q of another [Pottmann2007, (4)].

    vertices_p, vertices_q (N, 3): the two meshes; normals (F, 3): unit normals of the planes of the faces, from which
    areas of counter-clockwise faces are positive. Symmetric and bilinear in P and Q, unchanged when faces are
    translated; with Q = P the signed area.
    """
    corners, faces = combinatorics.corners, combinatorics.corner_face
    # relative to the centroids, since products of coordinates far from the origin lose digits
    p = vertices_p[corners] - face_centroids(vertices_p, combinatorics)[faces]
    q = vertices_q[corners] - face_centroids(vertices_q, combinatorics)[faces]
    following = combinatorics.next_corner
    crossed = np.cross(p, q[following]) + np.cross(q, p[following])
    return np.asarray(np.einsum("fk,fk->f", face_sums(combinatorics, crossed), normals) / 4)


def best_planes(vertices: FloatArray, combinatorics: Combinatorics) -> tuple[FloatArray, FloatArray]:
    """Unit normals (F, 3) of the planes with the least squared distance to the corners, and the largest distance (F,).

    Normals point to the side of the vector area. A face whose corners lie on a line has no best plane; any
    plane through the line is returned for it.
    """
    local = vertices - vertices.mean(axis=0)  # sums of coordinates far from the origin lose digits
    faces = combinatorics.corner_face
    here = local[combinatorics.corners] - face_centroids(local, combinatorics)[faces]
    normals = np.linalg.eigh(face_sums(combinatorics, here[:, :, None] * here[:, None, :]))[1][:, :, 0]
    areas = face_sums(combinatorics, np.cross(here, here[combinatorics.next_corner]))
    normals[np.einsum("fk,fk->f", normals, areas) < 0] *= -1
    distances = np.abs(np.einsum("ck,ck->c", here, normals[faces]))
    return normals, np.maximum.reduceat(distances, combinatorics.face_starts[:-1])


def face_mean_edge_lengths(vertices: FloatArray, combinatorics: Combinatorics) -> FloatArray:
    """(F,) mean edge length of each face."""
    ends = vertices[combinatorics.corners]
    lengths = np.linalg.norm(ends[combinatorics.next_corner] - ends, axis=1)
    return face_sums(combinatorics, lengths) / combinatorics.face_sizes


def perpendicular_pair(directions: FloatArray) -> FloatArray:
    """(n, 2, 3) two unit vectors perpendicular to each unit direction (n, 3) and to each other."""
    smallest = np.eye(3)[np.abs(directions).argmin(axis=1)]
    first = np.cross(directions, smallest)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=1)
