"""Triangles as parts of the complex plane, each with its own frame; vectors in a frame are complex numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import ComplexArray, FloatArray, IntArray, complexes, floats, integers
from geometry.mesh import Combinatorics, Mesh

__all__ = ["TangentFrames"]

AXIS_PAIRS = ((0, 0), (0, 1), (1, 1))
"""Pairs of axes of a frame that belong to the entries xx, xy and yy of a tensor."""


@dataclass(frozen=True, eq=False)
class TangentFrames:
    """Frames of the triangles of a mesh: the first axis runs from corner 0 to corner 1, the second is to its left.

    Corner k of triangle f is corner 3 f + k of the combinatorics; side k runs from corner k to the next one.
    """

    mesh: Mesh

    @property
    def combinatorics(self) -> Combinatorics:
        return self.mesh.combinatorics

    @property
    def n_triangles(self) -> int:
        return self.mesh.n_faces

    @cached_property
    def triangles(self) -> IntArray:
        """(F, 3) vertices."""
        return self.combinatorics.corners.reshape(-1, 3)

    @cached_property
    def areas(self) -> FloatArray:
        """(F,) areas of the triangles."""
        return floats(np.linalg.norm(self.mesh.vector_areas, axis=1))

    @cached_property
    def axes(self) -> FloatArray:
        """(F, 2, 3) the axes of the frames: unit vectors in space."""
        normals = self.mesh.vector_areas / self.areas[:, None]
        points = self.mesh.vertices[self.triangles]
        first = points[:, 1] - points[:, 0]
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        return floats(np.stack([first, np.cross(normals, first)], axis=1))

    @cached_property
    def sides(self) -> ComplexArray:
        """(F, 3) vectors along the sides, from each corner to the next."""
        points = self.mesh.vertices[self.triangles]
        return complexes(self.flat(np.roll(points, -1, axis=1) - points))

    @cached_property
    def gradients(self) -> ComplexArray:
        """(F, 3) gradients of the linear functions that are 1 at one corner and 0 at the two others."""
        return complexes(1j * np.roll(self.sides, -1, axis=1) / (2 * self.areas[:, None]))

    @cached_property
    def centres(self) -> FloatArray:
        """(F, 3) centroids of the triangles, in space."""
        return floats(self.mesh.vertices[self.triangles].mean(axis=1))

    @cached_property
    def inner_edges(self) -> tuple[IntArray, IntArray, IntArray]:
        """Edges inside (n,), and the triangles to their left and right (n,)."""
        c = self.combinatorics
        inner = np.flatnonzero(~c.is_boundary_edge)
        left, right = c.edge_faces[inner].T
        return integers(inner), integers(left), integers(right)

    @cached_property
    def stiffness(self) -> FloatArray:
        """(n,) for the inner edges: weights of the squared differences across them in the integral of |grad|^2."""
        inner, left, right = self.inner_edges
        return floats(3 * self.mesh.edge_lengths[inner] ** 2 / (self.areas[left] + self.areas[right]))

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree(self.centres)

    def nearest(self, points: FloatArray) -> IntArray:
        """(n,) the triangle whose centre is nearest to each point (n, 3)."""
        return np.asarray(self._tree.query(points)[1])

    def flat(self, vectors: FloatArray) -> ComplexArray:
        """Vectors (F, ..., 3) in space as vectors (F, ...) of the frames, without their components along the
        normals."""
        x, y = np.einsum("f...i,fai->af...", vectors, self.axes)
        return np.asarray(x + 1j * y)

    def in_space(self, vectors: ComplexArray) -> FloatArray:
        """(F, 3) vectors (F,) of the frames."""
        return np.asarray(vectors.real[:, None] * self.axes[:, 0] + vectors.imag[:, None] * self.axes[:, 1])

    def traceless(self, tensors: FloatArray) -> ComplexArray:
        """(F,) the traceless part q of symmetric bilinear forms (F, 3, 3): |q| is half the difference of their two
        principal values, and the angle of q is twice that of the direction of the larger one.
        """
        xx, xy, yy = (np.einsum("fi,fij,fj->f", self.axes[:, a], tensors, self.axes[:, b]) for a, b in AXIS_PAIRS)
        return np.asarray((xx - yy) / 2 + 1j * xy)

    @cached_property
    def edge_turns(self) -> FloatArray:
        """(E,) the change of the angle of a vector that is carried across an edge from the left to the right face, as
        if both were in one plane.

        Zero at the boundary.
        """
        c = self.combinatorics
        inner = ~c.is_boundary_edge
        left, right = c.edge_corners[inner].T
        turns = np.zeros(c.n_edges)
        turns[inner] = np.angle(-self.sides.ravel()[right] * self.sides.ravel()[left].conj())
        return floats(turns)
