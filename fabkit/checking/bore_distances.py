"""How far bores are from the edges of their faces and from each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fabkit.connections import LEAST_EDGE_RATIO, LEAST_PITCH_RATIO, LEAST_WALL_MM
from fabkit.parts import BORE, Measures, SolidArray
from geometry.arrays import FloatArray, IntArray

__all__ = ["drilling_faults", "edge_ratios", "pitch_ratios", "walls"]

ROUNDING = 1e-6
"""Difference in mm, or over a diameter, up to which a distance of bores counts as the least one."""


def _bores(measures: Measures) -> IntArray:
    return np.asarray(np.flatnonzero(measures.topology.rounds[:, 6] == BORE))


def edge_ratios(measures: Measures) -> FloatArray:
    """(P,) least distance of the centre of a bore from a straight edge of a face in which it ends, over the
    diameter of the bore; infinite where there is none."""
    t, points = measures.topology, measures.points
    found = np.full(points.shape[1], np.inf)
    for k in _bores(measures).tolist():
        for face, centre in zip(t.rounds[k, 4:6], t.rounds[k, [0, 2]], strict=True):
            corners = np.flatnonzero(t.corner_face == face)
            if len(corners):
                tail, head = points[:, :, t.corners[corners]], points[:, :, t.corners[t.next_corner[corners]]]
                edge, away = head - tail, points[:, :, centre, None] - tail
                share = np.clip((edge * away).sum(axis=0) / (edge * edge).sum(axis=0), 0.0, 1.0)
                nearest = np.sqrt(((away - share * edge) ** 2).sum(axis=0)).min(axis=1)
                found = np.minimum(found, nearest / (2 * measures.radii[:, k]))
    return found


def pitch_ratios(measures: Measures) -> FloatArray:
    """(P,) least distance of the centres of two bores in one face over the mean of their diameters; infinite where
    there are no two."""
    t = measures.topology
    found = np.full(measures.points.shape[1], np.inf)
    own = _bores(measures)
    for first, second in zip(*np.triu_indices(len(own), 1), strict=True):
        a, b = t.rounds[own[first]], t.rounds[own[second]]
        if a[4] == b[4]:
            apart = np.sqrt(((measures.points[:, :, a[0]] - measures.points[:, :, b[0]]) ** 2).sum(axis=0))
            found = np.minimum(found, apart / measures.radii[:, own[[first, second]]].sum(axis=1))
    return found


def walls(measures: Measures) -> FloatArray:
    """(P,) least thickness in mm between two bores; infinite where there are no two.

    Two cylinders are apart at least by the gap between their projections onto any line. Taken are their axes, the
    difference of these, which is normal to the plane between two bores that meet in the axis of a node, their common
    normal, and the line from one to the other across the first axis, for parallel ones.
    """
    t = measures.topology
    found = np.full(measures.points.shape[1], np.inf)
    own = _bores(measures)
    first, second = own[np.stack(np.triu_indices(len(own), 1))]
    if not len(first):
        return found
    middles = measures.points[:, :, t.rounds[:, [0, 2]]].mean(axis=3)
    axes, halves, radii = measures.round_axes, measures.lengths / 2, measures.radii
    between = middles[:, :, first] - middles[:, :, second]
    a, b = axes[:, :, first], axes[:, :, second]
    gap = np.full(between.shape[1:], -np.inf)
    across = between - (between * a).sum(axis=0) * a
    for line in (a, b, a - b, np.cross(a, b, axis=0), across):
        size = np.sqrt((line * line).sum(axis=0))
        unit = np.divide(line, size, out=np.zeros_like(line), where=size > 0)
        reach = 0.0
        for axis, bore in ((a, first), (b, second)):
            along = np.abs((axis * unit).sum(axis=0))
            reach = reach + halves[:, bore] * along + radii[:, bore] * np.sqrt(np.maximum(1 - along * along, 0.0))
        gap = np.maximum(gap, np.where(size > 0, np.abs((between * unit).sum(axis=0)) - reach, -np.inf))
    return np.asarray(np.minimum(found, gap.min(axis=1)))


def drilling_faults(batch: SolidArray) -> Iterator[tuple[int, str, str]]:
    """Solids whose bores are too near an edge or each other: row in the batch, what is wrong, and a cure."""
    measures = Measures(batch.topology, batch.vertices)
    if not len(_bores(measures)):
        return
    for values, least, words in (
        (edge_ratios(measures), LEAST_EDGE_RATIO, "an edge within {:.3g} of its diameter, least {:g}"),
        (pitch_ratios(measures), LEAST_PITCH_RATIO, "another bore within {:.3g} of their diameter, least {:g}"),
        (walls(measures), LEAST_WALL_MM, "another bore behind a wall of {:.3g} mm, least {:g}"),
    ):
        for row in np.flatnonzero(values < least - ROUNDING).tolist():
            cure = "take smaller bolts or bores, or leave the beam out with --skip-unbuildable"
            yield row, f"has a bore with {words.format(values[row], least)}", cure
