"""A curve through given points, on which vertices of boundaries and feature lines slide."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import GeometryError
from geometry.surface.surface import check_points

__all__ = ["CORNER_ANGLE", "Curve"]

CORNER_ANGLE = np.radians(50.0)
"""Turn of the polyline at a point above which the curve has a corner there; a circle through 8 points turns by 45."""

SAMPLES_PER_SPAN = 16
"""Number of samples for each span, so that the distance from a point has only one minimum between two of them."""

NEAREST_SAMPLES = 4
"""Number of nearest samples that are tried: where parts of the curve are nearly equally far, the nearest sample may be
on the wrong one."""

TIED_DISTANCE_ROUNDING = 1e-12
"""Relative difference of distances that may be rounding."""

MAX_FOOT_STEPS = 60
"""Largest number of steps of Newton's method, safeguarded by bisection; 5 mostly suffice, and bisection alone would
reach full precision."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Cubic spans, one after the other, smooth except at the corners.

    spans (S, 4, 3): coefficients of t^3, t^2, t, 1 for t from 0 to 1; span s begins at point s. corners: indices of the
    points where the curve turns sharply.

    >>> import numpy as np
    >>> from geometry.surface import Curve
    >>> angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    >>> circle = Curve.through(np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1), closed=True)
    >>> circle
    Curve(spans (24, 4, 3), closed=True, corners (0,))
    """

    __repr__ = short_repr

    spans: FloatArray
    closed: bool
    corners: IntArray

    @classmethod
    def through(cls, points: FloatArray, *, closed: bool, corner_angle: float = CORNER_ANGLE) -> Curve:
        """The cubic spline, by chord length, through points (k, 3) in order; if `closed`, it returns to the first one.

        Where the polyline of the points turns by more than `corner_angle` (radians) the curve has a corner. Two
        points give a straight segment. Raises GeometryError for fewer than 2 points (closed: 3), for points that are
        not finite, and where two points in a row are the same.
        """
        points = _checked(points, closed)
        chords = np.diff(points, axis=0, append=points[:1])[: len(points) - (not closed)]
        lengths = np.linalg.norm(chords, axis=1)
        directions = chords / lengths[:, None]
        turns = np.linalg.norm(directions - np.roll(directions, 1, axis=0), axis=1) > 2 * np.sin(corner_angle / 2)
        corners = np.flatnonzero(turns[: len(points)] if closed else np.append(turns, False))
        corners = corners if closed else corners[(corners > 0) & (corners < len(points) - 1)]
        return cls(_splines(points, lengths, corners, closed), closed, integers(corners))

    def closest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Feet (n, 3) of points (n, 3), which are the nearest points of the curve, and unit tangents (n, 3) there.

        Tangents have the direction of the curve; at a corner, it is the tangent that is more nearly perpendicular to
        the vector to the point.
        Raises GeometryError for points that are not finite.
        """
        points = check_points(points)
        nearest = np.asarray(self._tree.query(points, k=NEAREST_SAMPLES)[1], dtype=np.int64).reshape(
            -1, NEAREST_SAMPLES
        )
        intervals, n_intervals = np.concatenate([nearest - 1, nearest], axis=1), SAMPLES_PER_SPAN * len(self.spans)
        intervals = intervals % n_intervals if self.closed else intervals.clip(0, n_intervals - 1)
        feet, tangents = self._feet(np.repeat(points, 2 * NEAREST_SAMPLES, axis=0), intervals.ravel())
        feet, tangents = (part.reshape(len(points), 2 * NEAREST_SAMPLES, 3) for part in (feet, tangents))
        offsets = points[:, None] - feet
        distances = np.linalg.norm(offsets, axis=2)
        ties = distances <= distances.min(axis=1, keepdims=True) * (1 + TIED_DISTANCE_ROUNDING)
        along = np.abs(np.einsum("nki,nki->nk", offsets, tangents))
        best = np.where(ties, along, np.inf).argmin(axis=1)
        rows = np.arange(len(points))
        return feet[rows, best], tangents[rows, best]

    def _feet(self, points: FloatArray, intervals: IntArray) -> tuple[FloatArray, FloatArray]:
        """Feet (n, 3) of points (n, 3), each on one interval (n,) between samples, and unit tangents (n, 3)."""
        spans, places = np.divmod(intervals, SAMPLES_PER_SPAN)
        low, high = places / SAMPLES_PER_SPAN, (places + 1) / SAMPLES_PER_SPAN
        coefficients = self.spans[spans]
        low = np.where(_slopes(coefficients, high, points)[0] >= 0, high, low)  # the nearest point is an end
        high = np.where(_slopes(coefficients, low, points)[0] <= 0, low, high)
        t, inside = low, np.flatnonzero(low < high)
        t[inside] = _roots(coefficients[inside], low[inside], high[inside], points[inside])
        feet, derivatives, _ = _evaluate(coefficients, t)
        return feet, derivatives / np.linalg.norm(derivatives, axis=1, keepdims=True)

    @cached_property
    def _tree(self) -> KDTree:
        """The tree of the samples; interval j begins at sample j."""
        t = np.arange(SAMPLES_PER_SPAN) / SAMPLES_PER_SPAN
        powers = np.stack([t**3, t**2, t, np.ones(SAMPLES_PER_SPAN)], axis=1)
        samples = np.einsum("tp,spi->sti", powers, self.spans).reshape(-1, 3)
        return KDTree(samples if self.closed else np.concatenate([samples, self.spans[-1:].sum(axis=1)]))


