"""Symmetries: frames from which a part is the same piece. A bar may be turned end for end, a block may begin with any
of its beams, a plate with any of its edges.

A part has a *ring* of places (the ends of a beam, the beams of a node, the edges of a panel), and some of its data have
a value for each place. In turn t the part is described from place t: its frame is moved in the xy-plane, its corners
are renumbered, and the ring begins at t.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from geometry.arrays import FloatArray, IntArray

__all__ = ["Corners", "Symmetry", "Turns", "moved", "other_end", "shifted"]

Corners = Callable[[IntArray, IntArray, IntArray], IntArray]
"""(parts (q,), turns (q,), corners (c,)) -> (q, c): number of the corner that replaces each of these corners in the
turn of each part."""


@dataclass(frozen=True, eq=False)
class Turns:
    """The t turns of each of n parts; turn 0 leaves the part as it is.

    starts (n, t, 2): origins of the turned frames, in mm; along (n, t, 2): unit directions of their x axes; both in the
    parts' own frames. over_mm (n, t): where the part is turned over, the level at which the origin then lies, with the
    z axis downwards; NaN where it is not; None where no turn does that.

    >>> from fabkit.parts import Turns, shifted
    >>> quarter = Turns(np.zeros((1, 2, 2)), np.array([[[1.0, 0], [0, 1]]]), shifted(np.array([[0, 1]]), 4))
    >>> quarter.corners(np.array([0]), np.array([1]), np.arange(4)).tolist()
    [[1, 2, 3, 0]]
    """

    starts: FloatArray
    along: FloatArray
    corners: Corners
    over_mm: FloatArray | None = None

    def over(self, parts: IntArray, turns: IntArray) -> FloatArray:
        """(q,) over_mm of these parts (q,) in these turns (q,)."""
        return np.full(len(parts), np.nan) if self.over_mm is None else self.over_mm[parts, turns]


P = TypeVar("P")


@dataclass(frozen=True)
class Symmetry(Generic[P]):
    """The turns of a kind of part; P is the type of its parts.

    ring_fields: names of the details with a value for each place of the ring, as rows of a Ragged or of an array (n,
    places). azimuth_fields: those of them that are angles in degrees from the x axis. turns: a function of parts with
    one topology and equally many places, and of their corners (n, c, 3) in their own frames, that returns their turns.
    turned_over: a function of the parts, these turns and corners that returns the turns with as many more, in which the
    part is turned over and place t is in front, those before it following, or as they are where the parts have an outer
    side; None where all of the kind have one. corner_fields: names of the ring fields whose values belong to the
    beginnings of places.

    >>> from fabkit.kinds import NODE
    >>> NODE.symmetry.ring_fields, NODE.symmetry.azimuth_fields
    (('beams', 'azimuths_deg', 'inclinations_deg', 'setbacks_mm', 'uncovered_percent'), ('azimuths_deg',))
    """

    ring_fields: tuple[str, ...]
    azimuth_fields: tuple[str, ...]
    turns: Callable[[P, FloatArray], Turns]
    turned_over: Callable[[P, Turns, FloatArray], Turns] | None = None
    corner_fields: tuple[str, ...] = ()


def other_end(n_corners: int) -> Corners:
    """The renumbering of the corners of a bar that is turned end for end: it reverses the order of its corners.

    >>> from fabkit.parts import other_end
    >>> corners = other_end(8)
    >>> corners(np.array([0]), np.array([1]), np.arange(8)).tolist()
    [[7, 6, 5, 4, 3, 2, 1, 0]]
    """

    def corners(parts: IntArray, turns: IntArray, chosen: IntArray) -> IntArray:
        return np.where(turns[:, None] == 0, chosen, n_corners - 1 - chosen)

    return corners


def shifted(first: IntArray, n: int) -> Corners:
    """The renumbering of the corners of prisms over polygons with n corners, the lower ones first: in each turn, corner
    `first` (parts, turns) becomes corner 0.

    >>> from fabkit.parts import shifted
    >>> corners = shifted(np.array([[0, 1, 2]]), 3)
    >>> corners(np.array([0]), np.array([1]), np.arange(6)).tolist()
    [[1, 2, 0, 4, 5, 3]]
    """

    def corners(parts: IntArray, turns: IntArray, chosen: IntArray) -> IntArray:
        result: IntArray = (first[parts, turns][:, None] + chosen) % n + chosen // n * n
        return result

    return corners


def moved(points: FloatArray, starts: FloatArray, along: FloatArray, over_mm: FloatArray | None = None) -> FloatArray:
    """Points (q, c, 3) in the frames with origins at starts (q, 2) and x axes along (q, 2), turned over at the levels
    over_mm (q,) where these are not NaN.

    >>> from fabkit.parts import moved
    >>> moved(np.array([[[5.0, 2, 1]]]), np.array([[3.0, 0]]), np.array([[0.0, 1]])).tolist()
    [[[2.0, -2.0, 1.0]]]
    """
    flat = points[..., :2] - starts[:, None]
    x, y = along[:, :1], along[:, 1:]
    turned = [flat[..., 0] * x + flat[..., 1] * y, flat[..., 1] * x - flat[..., 0] * y, points[..., 2]]
    if over_mm is not None:
        over = ~np.isnan(over_mm)
        turned[1][over] *= -1
        turned[2] = np.where(over[:, None], over_mm[:, None] - turned[2], turned[2])
    return np.stack(turned, axis=2)
