"""The pair to build a planar mesh with: exact offsets where it has them, else as near to the unit sphere as can be."""

from __future__ import annotations

from typing import Any

from geometry.exact_offsets.offset_kinds import best_offset_pair
from geometry.gauss.pair import Pair
from geometry.gauss.rounded_mesh import rounded_mesh_pair
from geometry.mesh import MeshLike, as_mesh

__all__ = ["EXACT_OFFSET_TOLERANCE", "exact_or_approximate_pair"]

EXACT_OFFSET_TOLERANCE = 1e-6
"""Deviation from 1 up to which distances of S count as exact: a ten-thousandth of a millimetre in a beam of 100 mm.
CAD programs write seven digits; a mesh that had an exact offset before it was written should still have it."""

DISTANCE_ROUNDINGS = 4.0
"""Deviation of exact distances of S that is allowed, in roundings of the coordinates over the mean edge length: fair
meshes at map coordinates have a seventh of one, those with short edges or sharp angles more."""


def exact_or_approximate_pair(
    mesh: MeshLike,
    *,
    moved: float = 0.0,
    rounding: float = 0.0,
    tolerance: float = EXACT_OFFSET_TOLERANCE,
    **weights: Any,
) -> tuple[Pair, str | None]:
    """M and S of a planar mesh, and the kind of offset of an exact S: "edge", "vertex" or "face" where M has one and
    no weights are given; else S is as near to the unit sphere as the weights of `approximate_pair` say.

    moved: how far a vertex moved at most where faces were made planar; M is moved as little again where that would
    decide about S.

    rounding: of the coordinates that M was read with, in its unit: distances of S are no more exact than they are.

    tolerance: how far distances of an exact S may be from 1, beside that.

    Beams follow the mean normals of their faces, at the boundary too. Raises as `approximate_pair` does,
    but for meshes of triangles that have an exact S.

    >>> from geometry.mesh.shapes import dome
    >>> pair, kind = exact_or_approximate_pair(dome(8, 3))
    >>> kind
    'face'
    >>> exact_or_approximate_pair(dome(8, 3), faces=1.0)[1] is None  # weights ask for an approximate S
    True
    """
    mesh = as_mesh(mesh)
    tolerance = max(tolerance, DISTANCE_ROUNDINGS * rounding / mesh.mean_edge_length)
    exact = None if weights else best_offset_pair(mesh, tolerance=tolerance)
    if exact is not None:
        return exact[1], exact[0]
    return rounded_mesh_pair(mesh, moved, normals=mesh.vertex_normals, **weights), None
