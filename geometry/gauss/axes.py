"""Node axes: from a parallel mesh to axes, and back [Pottmann2007, Prop. 1]."""

from __future__ import annotations

from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError, MeshError, ParallelityError, raise_worst
from geometry.mesh import Mesh, MeshLike, as_gauss_image, as_mesh
from geometry.mesh.spanning_forests import SpanningForest, spanning_forest
from geometry.parallel.edge_parallelity import check_parallel, perpendicular_part

__all__ = ["AXIS_TOLERANCE", "axis_directions", "node_axes", "parallel_from_axes"]

AXIS_TOLERANCE = 1e-9
"""Angle in radians by which two axes may fail to be coplanar, and distance by which two meshes may fail to be
parallel, over their largest distance: the rounding of meshes a million times larger than their distance."""

LEAST_AXIS_ANGLE = 1e-6
"""Angle in radians between a node axis and an edge, below which the axis counts as lying in the edge: a thousand times
`AXIS_TOLERANCE`, so that the plane through edge and axis is still determined."""


def node_axes(mesh: MeshLike, parallel: MeshLike, *, tolerance: float = AXIS_TOLERANCE) -> FloatArray:
    """(N, 3) unit directions from m_i to m'_i: node axes of M, where M' is parallel to M; zero for vertices that belong
    to no face.

    tolerance: distance by which an end of an edge of M' may be off the direction of its edge of M, over the largest
    distance of corresponding vertices.

    Raises MeshError where the meshes do not have the same faces or an edge of M has no length, ParallelityError
    where they are not parallel, and GeometryError where a vertex is the same in both or an axis lies in an edge.

    >>> from geometry.mesh.shapes import grid
    >>> node_axes(grid(2, 2), grid(2, 2).translated([0, 0, 0.5]))[0].tolist()
    [0.0, 0.0, 1.0]
    """
    mesh = as_mesh(mesh)
    parallel = as_gauss_image(parallel)
    apart = parallel - mesh
    lengths = np.linalg.norm(apart.vertices, axis=1)
    largest = float(lengths.max())
    same = np.flatnonzero(mesh.combinatorics.is_used & (lengths <= tolerance * largest))
    if len(same):
        raise GeometryError(
            f"vertex {same[0]} is at the same place in both meshes, so it has no node axis; translate one of them",
            elements=same.tolist(),
            value=float(lengths[same[0]]),
            bound=tolerance * largest,
        )
    check_parallel(mesh, apart, tolerance * largest, what="the other mesh")
    axes = axis_directions(mesh, apart.vertices)
    _across(mesh, axes)
    return axes


