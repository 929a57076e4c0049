"""From where else a part may be seen, so that it is the same piece: a bar from its other end, a block from another of
its beams, a plate from another of its edges.

A part has a *ring* of places; what is known of each place runs around it. In turn t the part is seen with place t in
front: it is moved in the xy-plane of its own frame, its corners change places, and the ring begins at t.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from geometry.arrays import FloatArray, IntArray

__all__ = ["Corners", "Symmetry", "Turns", "moved", "other_end", "shifted"]

Corners = Callable[[IntArray, IntArray, IntArray], IntArray]
"""(parts (q,), turns (q,), corners (c,)) -> (q, c): which corner of each part takes each one's place in that turn."""


@dataclass(frozen=True, eq=False)
class Turns:
    """n parts with t turns each, the first of which is how they stand.

    starts (n, t, 2): where the turned frame stands, in mm; along (n, t, 2): unit direction in which its x-axis looks.

    >>> from fabkit.parts import Turns, shifted
    >>> quarter = Turns(np.zeros((1, 2, 2)), np.array([[[1.0, 0], [0, 1]]]), shifted(np.array([[0, 1]]), 4))
    >>> quarter.corners(np.array([0]), np.array([1]), np.arange(4)).tolist()
    [[1, 2, 3, 0]]
    """

    starts: FloatArray
    along: FloatArray
    corners: Corners


P = TypeVar("P")


@dataclass(frozen=True)
class Symmetry(Generic[P]):
    """The turns of a kind of part, of which P are some.

    ring_fields: names of the details with a value for each place of the ring, rows of a Ragged or of an array (n,
    places). azimuth_fields: those among them that are angles in degrees from the x-axis. turns: of parts of one
    topology with equally many places, and of their corners (n, c, 3) in their own frames.

    >>> from fabkit.kinds import NODE
    >>> NODE.symmetry.ring_fields, NODE.symmetry.azimuth_fields
    (('beams', 'azimuths_deg', 'inclinations_deg', 'setbacks_mm'), ('azimuths_deg',))
    """

    ring_fields: tuple[str, ...]
    azimuth_fields: tuple[str, ...]
    turns: Callable[[P, FloatArray], Turns]


def other_end(n_corners: int) -> Corners:
    """Half a turn of a bar, of any section: its corners are listed so that this reverses their order.

    >>> from fabkit.parts import other_end
    >>> corners = other_end(8)
    >>> corners(np.array([0]), np.array([1]), np.arange(8)).tolist()
    [[7, 6, 5, 4, 3, 2, 1, 0]]
    """

    def corners(parts: IntArray, turns: IntArray, chosen: IntArray) -> IntArray:
        return np.where(turns[:, None] == 0, chosen, n_corners - 1 - chosen)

    return corners


def shifted(first: IntArray, n: int) -> Corners:
    """Prisms over polygons with n corners, the lower ones first: corner number first (parts, turns) comes in front.

    >>> from fabkit.parts import shifted
    >>> corners = shifted(np.array([[0, 1, 2]]), 3)
    >>> corners(np.array([0]), np.array([1]), np.arange(6)).tolist()
    [[1, 2, 0, 4, 5, 3]]
    """

    def corners(parts: IntArray, turns: IntArray, chosen: IntArray) -> IntArray:
        result: IntArray = (first[parts, turns][:, None] + chosen) % n + chosen // n * n
        return result

    return corners


def moved(points: FloatArray, starts: FloatArray, along: FloatArray) -> FloatArray:
    """Points (q, c, 3) seen from the frames at starts (q, 2) with x-axes along (q, 2).

    >>> from fabkit.parts import moved
    >>> moved(np.array([[[5.0, 2, 1]]]), np.array([[3.0, 0]]), np.array([[0.0, 1]])).tolist()
    [[[2.0, -2.0, 1.0]]]
    """
    flat = points[..., :2] - starts[:, None]
    ahead, aside = along[:, :1], along[:, 1:]
    turned = [flat[..., 0] * ahead + flat[..., 1] * aside, flat[..., 1] * ahead - flat[..., 0] * aside, points[..., 2]]
    return np.stack(turned, axis=2)
