"""The approximate Gauss image: a mesh parallel to a given one, as near to the unit sphere as can be."""

from __future__ import annotations

import numpy as np

from geometry.errors import GeometryError
from geometry.functionals.fairness import laplacian
from geometry.functionals.normals import close_to_vertex_normals, unit_face_distances
from geometry.functionals.parallelity import parallel_to
from geometry.functionals.planarity import face_deviations
from geometry.mesh import Mesh
from geometry.optimise.constrained import minimise_quadratic
from geometry.optimise.functional import normal_equations
from geometry.optimise.solution import ConvergenceError, Solution
from geometry.parallel.space import parallelity

__all__ = ["PARALLEL", "PLANAR", "gauss_image", "refuse_triangle_mesh"]

PLANAR = 1e-12
"""How far a corner may be off its face's plane, over the mean edge length: what `planarise` reaches."""

PARALLEL = 1e-11
"""How far an end of an edge of S may be off the direction of its edge of M; S has unit size. The solver aims at
1e-13, and mostly reaches 1e-15; faces planar to 1e-12 only, or coordinates far from the origin, leave more."""

LEAST_VERTEX_WEIGHT = 1e-8
"""Least weight of the vertices over the largest weight: with less, rounding decides what they should."""


def gauss_image(mesh: Mesh, *, faces: float = 1.0, vertices: float = 0.1, fairness: float = 0.0) -> Mesh:
    """The mesh S parallel to M that minimises faces f_faces + vertices f_vert + fairness f_Laplacian.

    [Pottmann2007, 4.2 and (3)]. f_faces asks for faces at distance 1 from the origin, f_vert for vertices at the
    estimated normals of M, f_Laplacian for a fair S: beam heights hardly need that, and it doubles the time.
    S shares the combinatorics of M, and depends neither on the size nor on the place of M. Vertices that belong to no
    face are at the origin.

    Unlike the paper this needs no basis of P(M), hence no singular value decomposition.

    Raises GeometryError for weights that do not determine S, for a face that is not planar (the bound is `PLANAR`)
    and for a mesh of triangles only; MeshError for an edge without length; ConvergenceError where S is parallel
    to M no better than `PARALLEL`.
    """
    _check_weights(faces, vertices, fairness)
    refuse_triangle_mesh(mesh)
    _check_planar(mesh)
    H, g = normal_equations(
        [
            (vertices, close_to_vertex_normals(mesh)),
            (faces, unit_face_distances(mesh)),
            (fairness, laplacian(mesh.combinatorics)),
        ]
    )
    constraint = parallel_to(mesh)
    solution = minimise_quadratic(H, g, constraint.matrix, constraint.target, tolerance=PARALLEL / 100)
    image = mesh.with_vertices(solution.x.reshape(-1, 3))
    _check_parallel(mesh, image, solution)
    return image


def refuse_triangle_mesh(mesh: Mesh) -> None:
    """Raise GeometryError where all faces are triangles."""
    if mesh.combinatorics.face_sizes.max() == 3:
        raise GeometryError(
            "all faces are triangles: meshes parallel to a triangle mesh are only scaled copies of it, so there is no "
            "Gauss image to be found; take its dual, or lay a mesh of planar quads or hexagons over the surface"
        )


def _check_weights(faces: float, vertices: float, fairness: float) -> None:
    for name, weight in [("faces", faces), ("vertices", vertices), ("fairness", fairness)]:
        if not (np.isfinite(weight) and weight >= 0):
            raise GeometryError(f"the weight {name} is {weight}: weights are numbers from 0 upwards", value=weight)
    if vertices < LEAST_VERTEX_WEIGHT * max(faces, fairness, 1e-300):
        raise GeometryError(
            f"the weight vertices is {vertices:g}: at least {LEAST_VERTEX_WEIGHT:g} of the largest weight is needed, "
            "because faces alone do not determine the Gauss image at the boundary, nor fairness where it lies",
            value=vertices,
            bound=LEAST_VERTEX_WEIGHT * max(faces, fairness),
        )


def _check_planar(mesh: Mesh) -> None:
    deviations = face_deviations(mesh)
    face = int(deviations.argmax())
    value = float(deviations[face])
    if value > PLANAR:
        raise GeometryError(
            f"face {face} leaves its plane by {value:.1e} of the mean edge length, allowed {PLANAR:.0e}; "
            "planarise the mesh first",
            elements=[face],
            value=value,
            bound=PLANAR,
        )


def _check_parallel(mesh: Mesh, image: Mesh, solution: Solution) -> None:
    sideways = parallelity(mesh, image)
    edge = int(sideways.argmax())
    value = float(sideways[edge])
    if not value <= PARALLEL:
        i, j = mesh.combinatorics.edges[edge].tolist()
        raise ConvergenceError(
            f"edge {edge} from vertex {i} to vertex {j} of the Gauss image is off the direction of its mesh edge by "
            f"{value:.1e}, allowed {PARALLEL:.0e}; move the mesh nearer to the origin, and planarise it further",
            solution=solution,
            elements=[edge],
            value=value,
            bound=PARALLEL,
        )
