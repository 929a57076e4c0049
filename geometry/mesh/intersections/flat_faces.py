"""Faces as polygons in their best planes: which are simple, which are coplanar, and which of these share area."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections.box_trees import PAIRS_AT_ONCE, BoxTree, box_trees, meeting_sets
from geometry.mesh.polygons import perpendicular_pair

__all__ = ["CLEARANCE", "are_simple", "coplanar", "extreme_corners", "heights_over", "outlines", "overlapping"]

CLEARANCE = 1e-9
"""Distance from a plane over the mean edge length, up to which a vertex counts as in the plane. Faces are planar to
1e-12; the planes of thin faces are less accurate in proportion to how thin they are."""

LEAST_OVERLAP_SHARE = 1e-6
"""Area that two coplanar faces share, over the area of the smaller one, below which they only touch."""

MANY_CORNERS = 64
"""Largest number of corners of a face that is compared with others as a whole; larger ones are cut into triangles or
prepared with a tree of their edges."""

OVERLAY_GRID = 2.0**-42
"""Grid to which overlays are rounded, over the largest coordinate. Without it, where corners are off an edge by
rounding, GEOS finds shared area for some per cent of the polygons that only touch, and none for some that overlap."""


def outlines(mesh: Mesh, faces: IntArray, planes: IntArray) -> npt.NDArray[np.object_]:
    """(k,) shapely polygons of faces (k,), seen along the normals of the faces `planes` (k,)."""
    corners, owner = mesh.combinatorics.corners_of(faces)
    here = mesh.vertices[mesh.combinatorics.corners[corners]]
    flat = np.einsum("kai,ki->ka", perpendicular_pair(mesh.face_normals)[planes[owner]], here)
    return np.asarray(shapely.polygons(shapely.linearrings(flat, indices=owner)))


def are_simple(mesh: Mesh) -> BoolArray:
    """(F,) whether the edges of a face meet only in common corners."""
    faces = np.arange(mesh.n_faces)
    return np.asarray(shapely.is_valid(outlines(mesh, faces, faces)))


def heights_over(mesh: Mesh, faces: IntArray, points: FloatArray) -> FloatArray:
    """(k,) heights of points (k, 3) above the planes of faces (k,), zero within the clearance."""
    first = mesh.vertices[mesh.combinatorics.corners[mesh.combinatorics.face_starts[faces]]]
    heights = np.einsum("ki,ki->k", points - first, mesh.face_normals[faces])
    heights[np.abs(heights) <= CLEARANCE * mesh.mean_edge_length] = 0.0
    return np.asarray(heights)


# --- coplanar faces


def extreme_corners(mesh: Mesh) -> IntArray:
    """(F, 4) the extreme vertices of each face in four directions: if they are in a plane, the others mostly are,
    too."""
    c = mesh.combinatorics
    across = perpendicular_pair(mesh.face_normals)[c.corner_face]
    found = []
    for values in np.einsum("cai,ci->ac", across, mesh.vertices[c.corners]):
        order = np.lexsort((values, c.corner_face))
        found += [order[c.face_starts[:-1]], order[c.face_starts[1:] - 1]]
    return np.asarray(c.corners[np.stack(found, axis=1)])


def coplanar(mesh: Mesh, extremes: IntArray, pairs: IntArray) -> BoolArray:
    """(k,) whether all corners of one face of each pair (k, 2) lie in the plane of the other."""
    small, large = _by_size(mesh, pairs)
    found = _in_plane(mesh, extremes, large, small)
    remaining = np.flatnonzero(~found)
    found[remaining] = _in_plane(mesh, extremes, small[remaining], large[remaining])
    return found


def _by_size(mesh: Mesh, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """The face with fewer corners (k,) of each pair (k, 2), and the other one (k,)."""
    sizes = mesh.combinatorics.face_sizes[pairs]
    swapped = sizes[:, 0] > sizes[:, 1]
    return np.where(swapped, pairs[:, 1], pairs[:, 0]), np.where(swapped, pairs[:, 0], pairs[:, 1])


def _in_plane(mesh: Mesh, extremes: IntArray, faces: IntArray, others: IntArray) -> BoolArray:
    """(k,) whether all corners of the other faces lie in the planes of faces (k,)."""
    c, vertices = mesh.combinatorics, mesh.vertices
    found = np.ones(len(faces), dtype=bool)
    for column in range(4):
        remaining = np.flatnonzero(found)
        found[remaining] = heights_over(mesh, faces[remaining], vertices[extremes[others[remaining], column]]) == 0
    remaining = np.flatnonzero(found)
    corners, owner = c.corners_of(others[remaining])
    is_off_plane = heights_over(mesh, faces[remaining][owner], vertices[c.corners[corners]]) != 0
    found[remaining] = np.bincount(owner, is_off_plane, minlength=len(remaining)) == 0
    return found


# --- shared area


def overlapping(mesh: Mesh, pairs: IntArray) -> IntArray:
    """(n, 2) those of the pairs (k, 2) of coplanar faces that are simple and share area."""
    faces, which = np.unique(pairs, return_inverse=True)
    pairs = pairs[shapely.is_valid(outlines(mesh, faces, faces))[which].reshape(-1, 2).all(axis=1)]
    small, large = _by_size(mesh, pairs)
    is_large = mesh.combinatorics.face_sizes[large] > MANY_CORNERS
    found = np.zeros(len(pairs), dtype=bool)
    usual = np.flatnonzero(~is_large)
    for part in (usual[start : start + PAIRS_AT_ONCE] for start in range(0, len(usual), PAIRS_AT_ONCE)):
        found[part] = _share_area(mesh, small[part], large[part])
    order = np.flatnonzero(is_large)[np.argsort(large[is_large], kind="stable")]
    for part in np.split(order, np.flatnonzero(np.diff(large[order])) + 1) if len(order) else []:
        found[part] = _share_area_with(mesh, small[part], large[part])
    return np.asarray(pairs[found])


def _share_area(mesh: Mesh, small: IntArray, large: IntArray) -> BoolArray:
    """(k,) whether faces (k,) share area with larger ones (k,)."""
    faces, which = np.unique(large, return_inverse=True)
    polygons, others = outlines(mesh, faces, faces)[which], outlines(mesh, small, large)
    least = _least_areas(mesh, polygons, others)
    found = np.isfinite(least)
    found[found] = _shared_areas(polygons[found], others[found]) > least[found]
    return found


def _share_area_with(mesh: Mesh, small: IntArray, large: IntArray) -> BoolArray:
    """(k,) whether faces (k,) share area with one face of very many corners, repeated k times, which is cut only
    once."""
    polygon, others = outlines(mesh, large[:1], large[:1]), outlines(mesh, small, large)
    least = _least_areas(mesh, polygon, others)
    wide = np.flatnonzero(np.isfinite(least))
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    areas = np.zeros(len(small))
    for other, triangle in meeting_sets(_boxes(others[wide]), _boxes(triangles)):
        shared = _shared_areas(triangles[triangle], others[wide[other]])
        areas += np.bincount(wide[other], shared, minlength=len(small))
    return np.asarray(areas > least)


def _boxes(polygons: npt.NDArray[np.object_]) -> list[BoxTree]:
    """Trees of polygons (k,) without margin, since area that they share in a margin is only rounding."""
    points, owner = shapely.get_coordinates(polygons, include_z=True, return_index=True)
    starts = np.searchsorted(owner, np.arange(len(polygons) + 1))
    return box_trees(np.nan_to_num(points), starts, np.zeros(len(polygons)), np.full((len(polygons), 2), -1))


def _shared_areas(polygons: npt.NDArray[np.object_], others: npt.NDArray[np.object_]) -> FloatArray:
    """(k,) area that polygons (k,) share with others (k,)."""
    areas = np.zeros(len(polygons))
    meet = np.flatnonzero(~shapely.relate_pattern(polygons, others, "F********"))  # the others only touch, exactly
    areas[meet] = shapely.area(_overlay(polygons[meet], others[meet]))
    return areas


def _overlay(polygons: npt.NDArray[np.object_], others: npt.NDArray[np.object_]) -> npt.NDArray[np.object_]:
    """(k,) the intersections of polygons (k,) with others (k,), on a grid."""
    size = np.abs(shapely.bounds(polygons)).max(initial=0.0)
    return np.asarray(shapely.intersection(polygons, others, grid_size=OVERLAY_GRID * size))


def _least_areas(mesh: Mesh, polygons: npt.NDArray[np.object_], others: npt.NDArray[np.object_]) -> FloatArray:
    """(k,) the area above which polygons and others (k,) overlap; infinite where one has no area except by rounding.

    A simple face that crosses itself in the projection to the plane of the other one counts as without area.
    """
    smaller = np.minimum(shapely.area(polygons), shapely.area(others))
    wide = shapely.is_valid(others) & (smaller > (CLEARANCE * mesh.mean_edge_length) ** 2)
    return np.where(wide, LEAST_OVERLAP_SHARE * smaller, np.inf)
