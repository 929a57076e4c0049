"""The polygons between isolines: faces of the graph of isolines and boundary, from the order of edges about nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import GeometryError
from geometry.layout.exact_maps import CELL_SIZE, ExactMap
from geometry.layout.grid_points import GridPoints
from geometry.layout.rays import rays_between

__all__ = ["Cells", "cells_between_isolines"]


@dataclass(frozen=True, eq=False)
class Cells:
    """Polygons on a surface. triangles (n,), weights (n, 3): the triangle of each corner point and its barycentric
    coordinates; vertices (n,): the vertex of the surface at this point, -1 where there is none. corners, starts: as in
    `Combinatorics`.
    """

    triangles: IntArray
    weights: FloatArray
    vertices: IntArray
    corners: IntArray
    starts: IntArray


def cells_between_isolines(exact_map: ExactMap) -> Cells:
    """All faces between isolines; those at the boundary also have the vertices of the boundary.

    Raises GeometryError where no isoline meets a boundary loop or a whole connected part.
    """
    points = GridPoints(exact_map)
    rays = rays_between(points)
    rim_tails, rim_heads, ends = _rim(points)
    n_rays, n_rim = len(rays.tails), len(rim_tails)
    tails = np.concatenate([rays.tails, rim_tails, rim_heads])
    forward, back = n_rays + np.arange(n_rim), n_rays + n_rim + np.arange(n_rim)
    twins = np.concatenate([rays.twins, back, forward])
    fans = np.concatenate([rays.fans, np.zeros(n_rim, dtype=np.int64), np.full(n_rim, np.iinfo(np.int64).max)])
    ranks = np.concatenate([rays.ranks, np.full(2 * n_rim, -1)])
    order = np.lexsort((ranks, fans, tails))
    first = np.searchsorted(tails[order], tails[order])
    last = np.searchsorted(tails[order], tails[order], side="right") - 1
    before = np.arange(len(order)) - 1
    before = np.where(before < first, last, before)
    clockwise = np.empty(len(order), dtype=np.int64)
    clockwise[order] = order[before]
    following = clockwise[twins]

    inside = np.arange(n_rays + n_rim)
    face_labels = connected_components(
        coo_array((np.ones(len(inside)), (inside, following[inside])), shape=(len(inside), len(inside)))
    )[1].astype(np.int64)
    _check_rim(points, face_labels, n_rays, ends)
    corners, starts = _grouped_by_face(following[: len(inside)], face_labels)
    triangles, weights = points.positions
    vertices = np.full(points.n_nodes, -1)
    on_nodes = np.flatnonzero(points.at_vertices >= 0)
    vertices[points.at_vertices[on_nodes]] = on_nodes
    used, numbered = np.unique(tails[corners], return_inverse=True)
    return Cells(triangles[used], weights[used], vertices[used], integers(numbered), starts)


def _rim(points: GridPoints) -> tuple[IntArray, IntArray, IntArray]:
    """First and last nodes (n,) of the parts of boundary edges between nodes, in the direction of their faces, and a
    vertex (n,) of the surface to name each part in messages."""
    c, x = points.exact_map.combinatorics, points.crossings
    at = points.exact_map.values.reshape(-1, 2)
    halves = np.flatnonzero(c.twin < 0)
    tail, head = at[x.halves, x.components], at[c.next_corner[x.halves], x.components]
    share = (x.values * CELL_SIZE - tail) / (head - tail)
    half = np.concatenate([halves, x.halves, halves])
    place = np.concatenate([np.full(len(halves), -1.0), share, np.full(len(halves), 2.0)])
    heads = c.corners[c.next_corner[halves]]
    nodes = np.concatenate([points.at_vertices[c.corners[halves]], x.nodes, points.at_vertices[heads]])
    order = np.lexsort((place, half))
    half, nodes = half[order], nodes[order]
    keep = (half[1:] == half[:-1]) & (nodes[1:] != nodes[:-1])
    return nodes[:-1][keep], nodes[1:][keep], c.corners[half[1:][keep]]


def _check_rim(points: GridPoints, face_labels: IntArray, n_rays: int, ends: IntArray) -> None:
    meets_no_line = np.bincount(face_labels[n_rays:], minlength=face_labels.max() + 1) == np.bincount(face_labels)
    meets_no_line = np.flatnonzero(meets_no_line[face_labels[n_rays:]])
    if len(meets_no_line):
        one_of_each = np.unique(face_labels[n_rays:][meets_no_line], return_index=True)[1]
        vertices = ends[meets_no_line[one_of_each]]
        others = f" and {len(vertices) - 1} more like it meet" if len(vertices) > 1 else " meets"
        raise GeometryError(
            f"the boundary through vertex {vertices[0]}{others} no line of the mesh: the hole or connected "
            "part is smaller than a face; fill it or leave it out, align the boundary of a hole, or give a shorter "
            "edge length",
            elements=vertices.tolist(),
        )


def _grouped_by_face(following: IntArray, face_labels: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges (n,), face after face and in their order around the face, and where each face begins (F+1,)."""
    faces, start, sizes = np.unique(face_labels, return_index=True, return_counts=True)
    starts = np.concatenate([[0], np.cumsum(sizes)])
    corners = np.empty(len(face_labels), dtype=np.int64)
    face, at = np.arange(len(faces)), start
    for step in range(int(sizes.max())):
        here = sizes[face] > step
        face, at = face[here], at[here]
        corners[starts[face] + step] = at
        at = following[at]
    return integers(corners), integers(starts)
