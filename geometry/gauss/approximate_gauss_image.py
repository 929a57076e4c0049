"""The approximate Gauss image: the mesh parallel to a given one that is nearest to the unit sphere."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError
from geometry.functionals import (
    close_to,
    close_to_vertex_normals,
    edge_normals,
    edges_at_unit_distance,
    faces_at_unit_distance,
    laplacian,
)
from geometry.gauss.pair import Pair
from geometry.gauss.unit_distances import approach_unit_distances, least_squares_parallel
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.optimise import SparseMatrix, normal_equations
from geometry.parallel.edge_parallelity import check_planar

__all__ = ["approximate_pair", "first_objective", "refuse_triangle_mesh"]

LEAST_VERTEX_WEIGHT = 1e-8
"""Least weight of the vertices over the largest weight: with a smaller one, rounding decides what the vertices should
determine."""


def approximate_pair(
    mesh: MeshLike,
    *,
    faces: float = 1.0,
    edges: float = 0.0,
    vertices: float = 0.1,
    fairness: float = 0.0,
    rounds: int = 1,
    normals: FloatArray | None = None,
) -> Pair:
    """M with the S parallel to it for which faces f_faces + edges f_edges + vertices f_vert + fairness f_Laplacian is
    least.

    [Pottmann2007, 4.2 and (3)]. f_faces asks for faces at distance 1 from the origin, f_edges the same of edge lines,
    in the direction halfway between the normals of their faces (beam heights), f_vert for vertices at the
    normals of M, f_Laplacian for a fair S, which hardly improves beam heights and doubles the time.
    normals (N, 3): unit vectors, if the surface is known; left out, they are estimated: `extrapolated_normals`, with
    which mean curvatures converge at the boundary too.
    S shares the combinatorics of M, and depends neither on the size nor on the position of M. Vertices that belong to
    no face are at the origin.

    The paper takes one round. Each further round takes the directions of edges and vertices from the previous S, and
    requires vertices to be only at distance 1, not at normals. The rounds reduce
    faces sum (dist_F - 1)^2 + edges sum (dist_e - 1)^2 + vertices sum (|s_i| - 1)^2 + fairness f_Laplacian,
    and keep what this does not determine; see `approach_unit_distances`. So `faces=0, edges=1, vertices=0, rounds=10`
    finds the S with all beams of equal height, if there is one nearby. Without faces and edges many rounds lead to S =
    one point, where |s_i| = 1 too. A round takes about as long as the first.

    Unlike the paper this needs no basis of P(M), hence no singular value decomposition.

    S is checked for being parallel to M and for being the minimum. Raises GeometryError for weights that do not
    determine S, for normals of another shape or not finite, for a face that is not planar and for a mesh of triangles
    only; MeshError for an edge without length;
    RankError where rounding decides about S, with the edges and the singular values, as where faces are nearly in one
    plane; ConvergenceError where S is not parallel to M, or not the minimum.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import translation_surface
    >>> u = np.linspace(-1, 1, 7)[:, None]
    >>> mesh = translation_surface(u * [3, 0, 0.2] - u**2 * [0, 0, 1.2], u * [0.9, 2.6, 0] - u**2 * [0, 0, 0.7])
    >>> pair = approximate_pair(mesh)
    >>> even = approximate_pair(mesh, faces=0, edges=1, vertices=0.1, rounds=3)
    >>> bool(np.ptp(even.edge_distances) < np.ptp(pair.edge_distances))  # beam heights over d
    True
    """
    mesh = as_mesh(mesh)
    _check_weights(faces, edges, vertices, fairness, rounds)
    refuse_triangle_mesh(mesh)
    check_planar(mesh)
    H, g = first_objective(mesh, faces=faces, edges=edges, vertices=vertices, fairness=fairness, normals=normals)
    gauss_image = least_squares_parallel(mesh, H, g)
    if rounds > 1:
        gauss_image = approach_unit_distances(
            mesh, gauss_image, faces=faces, edges=edges, vertices=vertices, fairness=fairness, rounds=rounds - 1
        )
    return Pair(mesh, gauss_image)


def first_objective(
    mesh: Mesh, *, faces: float, edges: float, vertices: float, fairness: float, normals: FloatArray | None
) -> tuple[SparseMatrix, FloatArray]:
    """H (3N, 3N) and g (3N,): the first round minimises s H s / 2 - g s over the S = s in P(M)."""
    near_normals = close_to_vertex_normals(mesh) if normals is None else close_to(_checked_normals(mesh, normals))
    terms = [
        (max(vertices, LEAST_VERTEX_WEIGHT * max(faces, edges, fairness)), near_normals),
        (faces, faces_at_unit_distance(mesh)),
    ]
    if edges > 0:
        terms.append((edges, edges_at_unit_distance(mesh, edge_normals(mesh))))
    if fairness > 0:
        terms.append((fairness, laplacian(mesh.combinatorics)))
    return normal_equations(terms)


def refuse_triangle_mesh(mesh: Mesh) -> None:
    """Raise GeometryError where all faces are triangles.

    >>> from geometry.mesh.shapes import octahedron
    >>> refuse_triangle_mesh(octahedron())  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    geometry.errors.GeometryError: all faces are triangles: ...
    """
    if mesh.combinatorics.face_sizes.max() == 3:
        raise GeometryError(
            "all faces are triangles: meshes parallel to a triangle mesh are only scaled copies of it, so there is no "
            "Gauss image to be found; lay planar quads on this surface by `remesh`"
        )


def _checked_normals(mesh: Mesh, normals: FloatArray) -> FloatArray:
    given = floats(normals)
    if given.shape != mesh.vertices.shape:
        raise GeometryError(f"normals have shape {given.shape}, one a vertex is needed: {mesh.vertices.shape}")
    return given


def _check_weights(faces: float, edges: float, vertices: float, fairness: float, rounds: int) -> None:
    if rounds < 1:
        raise GeometryError(f"the number of rounds is {rounds}, at least 1 is needed", value=rounds, bound=1)
    for name, weight in [("faces", faces), ("edges", edges), ("vertices", vertices), ("fairness", fairness)]:
        if not (np.isfinite(weight) and weight >= 0):
            raise GeometryError(f"the weight {name} is {weight}: weights are numbers from 0 upwards", value=weight)
    if rounds > 1 and max(faces, edges) > 0:
        return  # later rounds leave what the distances do not determine where the first one put it
    if vertices < LEAST_VERTEX_WEIGHT * max(faces, edges, fairness, 1e-300):
        raise GeometryError(
            f"the weight vertices is {vertices:g}: at least {LEAST_VERTEX_WEIGHT:g} of the largest weight is needed, "
            "because faces alone do not determine the Gauss image at the boundary, nor fairness its position",
            value=vertices,
            bound=LEAST_VERTEX_WEIGHT * max(faces, edges, fairness),
        )
