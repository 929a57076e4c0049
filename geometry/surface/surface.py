"""A design surface Phi, on which meshes are laid and vertices slide."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import igl
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import GeometryError, MeshError, described, raise_worst
from geometry.mesh import Combinatorics, Mesh, as_mesh
from geometry.mesh.intersections import crossing_triangles
from geometry.mesh.polygons import face_centroids

__all__ = ["Surface", "check_points"]

LEAST_TRIANGLE_AREA = 1e-9
"""Area of a triangle over the square of its longest edge, below which its normal is uncertain: coordinates have
six digits."""

MAX_COORDINATE = 1e100
"""Largest coordinate of a point, so that the square of a distance is finite."""

EDGE_TOLERANCE = 1e-9
"""Barycentric coordinate up to which a foot is on an edge, and offset over the size of a triangle up to which a
point is straight above it: well above rounding, and otherwise without effect."""


def check_points(points: FloatArray) -> FloatArray:
    """The points (n, 3) as floats. Raises GeometryError for another shape, and where a coordinate is not finite."""
    try:
        array = np.ascontiguousarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise GeometryError(
            f"points are numbers in an array (n, 3), such as mesh.vertices, not {described(points)}"
        ) from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise GeometryError(f"points have shape {array.shape}, (n, 3) is needed")
    not_finite = np.flatnonzero(~(np.abs(array) <= MAX_COORDINATE).all(axis=1))
    if len(not_finite):
        raise GeometryError(
            f"point {not_finite[0]} is {array[not_finite[0]].tolist()}: coordinates must be finite numbers up to "
            f"{MAX_COORDINATE:.0e}",
            elements=not_finite.tolist(),
            bound=MAX_COORDINATE,
        )
    return array


@dataclass(frozen=True, eq=False)
class Surface:
    """The surface of the triangles of a mesh; faces with more corners are cut into triangles about their centroids.

    Normals are interpolated from those at the vertices, so that they are continuous. Raises MeshError for triangles
    without area, faces that cannot be cut in this way, and vertices without a normal.

    >>> import numpy as np
    >>> from geometry import Surface
    >>> from geometry.mesh import shapes
    >>> surface = Surface(shapes.grid(4, 4))
    >>> feet, normals = surface.closest(np.array([[1.3, 2.0, 5.0], [9.0, 2.0, 0.0]]))
    >>> feet.round(9).tolist(), normals.round(9).tolist()
    ([[1.3, 2.0, 0.0], [4.0, 2.0, 0.0]], [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    """

    __repr__ = short_repr

    mesh: Mesh

    is_exact: ClassVar[bool] = False
    """Whether nearest points are those of a smooth surface, and not of its triangles."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "mesh", as_mesh(self.mesh))
        self._check_areas()
        lengths = np.linalg.norm(self._normals[self._triangles], axis=2)
        if (lengths == 0).any():
            vertex = int(self._triangles[lengths == 0][0])
            raise MeshError(
                f"the faces at vertex {vertex} face opposite directions, so that the surface has no normal there: "
                "keep only one of its two layers",
                elements=[vertex],
            )

    def moved(self, scale: float, offset: FloatArray) -> Surface:
        """The surface scaled about the origin and then moved by a vector (3,)."""
        return Surface(self.mesh.with_vertices(self.mesh.vertices * scale + offset))

    def closest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Feet (n, 3) of points (n, 3), the nearest points of the surface, and unit normals (n, 3) there.

        Raises GeometryError for points that are not finite.
        """
        feet, _, normals, _ = self.locate(check_points(points))
        return feet, normals

    def distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distances (n,) of points (n, 3) along the normals at their feet, and their gradients (n, 3).

        Positive on the side of the normals. Beyond the boundary, the surface continues perpendicular to its
        normals. The gradients are exact up to terms of the order of the distance from the foot. They differ slightly
        from the normals at the feet, since interpolated normals are not perpendicular to the flat triangles.
        """
        points = check_points(points)
        feet, triangles, normals, weights = self.locate(points)
        offsets = points - feet
        flat, size = self._triangle_normals[triangles], self._sizes[triangles]
        sideways = offsets - np.einsum("ni,ni->n", offsets, flat)[:, None] * flat
        moves = (
            weights > EDGE_TOLERANCE
        )  # whether a foot moves in its triangle, along its edge, or not at all, when its point moves
        above = moves.all(axis=1) | (np.linalg.norm(sideways, axis=1) <= EDGE_TOLERANCE * size)
        on_edge = ~above & (moves.sum(axis=1) == 2)
        gradients = normals.copy()
        gradients[above] = _along(normals[above], flat[above])
        edges = self._opposite_edges(triangles[on_edge], ~moves[on_edge])
        gradients[on_edge] -= _along(normals[on_edge], edges)
        return np.einsum("ni,ni->n", offsets, normals), gradients

    def locate(self, points: FloatArray) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
        """Feet (n, 3), their triangles (n,), normals (n, 3) and barycentric coordinates (n, 3) in the triangles."""
        _, triangles, feet = self._tree.squared_distance(self._vertices, self._triangles, points)
        triangles = np.asarray(triangles, dtype=np.int64).reshape(-1)
        feet = np.asarray(feet, dtype=np.float64).reshape(-1, 3)
        corners = self._vertices[self._triangles[triangles]]
        areas = np.cross(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], feet[:, None] - corners[:, [1, 2, 0]])
        weights = np.einsum("nki,ni->nk", areas, self._triangle_normals[triangles]).clip(min=0.0)
        weights /= weights.sum(axis=1, keepdims=True)
        normals = np.einsum("nk,nki->ni", weights, self._normals[self._triangles[triangles]])
        return feet, triangles, normals / np.linalg.norm(normals, axis=1, keepdims=True), weights

    def _opposite_edges(self, triangles: IntArray, corners: BoolArray) -> FloatArray:
        """(n, 3) unit vectors along the edges opposite to one corner of each triangle; corners (n, 3) is true at this
        corner."""
        corner = corners.argmax(axis=1)
        vertices = self._triangles[triangles]
        rows = np.arange(len(vertices))
        edges = self._vertices[vertices[rows, corner - 1]] - self._vertices[vertices[rows, corner - 2]]
        return np.asarray(edges / np.linalg.norm(edges, axis=1, keepdims=True))

    # --- triangles

    @cached_property
    def crossing_faces(self) -> IntArray:
        """(n, 2) pairs of faces where the surface crosses, touches or covers itself, apart from its boundary."""
        c = Combinatorics(len(self._vertices), self._triangles.ravel(), 3 * np.arange(len(self._triangles) + 1))
        pairs = crossing_triangles(Mesh(self._vertices, c).near_zero()[0])
        return integers(np.unique(np.sort(self._pieces[1][pairs], axis=1), axis=0))

    def check_embedded(self) -> None:
        """Raise MeshError where the surface crosses, touches or covers itself, so that no mesh can be laid on it."""
        pairs = self.crossing_faces
        if len(pairs):
            first, second = pairs[0].tolist()
            others = f"; so do {len(pairs) - 1} other pairs of faces" if len(pairs) > 1 else ""
            raise MeshError(
                f"the surface crosses, touches or covers itself: faces {first} and {second} meet apart from common "
                f"vertices{others}; cut the surface there and lay a mesh on each part, or remove one of its layers",
                elements=np.unique(pairs).tolist(),
                value=len(pairs),
                bound=0,
            )

    @cached_property
    def triangulated(self) -> Mesh:
        """The triangles as a mesh without unused vertices. A vertex where several fans of triangles meet becomes one
        vertex for each fan."""
        c = Combinatorics(len(self._vertices), self._triangles.ravel(), 3 * np.arange(len(self._triangles) + 1))
        at_inner_edges = np.flatnonzero(c.twin[c.previous_corner] >= 0)
        pairs = (
            at_inner_edges,
            c.twin[c.previous_corner[at_inner_edges]],
        )  # corners of one vertex in neighbouring triangles
        fans = coo_array((np.ones(len(at_inner_edges)), pairs), shape=(c.n_corners, c.n_corners))
        corners = connected_components(fans, directed=False)[1]
        _, first = np.unique(corners, return_index=True)
        if len(first) == self.mesh.n_vertices and self.mesh.combinatorics.face_sizes.max() == 3:
            return self.mesh
        order = np.argsort(np.argsort(c.corners[first], kind="stable"), kind="stable")
        positions = np.empty((len(first), 3))
        positions[order] = self._vertices[c.corners[first]]
        return Mesh(positions, Combinatorics(len(first), order[corners], c.face_starts))

    @cached_property
    def _pieces(self) -> tuple[IntArray, IntArray]:
        """Triangles (T, 3), and their faces (T,); the centroid of face f has the vertex number N + f."""
        c = self.mesh.combinatorics
        whole = np.flatnonzero(c.face_sizes == 3)
        cut = np.flatnonzero(c.face_sizes[c.corner_face] > 3)
        about = np.stack([c.corners[cut], c.corners[c.next_corner[cut]], c.n_vertices + c.corner_face[cut]], axis=1)
        triangles = np.concatenate([c.corners[c.face_starts[whole][:, None] + np.arange(3)], about])
        return integers(triangles), integers(np.concatenate([whole, c.corner_face[cut]]))

    @property
    def _triangles(self) -> IntArray:
        return self._pieces[0]

    @cached_property
    def _vertices(self) -> FloatArray:
        """(N + F, 3) vertices, then centroids of faces."""
        vertices = self.mesh.vertices
        return floats(np.concatenate([vertices, face_centroids(vertices, self.mesh.combinatorics)]))

    @cached_property
    def _normals(self) -> FloatArray:
        """(N + F, 3) at the vertices and centroids."""
        return floats(np.concatenate([self.mesh.vertex_normals, self.mesh.face_normals]))

    @cached_property
    def _areas(self) -> FloatArray:
        """(T, 3) twice the vector areas of the triangles."""
        a, b, c = self._vertices[self._triangles].swapaxes(0, 1)
        return floats(np.cross(b - a, c - a))

    @cached_property
    def _triangle_normals(self) -> FloatArray:
        """(T, 3) unit normals of the triangles."""
        return floats(self._areas / np.linalg.norm(self._areas, axis=1, keepdims=True))

    @cached_property
    def _sizes(self) -> FloatArray:
        """(T,) lengths of the longest edges of triangles."""
        corners = self._vertices[self._triangles]
        return floats(np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).max(axis=1))

    @cached_property
    def _tree(self) -> igl.AABB:
        tree = igl.AABB()
        tree.init(self._vertices, self._triangles)
        return tree

    def _check_areas(self) -> None:
        faces = self._pieces[1]
        upright = np.einsum("ti,ti->t", self._areas, self.mesh.face_normals[faces]) / 2
        relative = upright / np.maximum(self._sizes, np.finfo(float).tiny) ** 2

        def say(face: int, value: float) -> str:
            larger = self.mesh.combinatorics.face_sizes[face] > 3
            what = "cannot be cut into triangles about its centroid" if larger else "has no area"
            return (
                f"face {face} {what}: a triangle of it has {value:.1e} times the square of its longest edge, more "
                f"than {LEAST_TRIANGLE_AREA:.0e} is needed; {'cut the face into triangles' if larger else 'remove it'}"
            )

        raise_worst(relative, ">", LEAST_TRIANGLE_AREA, say, elements=faces, error=MeshError)


def _along(vectors: FloatArray, directions: FloatArray) -> FloatArray:
    """The parts of vectors (n, 3) along unit directions (n, 3)."""
    return np.asarray(np.einsum("ni,ni->n", vectors, directions)[:, None] * directions)
