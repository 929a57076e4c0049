"""Measures of a pair M, S: spread of distances, lean, exactness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, angles_between, integers
from geometry.functionals import close_to_vertex_normals, faces_at_unit_distance, parallel_to, relative_plane_deviations
from geometry.gauss import Pair
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.polygons import mixed_areas
from geometry.optimise import minimise_quadratic, normal_equations
from geometry.parallel import parallelity
from geometry.surface import Surface

__all__ = ["PairMeasures", "faces_off_the_rim", "independent_curvatures"]

SPREAD_QUANTILES = (0.025, 0.5, 0.975)
"""Quantiles of distances: the spread is the outer two's difference over the middle one."""


INDEPENDENT_VERTEX_WEIGHT, INDEPENDENT_PARALLELITY = 0.1, 1e-7
"""Weight of vertices over that of faces in a Gauss image of M alone, and its tolerance for being parallel to M."""


@dataclass(frozen=True)
class PairMeasures:
    """edge_spread, vertex_spread, face_spread: the range from the 2.5 % to the 97.5 % quantile of the distances from
    the origin, over their median; of edges, that is of beam heights. lean: of node axes from the normals of Phi, of M
    without one, in radians: the median, 95 % and the largest. surface_distance: of vertices from Phi, in mean edge
    lengths of M as given, 95 % and the largest; zero without Phi. plane_deviation, parallelity: the largest, in mean
    edge lengths of M and in S.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import dome
    >>> measures = PairMeasures.of(Pair(dome(8, 3), dome(8, 3)), None, dome(8, 3).mean_edge_length)
    >>> measures.vertex_spread < 1e-9, measures.edge_spread > 0.01
    (True, True)
    """

    edge_spread: float
    vertex_spread: float
    face_spread: float
    lean: tuple[float, float, float]
    surface_distance: tuple[float, float]
    plane_deviation: float
    parallelity: float

    @classmethod
    def of(cls, pair: Pair, surface: Surface | None, length: float) -> PairMeasures:
        """length: the mean edge length of M as given."""
        mesh, image = pair.mesh, pair.gauss_image
        used = mesh.combinatorics.is_used
        lean, away = pair.leans[used], np.zeros(int(used.sum()))
        if surface is not None:
            points = mesh.vertices[used]
            feet, normals = surface.closest(points)
            lean, away = angles_between(image.vertices[used], normals), np.linalg.norm(points - feet, axis=1) / length
        median, most, largest = np.nanquantile(lean, [0.5, 0.95, 1.0]).tolist()
        return cls(
            edge_spread=_spread(pair.edge_distances),
            vertex_spread=_spread(pair.vertex_distances[used]),
            face_spread=_spread(pair.face_distances),
            lean=(median, most, largest),
            surface_distance=(float(np.quantile(away, 0.95)), float(away.max())),
            plane_deviation=float(relative_plane_deviations(mesh).max()),
            parallelity=float(parallelity(mesh, image).max()),
        )


def _spread(distances: FloatArray) -> float:
    low, middle, high = np.quantile(distances, SPREAD_QUANTILES).tolist()
    return float((high - low) / abs(middle)) if middle else np.inf


def independent_curvatures(mesh: Mesh, *, gaussian: bool) -> tuple[FloatArray, float]:
    """H or K (F,) of the faces of M with respect to a Gauss image that is computed from M alone, and a size of it: the
    curvature that zero is to be compared with.

    A Gauss image that was optimised with M can be tilted until it has any curvature; this one cannot. It is that of
    `gauss.approximate_pair`, but parallel to `INDEPENDENT_PARALLELITY` only, so that it is found too where conditions
    of P(M) nearly depend on each other, as on meshes of constant curvature.
    """
    c = mesh.combinatorics
    terms = [(INDEPENDENT_VERTEX_WEIGHT, close_to_vertex_normals(mesh)), (1.0, faces_at_unit_distance(mesh))]
    conditions = parallel_to(mesh)
    found = minimise_quadratic(
        *normal_equations(terms), conditions.matrix, conditions.target, tolerance=INDEPENDENT_PARALLELITY
    ).x.reshape(-1, 3)
    areas, normals = np.linalg.norm(mesh.vector_areas, axis=1), mesh.face_normals
    mean = -mixed_areas(mesh.vertices, found, c, normals) / areas
    curvature = mixed_areas(found, found, c, normals) / areas
    if gaussian:
        return curvature, float(np.median(mean**2))
    return mean, float(np.sqrt(np.median(np.abs(curvature))))


def faces_off_the_rim(combinatorics: Combinatorics, rows: int) -> IntArray:
    """The faces (n,) with so many rows of faces between them and the boundary: at the rim, normals are less sure."""
    c = combinatorics
    outer = c.is_boundary_vertex
    for _ in range(rows):
        near = np.logical_or.reduceat(outer[c.corners], c.face_starts[:-1])
        outer = outer.copy()
        outer[c.corners[near[c.corner_face]]] = True
    return integers(np.flatnonzero(~np.logical_or.reduceat(outer[c.corners], c.face_starts[:-1])))
