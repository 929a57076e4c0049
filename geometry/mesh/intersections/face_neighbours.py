"""Pairs of faces with a common vertex that may also share area, without comparing all faces at crowded vertices."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections.box_trees import BoxTree, box_trees, meeting_sets
from geometry.mesh.intersections.flat_faces import CLEARANCE, heights_over
from geometry.mesh.ragged_arrays import rows_by_size

__all__ = ["edge_trees", "face_trees", "local", "margin", "neighbours"]

CROWDED_VERTEX_FACES = 16
"""Largest number of faces at a vertex for which all pairs of them are compared."""


def face_trees(mesh: Mesh) -> list[BoxTree]:
    """Trees of the faces, as polygons in their best planes."""
    c = mesh.combinatorics
    points = mesh.vertices[c.corners]
    points = points - heights_over(mesh, c.corner_face, points)[:, None] * mesh.face_normals[c.corner_face]
    order = np.lexsort((c.corners, -_faces_at_vertices(mesh)[c.corners], c.corner_face))
    at = c.corners[order[c.face_starts[:-1, None] + [0, 1]]]  # the vertices with most faces
    return box_trees(local(mesh, points), c.face_starts, np.full(mesh.n_faces, margin(mesh)), _names(mesh, at))


def edge_trees(mesh: Mesh, edges: IntArray) -> list[BoxTree]:
    """Trees of edges (k,), which are numbered by their positions in this array."""
    ends = mesh.combinatorics.edges[edges]
    points, starts = local(mesh, mesh.vertices[ends.ravel()]), 2 * np.arange(len(edges) + 1)
    return box_trees(points, starts, np.full(len(edges), margin(mesh)), _names(mesh, ends))


def neighbours(mesh: Mesh) -> IntArray:
    """(n, 2) pairs of faces that share a vertex, among them all coplanar pairs that share area; pairs may be repeated.

    At a vertex with few faces these are all pairs; at a crowded one, those whose angles there overlap. Faces that meet
    elsewhere than at a crowded vertex are met by an edge that does not end there, or edges from two crowded vertices
    cross.
    """
    c = mesh.combinatorics
    corner_face_counts = _faces_at_vertices(mesh)[c.corners]
    order = np.argsort(c.corners, kind="stable")
    starts = np.concatenate([[0], np.cumsum(_faces_at_vertices(mesh))])
    found = [
        _overlapping_angles(mesh, np.flatnonzero(corner_face_counts > CROWDED_VERTEX_FACES)),
        _crossing_edges(mesh),
    ]
    for _, places in rows_by_size(starts):
        if 2 <= places.shape[1] <= CROWDED_VERTEX_FACES:
            first, second = np.triu_indices(places.shape[1], 1)
            faces = c.corner_face[order[places]]
            found.append(np.stack([faces[:, first].ravel(), faces[:, second].ravel()], axis=1))
    return np.concatenate(found)


# --- crowded vertices


def _faces_at_vertices(mesh: Mesh) -> IntArray:
    """(N,) number of faces at each vertex."""
    return np.bincount(mesh.combinatorics.corners, minlength=mesh.n_vertices)


def _names(mesh: Mesh, vertices: IntArray) -> IntArray:
    """The vertices where many faces meet, -1 for others."""
    return np.where(_faces_at_vertices(mesh)[vertices] > CROWDED_VERTEX_FACES, vertices, -1)


def _overlapping_angles(mesh: Mesh, corners: IntArray) -> IntArray:
    """(n, 2) faces whose angles overlap at a corner of both, among corners (k,) of faces."""
    if not len(corners):
        return np.zeros((0, 2), dtype=np.int64)
    c = mesh.combinatorics
    here, normals = mesh.vertices[c.corners[corners]], mesh.face_normals[c.corner_face[corners]]
    sides = np.stack([mesh.vertices[c.corners[at[corners]]] - here for at in (c.next_corner, c.previous_corner)])
    lengths = np.maximum(np.linalg.norm(sides, axis=2), np.finfo(np.float64).tiny)
    margins = np.minimum(margin(mesh) / lengths, 2.0)  # the direction of a side as short as the clearance is uncertain
    rays = sides / lengths[:, :, None]
    across = np.cross(normals, rays[0])
    angles = np.arctan2(np.einsum("ki,ki->k", across, rays[1]), np.einsum("ki,ki->k", rays[0], rays[1]))
    angles = np.where(angles < 0, angles + 2 * np.pi, angles)
    # an arc lies within the hull of its ends and the corners of a polygon of tangents around it
    turns = angles[:, None] * (np.arange(4) + 0.5) / 4
    tangents = np.cos(turns)[:, :, None] * rays[0][:, None] + np.sin(turns)[:, :, None] * across[:, None]
    tangents /= np.cos(angles / 8)[:, None, None]
    arcs = np.concatenate([rays[0][:, None], tangents, rays[1][:, None]], axis=1)

    hubs = np.unique(c.corners[corners], return_inverse=True)[1]
    shift = 4.0 * hubs[:, None] * np.eye(3)[0]  # a separate unit sphere for each vertex
    k, nameless = len(corners), np.full((2 * len(corners), 2), -1)
    ends = (rays + shift).reshape(-1, 3)
    one = box_trees(ends, np.arange(2 * k + 1), margins.ravel(), nameless)
    other = box_trees((arcs + shift[:, None]).reshape(-1, 3), 6 * np.arange(k + 1), margins.max(axis=0), nameless[:k])
    faces = c.corner_face[corners]
    found = [np.zeros((0, 2), dtype=np.int64)]
    found += [np.stack([faces[end % k], faces[arc]], axis=1) for end, arc in meeting_sets(one, other)]
    pairs = np.concatenate(found)
    return np.asarray(pairs[pairs[:, 0] != pairs[:, 1]])


def _crossing_edges(mesh: Mesh) -> IntArray:
    """(n, 2) faces at edges that may cross and end at two different vertices with very many faces."""
    c = mesh.combinatorics
    edges = np.flatnonzero((_names(mesh, c.edges) >= 0).any(axis=1))
    found = [np.zeros((0, 2), dtype=np.int64)]
    if len(edges):
        trees = edge_trees(mesh, edges)
        for first, second in meeting_sets(trees, trees):
            sides = [c.edge_faces[edges[at]] for at in (first, second)]
            pairs = np.stack(np.broadcast_arrays(sides[0][:, :, None], sides[1][:, None, :]), axis=3).reshape(-1, 2)
            found.append(pairs[(pairs[:, 0] < pairs[:, 1]) & (pairs[:, 0] >= 0)])
    return np.concatenate(found)


# --- coordinates and margins


def local(mesh: Mesh, points: FloatArray) -> FloatArray:
    """Points (k, 3) relative to the centre of the mesh, since far from the origin oriented boxes would lose digits."""
    return np.asarray(points - mesh.vertices[mesh.combinatorics.corners].mean(axis=0))


def margin(mesh: Mesh) -> float:
    """The margin of the boxes: the clearance within which parts count as meeting, and rounding."""
    size = float(np.abs(local(mesh, mesh.vertices)).max())
    far = float(np.abs(mesh.vertices).max())
    return 2 * CLEARANCE * mesh.mean_edge_length + 1e-14 * size + 1e-15 * far
