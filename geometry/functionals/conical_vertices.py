"""Conical vertices, whose faces are tangent to a cone of revolution [Pottmann2007, Prop. 2].

That is: their normals lie on a circle of the unit sphere, k - 3 conditions on k faces. But normals nearly coincide
where a mesh is nearly flat, and nearly coincide in pairs where it is nearly a cylinder; there the
circle through them is ill-determined, and Newton's method on it goes astray. With four faces the condition can be
freed of the curvature: the normals n_i, n_i+1 on either side of an edge differ by a vector perpendicular to it, so
whether the four lie on a circle depends on the directions of the four edges only, namely on their angles w_i:
conical if and only if w_1 + w_3 = w_2 + w_4 [PottmannWallner2007]. This condition is used here for vertices with four
faces; it holds for the limits of conical vertices. Where all normals coincide, or in pairs on either side of a straight
line, they are on a circle whatever the angles are: there the equation asks for more than the definition.

With five faces and more, the condition depends on how the curvatures in the edges compare, which nothing says in a flat
mesh. There the residuals are distances of the normals from their best plane, over the sine of the cone's
opening, which makes angles of them. The sine is kept away from zero: flat vertices fulfil the condition.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, vstack
from scipy.sparse.csgraph import connected_components

from geometry.arrays import FloatArray, IntArray
from geometry.functionals.face_frames import FaceFrames
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics
from geometry.mesh.polygons import vector_areas
from geometry.optimise import SparseMatrix

__all__ = ["ConicalVertices", "closed_fans"]

FLAT_VERTEX_ANGLE = 1e-3
"""Angle of the normals with the axis, in radians, below which a vertex with five or more faces counts as flat. The
rounding of normals (1e-16) over this angle stays below tolerances of 1e-12."""

ALTERNATING = np.array([0.5, -0.5, 0.5, -0.5])
"""Of unit length, as the bases in `face_frames` are."""


def closed_fans(combinatorics: Combinatorics) -> list[IntArray]:
    """For each k: the interior vertices with k faces, each as its corners (n, k) in these faces, counter-clockwise.

    >>> from geometry.mesh import shapes
    >>> [fan.shape for fan in closed_fans(shapes.grid(3, 3).combinatorics)]  # four interior vertices with four faces
    [(4, 4)]
    """
    c = combinatorics
    onwards = c.twin[c.previous_corner]  # the corner at the same vertex in the next face, -1 at the boundary
    here = np.flatnonzero(onwards >= 0)
    steps = coo_array((np.ones(len(here)), (here, onwards[here])), shape=(c.n_corners, c.n_corners))
    fan = connected_components(steps, directed=False)[1]
    sizes = np.bincount(fan)
    sizes[fan[onwards < 0]] = 0  # open
    firsts = np.unique(fan, return_index=True)[1]
    fans = []
    for size in np.unique(sizes[sizes > 0]):
        ring = [firsts[sizes == size]]
        for _ in range(size - 1):
            ring.append(onwards[ring[-1]])
        fans.append(np.stack(ring, axis=1))
    return fans


@dataclass(frozen=True, eq=False)
class ConicalVertices:
    """k - 3 residuals for each interior vertex with k >= 4 faces, in radians; the unknown is all coordinates (3N,).

    First those with 4 faces, then the others by k. Faces must have an area. The Jacobian is exact where faces are
    planar and, for five faces and more, up to terms of the order of the residual.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(2, 2)
    >>> r = ConicalVertices(grid.combinatorics)
    >>> bent = grid.vertices + [(0.1, 0.2, 0.0) if k == 4 else (0, 0, 0) for k in range(9)]
    >>> r.residual(grid.vertices.ravel()).round(12).tolist() == [0.0], abs(r.residual(bent.ravel())).max().item() > 0.01
    (True, True)
    """

    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        positions = x.reshape(-1, 3)
        areas = vector_areas(positions, self.combinatorics)
        parts = [(self._angles(positions, areas)[self._crossings] @ ALTERNATING)]
        parts += [_Cones.of(areas, faces).residuals.ravel() for _, faces in self._larger]
        return np.concatenate(parts)

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        positions = x.reshape(-1, 3)
        areas = vector_areas(positions, self.combinatorics)
        parts = [self._angle_rows(positions, areas)]
        parts += [self._cone_rows(positions, areas, faces) for _, faces in self._larger]
        return csr_array(vstack(parts, format="csr"))

    # --- four faces

    @cached_property
    def _fans(self) -> dict[int, IntArray]:
        return {fans.shape[1]: fans for fans in closed_fans(self.combinatorics)}

    @property
    def _crossings(self) -> IntArray:
        """(n, 4) corners."""
        return self._fans.get(4, np.zeros((0, 4), dtype=np.int64))

    def _spokes(self, positions: FloatArray, areas: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(C, 3) at each corner: to the next one, to the one before, unit normal of the face."""
        c = self.combinatorics
        normals = areas / np.linalg.norm(areas, axis=1, keepdims=True)
        here = positions[c.corners]
        return here[c.next_corner] - here, here[c.previous_corner] - here, normals[c.corner_face]

    def _angles(self, positions: FloatArray, areas: FloatArray) -> FloatArray:
        """(C,) of the faces at their corners, more than pi where a corner turns backwards."""
        ahead, back, normals = self._spokes(positions, areas)
        across = np.einsum("ci,ci->c", normals, np.cross(ahead, back))
        return np.asarray(np.arctan2(across, np.einsum("ci,ci->c", ahead, back)) % (2 * np.pi))

    def _angle_rows(self, positions: FloatArray, areas: FloatArray) -> SparseMatrix:
        """Normals count as constant: rotating them does not change angles in their planes."""
        c, corners = self.combinatorics, self._crossings
        ahead, back, normals = (part[corners] for part in self._spokes(positions, areas))
        by_next = -np.cross(normals, ahead) / np.einsum("nki,nki->nk", ahead, ahead)[..., None]
        by_previous = np.cross(normals, back) / np.einsum("nki,nki->nk", back, back)[..., None]
        derivatives = np.stack([-by_next - by_previous, by_next, by_previous], axis=2) * ALTERNATING[:, None, None]
        at = np.stack([corners, c.next_corner[corners], c.previous_corner[corners]], axis=2)
        rows = np.broadcast_to(np.arange(len(corners))[:, None, None, None], derivatives.shape)
        return self._matrix(derivatives, rows, coordinates(c.corners[at]), len(corners))

    # --- five and more

    @cached_property
    def _larger(self) -> list[tuple[int, IntArray]]:
        """For each k > 4: k and the faces (n, k) around the vertices."""
        faces = self.combinatorics.corner_face
        return [(k, faces[corners]) for k, corners in sorted(self._fans.items()) if k > 4]

    def _cone_rows(self, positions: FloatArray, areas: FloatArray, faces: IntArray) -> SparseMatrix:
        """With A the vector area of a face, dA is half the sum of dp_i x (p_i+1 - p_i-1)."""
        c = self.combinatorics
        cones = _Cones.of(areas, faces)
        n, k, n_rows = cones.by_area.shape[:3]
        sizes = c.face_sizes[faces.ravel()]
        place = np.repeat(np.arange(n * k), sizes)  # of a face in its fan, once for each of its corners
        nth = np.arange(len(place)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        corners = c.face_starts[faces.ravel()][place] + nth
        diagonals = positions[c.corners[c.next_corner[corners]]] - positions[c.corners[c.previous_corner[corners]]]
        derivatives = np.cross(diagonals[:, None, :], cones.by_area.reshape(n * k, n_rows, 3)[place]) / 2
        rows = (place // k * n_rows)[:, None] + np.arange(n_rows)
        columns = coordinates(c.corners[corners])[:, None, :]
        return self._matrix(derivatives, rows[:, :, None], columns, n * n_rows)

    def _matrix(self, values: FloatArray, rows: IntArray, columns: IntArray, n_rows: int) -> SparseMatrix:
        places = tuple(np.broadcast_to(part, values.shape).ravel() for part in (rows, columns))
        return coo_array((values.ravel(), places), shape=(n_rows, 3 * self.combinatorics.n_vertices)).tocsr()


@dataclass(frozen=True, eq=False)
class _Cones:
    """Best cones of n fans of k faces.

    residuals (n, k-3) and by_area (n, k, k-3, 3): their derivatives by the vector areas of the faces.
    """

    residuals: FloatArray
    by_area: FloatArray

    @classmethod
    def of(cls, areas: FloatArray, faces: IntArray) -> _Cones:
        """areas (F, 3) and the faces (n, k) of the fans."""
        sizes = np.linalg.norm(areas, axis=1)[faces][..., None]
        normals = areas[faces] / sizes
        frames = FaceFrames.of(normals)
        axes = frames.normals[:, None, :]
        opening = np.sqrt((np.cross(axes, normals) ** 2).sum(axis=2).mean(axis=1) + FLAT_VERTEX_ANGLE**2)[:, None]
        across = axes - np.einsum("nki,nki->nk", np.broadcast_to(axes, normals.shape), normals)[..., None] * normals
        by_area = np.einsum("nkq,nki->nkqi", frames.basis, across / sizes) / opening[:, :, None, None]
        return cls(frames.project_out(frames.heights) / opening, by_area)
