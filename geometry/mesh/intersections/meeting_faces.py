"""Where a mesh meets itself: faces whose outline crosses itself, and faces that intersect each other.

Faces are polygons in their best planes, convex or not. Vertices and edges that belong to two faces do not count.
"""

from __future__ import annotations

import numpy as np
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections.face_neighbours import neighbours
from geometry.mesh.intersections.flat_faces import (
    MANY_CORNERS,
    are_simple,
    coplanar,
    extreme_corners,
    heights_over,
    outlines,
    overlapping,
)
from geometry.mesh.intersections.near_pairs import near_pairs
from geometry.mesh.polygons import perpendicular_pair

__all__ = [
    "edge_ends_over",
    "faces_at_edges",
    "intersecting_faces",
    "is_embedded",
    "self_crossing_faces",
    "without_common_vertex",
]


def self_crossing_faces(mesh: Mesh) -> IntArray:
    """The faces (n,) that are not simple polygons: two edges meet elsewhere than in a common corner.

    >>> from geometry import Mesh
    >>> from geometry.mesh.intersections import self_crossing_faces
    >>> bow = Mesh.from_faces([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1.5, 0]], [[0, 1, 2, 3]])
    >>> self_crossing_faces(bow).tolist()
    [0]
    """
    return np.flatnonzero(~are_simple(mesh))


def intersecting_faces(mesh: Mesh) -> IntArray:
    """(n, 2) pairs of faces that meet elsewhere than in their common vertices and edges, the lower first; sorted.

    They cross each other, a vertex of one lies in the other, or they overlap in one plane. Where boundaries just touch,
    rounding decides. A self-crossing face contains the points around which its outline runs an odd number of times.

    >>> import numpy as np
    >>> from geometry import Mesh
    >>> from geometry.mesh.intersections import intersecting_faces
    >>> upright = [[0.5, -1, -1], [0.5, 2, -1], [0.5, 2, 1], [0.5, -1, 1]]
    >>> mesh = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], *upright], [[0, 1, 2, 3], [4, 5, 6, 7]])
    >>> intersecting_faces(mesh).tolist()
    [[0, 1]]
    """
    c, extremes = mesh.combinatorics, extreme_corners(mesh)
    neighbour_pairs = neighbours(mesh)
    crossing_pairs, flat = [], [neighbour_pairs[coplanar(mesh, extremes, neighbour_pairs)]]
    corner_keys = np.sort(c.corner_face * c.n_vertices + c.corners)
    for pairs in near_pairs(mesh):
        edges, faces = without_common_vertex(mesh, corner_keys, *pairs)
        crossing_pairs.append(_edges_through_planes(mesh, edges, faces))
        pairs_with_edge_faces = faces_at_edges(mesh, edges, faces)
        flat.append(pairs_with_edge_faces[coplanar(mesh, extremes, pairs_with_edge_faces)])
    edges, faces = _within(mesh, *np.concatenate([np.zeros((2, 0), dtype=np.int64), *crossing_pairs], axis=1))
    shared = overlapping(mesh, np.unique(np.sort(np.concatenate(flat), axis=1), axis=0))
    return np.unique(np.sort(np.concatenate([faces_at_edges(mesh, edges, faces), shared]), axis=1), axis=0)


def is_embedded(mesh: Mesh) -> bool:
    """Whether all faces are simple polygons and no two of them intersect.

    >>> from geometry.mesh import solids
    >>> from geometry.mesh.intersections import is_embedded
    >>> is_embedded(solids.snub_cube())
    True
    """
    return bool(are_simple(mesh).all()) and not len(intersecting_faces(mesh))


# --- edges through faces: where two faces cross in a segment, its ends are on edges of the two


def without_common_vertex(
    mesh: Mesh, corner_keys: IntArray, edges: IntArray, faces: IntArray
) -> tuple[IntArray, IntArray]:
    """Those of edges (k,) and faces (k,) that share no vertex. corner_keys (C,): face and vertex of all corners
    as one number, sorted."""
    c = mesh.combinatorics
    keys = faces[:, None] * c.n_vertices + c.edges[edges]
    places = np.minimum(np.searchsorted(corner_keys, keys), c.n_corners - 1)
    apart = (corner_keys[places] != keys).all(axis=1)
    return edges[apart], faces[apart]


def faces_at_edges(mesh: Mesh, edges: IntArray, faces: IntArray) -> IntArray:
    """(n, 2) the faces at edges (k,), and faces (k,)."""
    sides = mesh.combinatorics.edge_faces[edges]
    pairs = np.stack([sides, np.broadcast_to(faces[:, None], sides.shape)], axis=2)
    return np.asarray(pairs[sides >= 0])


def _edges_through_planes(mesh: Mesh, edges: IntArray, faces: IntArray) -> IntArray:
    """(2, n) those of edges (k,) and faces (k,) where the edge meets the plane of the face without lying in it."""
    heights = edge_ends_over(mesh, edges, faces)
    within = (heights == 0).all(axis=0)  # in the plane: found as overlapping faces, or at other edges
    passes = (heights.min(axis=0) <= 0) & (heights.max(axis=0) >= 0) & ~within
    return np.stack([edges[passes], faces[passes]])


def _within(mesh: Mesh, edges: IntArray, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Those of edges (k,) that meet the planes of faces (k,) within the faces, and these faces."""
    heights = edge_ends_over(mesh, edges, faces)
    share = heights[0] / (heights[0] - heights[1])
    tails = mesh.vertices[mesh.combinatorics.edges[edges, 0]]
    hit = _contain(mesh, faces, tails + share[:, None] * mesh.edge_vectors[edges])
    return edges[hit], faces[hit]


def edge_ends_over(mesh: Mesh, edges: IntArray, faces: IntArray) -> FloatArray:
    """(2, k) heights of the ends of edges (k,) above the planes of faces (k,)."""
    ends = mesh.vertices[mesh.combinatorics.edges[edges]]
    return np.stack([heights_over(mesh, faces, ends[:, end]) for end in (0, 1)])


def _contain(mesh: Mesh, faces: IntArray, points: FloatArray) -> BoolArray:
    """(k,) whether faces (k,) contain points (k, 3) of their planes: a ray crosses an odd number of edges."""
    c = mesh.combinatorics
    large = c.face_sizes[faces] > MANY_CORNERS
    if large.any():
        found = np.zeros(len(faces), dtype=bool)
        found[~large] = _contain(mesh, faces[~large], points[~large])
        found[large] = _large_contain(mesh, faces[large], points[large])
        return found
    axes = perpendicular_pair(mesh.face_normals)[faces]
    corners, owner = c.corners_of(faces)
    tail, head = (
        np.einsum("kai,ki->ak", axes[owner], mesh.vertices[c.corners[at]] - points[owner])
        for at in (corners, c.next_corner[corners])
    )
    spans = (tail[1] > 0) != (head[1] > 0)
    ahead = (tail[0] * head[1] > tail[1] * head[0]) == (head[1] > tail[1])
    return np.asarray(np.bincount(owner, spans & ahead, minlength=len(faces)) % 2 == 1)


def _large_contain(mesh: Mesh, faces: IntArray, points: FloatArray) -> BoolArray:
    """(k,) the same for faces of very many corners; each is prepared once for all of its points."""
    which, face = np.unique(faces, return_inverse=True)
    polygons = outlines(mesh, which, which)
    shapely.prepare(polygons)
    x, y = np.einsum("kai,ki->ak", perpendicular_pair(mesh.face_normals)[faces], points)
    return np.asarray(shapely.contains_xy(polygons[face], x, y))
