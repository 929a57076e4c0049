"""Where a mesh meets itself: faces whose outline crosses itself, and faces that cross each other.

Faces are taken as polygons in their best planes, convex or not. What two of them share by combinatorics, a vertex or
an edge, does not count.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh.mesh import Mesh
from geometry.mesh.polygons import two_across

__all__ = ["intersecting_faces", "is_embedded", "meeting_boxes", "self_crossing_faces"]

CLEARANCE = 1e-9
"""Distance from a plane over the mean edge length, up to which a vertex lies in it: faces are planar to 1e-12, and
their planes are known to about that over how thin they are."""

LARGE = 64
"""Corners of a face, above which points are sought in it by a tree over its edges."""

OVERLAP = 1e-6
"""Area that two faces in one plane share, over that of the smaller one, below which they only touch."""


def self_crossing_faces(mesh: Mesh) -> IntArray:
    """The faces (n,) that are no simple polygons: two edges meet elsewhere than in a common corner."""
    return np.flatnonzero(~_is_simple(mesh))


def intersecting_faces(mesh: Mesh) -> IntArray:
    """(n, 2) every two faces that meet elsewhere than in the vertices and edges they share, the lower first; sorted.

    They cross each other, a vertex of one lies in the other, or they overlap in one plane. Where boundaries only just
    touch, rounding decides. A self-crossing face contains what its outline runs around an odd number of times.
    """
    pairs = np.concatenate([_crossing(mesh), _overlapping(mesh)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def is_embedded(mesh: Mesh) -> bool:
    """Whether all faces are simple polygons and no two of them intersect."""
    return bool(_is_simple(mesh).all()) and not len(intersecting_faces(mesh))


# --- edges that pass through faces: where two faces cross in a segment, it ends at edges of theirs


def _crossing(mesh: Mesh) -> IntArray:
    """(n, 2) a face at an edge, and another face that the edge meets without a vertex in common."""
    c = mesh.combinatorics
    ends = mesh.vertices[c.edges]
    edges, faces = meeting_boxes(ends.min(axis=1), ends.max(axis=1), *_face_boxes(mesh))
    of_corners = c.corner_face * c.n_vertices + c.corners
    apart = ~np.isin(faces[:, None] * c.n_vertices + c.edges[edges], of_corners).any(axis=1)
    edges, faces = edges[apart], faces[apart]

    heights = np.stack([_heights(mesh, faces, ends[edges, end]) for end in (0, 1)])
    within = (heights == 0).all(axis=0)  # the plane: what is there shows where faces overlap, or at other edges
    passes = (heights.min(axis=0) <= 0) & (heights.max(axis=0) >= 0) & ~within
    edges, faces, heights = edges[passes], faces[passes], heights[:, passes]
    share = heights[0] / (heights[0] - heights[1])
    hit = _contain(mesh, faces, ends[edges, 0] + share[:, None] * mesh.edge_vectors[edges])
    sides = c.edge_faces[edges[hit]]
    pairs = np.stack([sides, np.broadcast_to(faces[hit, None], sides.shape)], axis=2)
    return np.asarray(pairs[sides >= 0])


def _heights(mesh: Mesh, faces: IntArray, points: FloatArray) -> FloatArray:
    """(k,) of points (k, 3) above the planes of faces (k,), zero within the clearance."""
    first = mesh.vertices[mesh.combinatorics.corners[mesh.combinatorics.face_starts[faces]]]
    heights = np.einsum("ki,ki->k", points - first, mesh.face_normals[faces])
    heights[np.abs(heights) <= CLEARANCE * mesh.mean_edge_length] = 0.0
    return np.asarray(heights)


def _contain(mesh: Mesh, faces: IntArray, points: FloatArray) -> BoolArray:
    """(k,) whether faces (k,) contain points (k, 3) of their planes: a ray crosses an odd number of edges."""
    c = mesh.combinatorics
    large = c.face_sizes[faces] > LARGE
    if large.any():
        found = np.zeros(len(faces), dtype=bool)
        found[~large] = _contain(mesh, faces[~large], points[~large])
        found[large] = _large_contain(mesh, faces[large], points[large])
        return found
    axes = two_across(mesh.face_normals)[faces]
    corners, owner = c.corners_of(faces)
    tail, head = (
        np.einsum("kai,ki->ak", axes[owner], mesh.vertices[c.corners[at]] - points[owner])
        for at in (corners, c.next_corner[corners])
    )
    spans = (tail[1] > 0) != (head[1] > 0)
    ahead = (tail[0] * head[1] > tail[1] * head[0]) == (head[1] > tail[1])
    return np.asarray(np.bincount(owner, spans & ahead, minlength=len(faces)) % 2 == 1)


def _large_contain(mesh: Mesh, faces: IntArray, points: FloatArray) -> BoolArray:
    """The same for faces of very many corners, each of which is searched once and not anew for every point."""
    which, face = np.unique(faces, return_inverse=True)
    polygons = _polygons(mesh, which, which)
    shapely.prepare(polygons)
    x, y = np.einsum("kai,ki->ak", two_across(mesh.face_normals)[faces], points)
    return np.asarray(shapely.contains_xy(polygons[face], x, y))


# --- faces in one plane


def _overlapping(mesh: Mesh) -> IntArray:
    """(n, 2) simple faces in one plane that share area."""
    boxes = _face_boxes(mesh)
    first, second = meeting_boxes(*boxes, *boxes)
    is_simple = _is_simple(mesh)
    candidates = (first < second) & is_simple[first] & is_simple[second]
    first, second = first[candidates], second[candidates]
    flat = _in_plane(mesh, first, second) | _in_plane(mesh, second, first)
    first, second = first[flat], second[flat]
    one, other = _polygons(mesh, first, first), _polygons(mesh, second, first)
    smaller = np.minimum(shapely.area(one), shapely.area(other))
    # a simple polygon that crosses itself in another plane it lies in has no area but for rounding either
    wide = shapely.is_valid(other) & (smaller > (CLEARANCE * mesh.mean_edge_length) ** 2)
    first, second, one, other, smaller = first[wide], second[wide], one[wide], other[wide], smaller[wide]
    shared = shapely.area(shapely.intersection(one, other)) > OVERLAP * smaller
    return np.stack([first[shared], second[shared]], axis=1)


def _in_plane(mesh: Mesh, faces: IntArray, others: IntArray) -> BoolArray:
    """(k,) whether all corners of the other faces lie in the planes of faces (k,)."""
    c, vertices = mesh.combinatorics, mesh.vertices
    found = _heights(mesh, faces, vertices[c.corners[c.face_starts[others]]]) == 0  # the first corner decides mostly
    rest = np.flatnonzero(found)
    corners, owner = c.corners_of(others[rest])
    off = _heights(mesh, faces[rest][owner], vertices[c.corners[corners]]) != 0
    found[rest] = np.bincount(owner, off, minlength=len(rest)) == 0
    return np.asarray(found)


def _is_simple(mesh: Mesh) -> BoolArray:
    """(F,)"""
    faces = np.arange(mesh.n_faces)
    return np.asarray(shapely.is_valid(_polygons(mesh, faces, faces)))


def _polygons(mesh: Mesh, faces: IntArray, planes: IntArray) -> npt.NDArray[np.object_]:
    """(k,) shapely polygons of faces (k,), seen along the normals of the faces `planes` (k,)."""
    corners, owner = mesh.combinatorics.corners_of(faces)
    here = mesh.vertices[mesh.combinatorics.corners[corners]]
    flat = np.einsum("kai,ki->ka", two_across(mesh.face_normals)[planes[owner]], here)
    return np.asarray(shapely.polygons(shapely.linearrings(flat, indices=owner)))


# --- faces and boxes


def _face_boxes(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """(F, 3) least and largest coordinates of each face."""
    corners, starts = mesh.vertices[mesh.combinatorics.corners], mesh.combinatorics.face_starts[:-1]
    return np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)


def meeting_boxes(
    lower: FloatArray, upper: FloatArray, lower_2: FloatArray, upper_2: FloatArray
) -> tuple[IntArray, IntArray]:
    """Which boxes (n, 3) meet which others (m, 3)."""
    if not len(lower_2):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    z, x, y = np.argsort(np.ptp(lower_2, axis=0))  # the tree is flat: its plane is that of the two longest extents
    boxes = shapely.box(lower[:, x], lower[:, y], upper[:, x], upper[:, y])
    others = shapely.box(lower_2[:, x], lower_2[:, y], upper_2[:, x], upper_2[:, y])
    first, second = shapely.STRtree(others).query(boxes)
    meet = (lower[first, z] <= upper_2[second, z]) & (lower_2[second, z] <= upper[first, z])
    return first[meet], second[meet]
