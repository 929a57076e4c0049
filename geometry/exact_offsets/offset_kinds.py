"""Which exact offsets a mesh has, and the pair with an exact Gauss image to build it with.

Almost no mesh has any, and searching for an exact S takes longer than computing the approximate one. Necessary
conditions around each vertex, or along a tree of edges, are therefore checked first; they cost little.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, angles_between
from geometry.errors import RankError
from geometry.exact_offsets.edge_cones import best_cones, edge_stars, line_spread
from geometry.exact_offsets.exact_gauss_image import circumscribed_pair, inscribed_pair, midscribed_pair
from geometry.exact_offsets.inscribed import inscribed_candidate
from geometry.exact_offsets.midscribed import LEAST_LINE_SPREAD
from geometry.exact_offsets.offset_conditions import conicality
from geometry.gauss.distances import DISTANCE_TOLERANCE
from geometry.gauss.pair import Pair
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.mesh.polygons import face_sums
from geometry.optimise import ConvergenceError
from geometry.parallel.edge_parallelity import check_planar, parallelity, perpendicular_part

__all__ = ["best_offset_pair", "offset_deviations"]

LARGEST_LOCAL_DEVIATION = 1e-4
"""Angle in radians, or distance on the unit sphere, by which the faces or edges around a vertex may deviate where S
may still be exact. Distances of S to 1e-9 determine angles to 1e-9 over the length of its edges, some hundredths or
thousandths."""

LARGEST_REPORTED_DEVIATION = 0.1
"""The same, above which `offset_deviations` looks for no S."""

EQUAL_CONES_TOLERANCE = LARGEST_LOCAL_DEVIATION
"""Deviation of lines from several cones, up to which the cones count as equally good: as large as for any that may be
exact."""

LEAST_BEAM_HEIGHT, LARGEST_BEAM_HEIGHT = 0.5, 2.0
"""Beam heights over the nominal one, beyond which an S is no Gauss image to build with, however exact: where faces next
to each other are nearly coplanar, those of three planes meet anywhere."""

LEAST_FACE_DISTANCE = 0.1
"""Least distance of a face of S over the least beam height: beams are within 84 degrees of the outer normals of their
faces."""

ONE_POINT_SIZE = 1e-6
"""Mean edge length of S, below which S counts as a single point, which is exact for every flat mesh and every mesh of
triangles but gives nothing that the approximate S does not."""

LARGEST_MEDIAN_LEAN = np.radians(30)
"""Largest median angle in radians between node axes and normals: with more, the axes are no longer useful as
normals."""


def best_offset_pair(mesh: MeshLike, *, tolerance: float = DISTANCE_TOLERANCE) -> tuple[str, Pair] | None:
    """The kind of exact offset, "edge", "vertex" or "face", with which the mesh is best built, and that pair; None
    where it has no exact offset.

    An edge offset comes first, as its beams have one height; of the others, the one with the smaller spread of beam
    heights. Distances are 1 to within `tolerance`, beams point to the outside of their faces, their heights are of the
    order of the nominal one, and axes are near the normals: an exact S that violates one of these is rejected. Meshes
    of triangles too: those inscribed in a sphere, or whose edges or faces touch one, have their own scaled copies.

    Raises GeometryError where a face is not planar or the tolerance is not positive, MeshError for an edge without
    length.

    >>> from geometry.mesh.shapes import box, dome
    >>> best_offset_pair(box(2, 3, 4))[0]
    'edge'
    """
    mesh = as_mesh(mesh)
    edge = _exact(mesh, "edge", tolerance)
    if edge is not None:
        return "edge", edge
    found = {kind: _exact(mesh, kind, tolerance) for kind in ("vertex", "face")}
    pairs = [(kind, pair) for kind, pair in found.items() if pair is not None]
    return min(pairs, key=lambda of_kind: float(np.ptp(of_kind[1].edge_distances)), default=None)


def offset_deviations(mesh: MeshLike) -> dict[str, float]:
    """How far the vertices, edges and faces of the nearest S of each kind are from distance 1 at most, by "vertex",
    "edge" and "face": rounding for an offset that the mesh has; infinite where no S is near.

    Faces may have any number of corners: triangles are always circular, and have a vertex offset hardly ever;
    pentagons and hexagons need not be circular [Pottmann2007, Prop. 2]. Raises as `best_offset_pair` does.

    >>> from geometry.mesh.shapes import dome
    >>> {kind: deviation < 1e-9 for kind, deviation in offset_deviations(dome(6, 2)).items()}
    {'vertex': True, 'edge': False, 'face': True}
    """
    mesh = as_mesh(mesh)
    return {
        kind: _nearest(mesh, kind, LARGEST_REPORTED_DEVIATION, DISTANCE_TOLERANCE)[1]
        for kind in ("vertex", "edge", "face")
    }


def _exact(mesh: Mesh, kind: str, tolerance: float) -> Pair | None:
    """M and S of this kind, if there is one to build with."""
    pair, deviation = _nearest(mesh, kind, LARGEST_LOCAL_DEVIATION, tolerance)
    if pair is None or not deviation <= tolerance:
        return None
    heights, faces = pair.edge_distances, pair.face_distances
    is_buildable = (
        pair.gauss_image.mean_edge_length > ONE_POINT_SIZE
        and heights.min() >= LEAST_BEAM_HEIGHT
        and heights.max() <= LARGEST_BEAM_HEIGHT
        and faces.min() >= LEAST_FACE_DISTANCE * heights.min()
        and np.nanmedian(pair.leans) <= LARGEST_MEDIAN_LEAN
    )
    return pair if is_buildable else None


def _nearest(mesh: Mesh, kind: str, bound: float, tolerance: float) -> tuple[Pair | None, float]:
    """M, S of this kind and how far it is from distance 1, unless some neighbourhood fails by more than the bound."""
    local, nearest = {
        "vertex": (_off_circles, inscribed_pair),
        "edge": (_off_cones, midscribed_pair),
        "face": (conicality, circumscribed_pair),
    }[kind]
    check_planar(mesh)
    if np.nan_to_num(local(mesh)).max(initial=0.0) > bound:
        return None, np.inf
    try:
        found, deviations = nearest(mesh, tolerance)
    except (ConvergenceError, RankError):  # P(M) is ill-conditioned: no exact S can be computed
        return None, np.inf
    return found, float(deviations.max())


def _off_circles(mesh: Mesh) -> FloatArray:
    """(F,) angle in radians by which no polygon with the edge directions of a face has a circumcircle; or (E,) by how
    much edges are off their directions where vertices on the unit sphere are computed along a tree.

    A chord reflects one of its ends to the other: around a face with an even number of corners, the sum of
    every second exterior angle is a multiple of pi. A face with an odd number of corners always closes, so that only
    the whole mesh decides.
    """
    c = mesh.combinatorics
    if (c.face_sizes % 2 == 1).any():
        return parallelity(mesh, mesh.with_vertices(inscribed_candidate(mesh, DISTANCE_TOLERANCE)))
    before, after = mesh.corner_directions[c.previous_corner], mesh.corner_directions
    sines = np.einsum("ck,ck->c", np.cross(before, after), mesh.face_normals[c.corner_face])
    turns = np.arctan2(sines, np.einsum("ck,ck->c", before, after))
    second = (np.arange(c.n_corners) - c.face_starts[c.corner_face]) % 2 == 1
    sums = face_sums(c, np.where(second, turns, 0.0))
    return np.asarray(np.abs(sums - np.pi * np.round(sums / np.pi)))


def _off_cones(mesh: Mesh) -> FloatArray:
    """How far edges are from cones (N,), and the axes of cones from coplanar (E,), in radians; together (N + E,).

    NaN at vertices with less than three edge lines, which lie on many cones. Axes are not asked where cones fail.
    """
    n = mesh.n_vertices
    axes, deviations = np.full((n, 4, 3), np.nan), np.full((n, 4), np.nan)
    for vertices, directions in edge_stars(mesh, least_valence=3):
        clear = line_spread(directions) > LEAST_LINE_SPREAD
        axes[vertices[clear]], deviations[vertices[clear]] = best_cones(directions[clear])
    off: FloatArray = deviations.min(axis=1)
    if np.nan_to_num(off).max(initial=0.0) > LARGEST_REPORTED_DEVIATION:
        return off
    axes[deviations > np.maximum(2 * off, EQUAL_CONES_TOLERANCE)[:, None]] = (
        np.nan
    )  # of three lines all four, of more the best
    ends, along = axes[mesh.combinatorics.edges], mesh.edge_directions[:, None, :]
    first, second = (perpendicular_part(end, along) for end in ends.swapaxes(0, 1))
    angles = angles_between(first[:, :, None], second[:, None, :])
    twists = np.fmin.reduce(np.minimum(angles, np.pi - angles), axis=(1, 2))
    return np.concatenate([off, twists])
