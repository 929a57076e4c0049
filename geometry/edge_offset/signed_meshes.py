"""Edge offset meshes from a Koebe polyhedron S: the fairest mesh in P(S) whose edges keep or reverse their orientation.

All meshes M in P(S) have the edge offsets M + d S [Pottmann2007, Prop. 2]. A design chooses one of them by saying which
edges run against those of S (Fig. 11), how long the edges are, and which vertices are fixed. A *sign* is 1 for an edge
of M that runs as in S, -1 for one that runs the other way, 0 for one that may do either.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.edge_offset.contradictory_signs import check_faces_can_close, check_signs_fit_together, checked_signs
from geometry.edge_offset.koebe_polyhedra import EDGE_TANGENCY_TOLERANCE, KoebePolyhedron
from geometry.errors import GeometryError, raise_worst
from geometry.functionals import laplacian
from geometry.gauss import edge_feet
from geometry.mesh import CombinatoricsLike, Mesh, MeshLike, as_combinatorics, as_gauss_image, as_mesh
from geometry.optimise import LinearFunctional, distances_from_zero, max_norm
from geometry.parallel import ParallelSpace, edge_factors
from geometry.parallel.constraints import FactorBounds, FixedVertices
from geometry.parallel.edge_parallelity import perpendicular_part
from geometry.spheres.lorentz import array_of

__all__ = ["alternating_signs", "edge_offset_mesh", "guided_signs", "saddle_signs"]

GUIDE_COSINE_TOLERANCE = 1e-9
"""Cosine of the angle between an edge and its guide, up to which the guide determines no sign."""

LEAST_MESH_SIZE = 1e-6
"""Mean edge length over the largest coordinate or required length, below which a mesh counts as shrunk to a point:
bounds are met to 1e-9."""


def edge_offset_mesh(
    gauss_image: MeshLike,
    *,
    signs: Any = 0,
    lengths: tuple[Any, Any] = (0.0, np.inf),
    length: Any = None,
    evenness: float = 1.0,
    fixed: Mapping[int, Any] | None = None,
    near: Mapping[int, Any] | None = None,
    closeness: float = 1.0,
) -> Mesh:
    """The mesh M parallel to the Koebe polyhedron S for which the sum of the squared Laplacians (3) is least.

    signs (E,) or a number: 1 for edges that run as in S, -1 for edges that run the other way, 0 for either. lengths:
    the least and the largest length of an edge of M, numbers or arrays (E,); edges whose sign is 0 may be shorter.
    length: a number or (E,), the target lengths of the edges with a sign; the squared deviations are added, `evenness`
    times. fixed: positions that vertices must have; near: positions that vertices should have, whose squared distances
    are added, `closeness` times.

    The sum of the squared Laplacians alone is least for a mesh shrunk to a point, so the size of M must be given in one
    of three ways. A least length: among all M of these signs with no shorter edge, the fairest one is found. Target
    lengths: then the edges are more even. Both results are unique up to translation, with the mean of the vertices at
    the origin, and twice as large for twice the lengths. Or fixed vertices.

    Edges without a least length may vanish; if none does, M and S are a `Pair`.
    M is parallel to S, and fixed vertices and lengths are kept, as `ParallelSpace.minimise` promises.
    Raises GeometryError where S is no Koebe polyhedron, where the signs have no solution, naming the faces that cannot
    close or a few edges that contradict the others, where M has shrunk to a point, and as `ParallelSpace.minimise`
    does.

    >>> import numpy as np
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh.tilings import hexagon_patch
    >>> S = koebe(hexagon_patch(3, 3), coverage=0.3).mesh
    >>> M = edge_offset_mesh(S, signs=1, lengths=(0.8, np.inf))
    >>> (edge_factors(S, M) > 0).all().item(), M.edge_lengths.min().round(6).item()
    (True, 0.8)
    """
    gauss_image = as_gauss_image(gauss_image)
    KoebePolyhedron(gauss_image)  # checks it
    checked = checked_signs(gauss_image, signs)
    check_faces_can_close(gauss_image, checked)
    bounds = _bounds(gauss_image, checked, lengths)
    target = FixedVertices.of(gauss_image, near)
    given_sizes = [target.positions, FixedVertices.of(gauss_image, fixed).positions]
    given_sizes.append(distances_from_zero(*bounds) * gauss_image.edge_lengths)
    terms = [(1.0, laplacian(gauss_image.combinatorics))]
    if len(target.vertices):
        terms.append((closeness, LinearFunctional(target.rows(gauss_image.n_vertices), target.positions.ravel())))
    if length is not None and evenness != 0:
        terms.append((evenness, _close_to_lengths(gauss_image, checked, length)))
        given_sizes.append(terms[-1][1].target)
    size = max(map(max_norm, given_sizes))
    if size == 0:
        raise _shrunk(0.0)
    is_placed = bool(fixed or near)
    anchor = int(gauss_image.combinatorics.corners[0])  # without positions, any one determines the translation
    fixed_or_anchor = fixed if is_placed else {anchor: np.zeros(3)}
    try:
        found = ParallelSpace(gauss_image).minimise(terms, fixed=fixed_or_anchor, factor_bounds=bounds)
    except GeometryError as error:
        check_signs_fit_together(gauss_image, checked, error)
        raise
    if found.mean_edge_length <= LEAST_MESH_SIZE * max(size, max_norm(found.vertices)):
        raise _shrunk(found.mean_edge_length)
    return found if is_placed else found.translated(-found.vertices.mean(axis=0))


def _close_to_lengths(gauss_image: Mesh, signs: IntArray, length: Any) -> LinearFunctional:
    """The lengths of the signed edges minus their target lengths."""
    signed = np.flatnonzero(signs)
    rows = csr_array(FactorBounds.of(gauss_image, (0.0, 0.0)).rows(gauss_image)[signed])
    target = floats(length)
    if target.shape not in ((), (gauss_image.n_edges,)):
        raise GeometryError(f"the lengths have shape {target.shape}, there are {gauss_image.n_edges} edges")
    target = np.broadcast_to(target, gauss_image.n_edges)[signed]
    wrong = np.flatnonzero(~((target > 0) & np.isfinite(target)))
    if len(wrong):
        name = gauss_image.combinatorics.edge_name(int(signed[wrong[0]]))
        raise GeometryError(
            f"{name} has the target length {target[wrong[0]]}: a finite number above 0 is needed; signs "
            "determine the direction of edges",
            elements=signed[wrong].tolist(),
            value=float(target[wrong[0]]),
            bound=0.0,
        )
    return LinearFunctional(rows, target * signs[signed])


def _bounds(gauss_image: Mesh, signs: IntArray, lengths: tuple[Any, Any]) -> tuple[FloatArray, FloatArray]:
    """Lower and upper bounds (E,) of the edge factors."""
    allowed = FactorBounds.of(gauss_image, lengths)
    least, most = allowed.lower, allowed.upper
    raise_worst(
        least,
        ">=",
        0.0,
        lambda edge, value: (
            f"{gauss_image.combinatorics.edge_name(edge)} is to be at least {value} long: lengths are 0 or more"
        ),
    )
    least, most = least / gauss_image.edge_lengths, most / gauss_image.edge_lengths
    return np.choose(signs + 1, [-most, -most, least]), np.choose(signs + 1, [-least, most, most])


def _shrunk(mean_edge_length: float) -> GeometryError:
    return GeometryError(
        f"the mesh has shrunk to a point: its mean edge length is {mean_edge_length:.1e}, since nothing prescribes a "
        "size; ask for lengths of edges that keep or reverse their orientation, fix two vertices or more, or "
        "increase the closeness",
        value=mean_edge_length,
    )


# --- signs


def guided_signs(gauss_image: MeshLike, guide: MeshLike) -> IntArray:
    """(E,) 1 where an edge of the guide makes an acute angle with that of S, -1 for an obtuse one; 0 for a right angle
    or no length.

    The guide has the faces of S and roughly the intended shape. It need not be parallel to S, but the signs are certain
    to have a solution only if it is, as `ParallelSpace.project(guide)` is: then they are the signs of its edge factors
    (1). Raises MeshError where the guide has other faces.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import cube
    >>> np.unique(guided_signs(cube(), cube() * -2.0)).tolist()
    [-1]
    """
    gauss_image = as_gauss_image(gauss_image)
    guide = as_mesh(guide)
    sizes = np.maximum(guide.edge_lengths, np.finfo(float).tiny)
    cosines = edge_factors(gauss_image, guide) * gauss_image.edge_lengths / sizes
    return integers(np.where(np.abs(cosines) <= GUIDE_COSINE_TOLERANCE, 0, np.sign(cosines)))


def saddle_signs(gauss_image: MeshLike, direction: Any, *, pole: Any = None) -> IntArray:
    """(E,) for negative curvature: 1 for edges nearer to a direction field, -1 for those nearer to the perpendicular
    field.

    direction (3,) or (E, 3): vectors at the points where the edges touch the unit sphere, projected to its tangent
    planes there. One vector for all edges gives the directions of the meridians about it. With a pole (3,) on the
    sphere, the vectors are brought to these points by stereographic projection from the pole: one vector perpendicular
    to it gives the directions of the images of parallel lines. An edge halfway between, at the pole, or where the field
    vanishes, gets 0.

    Raises GeometryError for other shapes, numbers that are not finite, and a pole off the unit sphere.

    >>> import numpy as np
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh.tilings import quad_patch
    >>> S = koebe(quad_patch(4, 4), coverage=0.3).mesh
    >>> np.unique(saddle_signs(S, [1, 1, 0]), return_counts=True)[1].tolist()
    [20, 20]
    """
    gauss_image = as_gauss_image(gauss_image)
    field = floats(direction)
    if field.shape not in ((3,), (gauss_image.n_edges, 3)):
        raise GeometryError(f"the direction has shape {field.shape}, (3,) or ({gauss_image.n_edges}, 3) is needed")
    field = array_of(field, field.shape, "the direction")
    points = edge_feet(gauss_image)
    vectors = np.broadcast_to(field, points.shape)
    if pole is not None:
        vectors = _mirrored(vectors, points - _checked_pole(pole))
    flat = perpendicular_part(vectors, points)
    along = np.einsum("ei,ei->e", flat, gauss_image.edge_directions)
    rather_along = 2 * along**2 - np.einsum("ei,ei->e", flat, flat)
    size = float(np.square(field).sum(axis=-1).max())
    return integers(np.where(np.abs(rather_along) <= GUIDE_COSINE_TOLERANCE * size, 0, np.sign(rather_along)))


def _mirrored(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """(E, 3) the images of directions under the derivative of an inversion: reflections in the planes perpendicular to
    `normals`, the vectors from its centre. Zero at the centre itself.
    """
    squares = np.einsum("ei,ei->e", normals, normals)[:, None]
    inner = np.einsum("ei,ei->e", vectors, normals)[:, None]
    mirrored = vectors - 2 * inner / np.maximum(squares, np.finfo(float).tiny) * normals
    return np.where(squares > GUIDE_COSINE_TOLERANCE**2, mirrored, 0.0)


def _checked_pole(pole: Any) -> FloatArray:
    point = floats(pole)
    if point.shape != (3,) or not abs(np.linalg.norm(point) - 1) <= EDGE_TANGENCY_TOLERANCE:
        raise GeometryError(f"the pole is {point.tolist()}, a point of the unit sphere is needed")
    return point


def alternating_signs(combinatorics: CombinatoricsLike, *, first: int = 1) -> IntArray:
    """(E,) the signs of negative curvature in a mesh of quads: opposite edges have the same sign, neighbouring edges
    opposite ones.

    first: 1 or -1, the sign of edge 0, and of the first edge of each part that no quads connect with it. Faces of
    other sizes have no effect, and edges that belong to no quad get 0. Raises GeometryError, naming an edge, where that
    is contradictory, as around interior vertices of odd valence.

    >>> from geometry.mesh.tilings import quad_patch
    >>> alternating_signs(quad_patch(1, 1)).tolist()  # opposite edges have the same sign
    [1, -1, 1, -1]
    """
    combinatorics = as_combinatorics(combinatorics)
    if first not in (-1, 1):
        raise GeometryError(f"the first sign is {first}: it must be -1 or 1")
    c, n = combinatorics, combinatorics.n_edges
    in_quad = c.face_sizes[c.corner_face] == 4
    here, ahead = c.corner_edge[in_quad], c.corner_edge[c.next_corner[in_quad]]
    # edge e appears twice: as e for one sign and as n + e for the other one
    pairs = np.concatenate([here, here + n]), np.concatenate([ahead + n, ahead])
    parts = connected_components(coo_array((np.ones(2 * len(here)), pairs), shape=(2 * n, 2 * n)), directed=False)[1]
    contradictory = np.flatnonzero(parts[:n] == parts[n:])
    if len(contradictory):
        raise GeometryError(
            f"{c.edge_name(contradictory[0])} would have to keep and to reverse its orientation: where rows of quads "
            "run around a vertex of odd valence, or close with a twist, signs cannot alternate; give signs edge by "
            "edge",
            elements=contradictory.tolist(),
        )
    is_first = parts[:n] < parts[n:]  # parts are numbered in the order of their first edges
    connected = np.isin(np.arange(n), here)
    return integers(np.where(connected, np.where(is_first, first, -first), 0))
