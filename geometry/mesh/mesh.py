"""A mesh: vertex positions over combinatorics. M, a parallel mesh, a Gauss image and a Koebe polyhedron are meshes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, short_repr
from geometry.errors import MeshError, described, raise_worst
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.origin import whole_origin
from geometry.mesh.polygons import best_planes, face_mean_edge_lengths, vector_areas

__all__ = ["Mesh"]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices (N, 3), read-only, over combinatorics shared by reference.

    Meshes over the same combinatorics form a vector space: `+`, `-`, `sum`, and `*` and `/` with a number.
    Raises MeshError where the shape does not fit or a coordinate is not finite.

    >>> from geometry import Mesh
    >>> M = Mesh.from_faces([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [3, 1, 0]], [[0, 1, 2, 3], [1, 4, 2]])
    >>> M
    Mesh(5 vertices, 2 faces, 6 edges)
    >>> [face.tolist() for face in M.faces], M.vertices[M.faces[1]].tolist()
    ([[0, 1, 2, 3], [1, 4, 2]], [[2.0, 0.0, 0.0], [3.0, 1.0, 0.0], [2.0, 2.0, 0.0]])
    >>> (sum([M, M]) / 4 - M).vertices[2].tolist()
    [-1.0, -1.0, 0.0]
    """

    __repr__ = short_repr

    __array_ufunc__ = None  # so that numpy uses the operators of the mesh, as in 2.0 * mesh

    vertices: FloatArray
    combinatorics: Combinatorics

    def __post_init__(self) -> None:
        if not isinstance(self.combinatorics, Combinatorics):
            raise MeshError(
                f"Mesh(vertices, combinatorics) takes a Combinatorics, not {described(self.combinatorics)}: make a "
                "mesh from faces by Mesh.from_faces(vertices, faces)"
            )
        object.__setattr__(self, "vertices", _positions(self.vertices))
        expected = (self.combinatorics.n_vertices, 3)
        if self.vertices.shape != expected:
            raise MeshError(f"vertices have shape {self.vertices.shape}, the faces need {expected}")
        not_finite = np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))
        if len(not_finite):
            vertex = int(not_finite[0])
            raise MeshError(
                f"vertex {vertex} is {self.vertices[vertex].tolist()}: coordinates must be finite numbers",
                elements=not_finite.tolist(),
            )

    @classmethod
    def from_faces(cls, vertices: Any, faces: Iterable[Sequence[int]]) -> Mesh:
        """From positions (N, 3) and one sequence of vertices for each face, counter-clockwise seen from outside.

        Raises MeshError where they make no mesh; where the other order would, it says that they are exchanged.
        """
        faces = faces if isinstance(faces, np.ndarray) or not isinstance(faces, Iterable) else list(faces)
        try:
            positions = _positions(vertices)
            return cls(positions, Combinatorics.from_faces(len(positions), faces))
        except MeshError as error:
            if _make_a_mesh(faces, vertices):
                raise MeshError(
                    "vertices and faces are exchanged: the first argument has whole numbers, which are faces, and the "
                    "second positions; write Mesh.from_faces(vertices, faces)"
                ) from error
            raise

    @classmethod
    def from_grid(cls, points: Any, *, closed: tuple[bool, bool] = (False, False)) -> Mesh:
        """Quads over a grid of points (m, n, 3); vertex (i, j) has number i n + j.

        closed: whether the last row i = m - 1 is joined to the first one, and the last column j = n - 1 to the first;
        do not repeat the first points at the end. The normals point along (direction of i) x (direction of j), so
        upwards if i increases with x and j with y; `reversed` turns them over.

        Raises MeshError for another shape and for too few points: 2 in a direction, 3 where it is closed.

        >>> import numpy as np
        >>> from geometry import Mesh
        >>> x, y = np.meshgrid(np.arange(9), np.arange(6), indexing="ij")
        >>> Mesh.from_grid(np.stack([x, y, 0.1 * x * y], axis=2))
        Mesh(54 vertices, 40 faces, 93 edges)
        """
        grid = _positions(points)
        closed_rows, closed_columns = closed
        if (
            grid.ndim != 3
            or grid.shape[2] != 3
            or grid.shape[0] < 2 + closed_rows
            or grid.shape[1] < 2 + closed_columns
        ):
            raise MeshError(
                f"the points have shape {grid.shape}: a grid (m, n, 3) is needed, with m and n from 2 upwards, and "
                "from 3 upwards where it is closed"
            )
        m, n, _ = grid.shape
        return cls(grid.reshape(-1, 3), Combinatorics.grid(m, n, closed=(closed_rows, closed_columns)))

    def with_vertices(self, vertices: Any) -> Mesh:
        """The same combinatorics with other positions."""
        return Mesh(vertices, self.combinatorics)

    # --- sizes

    @property
    def n_vertices(self) -> int:
        return self.combinatorics.n_vertices

    @property
    def n_edges(self) -> int:
        return self.combinatorics.n_edges

    @property
    def n_faces(self) -> int:
        return self.combinatorics.n_faces

    @property
    def faces(self) -> tuple[IntArray, ...]:
        """The vertices of each face, counter-clockwise, read-only; flat arrays of all are in `combinatorics`."""
        return self.combinatorics.faces

    # --- the vector space of combinatorially equivalent meshes

    def __add__(self, other: Mesh) -> Mesh:
        return self.with_vertices(self.vertices + self._equivalent(other).vertices)

    def __radd__(self, other: Mesh | int) -> Mesh:
        """`sum` begins with 0."""
        return self if isinstance(other, int) and other == 0 else self._equivalent(other) + self

    def __sub__(self, other: Mesh) -> Mesh:
        return self.with_vertices(self.vertices - self._equivalent(other).vertices)

    def __rsub__(self, other: Mesh) -> Mesh:
        return self._equivalent(other) - self

    def __neg__(self) -> Mesh:
        return self.with_vertices(-self.vertices)

    def __mul__(self, factor: float) -> Mesh:
        return self.with_vertices(self.vertices * _number(factor))

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Mesh:
        if _number(divisor) == 0:
            raise MeshError("a mesh is divided by 0", value=0.0)
        return self.with_vertices(self.vertices / divisor)

    def _equivalent(self, other: Any) -> Mesh:
        other = getattr(other, "mesh", other)
        if not isinstance(other, Mesh):
            raise MeshError(
                f"only a mesh with the same faces can be added to a mesh, not {described(other)}: move it by a vector "
                "with mesh.translated(vector), or make a mesh from positions with mesh.with_vertices(positions)"
            )
        if not self.combinatorics.same_as(other.combinatorics):
            raise MeshError("the two meshes do not have the same faces: linear combinations need equal combinatorics")
        return other

    def translated(self, vector: Any) -> Mesh:
        """The mesh moved by a vector (3,). A translated Gauss image is a Gauss image, too [Pottmann2007, 4.4]."""
        shift = _positions(vector)
        if shift.shape != (3,):
            raise MeshError(f"a mesh is translated by a vector of 3 numbers, not by an array of shape {shift.shape}")
        return self.with_vertices(self.vertices + shift)

    def near_zero(self) -> tuple[Mesh, FloatArray]:
        """This mesh moved to zero by whole numbers, so that nothing is rounded, and the origin (3,) that was
        subtracted.

        Results for a mesh far from zero, as at map coordinates, are only as accurate as its coordinates. So begin with
        this and add the origin at the end, by `translated` or `write_mesh`. See `geometry.mesh.origin`.
        """
        origin = whole_origin(self.vertices[self.combinatorics.is_used])
        return self.with_vertices(self.vertices - origin), origin

    def part(self, faces: IntArray) -> Mesh:
        """A mesh of some of the faces (k,), in the given order, and of the vertices that they use, in their order."""
        c = self.combinatorics
        starts = np.concatenate([[0], np.cumsum(c.face_sizes[faces])])
        used, numbered = np.unique(c.corners[c.corners_of(faces)[0]], return_inverse=True)
        return Mesh(self.vertices[used], Combinatorics(len(used), numbered, starts))

    def reversed(self) -> Mesh:
        """The same mesh seen from the other side."""
        return Mesh(self.vertices, self.combinatorics.reversed())

    # --- measures

    @cached_property
    def edge_vectors(self) -> FloatArray:
        """(E, 3) from the tail to the head of each edge."""
        i, j = self.combinatorics.edges.T
        return floats(self.vertices[j] - self.vertices[i])

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """(E,) lengths of the edges."""
        return floats(np.linalg.norm(self.edge_vectors, axis=1))

    @cached_property
    def edge_directions(self) -> FloatArray:
        """(E, 3) unit vectors along the edges. Raises MeshError for an edge without length, which has no direction."""
        raise_worst(
            self.edge_lengths,
            ">",
            0.0,
            lambda edge, _: (
                f"{self.combinatorics.edge_name(edge)} has no length, so nothing is parallel to it: "
                "make its two vertices one"
            ),
            error=MeshError,
        )
        return floats(self.edge_vectors / self.edge_lengths[:, None])

    @cached_property
    def corner_directions(self) -> FloatArray:
        """(C, 3) unit vectors from each corner to the next one of its face. Raises as `edge_directions` does."""
        c = self.combinatorics
        along = np.where(c.runs_along_edge, 1.0, -1.0)
        return floats(along[:, None] * self.edge_directions[c.corner_edge])

    @cached_property
    def mean_edge_length(self) -> float:
        return float(self.edge_lengths.mean())

    @cached_property
    def vector_areas(self) -> FloatArray:
        """(F, 3) area times unit normal of each face."""
        return floats(vector_areas(self.vertices, self.combinatorics))

    @property
    def face_normals(self) -> FloatArray:
        """(F, 3) unit normals of the faces' best planes, outwards."""
        return self._planes[0]

    @property
    def plane_deviations(self) -> FloatArray:
        """(F,) largest distance of a corner from the face's best plane."""
        return self._planes[1]

    @cached_property
    def _planes(self) -> tuple[FloatArray, FloatArray]:
        normals, deviations = best_planes(self.vertices, self.combinatorics)
        return floats(normals), floats(deviations)

    @cached_property
    def planarity(self) -> FloatArray:
        """(F,) largest distance of a corner from the face's best plane, over the face's mean edge length."""
        return floats(self.plane_deviations / face_mean_edge_lengths(self.vertices, self.combinatorics))

    @cached_property
    def corner_angles(self) -> FloatArray:
        """(C,) angle in radians between the two edges of each corner, up to pi."""
        c = self.combinatorics
        ahead = self.vertices[c.corners[c.next_corner]] - self.vertices[c.corners]
        back = self.vertices[c.corners[c.previous_corner]] - self.vertices[c.corners]
        crossed = np.linalg.norm(np.cross(ahead, back), axis=1)
        return floats(np.arctan2(crossed, np.einsum("ck,ck->c", ahead, back)))

    @cached_property
    def vertex_normals(self) -> FloatArray:
        """(N, 3) unit normals at the vertices: the mean of the face normals, weighted by the faces' angles.

        Zero for a vertex that belongs to no face.
        """
        c = self.combinatorics
        sums = np.zeros((self.n_vertices, 3))
        np.add.at(sums, c.corners, self.corner_angles[:, None] * self.face_normals[c.corner_face])
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        return floats(np.divide(sums, lengths, out=np.zeros_like(sums), where=lengths > 0))


def _positions(given: Any) -> FloatArray:
    """Coordinates as floats, of any shape. Raises MeshError for what is no array of numbers."""
    try:
        return floats(given)
    except (TypeError, ValueError) as error:
        raise MeshError(
            f"coordinates are numbers in an array, (n, 3) for n vertices, not {described(given)}"
        ) from error


def _number(factor: Any) -> float:
    if isinstance(factor, (int, float, np.number)) and not isinstance(factor, np.complexfloating):
        return float(factor)
    raise MeshError(
        f"a mesh is multiplied by or divided by a number, not {described(factor)}: scale it along the axes with "
        "mesh.with_vertices(mesh.vertices * factors)"
    )


def _make_a_mesh(vertices: Any, faces: Any) -> bool:
    try:
        Mesh(vertices, Combinatorics.from_faces(len(vertices), faces))
    except (MeshError, TypeError):  # TypeError: `vertices` has no length
        return False
    return True
