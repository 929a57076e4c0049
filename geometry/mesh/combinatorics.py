"""Which vertices belong to which faces and edges: a mesh without its positions.

Vocabulary. A *corner* is a vertex within a face; the corners of all faces are in one flat array, face after face.
Corner c also denotes the half-edge from its vertex to the vertex of the next corner. An *edge* has the direction in
which its left face runs along it; the right face, if there is one, runs along it in the other direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import BoolArray, IntArray, integers, short_repr
from geometry.errors import MeshError, described
from geometry.mesh.orientability import wrong_edge
from geometry.mesh.ragged_arrays import next_in_row, row_of_entry, rows_by_size

__all__ = ["Combinatorics", "corners_and_sizes"]


def corners_and_sizes(faces: Iterable[Sequence[int]]) -> tuple[IntArray, IntArray]:
    """The vertices of all corners (C,) and the numbers of corners (F,) of faces given as one sequence of vertices each.

    Raises MeshError for vertices that are not whole numbers.
    """
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        given, sizes = faces.ravel(), integers(np.full(len(faces), faces.shape[1]))
    else:
        given, sizes = _flattened(faces)
    if given.dtype.kind in "iu" or not given.size:
        return integers(given), sizes
    if given.ndim != 1 or given.dtype.kind != "f":
        raise MeshError("faces are sequences of the numbers of their vertices, such as [[0, 1, 2], [0, 2, 3, 4]]")
    with np.errstate(invalid="ignore"):
        broken = given.astype(np.float64) % 1 != 0  # true for infinity and NaN, too
    if broken.any():
        places = np.flatnonzero(broken)
        wrong = np.unique(np.repeat(np.arange(len(sizes)), sizes)[places])
        raise MeshError(
            f"face {wrong[0]} names vertex {given[places[0]]}: vertices have whole numbers", elements=wrong.tolist()
        )
    return integers(given), sizes


def _flattened(faces: Iterable[Sequence[int]]) -> tuple[NDArray[Any], IntArray]:
    """All corners of faces of any sizes, and these sizes."""
    try:
        lists = [list(face) for face in faces]
        return np.array([vertex for face in lists for vertex in face]), integers([len(face) for face in lists])
    except (TypeError, ValueError) as error:  # no sequence, or sequences in place of vertices
        raise MeshError(
            f"faces are sequences of the numbers of their vertices, such as [[0, 1, 2], [0, 2, 3, 4]], not "
            f"{described(faces)}"
        ) from error


@dataclass(frozen=True, eq=False)
class Combinatorics:
    """An oriented manifold of polygons.

    n_vertices: number of vertices, used by a face or not.
    corners (C,): the vertex of each corner; faces run counter-clockwise seen from outside.
    face_starts (F+1,): face f has the corners face_starts[f] .. face_starts[f+1] - 1.

    Raises MeshError where a face has fewer than three corners or meets a vertex twice, where an index is out of
    range, and where a directed edge belongs to two faces (not manifold, or not oriented).

    >>> from geometry import Combinatorics
    >>> c = Combinatorics.from_faces(5, [[0, 1, 2, 3], [1, 4, 2]])
    >>> c
    Combinatorics(5 vertices, 2 faces, 6 edges)
    >>> c.edges[c.is_boundary_edge].tolist(), c.vertex_degrees.tolist()
    ([[0, 1], [2, 3], [3, 0], [1, 4], [4, 2]], [2, 3, 3, 2, 2])
    """

    __repr__ = short_repr

    n_vertices: int
    corners: IntArray
    face_starts: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "corners", integers(self.corners))
        object.__setattr__(self, "face_starts", integers(self.face_starts))
        self._check_faces()
        self._check_half_edges()

    @classmethod
    def from_faces(cls, n_vertices: int, faces: Iterable[Sequence[int]]) -> Combinatorics:
        """From one sequence of vertex indices for each face. Raises MeshError also where an index is not a whole
        number."""
        corners, sizes = corners_and_sizes(faces)
        return cls(n_vertices, corners, np.concatenate([[0], np.cumsum(sizes)]))

    @classmethod
    def grid(cls, m: int, n: int, *, closed: tuple[bool, bool] = (False, False)) -> Combinatorics:
        """Quads over m by n vertices; vertex (i, j) has number i n + j. See `Mesh.from_grid`."""
        i, j = np.indices((m - (not closed[0]), n - (not closed[1]))).reshape(2, -1)
        here, there, above = i * n, (i + 1) % m * n, (j + 1) % n
        corners = np.stack([here + j, there + j, there + above, here + above], axis=1)
        return cls(m * n, corners.ravel(), np.arange(0, corners.size + 1, 4))

    # --- faces and corners

    @property
    def n_faces(self) -> int:
        return len(self.face_starts) - 1

    @property
    def n_corners(self) -> int:
        return len(self.corners)

    @cached_property
    def face_sizes(self) -> IntArray:
        """(F,) number of corners of each face."""
        return integers(np.diff(self.face_starts))

    @cached_property
    def corner_face(self) -> IntArray:
        """(C,) face of each corner."""
        return row_of_entry(self.face_starts)

    @cached_property
    def next_corner(self) -> IntArray:
        """(C,) the corner after each corner, counter-clockwise in its face."""
        return next_in_row(self.face_starts)

    @cached_property
    def previous_corner(self) -> IntArray:
        """(C,) the corner before each corner."""
        before = np.empty(self.n_corners, dtype=np.int64)
        before[self.next_corner] = np.arange(self.n_corners)
        return integers(before)

    def face(self, face: int) -> IntArray:
        """Vertices of one face."""
        return self.corners[self.face_starts[face] : self.face_starts[face + 1]]

    @cached_property
    def faces(self) -> tuple[IntArray, ...]:
        """The vertices of each face, read-only: `mesh.vertices[face]` are the positions of its corners."""
        return tuple(np.split(self.corners, self.face_starts[1:-1]))

    def faces_by_size(self) -> list[tuple[IntArray, IntArray]]:
        """For each size k: the faces with k corners (n,) and their corners (n, k)."""
        return rows_by_size(self.face_starts)

    def corners_of(self, faces: IntArray) -> tuple[IntArray, IntArray]:
        """All corners (n,) of faces (k,), one face after another, and the index into `faces` (n,) for each."""
        sizes = self.face_sizes[faces]
        owner = np.repeat(np.arange(len(faces)), sizes)
        before = np.cumsum(sizes) - sizes
        return self.face_starts[faces][owner] + np.arange(len(owner)) - before[owner], owner

    # --- edges

    @cached_property
    def _edge_tables(self) -> tuple[IntArray, IntArray, IntArray]:
        """edges (E, 2), edge_corners (E, 2) with -1 where there is no right face, corner_edge (C,)."""
        tail, head = self.corners, self.corners[self.next_corner]
        low, high = np.minimum(tail, head), np.maximum(tail, head)
        keys = low * self.n_vertices + high
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        rank = np.argsort(np.argsort(first))  # edges are numbered in the order in which they occur in faces
        corner_edge = rank[inverse]
        left = np.sort(first)
        right = np.full(len(first), -1, dtype=np.int64)
        others = np.setdiff1d(np.arange(self.n_corners), left, assume_unique=True)
        right[corner_edge[others]] = others
        edges = np.stack([tail[left], head[left]], axis=1)
        return integers(edges), integers(np.stack([left, right], axis=1)), integers(corner_edge)

    @property
    def edges(self) -> IntArray:
        """(E, 2) tail and head of each edge, in the direction of its left face."""
        return self._edge_tables[0]

    @property
    def n_edges(self) -> int:
        return len(self.edges)

    @property
    def edge_corners(self) -> IntArray:
        """(E, 2) corner at the tail in the left face; corner at the head in the right face, -1 where none."""
        return self._edge_tables[1]

    @property
    def corner_edge(self) -> IntArray:
        """(C,) edge from each corner to the next."""
        return self._edge_tables[2]

    def edge_name(self, edge: int) -> str:
        """The name of an edge in messages."""
        i, j = self.edges[edge].tolist()
        return f"edge {edge} from vertex {i} to vertex {j}"

    @cached_property
    def edge_faces(self) -> IntArray:
        """(E, 2) left and right face, -1 where there is none."""
        corners = self.edge_corners
        return integers(np.where(corners >= 0, self.corner_face[corners], -1))

    @cached_property
    def twin(self) -> IntArray:
        """(C,) the corner whose half-edge runs the other way along the same edge, -1 at the boundary."""
        left, right = self.edge_corners.T
        twin = np.full(self.n_corners, -1, dtype=np.int64)
        twin[left] = right
        twin[right[right >= 0]] = left[right >= 0]
        return integers(twin)

    @cached_property
    def runs_along_edge(self) -> BoolArray:
        """(C,) whether the half-edge of a corner has the direction of its edge, so that its face is the left one."""
        along: BoolArray = self.edge_corners[self.corner_edge, 0] == np.arange(self.n_corners)
        return along

    @cached_property
    def is_boundary_edge(self) -> BoolArray:
        """(E,) whether an edge has one face only."""
        return self.edge_faces[:, 1] < 0

    @cached_property
    def is_boundary_vertex(self) -> BoolArray:
        """(N,) whether a vertex lies on a boundary edge."""
        on_boundary = np.zeros(self.n_vertices, dtype=bool)
        on_boundary[self.edges[self.is_boundary_edge]] = True
        return on_boundary

    @cached_property
    def inner_faces(self) -> IntArray:
        """The faces (n,) that have no vertex on the boundary."""
        outer = self.corner_face[self.is_boundary_vertex[self.corners]]
        return integers(np.setdiff1d(np.arange(self.n_faces), outer))

    # --- stars

    @cached_property
    def vertex_degrees(self) -> IntArray:
        """(N,) number of edges at each vertex."""
        return integers(np.bincount(self.edges.ravel(), minlength=self.n_vertices))

    @cached_property
    def is_used(self) -> BoolArray:
        """(N,) whether a vertex belongs to a face."""
        return self.vertex_degrees > 0

    @cached_property
    def adjacency(self) -> csr_array[np.float64, tuple[int, int]]:
        """(N, N) sparse, 1 where two vertices share an edge."""
        i, j = self.edges.T
        ones = np.ones(2 * self.n_edges)
        rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
        return coo_array((ones, (rows, columns)), shape=(self.n_vertices, self.n_vertices)).tocsr()

    # --- global properties

    @cached_property
    def boundary_loops(self) -> list[IntArray]:
        """The vertices of each boundary loop, with the mesh to the left; a vertex where two fans of faces meet occurs
        twice."""
        starts = np.flatnonzero(self.twin < 0)
        following = self.next_corner[starts]
        while (inner := self.twin[following] >= 0).any():  # turn about the head until the next boundary edge
            following = np.where(inner, self.next_corner[self.twin[following]], following)
        successor = dict(zip(starts.tolist(), following.tolist(), strict=True))
        loops = []
        while successor:
            first = corner = next(iter(successor))
            loop = []
            while corner in successor:
                loop.append(corner)
                corner = successor.pop(corner)
            assert corner == first
            loops.append(integers(self.corners[loop]))
        return loops

    @cached_property
    def euler_characteristic(self) -> int:
        """chi = V - E + F over the vertices in use."""
        return int(self.is_used.sum()) - self.n_edges + self.n_faces

    @cached_property
    def face_components(self) -> IntArray:
        """(F,) number of the edge-connected component of each face."""
        left, right = self.edge_faces[~self.is_boundary_edge].T
        pairs = coo_array((np.ones(len(left)), (left, right)), shape=(self.n_faces, self.n_faces))
        return integers(connected_components(pairs, directed=False)[1])

    def same_as(self, other: Combinatorics) -> bool:
        """Whether both have the same vertices and faces, with the same numbers."""
        return self is other or (
            self.n_vertices == other.n_vertices
            and np.array_equal(self.corners, other.corners)
            and np.array_equal(self.face_starts, other.face_starts)
        )

    def reversed(self) -> Combinatorics:
        """The same faces, seen from the other side."""
        order = self.face_starts[:-1][self.corner_face] + self.face_starts[1:][self.corner_face] - 1
        return Combinatorics(self.n_vertices, self.corners[order - np.arange(self.n_corners)], self.face_starts)

    # --- checks

    def _check_faces(self) -> None:
        if self.n_faces < 1:
            raise MeshError("the mesh has no faces")
        small = np.flatnonzero(self.face_sizes < 3)
        if len(small):
            face, size = int(small[0]), int(self.face_sizes[small[0]])
            raise MeshError(
                f"face {face} has {size} corners, at least 3 are needed", elements=[face], value=size, bound=3
            )
        wrong = np.flatnonzero((self.corners < 0) | (self.corners >= self.n_vertices))
        if len(wrong):
            face, vertex = int(self.corner_face[wrong[0]]), int(self.corners[wrong[0]])
            raise MeshError(
                f"face {face} names vertex {vertex}, but there are {self.n_vertices} vertices",
                elements=[face],
                value=vertex,
                bound=self.n_vertices - 1,
            )
        keys = np.sort(self.corner_face * self.n_vertices + self.corners)
        twice = np.flatnonzero(keys[1:] == keys[:-1])
        if len(twice):
            face, vertex = divmod(int(keys[twice[0]]), self.n_vertices)
            raise MeshError(f"face {face} touches itself: it meets vertex {vertex} twice", elements=[face])

    def _check_half_edges(self) -> None:
        tail, head = self.corners, self.corners[self.next_corner]
        keys = tail * self.n_vertices + head
        keys.sort()
        if (keys[1:] == keys[:-1]).any():
            sentence, faces = wrong_edge(self.n_vertices, self.corners, self.face_starts)
            raise MeshError(sentence, elements=faces)
