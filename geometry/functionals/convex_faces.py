"""Convex faces: an inequality for each corner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import MeshError
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics
from geometry.mesh.polygons import vector_areas
from geometry.optimise import SparseMatrix

__all__ = ["ConvexFaces"]


@dataclass(frozen=True, eq=False)
class ConvexFaces:
    """One residual for each corner of the chosen faces, >= 0 where the corner is convex or straight.

    With a the edge to the corner, b the edge from it and n the unit normal of the face, the residual is
    n . (a x b) over the mean length of a and b: in the unit of the coordinates, and zero where the corner is straight.
    Residuals are in the order of the chosen faces. The normal is that of the vector area, which must not vanish. The
    Jacobian takes it as constant, which is exact where faces are planar.

    Raises MeshError for a face that does not exist.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(1, 1)
    >>> r = ConvexFaces(grid.combinatorics, np.array([0]))
    >>> dart = grid.vertices - [(0, 0, 0), (0, 0, 0), (0, 0, 0), (0.7, 0.7, 0)]
    >>> r.residual(grid.vertices.ravel()).tolist(), (r.residual(dart.ravel()) < 0).sum().item()
    ([1.0, 1.0, 1.0, 1.0], 1)
    """

    combinatorics: Combinatorics
    faces: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", integers(self.faces).ravel())
        wrong = [face for face in self.faces.tolist() if not 0 <= face < self.combinatorics.n_faces]
        if wrong:
            raise MeshError(
                f"there is no face {wrong[0]} to keep convex: the faces end at {self.combinatorics.n_faces - 1}",
                elements=wrong,
                value=wrong[0],
                bound=self.combinatorics.n_faces - 1,
            )

    def residual(self, x: FloatArray) -> FloatArray:
        return self._turns(x)[3]

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        a, b, normals, turns = self._turns(x)
        lengths = [np.linalg.norm(edges, axis=1, keepdims=True) for edges in (a, b)]
        mean, turn = (lengths[0] + lengths[1]) / 2, turns[:, None] / 2
        by_a = (np.cross(b, normals) - turn * a / lengths[0]) / mean
        by_b = (np.cross(normals, a) - turn * b / lengths[1]) / mean
        values = np.concatenate([-by_a, by_a - by_b, by_b], axis=1)
        starts = np.arange(0, values.size + 1, 9)
        columns = coordinates(self._corners).ravel()
        return csr_array((values.ravel(), columns, starts), shape=(len(turns), 3 * self.combinatorics.n_vertices))

    @cached_property
    def _corners(self) -> IntArray:
        """(m, 3) the vertices before, at and after each corner."""
        c = self.combinatorics
        sizes = c.face_sizes[self.faces]
        nth = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        corners = np.repeat(c.face_starts[self.faces], sizes) + nth
        return integers(c.corners[np.stack([c.previous_corner[corners], corners, c.next_corner[corners]], axis=1)])

    def _turns(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """At each corner: a, b and n (m, 3), and the residual (m,)."""
        positions = x.reshape(-1, 3)
        before, here, after = positions[self._corners].swapaxes(0, 1)
        a, b = here - before, after - here
        areas = vector_areas(positions, self.combinatorics)[self.faces]
        normals = areas / np.linalg.norm(areas, axis=1, keepdims=True)
        normals = np.repeat(normals, self.combinatorics.face_sizes[self.faces], axis=0)
        mean = (np.linalg.norm(a, axis=1) + np.linalg.norm(b, axis=1)) / 2
        return a, b, normals, np.einsum("ci,ci->c", normals, np.cross(a, b)) / mean
