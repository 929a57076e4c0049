"""Closeness to given points, to a design surface, to a curve; and how much of an allowed distance is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError, MeshError
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Combinatorics
from geometry.mesh.polygons import perpendicular_pair
from geometry.optimise import Functional, LinearFunctional, SparseMatrix
from geometry.surface import Curve
from geometry.surface.surface import Surface, check_points

__all__ = ["InsideBalls", "OnCurve", "OnSmoothSurface", "OnSurface", "close_to"]


def close_to(
    points: Any, vertices: Sequence[int] | IntArray | None = None, *, n_vertices: int | None = None, weights: Any = None
) -> LinearFunctional:
    """x - points, for all vertices, or for chosen ones only; x (3N,) is all coordinates.

    points (N, 3); or, with `vertices` (k,) and the number `n_vertices` of all of them, points (k, 3): one for each
    chosen vertex, which may occur several times. weights: of the squared distances, one number from 0 upwards for each
    point; left out, all 1.

    Raises GeometryError for points that are not finite, for points, weights and vertices that are not equally many,
    and for weights that are negative or not finite; MeshError for a vertex that does not exist.

    >>> import numpy as np
    >>> from geometry import ParallelSpace
    >>> from geometry.functionals import close_to
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(4, 4)
    >>> corners, heights = [0, 4, 20, 24], np.array([[0.0, 0, 1], [0, 4, 1], [6, 0, 1], [6, 4, 1]])
    >>> nearest = ParallelSpace(grid).minimise([(1.0, close_to(heights, corners, n_vertices=25))])
    >>> nearest.vertices[corners].round(6).tolist()  # longer in one direction, lifted by 1
    [[0.0, 0.0, 1.0], [0.0, 4.0, 1.0], [6.0, 0.0, 1.0], [6.0, 4.0, 1.0]]
    """
    targets = check_points(points)
    if vertices is None:
        chosen, n = integers(np.arange(len(targets))), len(targets)
    elif n_vertices is None:
        raise GeometryError("vertices are chosen: give n_vertices too, the number of all vertices of the mesh")
    else:
        chosen, n = _checked(integers(vertices), n_vertices), n_vertices
    factors = np.ones(len(targets)) if weights is None else floats(weights)
    if not len(chosen) == len(targets) == factors.size:
        raise GeometryError(
            f"there are {len(targets)} points, {len(chosen)} vertices and {factors.size} weights: one of each is needed"
        )
    wrong = np.flatnonzero(~(np.isfinite(factors) & (factors >= 0)))
    if len(wrong):
        value = float(factors[wrong[0]])
        raise GeometryError(
            f"the weight of point {wrong[0]} is {value}: weights are numbers from 0 upwards",
            elements=wrong.tolist(),
            value=value,
            bound=0.0,
        )
    scale = np.repeat(np.sqrt(factors), 3)
    places = (scale, coordinates(chosen).ravel(), np.arange(3 * len(chosen) + 1))
    return LinearFunctional(csr_array(places, shape=(3 * len(chosen), 3 * n)), scale * targets.ravel())


@dataclass(frozen=True, eq=False)
class OnSurface:
    """f_close of chosen vertices and a design surface Phi [Pottmann2007, 4.4]; x (3 n_vertices,) is all coordinates.

    One residual for each: the distance along the normal of Phi at the closest point, positive on its side. The vertices
    glide freely along Phi and beyond its boundary. The Jacobian is exact on the triangles of Phi, up to terms of the
    order of the distance; between triangles it changes by about the angle between them. So use it as a constraint only
    where Phi is much finer than the mesh; on a coarse one, such as the triangles of the mesh itself, minimise |r|^2.
    Raises MeshError for a vertex that does not exist.

    >>> from geometry.mesh import shapes
    >>> r = OnSurface(Surface(shapes.grid(4, 4)), np.array([0, 1]), n_vertices=2)
    >>> r.residual(np.array([1.0, 1.0, 0.5, 2.0, 2.0, -0.25])).tolist()
    [0.5, -0.25]
    """

    surface: Surface
    vertices: IntArray
    n_vertices: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _checked(self.vertices, self.n_vertices))

    def residual(self, x: FloatArray) -> FloatArray:
        return self.surface.distances(x.reshape(-1, 3)[self.vertices])[0]

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        gradients = self.surface.distances(x.reshape(-1, 3)[self.vertices])[1]
        return _rows(gradients[:, None, :], self.vertices, self.n_vertices)


@dataclass(frozen=True, eq=False)
class OnSmoothSurface:
    """The same distances as `OnSurface`, for all vertices that belong to faces, as if Phi were smooth.

    The Jacobian consists of the normals at the closest points, which Gauss-Newton takes as constant in a step. It is
    continuous along Phi, also at the corners of its triangles, where the vertices start if they are those of Phi.

    >>> from geometry.mesh import shapes
    >>> mesh = shapes.grid(2, 2)
    >>> r = OnSmoothSurface(Surface(shapes.grid(4, 4)), mesh.combinatorics)
    >>> set(r.residual((mesh.vertices + [0, 0, 0.5]).ravel()).tolist())
    {0.5}
    """

    surface: Surface
    combinatorics: Combinatorics

    def residual(self, x: FloatArray) -> FloatArray:
        points = x.reshape(-1, 3)[self._used]
        feet, normals = self.surface.closest(points)
        return np.asarray(np.einsum("ni,ni->n", points - feet, normals))

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        normals = self.surface.closest(x.reshape(-1, 3)[self._used])[1]
        return _rows(normals[:, None, :], self._used, self.combinatorics.n_vertices)

    @property
    def _used(self) -> IntArray:
        return integers(np.flatnonzero(self.combinatorics.is_used))


@dataclass(frozen=True, eq=False)
class OnCurve:
    """Chosen vertices on a curve; x (3 n_vertices,) is all coordinates.

    Two residuals for each: the distances along two directions perpendicular to the tangent at the closest point. The
    vertices glide freely along the curve and straight on beyond its ends. They do not pass corners, so fix the vertices
    there. The Jacobian is exact up to terms of the order of the distance.
    Raises MeshError for a vertex that does not exist.

    >>> line = Curve.through(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), closed=False)
    >>> r = OnCurve(line, np.array([0]), n_vertices=1)
    >>> np.linalg.norm(r.residual(np.array([0.7, 0.3, 0.4]))).round(6).item()
    0.5
    """

    curve: Curve
    vertices: IntArray
    n_vertices: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _checked(self.vertices, self.n_vertices))

    def residual(self, x: FloatArray) -> FloatArray:
        points = x.reshape(-1, 3)[self.vertices]
        feet, tangents = self.curve.closest(points)
        return np.asarray(np.einsum("nki,ni->nk", perpendicular_pair(tangents), points - feet).ravel())

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        _, tangents = self.curve.closest(x.reshape(-1, 3)[self.vertices])
        return _rows(perpendicular_pair(tangents), self.vertices, self.n_vertices)


@dataclass(frozen=True, eq=False)
class InsideBalls:
    """radius - |r_i| for residuals of another functional, `size` of them each: positive where they are shorter.

    >>> line = Curve.through(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), closed=False)
    >>> near = InsideBalls(OnCurve(line, np.array([0]), n_vertices=1), size=2, radius=0.6)
    >>> near.residual(np.array([0.7, 0.3, 0.4])).round(6).tolist()
    [0.1]
    """

    functional: Functional
    size: int
    radius: float

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.radius - np.linalg.norm(self.functional.residual(x).reshape(-1, self.size), axis=1))

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        residuals = self.functional.residual(x).reshape(-1, self.size)
        lengths = np.linalg.norm(residuals, axis=1, keepdims=True)
        inwards = -np.divide(residuals, lengths, out=np.zeros_like(residuals), where=lengths > 0)
        starts = np.arange(0, inwards.size + 1, self.size)
        rows = csr_array((inwards.ravel(), np.arange(inwards.size), starts), shape=(len(inwards), inwards.size))
        return csr_array(rows @ self.functional.jacobian(x))


def _checked(vertices: IntArray, n_vertices: int) -> IntArray:
    chosen = integers(vertices).ravel()
    wrong = chosen[(chosen < 0) | (chosen >= n_vertices)]
    if len(wrong):
        raise MeshError(
            f"there is no vertex {wrong[0]}: the vertices end at {n_vertices - 1}",
            elements=wrong.tolist(),
            value=float(wrong[0]),
            bound=n_vertices - 1,
        )
    return chosen


def _rows(gradients: FloatArray, vertices: IntArray, n_vertices: int) -> SparseMatrix:
    """(n r, 3 n_vertices) from the gradients (n, r, 3) of r residuals of each vertex."""
    columns = np.broadcast_to(coordinates(vertices)[:, None, :], gradients.shape)
    starts = np.arange(0, gradients.size + 1, 3)
    return csr_array((gradients.ravel(), columns.ravel(), starts), shape=(gradients.size // 3, 3 * n_vertices))
