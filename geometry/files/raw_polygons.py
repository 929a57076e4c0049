"""Polygons as a file holds them, before anything is checked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers
from geometry.errors import MAX_NAMED_FINDINGS, MeshError, listed
from geometry.mesh import Mesh
from geometry.mesh.combinatorics import corners_and_sizes
from geometry.mesh.ragged_arrays import next_in_row, row_of_entry

__all__ = ["RawPolygons"]


@dataclass(frozen=True, eq=False)
class RawPolygons:
    """Vertices and faces that may have any defect, and how messages count them.

    vertices (N, 3); corners (C,) and face_starts (F+1,) as in Combinatorics.
    origins (N,), face_origins (F,): the number in the file, counted from 0, of each vertex and each face; vertices may
    have been welded, and both may have been removed.
    count_from: the number that the file gives to its first vertex and to its first face.
    mended: a sentence for each thing that was mended.
    companion (N, 3): the positions of these vertices in another mesh over the same faces, which is mended likewise.

    Raises MeshError where vertices do not have three coordinates each.
    """

    vertices: FloatArray
    corners: IntArray
    face_starts: IntArray
    origins: IntArray
    face_origins: IntArray
    count_from: int = 0
    mended: tuple[str, ...] = ()
    companion: FloatArray | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices))
        for name in ("corners", "face_starts", "origins", "face_origins"):
            object.__setattr__(self, name, integers(getattr(self, name)))
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise MeshError(f"vertices have shape {self.vertices.shape}: each needs three coordinates, (n, 3)")

    @classmethod
    def from_arrays(
        cls, vertices: Any, corners: Any, sizes: Any, *, count_from: int = 0, mended: tuple[str, ...] = ()
    ) -> RawPolygons:
        """From positions (N, 3), the vertices of all corners (C,) and the number of corners of each face (F,)."""
        starts = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
        origins = np.arange(len(vertices)), np.arange(len(starts) - 1)
        return cls(vertices, corners, starts, *origins, count_from, mended)

    @classmethod
    def from_faces(cls, vertices: Any, faces: Iterable[Sequence[int]]) -> RawPolygons:
        """From positions (N, 3) and one sequence of vertices, counted from 0, for each face."""
        return cls.from_arrays(np.asarray(vertices, dtype=np.float64), *corners_and_sizes(faces))

    @classmethod
    def from_mesh(cls, mesh: Mesh) -> RawPolygons:
        """The faces of a mesh, with the numbers they have there."""
        c = mesh.combinatorics
        return cls(mesh.vertices, c.corners, c.face_starts, np.arange(c.n_vertices), np.arange(c.n_faces))

    @property
    def n_vertices(self) -> int:
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        return len(self.face_starts) - 1

    @cached_property
    def face_sizes(self) -> IntArray:
        """(F,) number of corners of each face."""
        return integers(np.diff(self.face_starts))

    @cached_property
    def corner_face(self) -> IntArray:
        """(C,) face of each corner."""
        return row_of_entry(self.face_starts)

    @cached_property
    def heads(self) -> IntArray:
        """(C,) the vertex of the next corner of the face; no face may be empty."""
        return integers(self.corners[next_in_row(self.face_starts)])

    @cached_property
    def corner_edge(self) -> IntArray:
        """(C,) a number for the edge from each corner to the next, the same from both sides."""
        low, high = np.minimum(self.corners, self.heads), np.maximum(self.corners, self.heads)
        return integers(np.unique(low * self.n_vertices + high, return_inverse=True)[1])

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """(C,) length of the edge from each corner to the next."""
        return floats(np.linalg.norm(self.vertices[self.heads] - self.vertices[self.corners], axis=1))

    def vertex_name(self, vertex: int) -> str:
        """The number of a vertex in the file."""
        return str(int(self.origins[vertex]) + self.count_from)

    def face_name(self, face: int) -> str:
        """The number of a face in the file."""
        return str(int(self.face_origins[face]) + self.count_from)

    def face_names(self, faces: IntArray) -> str:
        """Faces (n,) in a message: "face 3", "faces 3 and 5", "faces 1, 2, 3, 4, 5 and 37 more"."""
        return f"face{'s' * (len(faces) != 1)} {listed(map(self.face_name, faces), len(faces))}"

    def corner_names(self, face: int) -> str:
        """The vertices of a face in a message, in their order around it."""
        corners = self.corners[self.face_starts[face] : self.face_starts[face + 1]]
        more = f" and {len(corners) - MAX_NAMED_FINDINGS} more" if len(corners) > MAX_NAMED_FINDINGS else ""
        return ", ".join(map(self.vertex_name, corners[:MAX_NAMED_FINDINGS])) + more

    def likewise(self, faces: IntArray) -> str:
        """The end of a message about a face, which names the other faces with the same defect; empty if there are
        none."""
        return f"; likewise {self.face_names(faces)}" if len(faces) else ""

    def likewise_vertices(self, vertices: IntArray) -> str:
        """The same for vertices."""
        return f"; likewise {listed(map(self.vertex_name, vertices), len(vertices))}" if len(vertices) else ""

    def faces_of_file(self, faces: IntArray) -> list[int]:
        """Faces (n,) as the elements of an error: by their numbers in the file, counted from 0, sorted."""
        found: list[int] = np.unique(self.face_origins[faces]).tolist()
        return found

    @cached_property
    def is_used(self) -> BoolArray:
        """(N,) whether a vertex belongs to a face."""
        used = np.zeros(self.n_vertices, dtype=bool)
        used[self.corners] = True
        return used

    @cached_property
    def is_open(self) -> BoolArray:
        """(C,) whether the edge from each corner to the next has one face only."""
        is_open: BoolArray = (np.bincount(self.corner_edge) == 1)[self.corner_edge]
        return is_open

    @property
    def counting(self) -> str:
        """The end of a message, which says from what number it counts."""
        return f"(vertices and faces counted from {self.count_from})"

    def with_faces(self, corners: Any, face_starts: Any, *mended: str) -> RawPolygons:
        """The same vertices with other faces; `mended`: sentences that are added."""
        return replace(self, corners=corners, face_starts=face_starts, mended=self.mended + tuple(mended))

    def without_corners(self, is_removed: BoolArray, *mended: str) -> RawPolygons:
        """The same faces without the removed corners (C,); `mended`: sentences that are added."""
        remaining = np.bincount(self.corner_face, ~is_removed, minlength=self.n_faces)
        starts = np.concatenate([[0], np.cumsum(remaining, dtype=np.int64)])
        return self.with_faces(self.corners[~is_removed], starts, *mended)

    def without_faces(self, is_removed: BoolArray, *mended: str) -> RawPolygons:
        """The same vertices without the removed faces (F,); `mended`: sentences that are added."""
        starts = np.concatenate([[0], np.cumsum(self.face_sizes[~is_removed])])
        kept = self.corners[~is_removed[self.corner_face]]
        return replace(self.with_faces(kept, starts, *mended), face_origins=self.face_origins[~is_removed])

    def without_unused(self, *mended: str) -> RawPolygons:
        """Without vertices that belong to no face; `mended`: sentences that are added."""
        used = self.is_used
        return replace(
            self,
            vertices=self.vertices[used],
            corners=(np.cumsum(used) - 1)[self.corners],
            origins=self.origins[used],
            mended=self.mended + tuple(mended),
            companion=None if self.companion is None else self.companion[used],
        )
