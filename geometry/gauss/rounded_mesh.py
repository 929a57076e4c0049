"""The mesh before it was rounded to the digits of a file, with more meshes parallel to it, and its Gauss image.

Where conditions of P(M) depend on each other, as around a torus, on an ellipsoid or between boxes, P(M) is larger than
that of almost any mesh next to M. A file with seven digits holds such a mesh, and planarising does not restore that
freedom: the missing digits would decide about S. So conditions that nearly depend on each other are first met only to
the accuracy of the file, and then M and S are moved together, by as little, until they are exactly parallel.
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
"""Largest move that made faces planar, over the mean edge length, that counts as the rounding of a file: four digits
an edge. A mesh that moved further was not planar before."""

FINEST_ROUNDING = 1e-5
"""Least rounding, over the mean edge length, that sets the penalty on the conditions: a larger penalty costs the
factorisation its digits."""

SOFT_CONDITION_PENALTY = 1e-4
"""Penalty on a condition that the rounding breaks, over the mean weight of the vertices of S: practically none."""

MULTIPLIER_ROUNDS = 6
"""Rounds of multipliers: each halves the residual of a condition with a singular value of a hundred times the
rounding."""

LARGEST_MOVE_RATIO = 4.0
"""Largest move of a vertex over its largest move while planarising: the nearest mesh of any kind is as far away as the
nearest planar one, up to such a factor."""

SAME_IMAGE_AMPLIFICATION = 100.0
"""Change of S over the rounding, up to which it counts as the same S: the effect of singular values of a hundredth."""

SAME_IMAGE_TOLERANCE = 1e-4
"""Change of S up to which it counts as the same in any case: a hundredth of a millimetre in a beam of 100 mm."""


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
    """`approximate_pair` of M itself, unless rounding decides about S: then of a nearby mesh which allows a better S.

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
    direct, error = None, None
    try:
        direct = approximate_pair(mesh, rounds=rounds, normals=normals, **weights)
    except (RankError, ConvergenceError) as failure:
        error = failure
    rounding = moved / mesh.mean_edge_length
    if 0 < rounding <= LARGEST_FILE_ROUNDING:
        softly = partial(_softly_parallel, rounding=rounding)
        found = softly(mesh, *first_objective(mesh, normals=normals, **weights))
        found = approach_unit_distances(mesh, found, rounds=rounds - 1, solve=softly, **weights)
        is_same = direct is not None and _is_same(found, direct.gauss_image, rounding)
        pair = None if is_same else _made_exact(mesh, found, rounding)
        if pair is not None:
            return pair
    if direct is None:
        assert error is not None
        raise error
    return direct


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
    residual = apply(unknowns.open_constraints, origin)
    penalty = SOFT_CONDITION_PENALTY / max(rounding, FINEST_ROUNDING) ** 2 * float(H.diagonal().mean())
    factor = factorise(csr_array(H + penalty * (A.T @ A)))
    multipliers = penalty * residual
    for _ in range(MULTIPLIER_ROUNDS):
        x = factor.solve(g - np.asarray(multipliers @ A))
        multipliers = multipliers + penalty * (apply(A, x) + residual)
    return mesh.with_vertices((origin + apply(unknowns.matrix, x)).reshape(-1, 3))
