"""Finer meshes by Catmull-Clark subdivision, for faces with any number of corners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.errors import GeometryError, MeshError
from geometry.mesh import Combinatorics, Mesh, MeshLike, as_mesh
from geometry.mesh.polygons import face_centroids
from geometry.surface.rim_corners import boundary_corners

__all__ = ["subdivided"]

LARGEST_SUBDIVISION = 5_000_000
"""Largest number of faces of a subdivided mesh, which takes some gigabytes of memory while it is made."""


def subdivided(mesh: MeshLike, times: int = 1, *, corners: Sequence[int] | IntArray | None = None) -> Mesh:
    """The mesh after each face of k corners is divided into k quads, `times` times, with its vertices moved to smooth
    it.

    The scheme is that of [CatmullClark1978]: on regular quads the meshes converge to a bicubic B-spline. The
    boundary converges to cubic B-splines that depend on vertices of the boundary alone [BiermannLevinZorin2000], so
    that two patches with a common boundary still fit together. Faces are not planar afterwards: `planarise` them
    [Pottmann2007, Fig. 13].

    times: the number of subdivisions; each makes 4 quads of a quad, and 0 returns the same mesh.
    corners: vertices of the boundary that keep their positions, so that the boundary may have a kink there. The default
    are the vertices where it turns by more than `SHARP_BOUNDARY_TURN`, 35 degrees; () makes the whole boundary smooth.
    At other vertices the boundary moves to the inside of its angle. A vertex where several parts of the boundary meet
    keeps its position, and so do vertices without faces.
    The vertices are, in this order, the old ones, one for each edge and one for each face; the faces are in the order
    of the corners of the old mesh.
    Raises GeometryError where times is not a whole number from 0 upwards or there would be more faces than
    `LARGEST_SUBDIVISION`; MeshError for a corner that is not a vertex on the boundary.

    >>> from geometry import subdivided
    >>> from geometry.mesh import shapes, solids
    >>> fine = subdivided(shapes.grid(3, 2), 2)
    >>> fine.n_faces, fine.vertices[[0, 3 * 4 - 1]].tolist()  # the corners keep their positions
    (96, [[0.0, 0.0, 0.0], [3.0, 2.0, 0.0]])
    >>> ball = subdivided(solids.cube(), 3)
    >>> ball.n_faces, set(ball.combinatorics.face_sizes.tolist())
    (384, {4})
    """
    mesh = as_mesh(mesh)
    _check_times(mesh, times)
    is_kept = boundary_corners(mesh) if corners is None else _chosen(mesh, integers(corners))
    for _ in range(times):
        mesh = _once(mesh, is_kept)
        is_kept = np.append(is_kept, np.zeros(mesh.n_vertices - len(is_kept), dtype=bool))
    return mesh


def _once(mesh: Mesh, is_kept: BoolArray) -> Mesh:
    """The mesh after one subdivision; is_kept (N,): vertices of the boundary that do not move."""
    c, vertices = mesh.combinatorics, mesh.vertices
    centroids = face_centroids(vertices, c)
    middles = vertices[c.edges].mean(axis=1)
    inner = ~c.is_boundary_edge
    edge_points = middles.copy()
    edge_points[inner] = (middles[inner] + centroids[c.edge_faces[inner]].mean(axis=1)) / 2
    moved = np.where(c.is_boundary_vertex[:, None], _along_boundary(mesh, is_kept), _inside(mesh, centroids, middles))
    return Mesh(np.concatenate([moved, edge_points, centroids]), _quads(c))


def _quads(c: Combinatorics) -> Combinatorics:
    """A quad for each corner, with the vertices of the corner, of the edge after it, of the face and of the edge before
    it."""
    ahead, behind = c.corner_edge, c.corner_edge[c.previous_corner]
    n, m = c.n_vertices, c.n_edges
    corners = np.stack([c.corners, n + ahead, n + m + c.corner_face, n + behind], axis=1)
    return Combinatorics(n + m + c.n_faces, corners.ravel(), np.arange(0, corners.size + 1, 4))


def _inside(mesh: Mesh, centroids: FloatArray, middles: FloatArray) -> FloatArray:
    """(N, 3) (F + 2 R + (n - 3) v) / n for n edges at v, with F and R the means of centroids and of edge middles."""
    c = mesh.combinatorics
    n = np.maximum(c.vertex_degrees, 1)[:, None]
    faces, edges = np.zeros((2, c.n_vertices, 3))
    np.add.at(faces, c.corners, centroids[c.corner_face])
    np.add.at(edges, c.edges, middles[:, None, :])
    moved = (faces / n + 2 * edges / n + (n - 3) * mesh.vertices) / n
    return np.where(c.is_used[:, None], moved, mesh.vertices)


def _along_boundary(mesh: Mesh, is_kept: BoolArray) -> FloatArray:
    """(N, 3) v / 2 plus a quarter of the sum of the midpoints of the two boundary edges at v; v itself if it is
    kept."""
    c, vertices = mesh.combinatorics, mesh.vertices
    edges = c.edges[c.is_boundary_edge]
    middles, count = np.zeros((c.n_vertices, 3)), np.zeros(c.n_vertices, dtype=np.int64)
    np.add.at(middles, edges, vertices[edges].mean(axis=1)[:, None, :])
    np.add.at(count, edges, 1)
    return np.where((is_kept | (count != 2))[:, None], vertices, vertices / 2 + middles / 4)


def _check_times(mesh: Mesh, times: int) -> None:
    if not isinstance(times, (int, np.integer)) or times < 0:
        raise GeometryError(f"the mesh is to be subdivided {times} times: a whole number from 0 upwards is needed")
    faces = mesh.combinatorics.n_corners * 4.0 ** (times - 1) if times else mesh.n_faces
    if times and faces > LARGEST_SUBDIVISION:
        raise GeometryError(
            f"subdivided {times} times the mesh would have {faces:.2g} faces, at most {LARGEST_SUBDIVISION:.0e} are "
            "allowed: subdivide it less often",
            value=faces,
            bound=LARGEST_SUBDIVISION,
        )


def _chosen(mesh: Mesh, corners: IntArray) -> BoolArray:
    """(N,) whether a vertex is one of the corners."""
    n = mesh.n_vertices
    outside = corners[(corners < 0) | (corners >= n)]
    if not len(outside):
        outside = corners[~mesh.combinatorics.is_boundary_vertex[corners]]
    if len(outside):
        raise MeshError(
            f"vertex {outside[0]} is to be a corner of the boundary, but it is not on the boundary",
            elements=outside.tolist(),
        )
    is_kept = np.zeros(n, dtype=bool)
    is_kept[corners] = True
    return is_kept
