"""Signs of edges that no mesh parallel to S can have: which faces, or which edges, contradict the others."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array, hstack, vstack

from geometry.arrays import IntArray, integers
from geometry.errors import GeometryError
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.polygons import face_sums
from geometry.mesh.ragged_arrays import next_in_row
from geometry.optimise import Blocks, ConvergenceError, Reason, apply, minimise_bounded
from geometry.parallel import ParallelSpace
from geometry.parallel.constraints import FactorBounds

__all__ = ["check_faces_can_close", "check_signs_fit_together", "checked_signs", "conflicting_edges"]

HALF_TURN = np.pi + 1e-9
"""Angle in radians between consecutive directions, from which on all lie on one side: a half turn plus rounding."""

FEASIBILITY_TOLERANCE = 1e-6
"""Length of an edge in the linear programme, below which it counts as zero, where 1 is required; the solver stops at
1e-8."""


def checked_signs(gauss_image: Mesh, signs: Any) -> IntArray:
    values = np.asarray(signs)
    if values.shape not in ((), (gauss_image.n_edges,)):
        raise GeometryError(f"the signs have shape {values.shape}, there are {gauss_image.n_edges} edges")
    values = np.broadcast_to(values, gauss_image.n_edges)
    wrong = np.flatnonzero(~np.isin(values, (-1, 0, 1)))
    if len(wrong):
        name = gauss_image.combinatorics.edge_name(int(wrong[0]))
        raise GeometryError(
            f"{name} has the sign {values[wrong[0]]}: signs are -1, 0 and 1",
            elements=wrong.tolist(),
            value=float(values[wrong[0]]),
        )
    return integers(values)


def check_faces_can_close(gauss_image: Mesh, signs: IntArray) -> None:
    """Raise GeometryError for faces whose edges, directed by the signs, all point to one side, so that the face cannot
    close."""
    c, normals = gauss_image.combinatorics, gauss_image.face_normals
    steps = signs[c.corner_edge, None] * gauss_image.corner_directions
    x_axes = gauss_image.edge_directions[c.corner_edge[c.face_starts[:-1]]]
    y_axes = np.cross(normals, x_axes)
    x, y = (np.einsum("ci,ci->c", steps, axes[c.corner_face]) for axes in (x_axes, y_axes))
    angles = np.arctan2(y, x)
    angles = angles[np.lexsort((angles, c.corner_face))]
    gaps = (angles[next_in_row(c.face_starts)] - angles) % (2 * np.pi)
    is_signed = face_sums(c, np.abs(signs[c.corner_edge])) == c.face_sizes
    wide = np.maximum.reduceat(gaps, c.face_starts[:-1])
    open_faces = np.flatnonzero(is_signed & ((wide >= HALF_TURN) | (wide == 0)))
    if len(open_faces):
        face = int(open_faces[0])
        names = ", ".join(f"{'+' if s > 0 else '-'}{e}" for e, s in _edges_of(c, face, signs))
        raise GeometryError(
            f"the signs have no solution: face {face} cannot close, as its edges {names} then all point to one side"
            f"{_and_others(len(open_faces))}; reverse some of them, or give them the sign 0",
            elements=open_faces.tolist(),
        )


def _edges_of(combinatorics: Combinatorics, face: int, signs: IntArray) -> list[tuple[int, int]]:
    edges = combinatorics.corner_edge[combinatorics.face_starts[face] : combinatorics.face_starts[face + 1]]
    return list(zip(edges.tolist(), signs[edges].tolist(), strict=True))


def _and_others(count: int) -> str:
    return f" ({count} such faces)" if count > 1 else ""


def check_signs_fit_together(gauss_image: Mesh, signs: IntArray, error: GeometryError) -> None:
    """Raise GeometryError, from an error of the solver, where it is the signs that have no solution."""
    edges = conflicting_edges(gauss_image, signs)
    if len(edges):
        names = ", ".join(map(str, edges[:10].tolist())) + (" and others" if len(edges) > 10 else "")
        raise GeometryError(
            f"the signs have no solution: each face could close, but no mesh parallel to S has all of them. The signs "
            f"of edges {names} contradict the others: reverse these edges, or give them the sign 0",
            elements=edges.tolist(),
        ) from error


def conflicting_edges(gauss_image: Mesh, signs: Any) -> IntArray:
    """Edges (k,) that cannot have the signs (E,) together with the others: none where a mesh with these signs exists.

    A linear programme asks all signed edges to be at least 1 long and minimises the sum of the missing lengths; the
    edges are those with a missing length. Other choices may be as good. Raises ConvergenceError where it is not solved.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import cube
    >>> signs = np.ones(12)
    >>> conflicting_edges(cube(), signs).tolist()
    []
    >>> signs[0] = -1  # opposite edges of a rectangle run alike
    >>> conflicting_edges(cube(), signs).tolist()
    [0]
    """
    values = checked_signs(gauss_image, signs)
    signed = np.flatnonzero(values)
    A = ParallelSpace(gauss_image).matrix
    rows = csr_array(values[signed, None] * FactorBounds.of(gauss_image, (0.0, 0.0)).rows(gauss_image)[signed])
    m, n, k = *A.shape, len(signed)
    if not k:
        return integers([])
    unknowns, one_each = Blocks({"positions": (n // 3, 3), "lacking": (k,)}), csr_array(eye_array(k))
    pin = csr_array(eye_array(3, n))  # vertex 0 at the origin
    long_enough = unknowns.rows(csr_array(hstack([rows, one_each])), "positions", "lacking")
    limits = [long_enough, unknowns.rows(one_each, "lacking")]
    solution = minimise_bounded(
        csr_array((n + k, n + k)),
        -unknowns.join(positions=np.zeros((n // 3, 3)), lacking=np.ones(k)),
        unknowns.rows(csr_array(vstack([A, pin])), "positions"),
        np.zeros(m + 3),
        csr_array(vstack(limits)),
        np.repeat([1.0, 0.0], k),
        np.full(2 * k, np.inf),
        tolerance=FEASIBILITY_TOLERANCE,
    )
    lacking = signed[apply(rows, unknowns.split(solution.x)["positions"].ravel()) <= FEASIBILITY_TOLERANCE]
    if len(lacking) and solution.reason is not Reason.CONVERGED:
        raise ConvergenceError(
            f"whether the signs have a solution is not found out: the solver stopped because {solution.reason.value}",
            solution=solution,
            value=solution.violation,
            bound=FEASIBILITY_TOLERANCE,
        )
    return integers(lacking)