def _evaluate(coefficients: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """c(t), c'(t) and c''(t), (n, 3) each, of cubics (n, 4, 3) at t (n,)."""
    a, b, c, d = coefficients.swapaxes(0, 1)
    s = t[:, None]
    return ((a * s + b) * s + c) * s + d, (3 * a * s + 2 * b) * s + c, 6 * a * s + 2 * b


def _slopes(coefficients: FloatArray, t: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(p - c(t)) . c'(t), positive where the curve comes nearer, and its derivative by t."""
    here, first, second = _evaluate(coefficients, t)
    offsets = points - here
    change = np.einsum("ni,ni->n", offsets, second) - np.einsum("ni,ni->n", first, first)
    return np.einsum("ni,ni->n", offsets, first), change


def _roots(coefficients: FloatArray, low: FloatArray, high: FloatArray, points: FloatArray) -> FloatArray:
    """Where `_slopes` is zero, between parameters (n,) where it is positive and negative."""
    t = (low + high) / 2
    for _ in range(MAX_FOOT_STEPS):
        slopes, change = _slopes(coefficients, t, points)
        low, high = np.where(slopes > 0, t, low), np.where(slopes < 0, t, high)
        newton = t - np.divide(slopes, change, out=np.zeros_like(t), where=change < 0)
        inside = (newton > low) & (newton < high) & (change < 0)
        following = np.where(slopes == 0, t, np.where(inside, newton, (low + high) / 2))
        step, t = np.abs(following - t).max(initial=0.0), following
        if step <= np.finfo(float).eps:
            break
    return t


def _splines(points: FloatArray, lengths: FloatArray, corners: IntArray, closed: bool) -> FloatArray:
    """(S, 4, 3) spans through all the points, from corner to corner."""
    from scipy.interpolate import CubicSpline  # takes long to import

    k = len(points)
    if closed:
        smooth = len(corners) == 0
        breaks = np.array([0, k]) if smooth else np.append(corners, corners[0] + k)
    else:
        smooth = False
        breaks = np.unique(np.concatenate([[0], corners, [k - 1]]))
    spans = np.empty((len(lengths), 4, 3))
    for begin, end in zip(breaks[:-1].tolist(), breaks[1:].tolist(), strict=True):
        here = np.arange(begin, end)
        steps = lengths[here % len(lengths)]
        through = points[np.append(here, end) % k]
        spline = CubicSpline(np.append(0.0, np.cumsum(steps)), through, bc_type="periodic" if smooth else "not-a-knot")
        powers = steps[:, None] ** np.arange(3, -1, -1)  # from the parameter of the spline to t
        spans[here % len(lengths)] = spline.c.swapaxes(0, 1) * powers[:, :, None]
    return floats(spans)


def _checked(points: FloatArray, closed: bool) -> FloatArray:
    points = check_points(points)
    least = 3 if closed else 2
    if len(points) < least:
        raise GeometryError(
            f"{'a closed' if closed else 'an open'} curve needs at least {least} points, not {len(points)}",
            value=len(points),
            bound=least,
        )
    following = np.roll(points, -1, axis=0) if closed else points[1:]
    same = np.flatnonzero((following == points[: len(following)]).all(axis=1))
    if len(same):
        first, second = int(same[0]), (int(same[0]) + 1) % len(points)
        raise GeometryError(
            f"points {first} and {second} of the curve are the same, {points[first].tolist()}: leave one out",
            elements=[first, second],
            value=0.0,
        )
    return points
