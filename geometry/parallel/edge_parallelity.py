"""Parallelity and edge factors of two meshes, and checks of parallelity and planarity."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.errors import MeshError, ParallelityError, raise_worst
from geometry.functionals import relative_plane_deviations
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.mesh.coordinate_rounding import far_from_zero_cure

__all__ = ["PLANARITY_TOLERANCE", "check_parallel", "check_planar", "edge_factors", "parallelity", "perpendicular_part"]

PLANARITY_TOLERANCE = 1e-12
"""Largest distance of a corner from the plane of its face, over the mean edge length: `planarise` reaches it."""


def parallelity(mesh: MeshLike, other: MeshLike) -> FloatArray:
    """(E,) length of the component of s_j - s_i perpendicular to m_j - m_i, where S is `other`; zero where parallel.

    In the unit of S. Raises MeshError where the meshes do not have the same faces, and for an edge of `mesh` without
    length.

    >>> from geometry.mesh import shapes
    >>> M = shapes.grid(1, 1)
    >>> S = M.with_vertices([(0, 0, 0), (0, 2, 0), (3, 0, 0), (3, 2, 0.1)])
    >>> sorted(parallelity(M, S).tolist())
    [0.0, 0.0, 0.1, 0.1]
    """
    mesh = as_mesh(mesh)
    other = as_mesh(other)
    _, perpendicular = _along_and_perpendicular(mesh, other)
    return np.asarray(np.linalg.norm(perpendicular, axis=1))


def edge_factors(mesh: MeshLike, other: MeshLike) -> FloatArray:
    """(E,) the factors lambda of s_j - s_i = lambda (m_j - m_i), by projection [Pottmann2007, (1)].

    Negative where an edge of S runs opposite to that of M. Raises as `parallelity` does.

    >>> from geometry.mesh import shapes
    >>> M = shapes.grid(1, 1)
    >>> S = M.with_vertices(M.vertices * [3, -2, 1])
    >>> sorted(edge_factors(M, S).tolist())
    [-2.0, -2.0, 3.0, 3.0]
    """
    mesh = as_mesh(mesh)
    other = as_mesh(other)
    along, _ = _along_and_perpendicular(mesh, other)
    return along / mesh.edge_lengths


def perpendicular_part(vectors: FloatArray, directions: FloatArray) -> FloatArray:
    """The components of vectors (..., 3) perpendicular to unit directions (..., 3)."""
    along = np.einsum("...k,...k->...", vectors, directions)
    return np.asarray(vectors - along[..., None] * directions)


def check_parallel(mesh: Mesh, other: Mesh, bound: float, *, what: str) -> None:
    """Raise ParallelityError, naming the worst edge, where `parallelity` is above the bound. what: name of `other`."""
    raise_worst(
        parallelity(mesh, other),
        "<=",
        bound,
        lambda edge, value: (
            f"{mesh.combinatorics.edge_name(edge)} of {what} is off the direction of its mesh edge by "
            f"{value:.1e}, allowed {bound:.1e}: the two meshes are not parallel; the nearest that is comes from "
            "ParallelSpace(mesh).project(other)"
        ),
        error=ParallelityError,
    )


def check_planar(mesh: Mesh) -> None:
    """Raise GeometryError for a face off its plane by more than `PLANARITY_TOLERANCE` times the mean edge length."""
    raise_worst(
        relative_plane_deviations(mesh),
        "<=",
        PLANARITY_TOLERANCE,
        lambda face, value: (
            f"face {face} is off its plane by {value:.1e} of the mean edge length, allowed {PLANARITY_TOLERANCE:.0e}; "
            f"{' and '.join(filter(None, [far_from_zero_cure(mesh, value), 'planarise the mesh first']))}"
        ),
    )


def _along_and_perpendicular(mesh: Mesh, other: Mesh) -> tuple[FloatArray, FloatArray]:
    """(E,) and (E, 3): components of the edges of the other mesh along and perpendicular to those of the mesh."""
    if not mesh.combinatorics.same_as(other.combinatorics):
        raise MeshError("the two meshes do not have the same faces, so they cannot be parallel")
    directions = mesh.edge_directions
    along = np.einsum("ei,ei->e", other.edge_vectors, directions)
    return along, other.edge_vectors - along[:, None] * directions
