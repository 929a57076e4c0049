"""The guides of the vertices while the faces of a mesh are optimised: a surface, curves, fixed vertices, convexity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, integers, short_repr
from geometry.errors import GeometryError, MeshError, described, finite_number, printable, raise_worst
from geometry.mesh import Mesh
from geometry.surface import Curve, Surface

__all__ = ["Effort", "Faces", "Guides", "Indices", "MeshGuides", "in_edge_lengths"]

Indices: TypeAlias = "Sequence[int] | IntArray"
"""Vertices or faces by their numbers."""

Faces: TypeAlias = "Indices | Literal['all']"
"""Faces by their numbers, or all of them."""


def in_edge_lengths(mesh: Mesh) -> FloatArray:
    """(N, 3) vertices relative to their centroid, in mean edge lengths."""
    return np.asarray((mesh.vertices - mesh.vertices.mean(axis=0)) / mesh.mean_edge_length)


@dataclass(frozen=True, eq=False)
class Guides:
    """Guides of the vertices of a mesh. Lengths are relative to the mean edge length of the mesh.

    fairness: weight of the strain of edges, see `functionals.strain`, over the weight of squared moves. A small one
      (0.01) stays closer to the given vertices on average, but turns and shortens edges more; with a large one, edges
      collapse less easily.
    surface: vertices glide on it: squared distances from it weigh 10 times as much as squared moves, and
      those of what exceeds 0.05 edges 100 times as much. The largest remaining distance is part of the result.
    fixed: vertices that keep their positions exactly.
    curves: paths of vertices along edges; a path whose last vertex is its first one is closed. Their vertices slide on
      the spline through them, see `Curve.through`; ends, corners and crossings of curves keep their positions.
    keep_boundary: the same for all boundary loops; where there is a surface, too, their vertices are attracted to the
      spline instead of bound to it, with a weight of 30: faces at a boundary that crosses the lines of the mesh are
      planar some hundredths of an edge beside it, or folded on it. So are corners next to other corners, as of a jagged
      boundary; faces could not become planar between them.
    convex: faces all of whose corners have to turn to the same side, by `result_checks.LEAST_CONVEX_TURN` or more; or
      "all".

    Raises GeometryError for a surface that is no Surface, and a fairness that is negative or not finite.

    >>> import geometry
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(6, 6)
    >>> shell = grid.with_vertices([(x, y, -0.05 * (x * x + x * y / 4 + y * y)) for x, y, _ in grid.vertices])
    >>> corners = [0, 6, 42, 48]
    >>> result = geometry.planarise(shell, Guides(fairness=0.01, fixed=corners, surface=geometry.Surface(shell)))
    >>> result.moves[corners].tolist(), result.surface_distance < 0.05
    ([0.0, 0.0, 0.0, 0.0], True)
    """

    __repr__ = short_repr

    fairness: float = 0.3
    surface: Surface | None = None
    fixed: Indices = ()
    curves: Sequence[Indices] = ()
    keep_boundary: bool = False
    convex: Faces = ()

    def __post_init__(self) -> None:
        _check_number("fairness", self.fairness)
        if self.surface is not None and not isinstance(self.surface, Surface):
            raise GeometryError(
                f"the surface is a {type(self.surface).__name__}, not a Surface: make one by Surface(mesh)"
            )

    def expected_dimension(self, mesh: Mesh) -> int:
        """The number of free coordinates minus the number of equations for planar faces and curves, as an estimate.

        A face with a free vertex makes one equation for each corner beyond three. Where the number is not positive, the
        faces cannot become planar in general, unless equations depend on each other as those of planar meshes do: fix
        fewer vertices. Circular and conical meshes have twice as many equations. Raises as `planarise` does for
        vertices, faces and curves that do not fit the mesh.

        >>> from geometry import Guides
        >>> from geometry.mesh import shapes
        >>> for n in (2, 3, 8):
        ...     grid = shapes.grid(n, n)
        ...     boundary = grid.combinatorics.is_boundary_vertex.nonzero()[0]
        ...     print(Guides().expected_dimension(grid), Guides(fixed=boundary).expected_dimension(grid))
        23 -1
        39 3
        179 83
        """
        return MeshGuides.of(mesh, self).expected_dimension(mesh)


@dataclass(frozen=True)
class Effort:
    """Tolerance and numbers of steps. Raises GeometryError for numbers that are negative or not finite.

    tolerance: largest distance from planes, circles and curves in mean edge lengths, from cones in radians.
    anchored_steps: Newton steps that also minimise the distance from the given vertices. Each later step is the
      shortest one to the constraints, which converges quadratically. None: 16 in `planarise`, else 8.
    max_steps: Newton steps in all.

    >>> import geometry
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(6, 6)
    >>> shell = grid.with_vertices([(x, y, -0.05 * (x * x + x * y / 4 + y * y)) for x, y, _ in grid.vertices])
    >>> result = geometry.planarise(shell, effort=Effort(tolerance=1e-6, anchored_steps=4))
    >>> result.plane_deviation_after < 1e-6, result.iterations <= 6
    (True, True)
    """

    tolerance: float = 1e-12
    anchored_steps: int | None = None
    max_steps: int = 50

    def __post_init__(self) -> None:
        _check_number("tolerance", self.tolerance)
        _check_number("anchored_steps", 0 if self.anchored_steps is None else self.anchored_steps)
        _check_number("max_steps", self.max_steps)


def _check_number(name: str, number: float) -> None:
    if finite_number(name, number) < 0:
        raise GeometryError(f"{name} is {number}: a number from 0 upwards is needed", value=number, bound=0)


@dataclass(frozen=True, eq=False)
class MeshGuides:
    """Guides checked and evaluated for one mesh.

    surface: the one on which vertices slide, or None. is_fixed (N,): vertices that keep their positions. curves: each
    with the vertices that slide on it, relative to the centroid of the mesh and in mean edge lengths. boundary: the
    same of curves that vertices are attracted to. convex: faces that have to be convex.
    """

    fairness: float
    surface: Surface | None
    is_fixed: BoolArray
    curves: tuple[tuple[Curve, IntArray], ...]
    boundary: tuple[tuple[Curve, IntArray], ...]
    convex: IntArray

    @classmethod
    def of(cls, mesh: Mesh, guides: Guides) -> MeshGuides:
        """The guides for a mesh. Ends and corners of curves are fixed, and so are vertices on two curves.

        Raises MeshError for an edge without length, and GeometryError for a vertex or face that does not exist and for
        a curve that does not run along edges or meets itself.
        """
        _check_edges(mesh)
        is_fixed = np.zeros(mesh.n_vertices, dtype=bool)
        is_fixed[_indices("fixed", guides.fixed, mesh.n_vertices, "vertices")] = True
        paths = [_path(mesh, number, curve) for number, curve in enumerate(guides.curves)]
        if guides.keep_boundary:
            paths += [(loop, True) for loop in mesh.combinatorics.boundary_loops]
        positions = in_edge_lengths(mesh)
        made = [(Curve.through(positions[path], closed=closed), path) for path, closed in paths]
        n_curves = np.bincount(
            np.concatenate([np.zeros(0, np.int64), *(path for path, _ in paths)]), minlength=len(is_fixed)
        )
        is_fixed |= n_curves > 1
        n_exact = len(guides.curves) if guides.surface is not None else len(made)
        for number, (curve, path) in enumerate(made):
            is_fixed[path[curve.corners if number < n_exact else _isolated(curve.corners, len(path))]] = True
            is_fixed[path[:0] if curve.closed else path[[0, -1]]] = True
        sliding = [(curve, integers(path[~is_fixed[path]])) for curve, path in made]
        convex = guides.convex
        faces = range(mesh.n_faces) if isinstance(convex, str) and convex == "all" else convex
        return cls(
            guides.fairness,
            guides.surface,
            is_fixed,
            tuple(sliding[:n_exact]),
            tuple(sliding[n_exact:]),
            _indices("convex", faces, mesh.n_faces, "faces"),
        )

    def is_free(self, mesh: Mesh) -> BoolArray:
        """(N,) the vertices that belong to a face and are not fixed."""
        return np.asarray(mesh.combinatorics.is_used & ~self.is_fixed)

    def expected_dimension(self, mesh: Mesh) -> int:
        """See `Guides.expected_dimension`."""
        c, free = mesh.combinatorics, self.is_free(mesh)
        has_free_vertex = np.logical_or.reduceat(free[c.corners], c.face_starts[:-1])
        on_curves = sum(len(vertices) for _, vertices in self.curves)
        return int(3 * free.sum() - (c.face_sizes[has_free_vertex] - 3).sum() - 2 * on_curves)


def _isolated(corners: IntArray, n_points: int) -> IntArray:
    """The corners of a closed curve through n points that are not next to another corner."""
    is_corner = np.zeros(n_points, dtype=bool)
    is_corner[corners] = True
    return integers(np.flatnonzero(is_corner & ~np.roll(is_corner, 1) & ~np.roll(is_corner, -1)))


def _check_edges(mesh: Mesh) -> None:
    raise_worst(
        mesh.edge_lengths,
        ">",
        0.0,
        lambda edge, _: f"{mesh.combinatorics.edge_name(edge)} has no length: make its two vertices one",
        error=MeshError,
    )


def _indices(name: str, values: Any, count: int, noun: str) -> IntArray:
    """The values, if they are indices below `count`; otherwise GeometryError."""
    found = np.array([]) if isinstance(values, str) else np.asarray(values)
    if isinstance(values, str) or found.ndim != 1 or (found.size and found.dtype.kind not in "iu"):
        given = described(values) if isinstance(values, np.ndarray) else printable(repr(values))
        cure = "; np.flatnonzero turns a mask into numbers" if found.dtype.kind == "b" else ""
        raise GeometryError(f"{name} is {given}: {noun} are given by their numbers, in a sequence{cure}")
    wrong = found[(found < 0) | (found >= count)]
    if len(wrong):
        raise GeometryError(
            f"{name} names {wrong[0]}, but {noun} have the numbers 0 to {count - 1}",
            elements=wrong.tolist(),
            value=float(wrong[0]),
            bound=count - 1,
        )
    return integers(found)


def _path(mesh: Mesh, number: int, curve: Indices) -> tuple[IntArray, bool]:
    """The vertices along a curve, each once, and whether the curve is closed."""
    name = f"curve {number}"
    path = _indices(name, curve, mesh.n_vertices, "vertices")
    closed = len(path) > 1 and bool(path[0] == path[-1])
    once = path[:-1] if closed else path
    if len(once) < 2 + closed:
        raise GeometryError(f"{name} has {len(once)} vertices: at least 2 are needed, and 3 where it is closed")
    values, counts = np.unique(once, return_counts=True)
    if counts.max() > 1:
        vertex = int(values[counts.argmax()])
        raise GeometryError(f"{name} passes vertex {vertex} twice: split it into two curves", elements=[vertex])
    steps = np.sort(np.stack([path[:-1], path[1:]], axis=1), axis=1) @ [mesh.n_vertices, 1]
    edges = np.sort(mesh.combinatorics.edges, axis=1) @ [mesh.n_vertices, 1]
    without_edge = np.flatnonzero(~np.isin(steps, edges))
    if len(without_edge):
        i, j = path[without_edge[0] : without_edge[0] + 2].tolist()
        raise GeometryError(
            f"{name} runs from vertex {i} to vertex {j}, which no edge joins: list all vertices along it",
            elements=[i, j],
        )
    return once, closed
