"""Faces as polygons in their planes: which are simple, which lie in one plane, and which of these share area."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections.box_trees import PAIRS_AT_ONCE, BoxTree, box_trees, meeting_sets
from geometry.mesh.polygons import perpendicular_pair

__all__ = ["PLANE_CLEARANCE", "are_simple", "coplanar", "extreme_corners", "heights_over", "outlines", "overlapping"]

PLANE_CLEARANCE = 1e-9
"""Distance from a plane over the mean edge length, up to which a vertex lies in it: faces are planar to 1e-12, and
their planes are known to about that over how thin they are."""

LEAST_OVERLAP_SHARE = 1e-6
"""Area that two faces in one plane share, over that of the smaller one, below which they only touch."""

MANY_CORNERS = 64
"""Corners of a face, above which it is cut into pieces, or its edges are put into a tree, before many other faces or
points are compared with it."""

OVERLAY_ROUNDING = 2.0**-42
"""Places to which overlays round, over the largest coordinate. Without, where corners are off an edge by rounding, GEOS
takes some per cent of polygons that touch for polygons that share area, and some that share area for apart."""


def outlines(mesh: Mesh, faces: IntArray, planes: IntArray) -> npt.NDArray[np.object_]:
    """(k,) shapely polygons of faces (k,), seen along the normals of the faces `planes` (k,)."""
    corners, owner = mesh.combinatorics.corners_of(faces)
    here = mesh.vertices[mesh.combinatorics.corners[corners]]
    flat = np.einsum("kai,ki->ka", perpendicular_pair(mesh.face_normals)[planes[owner]], here)
    return np.asarray(shapely.polygons(shapely.linearrings(flat, indices=owner)))


def are_simple(mesh: Mesh) -> BoolArray:
    """(F,) whether no two edges of a face meet elsewhere than in a common corner."""
    faces = np.arange(mesh.n_faces)
    return np.asarray(shapely.is_valid(outlines(mesh, faces, faces)))


def heights_over(mesh: Mesh, faces: IntArray, points: FloatArray) -> FloatArray:
    """(k,) of points (k, 3) above the planes of faces (k,), zero within the clearance."""
    first = mesh.vertices[mesh.combinatorics.corners[mesh.combinatorics.face_starts[faces]]]
    heights = np.einsum("ki,ki->k", points - first, mesh.face_normals[faces])
    heights[np.abs(heights) <= PLANE_CLEARANCE * mesh.mean_edge_length] = 0.0
    return np.asarray(heights)


# --- faces in one plane


def extreme_corners(mesh: Mesh) -> IntArray:
    """(F, 4) the vertices of each face that are farthest to four sides: where they are in a plane, mostly all are."""
    c = mesh.combinatorics
    across = perpendicular_pair(mesh.face_normals)[c.corner_face]
    found = []
    for values in np.einsum("cai,ci->ac", across, mesh.vertices[c.corners]):
        order = np.lexsort((values, c.corner_face))
        found += [order[c.face_starts[:-1]], order[c.face_starts[1:] - 1]]
    return np.asarray(c.corners[np.stack(found, axis=1)])


def coplanar(mesh: Mesh, extremes: IntArray, pairs: IntArray) -> BoolArray:
    """(k,) whether all corners of one of two faces (k, 2) lie in the plane of the other."""
    small, large = _by_size(mesh, pairs)
    found = _in_plane(mesh, extremes, large, small)
    rest = np.flatnonzero(~found)
    found[rest] = _in_plane(mesh, extremes, small[rest], large[rest])
    return found


def _by_size(mesh: Mesh, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Of two faces (k, 2) that with less corners (k,), and the other (k,)."""
    sizes = mesh.combinatorics.face_sizes[pairs]
    swapped = sizes[:, 0] > sizes[:, 1]
    return np.where(swapped, pairs[:, 1], pairs[:, 0]), np.where(swapped, pairs[:, 0], pairs[:, 1])


def _in_plane(mesh: Mesh, extremes: IntArray, faces: IntArray, others: IntArray) -> BoolArray:
    """(k,) whether all corners of the other faces lie in the planes of faces (k,)."""
    c, vertices = mesh.combinatorics, mesh.vertices
    found = np.ones(len(faces), dtype=bool)
    for column in range(4):
        left = np.flatnonzero(found)
        found[left] = heights_over(mesh, faces[left], vertices[extremes[others[left], column]]) == 0
    rest = np.flatnonzero(found)
    corners, owner = c.corners_of(others[rest])
    off = heights_over(mesh, faces[rest][owner], vertices[c.corners[corners]]) != 0
    found[rest] = np.bincount(owner, off, minlength=len(rest)) == 0
    return found


# --- those that share area


def overlapping(mesh: Mesh, pairs: IntArray) -> IntArray:
    """(n, 2) those of the pairs (k, 2) of faces in one plane that are simple and share area."""
    pairs = pairs[are_simple(mesh)[pairs].all(axis=1)]
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
    """The same of (k,) faces with one that has very many corners, k times: it is cut once, and not searched anew."""
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
    """Trees of polygons (k,), as large as they are: what they share beyond is rounding."""
    points, owner = shapely.get_coordinates(polygons, include_z=True, return_index=True)
    starts = np.searchsorted(owner, np.arange(len(polygons) + 1))
    return box_trees(np.nan_to_num(points), starts, np.zeros(len(polygons)), np.full((len(polygons), 2), -1))


def _shared_areas(polygons: npt.NDArray[np.object_], others: npt.NDArray[np.object_]) -> FloatArray:
    """(k,) area that polygons (k,) share with others (k,)."""
    areas = np.zeros(len(polygons))
    meet = np.flatnonzero(~shapely.relate_pattern(polygons, others, "F********"))  # else they only touch, exactly
    areas[meet] = shapely.area(_overlay(polygons[meet], others[meet]))
    return areas


def _overlay(polygons: npt.NDArray[np.object_], others: npt.NDArray[np.object_]) -> npt.NDArray[np.object_]:
    """(k,) what polygons (k,) and others (k,) have in common, on a grid."""
    size = np.abs(shapely.bounds(polygons)).max(initial=0.0)
    return np.asarray(shapely.intersection(polygons, others, grid_size=OVERLAY_ROUNDING * size))


def _least_areas(mesh: Mesh, polygons: npt.NDArray[np.object_], others: npt.NDArray[np.object_]) -> FloatArray:
    """(k,) the area that polygons share with others (k,) if they overlap; infinite where one has none but for rounding.

    So has a simple face that crosses itself in the plane of the other one.
    """
    smaller = np.minimum(shapely.area(polygons), shapely.area(others))
    wide = shapely.is_valid(others) & (smaller > (PLANE_CLEARANCE * mesh.mean_edge_length) ** 2)
    return np.where(wide, LEAST_OVERLAP_SHARE * smaller, np.inf)
