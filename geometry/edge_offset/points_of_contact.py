"""Where a surface has given normals, and how high the planes with these normals lie that touch it there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import FloatArray, IntArray, floats
from geometry.errors import GeometryError
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.intersections import meeting_boxes
from geometry.surface import Surface

__all__ = ["touching_points"]

NORMAL_WEIGHT_TOLERANCE = 1e-9
"""Negative barycentric weight up to which a normal still belongs to a triangle, so that there is no gap between two of
them."""


def touching_points(surface: Surface, mesh: Mesh, curvature: int = 0) -> tuple[FloatArray, FloatArray]:
    """Points (F, 3) of a surface with the outer normals of the faces of a mesh, and heights n . x (F,) of the planes.

    NaN where there is none. Of several points, that on the part with most of the normals is taken, see `tangent_mesh`;
    curvature: 1 or -1 to take only those where the surface is curved positively or negatively.
    Raises GeometryError where no face has such a point.
    """
    if curvature not in (-1, 0, 1):
        raise GeometryError(f"the curvature is {curvature}, its sign is needed: -1, 0 or 1", value=curvature)
    found = _candidates(surface, mesh.face_normals, curvature)
    if not len(found.faces):
        raise GeometryError(
            "no face plane can touch the surface: it has no point with the normal of a face"
            + (f" and curvature of the sign {curvature}" if curvature else "")
            + "; turn the mesh, mirror it, or see the surface from the other side (`reversed`)"
        )
    chosen = _continuous(mesh.combinatorics, found)
    points, heights = np.full((mesh.n_faces, 3), np.nan), np.full(mesh.n_faces, np.nan)
    points[found.faces[chosen]], heights[found.faces[chosen]] = found.points[chosen], found.heights[chosen]
    return floats(points), floats(heights)


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Points (k, 3) where the surface has the normals of faces (k,), and the heights (k,) of the planes there.

    parts (k,): the part of the surface they are on, on which the curvature is of one sign.
    """

    faces: IntArray
    points: FloatArray
    heights: FloatArray
    parts: IntArray


def _candidates(surface: Surface, normals: FloatArray, curvature: int) -> _Candidates:
    """Where the normals interpolated over the triangles are those of the faces: sum w_i N_i = n with weights w >= 0."""
    triangles = _triangles(surface.mesh)
    p, N = surface.mesh.vertices[triangles], surface.mesh.vertex_normals[triangles]
    turning = np.einsum("ti,ti->t", N[:, 0], np.cross(N[:, 1], N[:, 2]))  # as the curvature: the sign of the Gauss map
    used = np.flatnonzero(turning * curvature > 0 if curvature else turning != 0)
    chords = np.square(N - N[:, [1, 2, 0]]).sum(axis=2).max(axis=1)
    bulge = chords[used, None] / 3  # |sum l_i N_i|^2 is 1 - sum l_i l_j |N_i - N_j|^2, at least 1 - chord^2 / 3
    faces, hit = meeting_boxes(normals, normals, N[used].min(axis=1) - bulge, N[used].max(axis=1) + bulge)
    hit = used[hit]
    across = np.cross(N[hit][:, [1, 2, 0]], N[hit][:, [2, 0, 1]])
    weights = np.einsum("kci,ki->kc", across, normals[faces]) / turning[hit, None]
    inside = (weights >= -NORMAL_WEIGHT_TOLERANCE).all(axis=1)
    faces, hit, weights = faces[inside], hit[inside], weights[inside]

    # the support function h is linear along rays, has the gradient p_i at N_i and is p_i . N_i there
    n = normals[faces]
    flat = np.einsum("kc,kci->ki", weights / weights.sum(axis=1, keepdims=True), p[hit])
    level = np.einsum("ki,ki->k", flat, n)
    heights = (level + np.einsum("kc,kci,kci->k", weights, p[hit], N[hit])) / 2
    parts = _parts(
        Combinatorics(surface.mesh.n_vertices, triangles.ravel(), 3 * np.arange(len(triangles) + 1)), turning
    )
    return _Candidates(faces, flat + (heights - level)[:, None] * n, heights, parts[hit])


def _triangles(mesh: Mesh) -> IntArray:
    """(T, 3) vertices; larger faces are cut from their first corner."""
    c = mesh.combinatorics
    first = c.face_starts[:-1][c.corner_face]
    corners = np.flatnonzero((first != np.arange(c.n_corners)) & (c.next_corner != first))
    return np.stack([c.corners[first[corners]], c.corners[corners], c.corners[c.next_corner[corners]]], axis=1)


def _parts(triangles: Combinatorics, turning: FloatArray) -> IntArray:
    """(T,) parts of the surface connected by edges over which the sign of the curvature stays."""
    left, right = triangles.edge_faces[~triangles.is_boundary_edge].T
    alike = turning[left] * turning[right] > 0
    pairs = coo_array((np.ones(alike.sum()), (left[alike], right[alike])), shape=(len(turning), len(turning)))
    return np.asarray(connected_components(pairs, directed=False)[1], dtype=np.int64)


def _continuous(combinatorics: Combinatorics, found: _Candidates) -> IntArray:
    """One candidate of each face that has any: those of the largest part, then ever more of those next to them."""
    n = combinatorics.n_faces
    seen = np.unique(np.stack([found.parts, found.faces], axis=1), axis=0)
    preferred = found.parts == np.bincount(seen[:, 0]).argmax()
    covered = np.isin(found.faces, found.faces[preferred])
    eligible = np.flatnonzero(preferred | ~covered)
    faces, points = found.faces[eligible], found.points[eligible]
    left, right = combinatorics.edge_faces[~combinatorics.is_boundary_edge].T
    places = (np.concatenate([left, right]), np.concatenate([right, left]))
    adjacency = csr_array(coo_array((np.ones(2 * len(left)), places), shape=(n, n)))

    choice = np.full(n, -1)  # of the eligible ones
    alone = preferred[eligible] & (np.bincount(faces, minlength=n)[faces] == 1)
    start = np.flatnonzero(alone) if alone.any() else np.flatnonzero(preferred[eligible])[:1]
    choice[faces[start]] = start
    while (undecided := choice[faces] < 0).any():
        decided = choice >= 0
        around = adjacency @ decided.astype(np.float64)
        sums = adjacency @ np.where(decided[:, None], points[choice], 0.0)
        reached = np.flatnonzero(undecided & (around[faces] > 0))
        if not len(reached):  # a part of S for itself
            reached = np.flatnonzero(undecided & (faces == faces[undecided][0]))
        middles = sums[faces[reached]] / np.maximum(around[faces[reached]], 1)[:, None]
        order = np.argsort(-np.linalg.norm(points[reached] - middles, axis=1))
        choice[faces[reached[order]]] = reached[order]  # the nearest one is written last
    return np.asarray(eligible[choice[choice >= 0]])
