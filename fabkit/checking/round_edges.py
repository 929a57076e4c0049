"""How far the edges of bores and round bars in planar faces are from all other edges of those faces."""

from __future__ import annotations

import numpy as np

from fabkit.parts import Measures
from geometry.arrays import FloatArray

__all__ = ["round_clearances"]

PARALLEL_ROUNDS_SINE = 1e-9
"""Sine of the angle up to which two rounds count as parallel: over 1 m they come nearer by 1e-6 mm."""


def round_clearances(of: Measures) -> FloatArray:
    """(P,) least distance in mm, across its axis, of the edge of a bore or round bar in a planar face from the other
    edges of that face; not positive where they cross, or where it is outside the face. Infinite without any.

    Rounds that are not parallel are taken for as wide as the major axes of their edges.
    """
    t, least = of.topology, np.full(len(of.vertices), np.inf)
    for k, end in np.argwhere(t.outer_round[t.rounds[:, 4:6]] != np.arange(len(t.rounds))[:, None]).tolist():
        face = int(t.rounds[k, 4 + end])
        if face in t.polygonal:
            least = np.minimum(least, _from_polygon(of, k, end, face))
        for other, other_end in np.argwhere(t.rounds[:, 4:6] == face).tolist():
            if other != k:
                is_outer = bool(t.outer_round[face] == other)
                least = np.minimum(least, _from_round(of, (k, end), (other, other_end), is_outer))
    return least


def _from_polygon(of: Measures, k: int, end: int, face: int) -> FloatArray:
    """The same of one end from the corners and sides of its face, in a plane in which its edge is the unit circle."""
    t = of.topology
    major = of.rims[end, :, :, k]
    minor = np.cross(of.round_axes[:, :, k], of.round_across[:, :, k], axis=0) * of.radii[:, k]
    corners = np.flatnonzero(t.corner_face == face)
    centre = of.points[:, :, t.rounds[k, 2 * end]]

    def flat(numbers: np.ndarray) -> FloatArray:
        away = of.points[:, :, t.corners[numbers]] - centre[:, :, None]
        return np.stack(
            [np.einsum("xpc,xp->pc", away, axis) / (axis * axis).sum(axis=0)[:, None] for axis in (major, minor)]
        )

    here, following = flat(corners), flat(t.next_corner[corners])
    side = following - here
    share = np.clip(-(here * side).sum(axis=0) / (side * side).sum(axis=0), 0, 1)
    distance = np.sqrt(((here + share * side) ** 2).sum(axis=0)).min(axis=1)
    crosses = (here[1] > 0) != (following[1] > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = here[0] - here[1] * side[0] / side[1] > 0
    is_inside = (crosses & right).sum(axis=1) % 2 == 1
    clearance: FloatArray = np.where(is_inside, distance - 1, -distance - 1) * of.radii[:, k]
    return clearance


def _from_round(of: Measures, one: tuple[int, int], other: tuple[int, int], is_outer: bool) -> FloatArray:
    """The same of one end from another one in its face. is_outer: the other is the outer edge of that face."""
    (k, end), (m, other_end), rounds = one, other, of.topology.rounds
    axis = of.round_axes[:, :, k]
    away = of.points[:, :, rounds[m, 2 * other_end]] - of.points[:, :, rounds[k, 2 * end]]
    across = away - (away * axis).sum(axis=0) * axis
    is_parallel = np.linalg.norm(np.cross(axis, of.round_axes[:, :, m], axis=0), axis=0) <= PARALLEL_ROUNDS_SINE
    half_axes = [np.linalg.norm(of.rims[e, :, :, n], axis=0) for n, e in (one, other)]
    distance = np.linalg.norm(np.where(is_parallel, across, away), axis=0)
    first, second = np.where(is_parallel, of.radii[:, [k, m]].T, half_axes)
    if is_outer:
        within: FloatArray = of.radii[:, m] - distance - first
        return within
    clearance: FloatArray = distance - first - second
    return clearance
