"""Faces cut into triangles between their corners, for libraries that accept only triangles."""

from __future__ import annotations

import numpy as np
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.errors import MeshError
from geometry.mesh.mesh import Mesh
from geometry.mesh.polygons import perpendicular_pair

__all__ = ["triangulated"]

STRAIGHT_CORNER = 1e-9
"""Sine of the turning angle at a corner, up to which it counts as straight; it covers rounding and is far below what
can be seen."""


def triangulated(mesh: Mesh) -> tuple[IntArray, IntArray]:
    """Triangles (T, 3) between the vertices of a mesh, oriented as its faces, and the face (T,) of each, ascending.

    A convex face becomes a fan about its first corner, another one the constrained Delaunay triangulation of its
    projection to its best plane. No vertex is added. Raises MeshError, naming the face, where an outline crosses
    itself.

    >>> from geometry.mesh import Mesh
    >>> mesh = Mesh.from_faces([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [3, 1, 0]], [[0, 1, 2, 3], [1, 4, 2]])
    >>> triangles, faces = triangulated(mesh)
    >>> triangles.tolist(), faces.tolist()
    ([[0, 1, 2], [0, 2, 3], [1, 4, 2]], [0, 0, 1])
    """
    c = mesh.combinatorics
    convex = _convex(mesh)
    fans = np.flatnonzero(convex)
    counts = c.face_sizes[fans] - 2
    faces = np.repeat(fans, counts)
    step = np.arange(len(faces)) - np.repeat(np.cumsum(counts) - counts, counts)
    first = c.face_starts[faces]
    corners = np.stack([first, first + step + 1, first + step + 2], axis=1)
    if not convex.all():
        others, other_faces = _constrained(mesh, np.flatnonzero(~convex))
        faces, corners = np.concatenate([faces, other_faces]), np.concatenate([corners, others])
    order = np.argsort(faces, kind="stable")
    return integers(c.corners[corners[order]]), integers(faces[order])


def _convex(mesh: Mesh) -> BoolArray:
    """(F,) whether a face is a triangle or has a left turn at each of its corners."""
    c = mesh.combinatorics
    ahead = mesh.vertices[c.corners[c.next_corner]] - mesh.vertices[c.corners]
    behind = ahead[c.previous_corner]
    turns = np.einsum("ck,ck->c", np.cross(behind, ahead), mesh.face_normals[c.corner_face])
    lengths = np.linalg.norm(ahead, axis=1)
    left = turns > STRAIGHT_CORNER * lengths * lengths[c.previous_corner]
    convex: BoolArray = np.logical_and.reduceat(left, c.face_starts[:-1]) | (c.face_sizes == 3)
    return convex


def _constrained(mesh: Mesh, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Corners (T, 3) of the triangles of some faces (k,), and the face (T,) of each."""
    c = mesh.combinatorics
    corners, owner = c.corners_of(faces)
    across = perpendicular_pair(mesh.face_normals[faces])[owner]
    centred = mesh.vertices[c.corners[corners]] - mesh.vertices[c.corners[c.face_starts[faces]]][owner]
    flat = np.einsum("cik,ck->ci", across, centred)
    polygons = shapely.polygons(shapely.linearrings(flat, indices=owner))
    crossing = np.flatnonzero(~shapely.is_valid(polygons))
    if len(crossing):
        raise MeshError(
            f"face {faces[crossing[0]]} cannot be cut into triangles, since its outline crosses itself; mend it first "
            "(faces counted from 0)",
            elements=faces[crossing].tolist(),
        )
    pieces, piece_faces = shapely.get_parts(shapely.constrained_delaunay_triangles(polygons), return_index=True)
    rings = shapely.get_coordinates(pieces).reshape(-1, 4, 2)[:, :3]
    found = _matching_rows(flat, owner, rings.reshape(-1, 2), np.repeat(piece_faces, 3)).reshape(-1, 3)
    (ax, ay), (bx, by), (cx, cy) = rings.transpose(1, 2, 0)
    clockwise = (bx - ax) * (cy - ay) < (by - ay) * (cx - ax)
    found[clockwise] = found[clockwise, ::-1]
    return corners[found], faces[piece_faces]


def _matching_rows(flat: FloatArray, owner: IntArray, points: FloatArray, point_owners: IntArray) -> IntArray:
    """For each point the row of flat (c, 2) with the same owner and exactly the same coordinates."""
    rows = np.concatenate([np.column_stack([owner, flat]), np.column_stack([point_owners, points])]) + 0.0
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return integers(first[inverse.ravel()[len(flat) :]]).copy()
