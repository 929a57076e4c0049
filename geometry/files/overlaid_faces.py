"""Duplicate faces: with the same vertices, or lying on a larger face whose vertices include theirs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.files.face_rings import first_with_same
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh.polygons import perpendicular_pair
from geometry.mesh.ragged_arrays import next_in_row

__all__ = ["overlaid_faces", "same_vertices"]

LEAST_PROJECTED_SHARE = 0.5
"""Area of a face projected along the normal of another one, over its area, above which it can lie on the other one; a
steeper face stands on it."""


def same_vertices(raw: RawPolygons) -> IntArray:
    """(n, 2) pairs of faces with the same vertices in any order: the first such face, and each of the others."""
    ordered = raw.corners[np.lexsort((raw.corners, raw.corner_face))]
    first = first_with_same(ordered, raw.face_starts)
    again = np.flatnonzero(first != np.arange(raw.n_faces))
    found: IntArray = np.stack([first[again], again], axis=1)
    return found[np.lexsort(found.T[::-1])]


def overlaid_faces(raw: RawPolygons) -> IntArray:
    """(n, 2) pairs of a face and a smaller one that lies on it and has only vertices of the larger one; sorted.

    An example is a quad with one of its triangles. A triangle in the notch of a face that is not convex is beside it.
    """
    pairs = _nested(raw)
    return pairs[_is_lying_on(raw, pairs)] if len(pairs) else pairs


def _nested(raw: RawPolygons) -> IntArray:
    """(n, 2) pairs of a face and a smaller one all of whose vertices it has; sorted.

    The smaller face is compared with the faces at that one of its vertices which has the fewest, so that the faces at a
    crowded vertex are not all compared.
    """
    n_at = np.bincount(raw.corners, minlength=raw.n_vertices)
    by_vertex = np.argsort(raw.corners, kind="stable")
    ends = np.cumsum(n_at)
    rarest = raw.corners[np.lexsort((n_at[raw.corners], raw.corner_face))[raw.face_starts[:-1]]]
    larger = np.maximum.reduceat(raw.face_sizes[raw.corner_face[by_vertex]], (ends - n_at)[n_at > 0])
    largest_at = np.zeros(raw.n_vertices, dtype=np.int64)
    largest_at[n_at > 0] = larger
    small = np.flatnonzero(raw.face_sizes < largest_at[rarest])
    counts = n_at[rarest[small]]
    guests = np.repeat(small, counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    hosts = raw.corner_face[by_vertex[(ends - n_at)[rarest[guests]] + within]]
    pairs = np.stack([hosts, guests], axis=1)[raw.face_sizes[hosts] > raw.face_sizes[guests]]
    corners, owner = _corners_of(raw, pairs[:, 1])
    known = np.sort(raw.corner_face * raw.n_vertices + raw.corners)
    wanted_keys = pairs[owner, 0] * raw.n_vertices + raw.corners[corners]
    missing = known[np.minimum(np.searchsorted(known, wanted_keys), len(known) - 1)] != wanted_keys
    nested: IntArray = pairs[np.bincount(owner, missing, minlength=len(pairs)) == 0]
    return nested[np.lexsort(nested.T[::-1])]


def _corners_of(raw: RawPolygons, faces: IntArray) -> tuple[IntArray, IntArray]:
    """All corners (n,) of faces (k,), and the index into `faces` (n,) for each."""
    sizes = raw.face_sizes[faces]
    owner = np.repeat(np.arange(len(faces)), sizes)
    within = np.arange(len(owner)) - (np.cumsum(sizes) - sizes)[owner]
    return raw.face_starts[faces][owner] + within, owner


def _is_lying_on(raw: RawPolygons, pairs: IntArray) -> BoolArray:
    """(n,) whether the second of each pair of faces has a point inside the first, in the projection along its
    normal."""
    centre = raw.vertices[raw.corners[raw.face_starts[pairs[:, 0]]]]
    hosts, host = np.unique(pairs[:, 0], return_inverse=True)
    areas = _areas(raw, hosts)
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    axes = perpendicular_pair(
        np.divide(areas, lengths, out=np.tile([0.0, 0.0, 1.0], (len(hosts), 1)), where=lengths > 0)
    )
    origin = raw.vertices[raw.corners[raw.face_starts[hosts]]]
    larger, smaller = _projected(raw, hosts, origin, axes), _projected(raw, pairs[:, 1], centre, axes[host])
    guest_areas = np.linalg.norm(_areas(raw, pairs[:, 1]), axis=1)
    lies = (
        shapely.is_valid(smaller)
        & shapely.is_valid(larger)[host]
        & (shapely.area(smaller) > LEAST_PROJECTED_SHARE * guest_areas)
    )
    shapely.prepare(larger)
    lies[lies] = shapely.contains(larger[host[lies]], shapely.point_on_surface(smaller[lies]))
    return np.asarray(lies)


def _areas(raw: RawPolygons, faces: IntArray) -> FloatArray:
    """(k, 3) vector areas of faces (k,)."""
    corners, owner = _corners_of(raw, faces)
    here = raw.vertices[raw.corners[corners]] - raw.vertices[raw.corners[raw.face_starts[faces]]][owner]
    ahead = here[next_in_row(np.concatenate([[0], np.cumsum(raw.face_sizes[faces])]))]
    return np.asarray(np.stack([np.bincount(owner, along) for along in np.cross(here, ahead).T], axis=1) / 2)


def _projected(raw: RawPolygons, faces: IntArray, origin: FloatArray, axes: FloatArray) -> npt.NDArray[np.object_]:
    """(k,) shapely polygons: the projections of faces (k,) to two axes (k, 2, 3) each, relative to points (k, 3)."""
    corners, owner = _corners_of(raw, faces)
    here = raw.vertices[raw.corners[corners]] - origin[owner]
    flat = np.einsum("kai,ki->ka", axes[owner], here)
    return np.asarray(shapely.polygons(shapely.linearrings(flat, indices=owner)))