def axis_directions(mesh: Mesh, vectors: FloatArray) -> FloatArray:
    """(N, 3) the vectors s_i at unit length; zero where s_i is zero, and for vertices that belong to no face."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    is_defined = (lengths > 0) & mesh.combinatorics.is_used[:, None]
    return floats(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=is_defined))


def parallel_from_axes(
    mesh: MeshLike, axes: Any, *, start: int = 0, distance: float = 1.0, tolerance: float = AXIS_TOLERANCE
) -> Mesh:
    """The mesh M' parallel to M with m'_i on the axis through m_i, and m'_start = m_start + distance axis_start.

    axes (N, 3): any vectors along the axes; their lengths and signs do not matter, except that the sign at `start`
    decides the direction of a positive `distance`. In each further component of M, its first vertex takes the place of
    `start`. Vertices that belong to no face do not move. tolerance: angle in radians by which the axes at both ends of
    an edge may fail to be coplanar, and relative distance between the positions of m'_i that follow from its
    neighbours.

    Raises ParallelityError, naming the worst edge, where its axes are not coplanar, or where M' does not
    close along a loop of edges, as Prop. 1 guarantees only for simply connected meshes with axes that lie in no face.
    Raises MeshError for an edge without length, GeometryError for axes that are zero or not finite.

    >>> from geometry.mesh.shapes import box
    >>> cube = box(2, 2, 2)
    >>> larger = parallel_from_axes(cube, cube.vertices, distance=3**0.5)  # axes from the centre
    >>> (larger.edge_lengths / cube.edge_lengths).round(9).max().item()
    2.0
    """
    mesh = as_mesh(mesh)
    directions = _checked_axes(mesh, axes)
    _check_start(mesh, start, distance)
    across = _across(mesh, directions)
    _check_coplanar(mesh, across, tolerance)
    c = mesh.combinatorics
    first, second = across[:, 0], across[:, 1]
    squares = np.einsum("enk,enk->en", across, across)
    ratio = np.sqrt(squares[:, 0] / squares[:, 1])  # of t_j over t_i: the parts across the edge are the same
    ratio *= np.sign(np.einsum("ek,ek->e", first, second))
    t = _along_forest(spanning_forest(c.n_vertices, c.edges, start=start), mesh, ratio, distance)
    _check_closed(mesh, across, t[c.edges], tolerance)
    return mesh.with_vertices(mesh.vertices + t[:, None] * directions)


def _along_forest(forest: SpanningForest, mesh: Mesh, ratio: FloatArray, distance: float) -> FloatArray:
    """t (N,): `distance` at the roots, multiplied by the ratios of the edges on the path from the root."""
    t = np.zeros(mesh.n_vertices)
    t[forest.roots] = distance
    for level in forest.levels:
        forwards = mesh.combinatorics.edges[level.edges, 0] == level.parents
        step = ratio[level.edges]
        t[level.children] = t[level.parents] * np.where(forwards, step, 1 / step)
    return t


def _across(mesh: Mesh, axes: FloatArray) -> FloatArray:
    """(E, 2, 3) the components of the axes at both ends perpendicular to the edge."""
    ends, along = axes[mesh.combinatorics.edges], mesh.edge_directions
    across = perpendicular_part(ends, along[:, None])
    sines = np.linalg.norm(across, axis=2)
    raise_worst(
        sines.min(axis=1),
        ">=",
        LEAST_AXIS_ANGLE,
        lambda edge, sine: (
            f"the node axis at vertex {mesh.combinatorics.edges[edge, sines[edge].argmin()]} lies in "
            f"{mesh.combinatorics.edge_name(edge)}: the angle between them is {np.degrees(sine):.1e} degrees, at least "
            f"{np.degrees(LEAST_AXIS_ANGLE):.1e} is needed"
        ),
    )
    return across


def _checked_axes(mesh: Mesh, axes: Any) -> FloatArray:
    given = floats(axes)
    if given.shape != (mesh.n_vertices, 3):
        raise MeshError(f"axes have shape {given.shape}, one vector a vertex is needed: {(mesh.n_vertices, 3)}")
    wrong = np.flatnonzero(mesh.combinatorics.is_used & ~(np.isfinite(given).all(axis=1) & given.any(axis=1)))
    if len(wrong):
        raise GeometryError(
            f"the axis at vertex {wrong[0]} is {given[wrong[0]].tolist()}: a direction must be finite and not zero",
            elements=wrong.tolist(),
        )
    scale = np.abs(given).max(axis=1, keepdims=True)  # so that no square leaves the range of a double
    return axis_directions(mesh, np.divide(given, scale, out=np.zeros_like(given), where=scale > 0))


def _check_start(mesh: Mesh, start: int, distance: float) -> None:
    if not (0 <= start < mesh.n_vertices and mesh.combinatorics.is_used[start]):
        raise GeometryError(f"there is no vertex {start} with a face to start from", elements=[start])
    if not (np.isfinite(distance) and distance != 0):
        raise GeometryError(
            f"the distance at vertex {start} is {distance:g}, it must be a number other than 0", elements=[start]
        )


def _check_coplanar(mesh: Mesh, across: FloatArray, tolerance: float) -> None:
    first, second = across[:, 0], across[:, 1]
    twists = np.arctan2(
        np.linalg.norm(np.cross(first, second), axis=1), np.abs(np.einsum("ek,ek->e", first, second))
    )  # axes are lines
    raise_worst(
        twists,
        "<=",
        tolerance,
        lambda edge, twist: (
            f"the axes at both ends of {mesh.combinatorics.edge_name(edge)} are not coplanar: the planes that they "
            f"span with the edge differ by {np.degrees(twist):.2g} degrees, allowed {np.degrees(tolerance):.1e}; no "
            "mesh parallel to this one has its vertices on these axes"
        ),
        error=ParallelityError,
    )


def _check_closed(mesh: Mesh, across: FloatArray, t: FloatArray, tolerance: float) -> None:
    """across (E, 2, 3), t (E, 2): where M' is parallel, t across is the same at both ends."""
    apart = np.linalg.norm(t[:, :1] * across[:, 0] - t[:, 1:] * across[:, 1], axis=1)
    raise_worst(
        apart / np.abs(t).max(axis=1),
        "<=",
        tolerance,
        lambda edge, gap: (
            f"the axes are coplanar over each edge, but no parallel mesh has its vertices on them: along a "
            f"loop of edges through {mesh.combinatorics.edge_name(edge)}, its vertices return {gap:.2g} of "
            f"their distance off, allowed {tolerance:.0e}; this happens around a hole, or where axes lie in the plane "
            "of a face"
        ),
        error=ParallelityError,
    )
