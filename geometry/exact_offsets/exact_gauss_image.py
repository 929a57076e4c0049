"""The exact Gauss images: S with all vertices, all edges or all faces at distance 1 from the origin.

A mesh has one if and only if it has offsets of that kind, and then every mesh parallel to it has them
[Pottmann2007, Prop. 2]. Each function here finds S from M: first vertex by vertex from the geometry of M, then by
reducing the deviations in P(M), so that S is parallel to rounding, and S is judged, not M.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, RankError, raise_worst
from geometry.exact_offsets.circumscribed import circumscribed_candidate
from geometry.exact_offsets.inscribed import inscribed_candidate
from geometry.exact_offsets.midscribed import midscribed_candidate
from geometry.exact_offsets.offset_conditions import circularity, conicality, edge_axis_twist, edge_cone_deviation
from geometry.functionals import close_to_vertex_normals, faces_at_unit_distance
from geometry.gauss.distances import DISTANCE_TOLERANCE, face_distances
from geometry.gauss.pair import Pair
from geometry.gauss.unit_distances import (
    GAUSS_IMAGE_PARALLELITY,
    LINEAR_DAMPING,
    approach_unit_distances,
    attracted_to_normals,
    least_squares_parallel,
)
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.optimise import ConvergenceError, LinearFunctional, SparseMatrix, normal_equations
from geometry.parallel.edge_parallelity import check_planar, parallelity

__all__ = [
    "circumscribed_pair",
    "edge_offset_pair",
    "exact_pairs",
    "face_offset_pair",
    "inscribed_pair",
    "midscribed_pair",
    "vertex_offset_pair",
]

CHORD_TOLERANCE = 0.1
"""Distance of s_j from the reflection of s_i at their edge, up to which S counts as inscribed. A larger one belongs to
another S on the sphere, with edges that have no length where they should, such as the single point that every mesh
has: [Pottmann2007, Prop. 2] excludes these."""

UNKNOWN_VERTEX_WEIGHT = 1e-4
"""Weight that attracts vertices of unknown position to their normals, over that of the known ones: three rounds reduce
the residual to its cube; with a smaller weight, rounding decides the position of vertices that the edges leave
free."""

MAX_DISTANCE_ROUNDS = 30
"""Most rounds of `approach_unit_distances` in the search for an exact S."""

LEAST_ROUND_GAIN = 0.5
"""Least part of the squared deviations that a round must remove: near an exact S each removes more; else there is
none."""

EQUALLY_EXACT_RATIO = 2.0
"""Ratio of the largest deviations of two S, up to which they count as equally exact: both minimise the squared
deviations."""


def vertex_offset_pair(mesh: MeshLike, *, tolerance: float = DISTANCE_TOLERANCE) -> Pair:
    """M and the S parallel to it with |s_i| = 1: M is circular, if its faces are quads [Pottmann2007, Prop. 2].

    Where M leaves a choice, as discs of circular quads do, S is as near to the vertex normals as possible. Distances
    are 1 to within `tolerance`; S is parallel to rounding. Vertices that belong to no face are at the origin.

    Raises GeometryError where there is no such S, naming the worst vertex; where a face is not planar; where the
    tolerance is not positive. Raises MeshError for an edge without length.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import dome
    >>> pair = vertex_offset_pair(dome(8, 3) * 5)
    >>> bool(np.abs(pair.vertex_distances - 1).max() < 1e-9)
    True
    """
    mesh = as_mesh(mesh)
    pair, deviations = inscribed_pair(mesh, tolerance)

    def say(vertex: int, off: float) -> str:
        off_circle = circularity(mesh)
        face = int(off_circle.argmax())
        return (
            f"the mesh has no vertex offset: vertex {vertex} of the nearest Gauss image is {off:.1e} "
            f"off its place on the unit sphere, allowed {tolerance:.0e}; the least circular face is {face}, its "
            f"corners {off_circle[face]:.1e} of its mean edge length off a circle; use `make_circular`, or "
            "`approximate_pair`"
        )

    raise_worst(deviations, "<=", tolerance, say)
    return pair


def edge_offset_pair(mesh: MeshLike, *, tolerance: float = DISTANCE_TOLERANCE) -> Pair:
    """M and the S parallel to it whose edge lines touch the unit sphere: a Koebe polyhedron [Pottmann2007, Prop. 2, 3].

    Edges may run the other way in S than in M: `edge_factors` says which. S is determined up to its sign, and taken
    with most of each component outside; where M leaves more choice, near the vertex normals. Distances are 1
    to within `tolerance`; S is parallel to rounding. Vertices that belong to no face are at the origin. Where coplanar
    faces meet at vertices with two edge lines only, which lie on many cones, an S may be missed.

    Raises GeometryError where no such S is found, naming the worst edge; where a face is not planar; where the
    tolerance is not positive. Raises MeshError for an edge without length.

    >>> import numpy as np
    >>> from geometry.mesh.solids import cuboctahedron
    >>> pair = edge_offset_pair(cuboctahedron() * 5)
    >>> bool(np.abs(pair.edge_distances - 1).max() < 1e-9)
    True
    """
    mesh = as_mesh(mesh)
    pair, deviations = midscribed_pair(mesh, tolerance)

    def say(edge: int, off: float) -> str:
        cones = float(np.nan_to_num(edge_cone_deviation(mesh)[mesh.combinatorics.edges[edge]]).max())
        twist = float(np.nan_to_num(edge_axis_twist(mesh)[edge]))
        return (
            f"no edge offset is found: {mesh.combinatorics.edge_name(edge)} of the nearest Gauss image is "
            f"{off:.1e} off distance 1 from the origin, allowed {tolerance:.0e}; the edges at its ends "
            f"leave cones of revolution by {cones:.1e}, and the axes of these cones differ by {twist:.1e} radians over "
            "the edge; use a mesh parallel to a Koebe polyhedron, or `approximate_pair` with a weight for edges"
        )

    raise_worst(deviations, "<=", tolerance, say)
    return pair


def face_offset_pair(mesh: MeshLike, *, tolerance: float = DISTANCE_TOLERANCE) -> Pair:
    """M and the S parallel to it with n_F . s_i = 1 in all faces: M is conical [Pottmann2007, Prop. 2].

    n_F are the outer unit normals of M, so all faces are offset to the same side. Where M leaves a choice, as at
    boundary vertices with one face, S is as near to the vertex normals as possible. Distances are 1 to within
    `tolerance`; S is parallel to rounding. Vertices that belong to no face are at the origin.

    Raises GeometryError where there is no such S, naming the worst face and vertex; where a face is not planar; where
    the tolerance is not positive. Raises MeshError for an edge without length.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import box
    >>> pair = face_offset_pair(box(2, 3, 4))
    >>> pair.face_distances.round(9).tolist()
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    >>> np.ptp(pair.offset_mesh(0.1).vertices, axis=0).round(9).tolist()
    [2.2, 3.2, 4.2]
    """
    mesh = as_mesh(mesh)
    pair, deviations = circumscribed_pair(mesh, tolerance)

    def say(face: int, off: float) -> str:
        off_cone = np.nan_to_num(conicality(mesh))
        vertex = int(off_cone.argmax())
        return (
            f"the mesh has no face offset: face {face} of the nearest Gauss image is {off:.1e} off "
            f"distance 1 from the origin, allowed {tolerance:.0e}; the least conical vertex is {vertex}, its faces "
            f"{off_cone[vertex]:.1e} radians off a cone of revolution; use `make_conical`, or "
            "`approximate_pair`"
        )

    raise_worst(deviations, "<=", tolerance, say)
    return pair


def exact_pairs(mesh: MeshLike, *, tolerance: float = DISTANCE_TOLERANCE) -> dict[str, Pair]:
    """The mesh with the exact Gauss images that it has, by "vertex", "edge" and "face" [Pottmann2007, Prop. 2].

    The offsets of M at distance d of these kinds are M + d S. Raises as the functions for each kind do, except where
    there is no S.

    >>> from geometry.mesh.shapes import dome
    >>> sorted(exact_pairs(dome(8, 3)))
    ['face', 'vertex']
    """
    mesh = as_mesh(mesh)
    found = {
        "vertex": inscribed_pair(mesh, tolerance),
        "edge": midscribed_pair(mesh, tolerance),
        "face": circumscribed_pair(mesh, tolerance),
    }
    return {kind: pair for kind, (pair, deviations) in found.items() if deviations.max() <= tolerance}


# --- the best S of each kind, and how far its distances are from 1


def inscribed_pair(mesh: Mesh, tolerance: float) -> tuple[Pair, FloatArray]:
    """The nearest S with vertices on the unit sphere, and deviations (N,): of distances from 1, and of chords."""
    _check(mesh, tolerance)
    gauss_image = _nearest(mesh, inscribed_candidate(mesh, tolerance))
    gauss_image = approach_unit_distances(
        mesh, gauss_image, vertices=1.0, rounds=MAX_DISTANCE_ROUNDS, least_gain=LEAST_ROUND_GAIN
    )
    return _attracted(mesh, gauss_image, _off_sphere, tolerance, vertices=1.0)


def _off_sphere(pair: Pair) -> FloatArray:
    """(N,) deviations of distances from 1, and of chords."""
    c = pair.mesh.combinatorics
    deviations = np.where(c.is_used, np.abs(pair.vertex_distances - 1), 0.0)
    sums = pair.gauss_image.vertices[c.edges].sum(axis=1)
    off_chord = np.abs(np.einsum("ei,ei->e", sums, pair.mesh.edge_directions))
    other = off_chord > CHORD_TOLERANCE
    np.maximum.at(deviations, c.edges[other], off_chord[other, None])
    return np.asarray(deviations)


def midscribed_pair(mesh: Mesh, tolerance: float) -> tuple[Pair, FloatArray]:
    """The nearest S with edge lines at distance 1, and deviations (E,) from that."""
    _check(mesh, tolerance)
    gauss_image = _nearest(mesh, midscribed_candidate(mesh))
    gauss_image = approach_unit_distances(
        mesh, gauss_image, edges=1.0, rounds=MAX_DISTANCE_ROUNDS, least_gain=LEAST_ROUND_GAIN
    )
    return _attracted(mesh, gauss_image, lambda pair: np.abs(pair.edge_distances - 1), tolerance, edges=1.0)


def _attracted(
    mesh: Mesh, gauss_image: Mesh, off: Callable[[Pair], FloatArray], tolerance: float, **weights: Any
) -> tuple[Pair, FloatArray]:
    """M, S and how far it is off; where S is exact, it is attracted to the vertex normals as far as its distances leave
    it free."""
    pair = Pair(mesh, gauss_image)
    deviations = off(pair)
    if deviations.max() > tolerance:
        return pair, deviations
    try:
        attracted = attracted_to_normals(mesh, gauss_image, **weights)
        attracted = approach_unit_distances(
            mesh, attracted, **weights, rounds=MAX_DISTANCE_ROUNDS, least_gain=LEAST_ROUND_GAIN
        )
    except (ConvergenceError, RankError):  # P(M) is ill-conditioned: the normals determine nothing
        return pair, deviations
    other = Pair(mesh, attracted)
    found = off(other)
    is_as_good = found.max() <= max(EQUALLY_EXACT_RATIO * deviations.max(), DISTANCE_TOLERANCE)
    return (other, found) if is_as_good else (pair, deviations)


def circumscribed_pair(mesh: Mesh, tolerance: float) -> tuple[Pair, FloatArray]:
    """The nearest S with face planes at distance 1, and deviations (F,) from that."""
    _check(mesh, tolerance)
    gauss_image = _from_planes(mesh)
    if np.abs(face_distances(gauss_image, mesh.face_normals) - 1).max() > DISTANCE_TOLERANCE:
        H, g = normal_equations([(1.0, faces_at_unit_distance(mesh)), (LINEAR_DAMPING, close_to_vertex_normals(mesh))])
        gauss_image = least_squares_parallel(mesh, H, g)
        gauss_image = approach_unit_distances(
            mesh, gauss_image, faces=1.0, rounds=MAX_DISTANCE_ROUNDS, least_gain=LEAST_ROUND_GAIN
        )
    return _attracted(mesh, gauss_image, lambda pair: np.abs(pair.face_distances - 1), tolerance, faces=1.0)


def _from_planes(mesh: Mesh) -> Mesh:
    """S with vertices where their planes meet, if the planes determine them; the other vertices make edges parallel.

    Exact where M is conical, after three rounds, in which minimising over the distances alone would take a dozen where
    vertices are far from their normals: a very small weight attracts the others to their normals, then to their last
    position.
    """
    places, known = circumscribed_candidate(mesh)
    weights = np.repeat(np.where(known, 1.0, UNKNOWN_VERTEX_WEIGHT), 3)
    roots: SparseMatrix = csr_array(diags_array(np.sqrt(weights)))
    gauss_image = mesh.with_vertices(places)
    for _ in range(3):
        target = np.where(known[:, None], places, gauss_image.vertices).ravel()
        near = LinearFunctional(roots, np.sqrt(weights) * target)
        gauss_image = least_squares_parallel(
            mesh, *normal_equations([(1.0, faces_at_unit_distance(mesh)), (1.0, near)])
        )
    return gauss_image


def _check(mesh: Mesh, tolerance: float) -> None:
    if not tolerance > 0:
        raise GeometryError(f"the tolerance is {tolerance:g}, it must be above 0", value=tolerance, bound=0.0)
    check_planar(mesh)


def _nearest(mesh: Mesh, positions: FloatArray) -> Mesh:
    """The mesh parallel to M nearest to positions (N, 3): themselves where they are parallel already."""
    candidate = mesh.with_vertices(positions)
    if parallelity(mesh, candidate).max() <= GAUSS_IMAGE_PARALLELITY:
        return candidate
    x = positions.ravel()
    return least_squares_parallel(mesh, csr_array(eye_array(len(x))), x)
