"""Nodes that look alike when they are turned about their axis, or mounted upside down."""

from __future__ import annotations

import numpy as np

from fabkit.parts import BORE, Ragged, Topology
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["OUTER_END", "dot_vertices", "look_alikes"]

LOOK_ALIKE_DEG = 2.0
"""Difference of directions in degrees up to which a turned node looks like the one that is not turned: over the 60 mm
of a facet 2 mm, less than an erector sees."""

HARMLESS_TURN_DEG = 1e-3
"""Difference of directions in degrees up to which a turned node is as good as the one that is not turned: the far end
of a beam of 3 m is then off by 0.05 mm."""

HARMLESS_SETBACK_MM = 0.01
"""Difference of setbacks in mm up to which a turned node is as good as the one that is not turned, a tenth of what a
saw keeps."""


OUTER_END = 1
"""Number of the outer end among the faces of blocks and caps."""


def dot_vertices(topology: Topology) -> IntArray:
    """(k,) the vertices of the dot in the outer end of a node, which is no part of what its mark is recognised by.

    >>> from fabkit.kinds.look_alikes import dot_vertices
    >>> from fabkit.parts import prism_topology
    >>> dot_vertices(prism_topology(4).bored([(0, 1), (1, None)])).tolist()
    [12, 13, 14, 15]
    """
    rounds = topology.rounds
    is_dot = (rounds[:, 4] == OUTER_END) & (rounds[:, 5] > OUTER_END) & (rounds[:, 6] == BORE)
    return np.asarray(rounds[is_dot, :4].ravel())


def look_alikes(azimuths_deg: Ragged, inclinations_deg: Ragged, setbacks_mm: Ragged) -> tuple[BoolArray, BoolArray]:
    """Which nodes could be mounted wrongly: (n,) turned about their axes, and (n,) upside down. The directions of their
    beams about the axis then look as if the node was in place, but its beams would not fit.

    azimuths_deg, inclinations_deg, setbacks_mm: of the beams around each node, see `NodeDetails`. A node that fits as
    well when it is turned is none of them.

    >>> from fabkit.parts import Ragged
    >>> from fabkit.kinds.look_alikes import look_alikes
    >>> azimuths = Ragged.of([[0, 90, 180, 270], [0, 91, 180, 270], [0, 80, 120, 230]])
    >>> level, equal = azimuths.with_values(np.zeros(12)), azimuths.with_values(np.full(12, 50.0))
    >>> turned, upside_down = look_alikes(azimuths, level, equal)
    >>> turned.tolist(), upside_down.tolist()
    ([False, True, False], [False, True, False])
    """
    found = np.zeros((2, len(azimuths_deg)), dtype=bool)
    for size in np.unique(azimuths_deg.sizes[azimuths_deg.sizes > 0]).tolist():
        nodes = np.flatnonzero(azimuths_deg.sizes == size)
        own = [each[nodes].values.reshape(-1, size) for each in (azimuths_deg, inclinations_deg, setbacks_mm)]
        azimuths, inclinations, setbacks = own
        mirrored = [-azimuths[:, ::-1], -inclinations[:, ::-1], setbacks[:, ::-1]]
        for shift in range(size):
            if shift > 0:
                found[0, nodes] |= _is_wrong(own, own, shift)
            found[1, nodes] |= _is_wrong(own, mirrored, shift)
    return found[0], found[1]


def _is_wrong(own: list[FloatArray], others: list[FloatArray], shift: int) -> BoolArray:
    """(m,) whether the beams (m, k) of nodes look like the others, beginning at the one at this place, and are not."""
    azimuths, inclinations, setbacks = (
        np.roll(other, -shift, axis=1) - each for each, other in zip(own, others, strict=True)
    )
    off = np.ptp(np.mod(azimuths - azimuths[:, :1] + 180.0, 360.0), axis=1) / 2
    fits = (np.maximum(2 * off, np.abs(inclinations).max(axis=1)) <= HARMLESS_TURN_DEG) & (
        np.abs(setbacks).max(axis=1) <= HARMLESS_SETBACK_MM
    )
    return np.asarray((off <= LOOK_ALIKE_DEG) & ~fits)
