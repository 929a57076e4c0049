"""The polygons between isolines: a graph of isolines and boundary, whose faces are found by turning at its nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import GeometryError
from geometry.layout.exact_maps import ISOLINE_SPACING, ExactMap
from geometry.layout.grid_points import GridPoints
from geometry.layout.rays import rays_between

__all__ = ["Cells", "cells_between_isolines"]


@dataclass(frozen=True, eq=False)
class Cells:
    """Polygons on a surface. triangles (n,), weights (n, 3): where their vertices are; vertices (n,): of the surface,
    -1 where there is none. corners, starts: as of Combinatorics.
    """

    triangles: IntArray
    weights: FloatArray
    vertices: IntArray
    corners: IntArray
    starts: IntArray


def cells_between_isolines(of: ExactMap) -> Cells:
    """All faces of the mesh of isolines, those at the boundary with all its vertices.

    Raises GeometryError where a boundary loop, or a whole piece, is met by no isoline.
    """
    points = GridPoints(of)
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
    label = connected_components(
        coo_array((np.ones(len(inside)), (inside, following[inside])), shape=(len(inside), len(inside)))
    )[1].astype(np.int64)
    _check_rim(points, label, n_rays, ends)
    corners, starts = _walked(following[: len(inside)], label)
    triangles, weights = points.positions
    vertices = np.full(points.n_nodes, -1)
    at = np.flatnonzero(points.at_vertices >= 0)
    vertices[points.at_vertices[at]] = at
    used, numbered = np.unique(tails[corners], return_inverse=True)
    return Cells(triangles[used], weights[used], vertices[used], integers(numbered), starts)


def _rim(points: GridPoints) -> tuple[IntArray, IntArray, IntArray]:
    """Nodes (n,) and (n,) at the ends of pieces of boundary edges, as faces run, and vertices (n,) to name them by."""
    c, x = points.of.combinatorics, points.crossings
    at = points.of.values.reshape(-1, 2)
    halves = np.flatnonzero(c.twin < 0)
    tail, head = at[x.halves, x.components], at[c.next_corner[x.halves], x.components]
    share = (x.values * ISOLINE_SPACING - tail) / (head - tail)
    half = np.concatenate([halves, x.halves, halves])
    place = np.concatenate([np.full(len(halves), -1.0), share, np.full(len(halves), 2.0)])
    heads = c.corners[c.next_corner[halves]]
    nodes = np.concatenate([points.at_vertices[c.corners[halves]], x.nodes, points.at_vertices[heads]])
    order = np.lexsort((place, half))
    half, nodes = half[order], nodes[order]
    keep = (half[1:] == half[:-1]) & (nodes[1:] != nodes[:-1])
    return nodes[:-1][keep], nodes[1:][keep], c.corners[half[1:][keep]]


def _check_rim(points: GridPoints, label: IntArray, n_rays: int, ends: IntArray) -> None:
    alone = np.bincount(label[n_rays:], minlength=label.max() + 1) == np.bincount(label)
    alone = np.flatnonzero(alone[label[n_rays:]])
    if len(alone):
        vertices = ends[alone][np.unique(label[n_rays:][alone], return_index=True)[1]]  # one of each boundary loop
        others = f" and {len(vertices) - 1} more like it are" if len(vertices) > 1 else " is"
        raise GeometryError(
            f"the boundary through vertex {vertices[0]}{others} met by no line of the mesh: the hole or piece is "
            "smaller than a face; fill it or leave it out, or give a shorter edge length",
            elements=vertices.tolist(),
        )


def _walked(following: IntArray, label: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges (n,), face after face, in the order in which they follow, and where each begins (F+1,)."""
    faces, start, sizes = np.unique(label, return_index=True, return_counts=True)
    starts = np.concatenate([[0], np.cumsum(sizes)])
    corners = np.empty(len(label), dtype=np.int64)
    face, at = np.arange(len(faces)), start
    for step in range(int(sizes.max())):
        here = sizes[face] > step
        face, at = face[here], at[here]
        corners[starts[face] + step] = at
        at = following[at]
    return integers(corners), integers(starts)
