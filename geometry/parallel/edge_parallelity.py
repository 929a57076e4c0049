"""How parallel two meshes are, edge by edge; the factors between their edges; and what a mesh must be for that."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.errors import MeshError, ParallelityError, raise_worst
from geometry.functionals import relative_plane_deviations
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.mesh.place import cure_of_place

__all__ = ["PLANARITY_TOLERANCE", "check_parallel", "check_planar", "edge_factors", "parallelity", "perpendicular_part"]

PLANARITY_TOLERANCE = 1e-12
"""How far a corner may be off its face's plane, over the mean edge length: what `planarise` reaches."""


def parallelity(mesh: MeshLike, other: MeshLike) -> FloatArray:
    """(E,) how far s_j - s_i is off the direction of m_j - m_i, in the unit of S = `other`; zero where parallel.

    Raises MeshError where the meshes do not have the same faces, and for an edge of `mesh` without length.

    >>> from geometry import parallelity
    >>> from geometry.mesh import solids
    >>> bool(parallelity(solids.cube(), solids.cube() * 3.0).max() < 1e-12)
    True
    """
    mesh = as_mesh(mesh)
    other = as_mesh(other)
    _, across = _along_and_across(mesh, other)
    return np.asarray(np.linalg.norm(across, axis=1))


def edge_factors(mesh: MeshLike, other: MeshLike) -> FloatArray:
    """(E,) the factors lambda of s_j - s_i = lambda (m_j - m_i), by projection [Pottmann2007, (1)].

    Negative where the correspondence of the edges reverses their orientation. Raises as `parallelity` does.

    >>> from geometry import edge_factors
    >>> from geometry.mesh import solids
    >>> set(edge_factors(solids.cube(), solids.cube() * 3.0).round(9).tolist())
    {3.0}
    """
    mesh = as_mesh(mesh)
    other = as_mesh(other)
    along, _ = _along_and_across(mesh, other)
    return along / mesh.edge_lengths


def perpendicular_part(vectors: FloatArray, directions: FloatArray) -> FloatArray:
    """What is left of vectors (..., 3) when their components along unit directions (..., 3) are taken off."""
    along = np.einsum("...k,...k->...", vectors, directions)
    return np.asarray(vectors - along[..., None] * directions)


def check_parallel(mesh: Mesh, other: Mesh, bound: float, *, what: str) -> None:
    """Raise ParallelityError, naming the worst edge, where `parallelity` is above the bound; `what` the other is."""
    raise_worst(
        parallelity(mesh, other),
        "<=",
        bound,
        lambda edge, value: (
            f"{mesh.combinatorics.edge_name(edge)} of {what} is off the direction of its mesh edge by "
            f"{value:.1e}, allowed {bound:.1e}: the two meshes are not parallel"
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
            f"{' and '.join(filter(None, [cure_of_place(mesh, value), 'planarise the mesh first']))}"
        ),
    )


def _along_and_across(mesh: Mesh, other: Mesh) -> tuple[FloatArray, FloatArray]:
    """(E,) and (E, 3): the edges of the other mesh, split by the edge directions of the mesh."""
    if not mesh.combinatorics.same_as(other.combinatorics):
        raise MeshError("the two meshes do not have the same faces, so they cannot be parallel")
    directions = mesh.edge_directions
    along = np.einsum("ei,ei->e", other.edge_vectors, directions)
    return along, other.edge_vectors - along[:, None] * directions
