"""Cones of revolution through the edges at each vertex [Pottmann2007, Prop. 3].

A cone has two halves, and an edge may lie on either: in the Gauss image some edges may run the other way (Fig. 11).
So an edge counts as a line. Three lines lie on four cones, of which mostly one contains a fourth line.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geometry.arrays import FloatArray, IntArray, angles_between
from geometry.mesh import Mesh

__all__ = ["best_cones", "edge_stars", "line_spread"]

SIGNS = np.array([(1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, -1.0), (1.0, -1.0, -1.0)])
"""The four ways to take rays of three lines, up to turning all of them."""


def edge_stars(mesh: Mesh, *, least_valence: int) -> Iterator[tuple[IntArray, FloatArray]]:
    """For each valence k: the vertices (n,) and the unit directions (n, k, 3) of their edges."""
    c = mesh.combinatorics
    directions = mesh.edge_directions
    order = np.argsort(c.edges.T.ravel(), kind="stable")
    outwards = np.concatenate([directions, -directions])[order]
    starts = np.concatenate([[0], np.cumsum(c.vertex_degrees)])
    for valence in np.unique(c.vertex_degrees[c.vertex_degrees >= least_valence]):
        vertices = np.flatnonzero(c.vertex_degrees == valence)
        yield vertices, outwards[starts[vertices][:, None] + np.arange(valence)]


def best_cones(directions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit axes (n, 4, 3) of the best cones of lines (n, k, 3), k >= 3, and how far these are from the lines (n, 4).

    The deviation is the largest difference between the angle of a line with the axis and the mean of these angles, in
    radians. Each of the four cones through the three lines that differ most decides which half the other lines are on;
    the axis is then the best one for all these rays.
    """
    three = np.take_along_axis(directions, _three_lines(directions)[..., None], axis=1)
    ends = three[:, None] * SIGNS[None, :, :, None]  # n, cone, line, coordinate
    axes = np.cross(ends[:, :, 1] - ends[:, :, 0], ends[:, :, 2] - ends[:, :, 0])
    if directions.shape[1] > 3:
        halves = np.where(np.einsum("nci,nki->nck", axes, directions) < 0, -1.0, 1.0)
        rays = directions[:, None] * halves[..., None]
    else:
        rays = ends
    deviations = rays - rays.mean(axis=2, keepdims=True)
    axes = np.linalg.eigh(np.einsum("ncki,nckj->ncij", deviations, deviations))[1][..., 0]
    angles = angles_between(rays, axes[:, :, None, :])
    return axes, np.abs(angles - angles.mean(axis=2, keepdims=True)).max(axis=2)


def line_spread(directions: FloatArray) -> FloatArray:
    """(n,) sine of the least angle between the three of the lines (n, k, 3) that differ most: zero for two lines."""
    three = np.take_along_axis(directions, _three_lines(directions)[..., None], axis=1)
    return np.asarray(np.linalg.norm(np.cross(three, np.roll(three, 1, axis=1)), axis=2).min(axis=1))


def _three_lines(directions: FloatArray) -> IntArray:
    """(n, 3) the first line, the one most across it, and the one that differs most from both."""
    from_first = np.linalg.norm(np.cross(directions, directions[:, :1]), axis=2)
    second = from_first.argmax(axis=1)
    across = np.take_along_axis(directions, second[:, None, None], axis=1)
    from_both = np.minimum(from_first, np.linalg.norm(np.cross(directions, across), axis=2))
    return np.stack([np.zeros_like(second), second, from_both.argmax(axis=1)], axis=1)
