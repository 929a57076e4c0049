"""Meshes parallel to M that minimise a quadratic function, and whose distances from the origin approach 1."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.functionals import (
    close_to_vertex_normals,
    edges_at_unit_distance,
    faces_at_unit_distance,
    laplacian,
    vertices_at_unit_distance,
)
from geometry.gauss.axes import axis_directions
from geometry.gauss.distances import edge_feet
from geometry.mesh import Mesh
from geometry.optimise import ConstrainedQuadratic, LinearFunctional, SparseMatrix, normal_equations
from geometry.parallel.face_unknowns import FaceUnknowns
from geometry.parallel.optimality import optimal_mesh

__all__ = [
    "GAUSS_IMAGE_PARALLELITY",
    "LINEAR_DAMPING",
    "approach_unit_distances",
    "attracted_to_normals",
    "foot_directions",
    "least_squares_parallel",
]

GAUSS_IMAGE_PARALLELITY = 1e-11
"""Largest distance of an end of an edge of S from the direction of its edge of M; S has unit size. Short edges of
faces that are planar to 1e-12 allow no smaller one."""

LEAST_GAUSS_IMAGE_PARALLELITY = 1e-12
"""The same, where the rounding of M does not require more."""

FIRST_DAMPING = 1e-3
"""Weight of the moves in the first round, over the sum of the weights; divided by ten after each round that reduces
the deviations."""

LINEAR_DAMPING = 1e-6
"""The same for faces alone, whose distances are linear in S, so that no step is too long."""

LEAST_DAMPING = 1e-9
"""Least weight of the moves: with less, rounding decides the position of vertices that the distances leave free."""

LARGEST_DAMPING = 1e3
"""Largest weight of the moves: where rounds gain nothing even with this one, no round will."""

NORMALS_WEIGHT = 1e-4
"""Weight of the vertex normals over that of the distances: what the distances leave free is then determined to twelve
digits."""

ATTRACTION_ROUNDS = 3
"""Rounds that attract S to the vertex normals, each with new directions; each squares the error of the directions."""

ZERO_DISTANCE_DEVIATION = 1e-15
"""Root mean square of the deviations of distances from 1, below which they count as zero."""


def least_squares_parallel(mesh: Mesh, H: SparseMatrix, g: FloatArray, *, start: FloatArray | None = None) -> Mesh:
    """The mesh S parallel to M, or start (3N,) plus one, that minimises x H x / 2 - g x; x is S, or S minus start.

    Raises as `optimal_mesh` does: where rounding decides about S, and where S is not parallel to M or no minimum.
    """
    unknowns = FaceUnknowns(mesh)
    H, g = unknowns.objective(H, g)
    return optimal_mesh(
        unknowns,
        ConstrainedQuadratic(H, unknowns.constraints),
        g,
        origin=np.zeros(3 * mesh.n_vertices) if start is None else start,
        size=1.0,
        bounds=(LEAST_GAUSS_IMAGE_PARALLELITY, GAUSS_IMAGE_PARALLELITY),
        what="the Gauss image",
    )


def approach_unit_distances(
    mesh: Mesh,
    gauss_image: Mesh,
    *,
    faces: float = 0.0,
    edges: float = 0.0,
    vertices: float = 0.0,
    fairness: float = 0.0,
    rounds: int,
    least_gain: float = 0.0,
    solve: Callable[..., Mesh] | None = None,
) -> Mesh:
    """Lower the sum of weight (distance - 1)^2 over the faces, edges and vertices of S, plus fairness f_Laplacian.

    gauss_image: parallel to M; so is the result. Levenberg-Marquardt in P(M): each round fixes the directions from the
    origin to vertices and edges, which makes distances linear, and adds a weight on the moves of vertices, so that
    vertices which the distances leave free do not move. The weight decreases after a round that reduces the sum; after
    one that does not, it increases and the round is discarded. Stops after `rounds`, each one solve; where all
    distances are 1; and where a round reduces the sum by less than the share `least_gain`. solve: computes S in each
    round, with the arguments of `least_squares_parallel`, which is the default. Raises as that does.
    """
    weights = faces, edges, vertices, fairness
    heaviest = sum(weights)
    damping = FIRST_DAMPING if edges + vertices > 0 else LINEAR_DAMPING
    value = _value(mesh, gauss_image, weights)
    for _ in range(rounds):
        if value <= ZERO_DISTANCE_DEVIATION**2 * heaviest * mesh.n_vertices or damping > LARGEST_DAMPING:
            break
        candidate = _moved(mesh, gauss_image, weights, damping * heaviest, solve or least_squares_parallel)
        reached = _value(mesh, candidate, weights)
        if not reached < value:
            damping *= 10
            continue
        enough = reached < (1 - least_gain) * value
        gauss_image, value = candidate, reached
        damping = max(damping / 10, LEAST_DAMPING)
        if not enough:
            break
    return gauss_image


def attracted_to_normals(
    mesh: Mesh, gauss_image: Mesh, *, faces: float = 0.0, edges: float = 0.0, vertices: float = 0.0
) -> Mesh:
    """S near to the vertex normals of M, as far as its distances leave it free.

    So M decides what is free, not the rounding of the S before. The normals change distances by about their weight,
    which `approach_unit_distances` corrects.
    """
    for _ in range(ATTRACTION_ROUNDS):
        terms = _terms(mesh, gauss_image, (faces, edges, vertices, 0.0))
        H, g = normal_equations([*terms, (NORMALS_WEIGHT * (faces + edges + vertices), close_to_vertex_normals(mesh))])
        gauss_image = least_squares_parallel(mesh, H, g)
    return gauss_image


def foot_directions(mesh: Mesh, gauss_image: Mesh) -> FloatArray:
    """(E, 3) unit vectors from the origin to the nearest points of the edge lines of S; zero for lines through it."""
    feet = edge_feet(gauss_image, mesh.edge_directions)
    lengths = np.linalg.norm(feet, axis=1, keepdims=True)
    return np.asarray(np.divide(feet, lengths, out=np.zeros_like(feet), where=lengths > 0))


def _terms(mesh: Mesh, gauss_image: Mesh, weights: tuple[float, ...]) -> list[tuple[float, LinearFunctional]]:
    faces, edges, vertices, fairness = weights
    terms = []
    if faces > 0:
        terms.append((faces, faces_at_unit_distance(mesh)))
    if edges > 0:
        terms.append((edges, edges_at_unit_distance(mesh, foot_directions(mesh, gauss_image))))
    if vertices > 0:
        terms.append((vertices, vertices_at_unit_distance(mesh, axis_directions(mesh, gauss_image.vertices))))
    if fairness > 0:
        terms.append((fairness, laplacian(mesh.combinatorics)))
    return terms


def _value(mesh: Mesh, gauss_image: Mesh, weights: tuple[float, ...]) -> float:
    """The residuals of the terms taken at S itself are its distances minus 1."""
    x = gauss_image.vertices.ravel()
    return sum(w * float(np.square(term.residual(x)).sum()) for w, term in _terms(mesh, gauss_image, weights))


def _moved(
    mesh: Mesh, gauss_image: Mesh, weights: tuple[float, ...], damping: float, solve: Callable[..., Mesh]
) -> Mesh:
    x = gauss_image.vertices.ravel()
    no_move = LinearFunctional(csr_array(eye_array(len(x))), np.zeros(len(x)))
    moves = [(w, LinearFunctional(term.matrix, -term.residual(x))) for w, term in _terms(mesh, gauss_image, weights)]
    H, g = normal_equations([*moves, (damping, no_move)])
    return solve(mesh, H, g, start=x)
