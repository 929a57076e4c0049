"""Where a surface of triangles crosses, touches or covers itself, apart from its boundary."""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections.face_neighbours import neighbours
from geometry.mesh.intersections.flat_faces import coplanar, overlapping
from geometry.mesh.intersections.meeting_faces import edge_ends_over, faces_at_edges, without_common_vertex
from geometry.mesh.intersections.near_pairs import near_pairs

__all__ = ["crossing_triangles"]

CONTACT_SHARE = 1e-6
"""Barycentric coordinate by which a point may be outside a triangle and still belongs to it: sheets may cross exactly
along edges, and coordinates of files have some six digits."""

BOUNDARY_CONTACT = 0.1
"""Distance from the boundary over the mean edge length, up to which parts of a surface may touch or overlap: two
polylines along one curve are that far apart."""


def crossing_triangles(mesh: Mesh) -> IntArray:
    """(n, 2) pairs of triangles of a mesh that meet elsewhere than in common vertices and edges; sorted.

    They cross or touch each other, or overlap in one plane. Unlike in `intersecting_faces`, sheets that touch or cross
    in their vertices or edges count, too, while parts whose boundaries touch each other or another part do not.

    >>> import numpy as np
    >>> from geometry.mesh import Mesh, solids
    >>> from geometry.mesh.intersections import crossing_triangles
    >>> ball = solids.icosahedron()
    >>> faces = np.array(ball.combinatorics.faces)
    >>> both = Mesh.from_faces(np.concatenate([ball.vertices, ball.vertices + [1, 0, 0]]), [*faces, *(faces + 12)])
    >>> len(crossing_triangles(ball)), len(crossing_triangles(both)) > 10
    (0, True)
    """
    c = mesh.combinatorics
    extremes = c.corners.reshape(-1, 3)[:, [0, 1, 2, 0]]
    corner_keys = np.sort(c.corner_face * c.n_vertices + c.corners)
    at_boundary: BoolArray = np.any(c.is_boundary_vertex[c.corners].reshape(-1, 3), axis=1)
    neighbour_pairs = neighbours(mesh)
    contacts, flat = [np.zeros((2, 0), dtype=np.int64)], [neighbour_pairs[coplanar(mesh, extremes, neighbour_pairs)]]
    for pairs in near_pairs(mesh):
        edges, faces = without_common_vertex(mesh, corner_keys, *pairs)
        contacts.append(_contacts(mesh, edges, faces))
        beside = faces_at_edges(mesh, edges, faces)
        beside = beside[~at_boundary[beside].all(axis=1)]
        flat.append(beside[coplanar(mesh, extremes, beside)])
    edges, faces = np.concatenate(contacts, axis=1)
    shared = overlapping(mesh, np.unique(np.sort(np.concatenate(flat), axis=1), axis=0))
    found = np.concatenate([faces_at_edges(mesh, edges, faces), shared])
    return np.unique(np.sort(found, axis=1), axis=0)


def _contacts(mesh: Mesh, edges: IntArray, faces: IntArray) -> IntArray:
    """(2, n) those of edges (k,) and triangles (k,) that meet, the edge not in the plane of the triangle, and not at
    the boundary of either sheet."""
    heights = edge_ends_over(mesh, edges, faces)
    passes = np.flatnonzero((heights.min(axis=0) <= 0) & (heights.max(axis=0) >= 0) & heights.any(axis=0))
    edges, faces, heights = edges[passes], faces[passes], heights[:, passes]
    share = heights[0] / (heights[0] - heights[1])
    points = mesh.vertices[mesh.combinatorics.edges[edges, 0]] + share[:, None] * mesh.edge_vectors[edges]
    corners = mesh.vertices[mesh.combinatorics.corners.reshape(-1, 3)[faces]]
    sides = np.roll(corners, -1, axis=1) - corners
    across = np.cross(sides, points[:, None] - corners)
    areas = np.einsum("nki,ni->nk", across, mesh.face_normals[faces])
    within = np.flatnonzero((areas >= -CONTACT_SHARE * np.abs(areas).sum(axis=1, keepdims=True)).all(axis=1))
    edges, faces, points = edges[within], faces[within], points[within]
    least = BOUNDARY_CONTACT * mesh.mean_edge_length
    inside = _from_boundary(mesh, faces, points) > least
    for side in (0, 1):
        beside = mesh.combinatorics.edge_faces[edges, side]
        inside &= (beside >= 0) & (_from_boundary(mesh, beside, points) > least)
    return np.stack([edges[inside], faces[inside]])


def _from_boundary(mesh: Mesh, triangles: IntArray, points: FloatArray) -> FloatArray:
    """(n,) distances of points (n, 3) from the boundary edges and vertices of triangles (n,)."""
    c = mesh.combinatorics
    corners = 3 * triangles[:, None] + np.arange(3)
    tails, heads = mesh.vertices[c.corners[corners]], mesh.vertices[c.corners[c.next_corner[corners]]]
    along, offsets = heads - tails, points[:, None] - tails
    shares = np.einsum("nki,nki->nk", offsets, along) / np.einsum("nki,nki->nk", along, along)
    shares = np.where(c.is_boundary_edge[c.corner_edge[corners]], shares.clip(0, 1), 0.0)
    distances = np.linalg.norm(offsets - shares[:, :, None] * along, axis=2)
    distances[~c.is_boundary_vertex[c.corners[corners]]] = np.inf
    return np.asarray(distances.min(axis=1))
