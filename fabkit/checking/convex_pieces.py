"""Triangulation of polygons into compact triangles, so that few of their bounding boxes overlap."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from geometry.arrays import FloatArray, IntArray

__all__ = ["MAX_CORNERS_UNCUT", "triangles"]

MAX_CORNERS_UNCUT = 32
"""Largest number of corners of a polygon that is triangulated without being halved first."""

Polygons = npt.NDArray[np.object_]


def triangles(outlines: FloatArray) -> tuple[FloatArray, IntArray]:
    """Corners (T, 3, 2), in either orientation, of triangles that fill simple polygons (P, n, 2); (T,) the polygon of
    each."""
    small, owner = _halved(shapely.polygons(outlines))
    found, of_small = shapely.get_parts(shapely.constrained_delaunay_triangles(small), return_index=True)
    return shapely.get_coordinates(found).reshape(-1, 4, 2)[:, :3], owner[of_small]


def _halved(polygons: Polygons) -> tuple[Polygons, IntArray]:
    """The polygons, those with many corners cut into halves repeatedly, and the original polygon of each piece.

    A cut leaves about half the corners on either side and adds some at the cut. A half with as many corners as the
    polygon before the cut is not cut again.
    """
    owner, before = np.arange(len(polygons)), np.full(len(polygons), np.iinfo(np.int64).max)
    done = []
    while len(polygons):
        counts = shapely.get_num_coordinates(polygons) - 1
        large = (counts > MAX_CORNERS_UNCUT) & (counts < before)
        done.append((polygons[~large], owner[~large]))
        boxes = np.array([_halves(polygon) for polygon in polygons[large]]).reshape(-1, 2)
        parts, index = shapely.get_parts(shapely.intersection(polygons[large, None], boxes).ravel(), return_index=True)
        areal = shapely.get_dimensions(parts) == 2
        polygons, whole = parts[areal], np.flatnonzero(large)[index[areal] // 2]
        owner, before = owner[whole], counts[whole]
    return np.concatenate([some for some, _ in done]), np.concatenate([of for _, of in done])


def _halves(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """Two boxes that together contain the polygon, divided across its longer extent where corners are far apart."""
    corners = shapely.get_coordinates(polygon)
    low, high = corners.min(axis=0) - 1.0, corners.max(axis=0) + 1.0
    axis = int((high - low).argmax())
    values = np.unique(corners[:, axis])
    middle = values[len(values) // 3 : len(values) - len(values) // 3 + 1]
    gap = int(np.diff(middle).argmax())
    cut = (middle[gap] + middle[gap + 1]) / 2
    first_high, second_low = high.copy(), low.copy()
    first_high[axis] = second_low[axis] = cut
    return [shapely.box(*low, *first_high), shapely.box(*second_low, *high)]
