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
from geometry.mesh.near_faces import meeting_boxes, near_faces
from geometry.mesh.polygons import two_across

__all__ = ["intersecting_faces", "is_embedded", "self_crossing_faces"]

CLEARANCE = 1e-9
"""Distance from a plane over the mean edge length, up to which a vertex lies in it: faces are planar to 1e-12, and
their planes are known to about that over how thin they are."""

LARGE = 64
"""Corners of a face, above which points are sought in it by a tree over its edges."""

BATCH = 4096
"""Pairs of faces whose edges are looked at together: more would take memory only."""

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
    near = near_faces(mesh, CLEARANCE * mesh.mean_edge_length)
    pairs = np.concatenate([_crossing(mesh, *near), _overlapping(mesh, *near)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def is_embedded(mesh: Mesh) -> bool:
    """Whether all faces are simple polygons and no two of them intersect."""
    return bool(_is_simple(mesh).all()) and not len(intersecting_faces(mesh))


# --- edges that pass through faces: where two faces cross in a segment, it ends at edges of theirs


def _crossing(mesh: Mesh, first: IntArray, second: IntArray) -> IntArray:
    """(n, 2) a face at an edge, and another face that the edge meets without a vertex in common, of faces near each
    other."""
    c = mesh.combinatorics
    ends = mesh.vertices[c.edges]
    edges, faces = _edges_near(mesh, np.concatenate([first, second]), np.concatenate([second, first]))

    heights = np.stack([_heights(mesh, faces, ends[edges, end]) for end in (0, 1)])
    within = (heights == 0).all(axis=0)  # the plane: what is there shows where faces overlap, or at other edges
    passes = (heights.min(axis=0) <= 0) & (heights.max(axis=0) >= 0) & ~within
    edges, faces, heights = edges[passes], faces[passes], heights[:, passes]
    share = heights[0] / (heights[0] - heights[1])
    hit = _contain(mesh, faces, ends[edges, 0] + share[:, None] * mesh.edge_vectors[edges])
    sides = c.edge_faces[edges[hit]]
    pairs = np.stack([sides, np.broadcast_to(faces[hit, None], sides.shape)], axis=2)
    return np.asarray(pairs[sides >= 0])


def _edges_near(mesh: Mesh, owners: IntArray, faces: IntArray) -> tuple[IntArray, IntArray]:
    """The edges (n,) of faces `owners` (k,) whose boxes meet those of faces (k,) at them, without a vertex in common;
    each edge with each face (n,) once."""
    c = mesh.combinatorics
    ends, corners = mesh.vertices[c.edges], mesh.vertices[c.corners]
    boxes = ends.min(axis=1), ends.max(axis=1)
    lower, upper = (of.reduceat(corners, c.face_starts[:-1]) for of in (np.minimum, np.maximum))
    is_large = c.face_sizes[owners] > LARGE
    found = [np.zeros((2, 0), dtype=np.int64)]
    for owner in np.unique(owners[is_large]):
        edges, others = c.corner_edge[c.corners_of(np.array([owner]))[0]], faces[owners == owner]
        at, which = meeting_boxes(boxes[0][edges], boxes[1][edges], lower[others], upper[others])
        found.append(np.stack([edges[at], others[which]]))
    owners, faces = owners[~is_large], faces[~is_large]
    for start in range(0, len(owners), BATCH):
        at, place = c.corners_of(owners[start : start + BATCH])
        edges, others = c.corner_edge[at], faces[start + place]
        meet = ((boxes[0][edges] <= upper[others]) & (lower[others] <= boxes[1][edges])).all(axis=1)
        found.append(np.stack([edges[meet], others[meet]]))
    pairs = np.unique(np.concatenate(found, axis=1), axis=1)
    keys = pairs[1][:, None] * c.n_vertices + c.edges[pairs[0]]
    edges, faces = pairs[:, ~np.isin(keys, c.corner_face * c.n_vertices + c.corners).any(axis=1)]
    return edges, faces


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


def _overlapping(mesh: Mesh, first: IntArray, second: IntArray) -> IntArray:
    """(n, 2) simple faces in one plane that share area, of faces near each other."""
    is_simple = _is_simple(mesh)
    candidates = is_simple[first] & is_simple[second]
    first, second = first[candidates], second[candidates]
    flat = _in_plane(mesh, first, second) | _in_plane(mesh, second, first)
    first, second = first[flat], second[flat]
    sizes = mesh.combinatorics.face_sizes
    larger = np.where(sizes[second] > sizes[first], second, first)
    smaller = first + second - larger
    which, place = np.unique(larger, return_inverse=True)
    planes = _polygons(mesh, which, which)
    other = _polygons(mesh, smaller, larger)
    areas = np.minimum(shapely.area(planes)[place], shapely.area(other))
    # a simple polygon that crosses itself in another plane it lies in has no area but for rounding either
    wide = shapely.is_valid(other) & (areas > (CLEARANCE * mesh.mean_edge_length) ** 2)
    wide[wide] = _may_overlap(planes, place[wide], other[wide], sizes[larger[wide]] > LARGE)
    first, second, one, other, areas = first[wide], second[wide], planes[place[wide]], other[wide], areas[wide]
    shared = shapely.area(shapely.intersection(one, other)) > OVERLAP * areas
    return np.stack([first[shared], second[shared]], axis=1)


def _may_overlap(
    planes: npt.NDArray[np.object_], place: IntArray, others: npt.NDArray[np.object_], is_large: BoolArray
) -> BoolArray:
    """(k,) False where another polygon only touches a large one, which is searched by its tree and not cut with it."""
    large, place = others[is_large], place[is_large]
    found = np.ones(len(others), dtype=bool)
    shapely.prepare(planes[np.unique(place)])
    # what is taken off is less than the area that would count
    inner = shapely.buffer(large, -OVERLAP / 10 * np.sqrt(shapely.area(large)), join_style="mitre")
    found[is_large] = shapely.is_empty(inner) | shapely.intersects(planes[place], inner)
    return found


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
