"""M and its Gauss image S optimised together [Pottmann2007, 4.4]: where constant heights and upright axes come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, short_repr
from geometry.errors import GeometryError
from geometry.gauss import Pair, PairLike, as_pair
from geometry.mesh import Mesh
from geometry.meshing.vertex_guides import Indices
from geometry.optimise import minimise_by_penalty
from geometry.optimised_pairs.pair_checks import check_given, check_outcome, check_solution
from geometry.optimised_pairs.pair_measures import PairMeasures
from geometry.optimised_pairs.pair_objective import Objective
from geometry.optimised_pairs.pair_targets import PairTargets
from geometry.surface import Surface

__all__ = ["OptimisedPair", "height_trade_off", "optimise_pair"]

OPTIMISED_PAIR_TOLERANCE = 5e-13
"""Largest residual of parallelity and planarity in mean edge lengths and in S, and of curvature."""

MAX_NEWTON_STEPS = 6
"""Most Newton steps: more than three or four mean that something collapsed."""

TRADE_OFF_HEIGHT_ERRORS = (0.1, 0.03, 0.01, 0.003)
"""Height errors that `height_trade_off` compares: weights of heights from 1 to 1000."""


@dataclass(frozen=True, eq=False)
class OptimisedPair:
    """An optimised pair M, S, with measures before and after.

    moves (N,): how far each vertex of M moved, in mean edge lengths of M as given. boundary_distance: of boundary
    vertices from where the boundary was, in the same unit, the median and the largest; zero of closed meshes.
    shortest_edge: the least length of an edge over what it was. turned: the most that a face turned, in radians.
    no_longer_convex: faces that were convex and are not. newton_steps: on the constraints, at the end.

    >>> import numpy as np
    >>> from geometry.gauss import approximate_pair
    >>> from geometry.mesh.shapes import translation_surface
    >>> u = np.linspace(-1, 1, 4)[:, None]
    >>> mesh = translation_surface(u * [3, 0, 0.2] - u**2 * [0, 0, 1.2], u * [0.9, 2.6, 0] - u**2 * [0, 0, 0.7])
    >>> found = optimise_pair(approximate_pair(mesh), PairTargets(vertices=True))
    >>> found.after.vertex_spread < found.before.vertex_spread, found.moves.shape
    (True, (16,))
    """

    __repr__ = short_repr

    pair: Pair
    targets: PairTargets
    before: PairMeasures
    after: PairMeasures
    moves: FloatArray
    boundary_distance: tuple[float, float]
    shortest_edge: float
    turned: float
    no_longer_convex: IntArray
    newton_steps: int

    @property
    def mesh(self) -> Mesh:
        return self.pair.mesh

    @property
    def gauss_image(self) -> Mesh:
        return self.pair.gauss_image


def optimise_pair(
    pair: PairLike,
    targets: PairTargets,
    *,
    surface: Surface | None = None,
    keep_boundary: bool = True,
    fixed: Indices = (),
) -> OptimisedPair:
    """Move M on Phi and S with it, so that they are parallel, M is planar and they meet the targets.

    surface: Phi, on which the vertices of M glide; left out, the surface of M itself, except where a curvature
    is required: then M is free. A mesh that follows suitable lines glides by about a fifth of an edge. keep_boundary:
    boundary vertices nearly glide along the boundary; otherwise they are free. fixed: vertices of M that do not move at
    all, to 1e-12 mean edge lengths: heights vary more with a fixed boundary, and not every boundary is that
    of a mesh of the required curvature.
    Edges keep most of their lengths, faces that are convex stay so, and strains are small. S is to be near the normals,
    and M near zero, see `Mesh.near_zero`.

    The result is parallel and planar to 1e-12. It is a local minimum of a sum of terms, found by a penalty method, see
    `optimise.penalty`; the constraints are met to rounding at its end, without regard to the terms, from 1e-3 before.

    Raises GeometryError where all faces are triangles, for a surface that is not that of M, and for a Gauss image of
    opposite orientation; ConvergenceError where M and S do not become parallel and planar, or do not meet the
    constraints; FoldedError where an edge collapsed or a face turned over; and GeometryError where axes lean too far,
    distances did not improve, or a curvature is one of S but not of M.

    >>> import numpy as np
    >>> from geometry.gauss import approximate_pair
    >>> from geometry.mesh.shapes import translation_surface
    >>> u = np.linspace(-1, 1, 4)[:, None]
    >>> mesh = translation_surface(u * [3, 0, 0.2] - u**2 * [0, 0, 1.2], u * [0.9, 2.6, 0] - u**2 * [0, 0, 0.7])
    >>> found = optimise_pair(approximate_pair(mesh), PairTargets(edges=True))  # beams of constant height
    >>> found.after.edge_spread < found.before.edge_spread
    True
    """
    pair = as_pair(pair)
    check_given(pair, surface)
    if surface is None and not targets.curved:
        surface = Surface(pair.mesh)
    objective = Objective(pair, targets, surface, keep_boundary, fixed)
    solution = minimise_by_penalty(
        objective.terms,
        objective.metric,
        objective.constraint,
        objective.start,
        penalties=objective.penalties,
        tolerance=OPTIMISED_PAIR_TOLERANCE,
        max_newton_steps=MAX_NEWTON_STEPS,
    )
    check_solution(objective, solution, OPTIMISED_PAIR_TOLERANCE)
    found = objective.pair_at(solution.x)
    mesh, moved = pair.mesh, found.mesh
    length = mesh.mean_edge_length
    optimised = OptimisedPair(
        pair=found,
        targets=targets,
        before=PairMeasures.of(pair, surface, length),
        after=PairMeasures.of(found, surface, length),
        moves=floats(np.linalg.norm(moved.vertices - mesh.vertices, axis=1) / length),
        boundary_distance=_median_and_largest(objective.boundary_distances(solution.x)),
        shortest_edge=float((moved.edge_lengths / mesh.edge_lengths).min()),
        turned=float(np.arccos(np.clip(np.einsum("fi,fi->f", mesh.face_normals, moved.face_normals).min(), -1, 1))),
        no_longer_convex=objective.no_longer_convex(solution.x),
        newton_steps=solution.steps,
    )
    check_outcome(moved, targets, optimised.before, optimised.after)
    return optimised


def _median_and_largest(values: FloatArray) -> tuple[float, float]:
    return (float(np.median(values)), float(values.max())) if len(values) else (0.0, 0.0)


def height_trade_off(
    pair: PairLike,
    targets: PairTargets,
    *,
    height_errors: Sequence[float] = TRADE_OFF_HEIGHT_ERRORS,
    surface: Surface | None = None,
    keep_boundary: bool = True,
    fixed: Indices = (),
) -> list[OptimisedPair]:
    """The pairs for several height errors, from the largest down: smaller spreads cost larger moves.

    Ends before the first one for which `optimise_pair` raises an error; raises the error where that is the largest.

    >>> import numpy as np
    >>> from geometry.gauss import approximate_pair
    >>> from geometry.mesh.shapes import translation_surface
    >>> u = np.linspace(-1, 1, 4)[:, None]
    >>> mesh = translation_surface(u * [3, 0, 0.2] - u**2 * [0, 0, 1.2], u * [0.9, 2.6, 0] - u**2 * [0, 0, 0.7])
    >>> rough, fine = height_trade_off(approximate_pair(mesh), PairTargets(edges=True), height_errors=[0.1, 0.03])
    >>> fine.after.edge_spread < rough.after.edge_spread
    True
    """
    pair = as_pair(pair)
    found: list[OptimisedPair] = []
    for error in sorted(height_errors, reverse=True):
        try:
            asked = replace(targets, height_error=error)
            found.append(optimise_pair(pair, asked, surface=surface, keep_boundary=keep_boundary, fixed=fixed))
        except GeometryError:
            if not found:
                raise
            break
    return found
