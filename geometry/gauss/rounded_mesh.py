"""The mesh that rounding hides: next to the given one, with more meshes parallel to it, and its Gauss image.

Where conditions of P(M) depend on each other, as around a torus, on an ellipsoid or between boxes, P(M) is larger than
that of almost any mesh next to M. A file with seven digits holds one of those, and made planar it has lost that freedom
for good: the digits that are missing decide which S is left. So conditions that nearly depend on each other are first
kept only as well as the file says them, and then M and S are moved together, by as little, to be exactly parallel.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray
from geometry.errors import RankError
from geometry.gauss.approximate_gauss_image import approximate_pair, first_objective
from geometry.gauss.nearest_pair import nearest_parallel_pair
from geometry.gauss.pair import Pair
from geometry.gauss.unit_distances import approach_unit_distances
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.optimise import ConvergenceError, SparseMatrix, apply, factorise
from geometry.parallel.face_unknowns import FaceUnknowns

__all__ = ["rounded_mesh_pair"]

LARGEST_FILE_ROUNDING = 1e-4
"""Largest move that made faces planar, over the mean edge length, that may be the rounding of a file: four digits an
edge. What moved further was no planar mesh."""

FINEST_ROUNDING = 1e-5
"""Conditions are never asked for more sharply than for this rounding: a larger penalty costs the factor its digits."""

SOFT_CONDITION_PENALTY = 1e-4
"""Penalty on a condition that is broken by the rounding, over the mean weight of the vertices of S: next to nothing."""

MULTIPLIER_ROUNDS = 6
"""Of multipliers: what is left of a condition with a singular value of a hundred times the rounding halves in each."""

LARGEST_MOVE_RATIO = 4.0
"""How much further than by planarising a vertex may move: the nearest mesh of any kind is as far as the nearest planar
one, up to such a factor."""

SAME_IMAGE_AMPLIFICATION = 100.0
"""Change of S over the rounding, up to which it is the same S: what singular values of a hundredth make of it."""

SAME_IMAGE_TOLERANCE = 1e-4
"""Change of S, up to which it is the same at least: a hundredth of a millimetre in a beam."""


def rounded_mesh_pair(
    mesh: MeshLike,
    moved: float,
    *,
    faces: float = 1.0,
    edges: float = 0.0,
    vertices: float = 0.1,
    fairness: float = 0.0,
    rounds: int = 1,
    normals: FloatArray | None = None,
) -> Pair:
    """`approximate_pair` of M itself, unless rounding decides about S: then of a mesh next to M which lets S be better.

    moved: how far a vertex moved at most where faces were made planar, in the unit of M. Where that is rounding, up to
    `LARGEST_FILE_ROUNDING` of an edge, M may move as far again, up to `LARGEST_MOVE_RATIO`. Raises as
    `approximate_pair` does, where no such mesh is found either.

    >>> import geometry
    >>> from geometry.mesh.shapes import dome
    >>> rounded = dome(6, 2).with_vertices(dome(6, 2).vertices.round(6))
    >>> planar = geometry.planarise(rounded)
    >>> pair = rounded_mesh_pair(planar.mesh, planar.largest_move * rounded.mean_edge_length)
    >>> bool(geometry.parallelity(pair.mesh, pair.gauss_image).max() < 1e-9)
    True
    """
    mesh = as_mesh(mesh)
    weights: dict[str, Any] = {"faces": faces, "edges": edges, "vertices": vertices, "fairness": fairness}
    as_it_is, error = None, None
    try:
        as_it_is = approximate_pair(mesh, rounds=rounds, normals=normals, **weights)
    except (RankError, ConvergenceError) as failure:
        error = failure
    rounding = moved / mesh.mean_edge_length
    if 0 < rounding <= LARGEST_FILE_ROUNDING:
        softly = partial(_softly_parallel, rounding=rounding)
        found = softly(mesh, *first_objective(mesh, normals=normals, **weights))
        found = approach_unit_distances(mesh, found, rounds=rounds - 1, solve=softly, **weights)
        is_same = as_it_is is not None and _is_same(found, as_it_is.gauss_image, rounding)
        pair = None if is_same else _made_exact(mesh, found, rounding)
        if pair is not None:
            return pair
    if as_it_is is None:
        assert error is not None
        raise error
    return as_it_is


def _is_same(found: Mesh, gauss_image: Mesh, rounding: float) -> bool:
    change = float(np.linalg.norm(found.vertices - gauss_image.vertices, axis=1).max())
    return change <= max(SAME_IMAGE_TOLERANCE, SAME_IMAGE_AMPLIFICATION * rounding)


def _made_exact(mesh: Mesh, found: Mesh, rounding: float) -> Pair | None:
    """M' and S', exactly parallel, near to M and an S; None where M' is further from M than rounding explains."""
    try:
        pair = nearest_parallel_pair(mesh, found)
    except ConvergenceError:
        return None
    of_mesh, _ = pair.moves_from(mesh, found)
    return pair if of_mesh.max() <= LARGEST_MOVE_RATIO * rounding else None


def _softly_parallel(
    mesh: Mesh, H: SparseMatrix, g: FloatArray, *, rounding: float, start: FloatArray | None = None
) -> Mesh:
    """S of `least_squares_parallel`, under conditions that hold as well as their singular values are above the
    rounding."""
    unknowns = FaceUnknowns(mesh)
    H, g = unknowns.objective(H, g)
    A, origin = unknowns.constraints, np.zeros(3 * mesh.n_vertices) if start is None else start
    left = apply(unknowns.open_constraints, origin)
    penalty = SOFT_CONDITION_PENALTY / max(rounding, FINEST_ROUNDING) ** 2 * float(H.diagonal().mean())
    factor = factorise(csr_array(H + penalty * (A.T @ A)))
    multipliers = penalty * left
    for _ in range(MULTIPLIER_ROUNDS):
        x = factor.solve(g - np.asarray(multipliers @ A))
        multipliers = multipliers + penalty * (apply(A, x) + left)
    return mesh.with_vertices((origin + apply(unknowns.matrix, x)).reshape(-1, 3))
