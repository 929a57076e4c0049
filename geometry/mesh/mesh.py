"""A mesh: positions over a combinatorics. M, a parallel mesh, a Gauss image, a Koebe polyhedron: all are this."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats
from geometry.errors import MeshError, raise_worst
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.origin import whole_origin
from geometry.mesh.polygons import best_planes, face_mean_edge_lengths, vector_areas

__all__ = ["Mesh"]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices (N, 3), read-only, over a combinatorics shared by reference.

    Meshes over the same combinatorics form a vector space: `+`, `-`, and `*` with a number.
    Raises MeshError where the shape does not fit or a coordinate is not finite.
    """

    vertices: FloatArray
    combinatorics: Combinatorics

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices))
        expected = (self.combinatorics.n_vertices, 3)
        if self.vertices.shape != expected:
            raise MeshError(f"vertices have shape {self.vertices.shape}, the faces need {expected}")
        broken = np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))
        if len(broken):
            vertex = int(broken[0])
            raise MeshError(
                f"vertex {vertex} is {self.vertices[vertex].tolist()}: coordinates must be finite numbers",
                elements=broken.tolist(),
            )

    @classmethod
    def from_faces(cls, vertices: Any, faces: Iterable[Sequence[int]]) -> Mesh:
        """From positions (N, 3) and one sequence of vertices a face, counter-clockwise seen from outside."""
        positions = floats(vertices)
        return cls(positions, Combinatorics.from_faces(len(positions), faces))

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

    def __sub__(self, other: Mesh) -> Mesh:
        return self.with_vertices(self.vertices - self._equivalent(other).vertices)

    def __mul__(self, factor: float) -> Mesh:
        return self.with_vertices(self.vertices * factor)

    __rmul__ = __mul__

    def _equivalent(self, other: Mesh) -> Mesh:
        if not self.combinatorics.same_as(other.combinatorics):
            raise MeshError("the two meshes do not have the same faces: linear combinations need equal combinatorics")
        return other

    def translated(self, vector: Any) -> Mesh:
        """All vertices moved by a vector (3,). Translates of a Gauss image are Gauss images [Pottmann2007, 4.4]."""
        shift = floats(vector)
        if shift.shape != (3,):
            raise MeshError(f"a mesh is translated by a vector of 3 numbers, not by an array of shape {shift.shape}")
        return self.with_vertices(self.vertices + shift)

    def near_zero(self) -> tuple[Mesh, FloatArray]:
        """This mesh moved to zero by whole numbers, so that nothing is rounded, and the origin (3,) that was taken out.

        What is computed of a mesh far from zero, as at map coordinates, is coarse as its coordinates are: begin here,
        and put the origin back at the end, by `translated` or `write_mesh`. See `geometry.mesh.origin`.
        """
        origin = whole_origin(self.vertices[self.combinatorics.is_used])
        return self.with_vertices(self.vertices - origin), origin

    def part(self, faces: IntArray) -> Mesh:
        """A mesh of some of the faces (k,), in that order, and of the vertices they use, in the order these have."""
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
        """(E,)"""
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
