"""Rectangles that are still to be placed; the one that fits a section best is found in logarithmic time."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from geometry.arrays import FloatArray

__all__ = ["RemainingRectangles"]


class _Sorted:
    """Rectangles sorted by one of their two sides, with a binary tree, stored as a list, of the minima of the other
    side over the free ones."""

    def __init__(self, measure: FloatArray, other: FloatArray) -> None:
        order = np.lexsort((-np.arange(len(measure)), measure))  # of equal ones, the first comes last
        self._rectangles: list[int] = order.tolist()
        self._measures: list[float] = measure[order].tolist()
        self._places: list[int] = np.argsort(order).tolist()
        self._others: list[float] = other.tolist()
        self._half = 1 << len(order).bit_length()  # more places than rectangles
        levels = [np.full(self._half, np.inf)]
        levels[0][: len(order)] = other[order]
        while len(levels[-1]) > 1:
            levels.append(levels[-1].reshape(-1, 2).min(axis=1))
        self._minimum: list[float] = [np.inf, *np.concatenate(levels[::-1]).tolist()]

    def largest(self, at_most: float, others_at_most: float) -> int:
        """The free rectangle with the largest side up to `at_most` whose other side is at most `others_at_most`; -1 if
        there is none."""
        minimum, half = self._minimum, self._half
        node = bisect_right(self._measures, at_most) + half
        while node > 1:
            if node & 1 and minimum[node - 1] <= others_at_most:
                node -= 1
                while node < half:
                    node += node + 1
                    if minimum[node] > others_at_most:
                        node -= 1
                return self._rectangles[node - half]
            node >>= 1
        return -1

    def set(self, rectangle: int, is_free: bool) -> None:
        minimum, node = self._minimum, self._half + self._places[rectangle]
        value = self._others[rectangle] if is_free else np.inf
        while node and minimum[node] != value:
            minimum[node] = value
            sibling = minimum[node ^ 1]
            value = sibling if sibling < value else value
            node >>= 1


class RemainingRectangles:
    """Rectangles with sizes (m, 2) in mm, the longer side first, each free or taken."""

    def __init__(self, sizes: FloatArray, rounding: float) -> None:
        """rounding: by how much in mm a rectangle may exceed a section and still fit."""
        self.is_free = [True] * len(sizes)
        self._longs, self._shorts = sizes[:, 0].tolist(), sizes[:, 1].tolist()
        self._by_long, self._by_short = _Sorted(sizes[:, 0], sizes[:, 1]), _Sorted(sizes[:, 1], sizes[:, 0])
        self._rounding, self._least = rounding, float(sizes.min(initial=np.inf)) - rounding

    def take(self, rectangle: int) -> None:
        self._set(rectangle, False)

    def put_back(self, rectangle: int) -> None:
        self._set(rectangle, True)

    def _set(self, rectangle: int, is_free: bool) -> None:
        self.is_free[rectangle] = is_free
        self._by_long.set(rectangle, is_free)
        self._by_short.set(rectangle, is_free)

    def extents(self, choice: int) -> tuple[float, float]:
        """Extents along x and y. choice: number of the rectangle, plus m if its long side runs along y."""
        turned, k = divmod(choice, len(self.is_free))
        return (self._shorts[k], self._longs[k]) if turned else (self._longs[k], self._shorts[k])

    def best(self, length: float, width: float, orientations: tuple[bool, bool]) -> tuple[float, int]:
        """Width of the narrowest strip that a free rectangle leaves beside it in a section, and the number of that
        rectangle, plus m if its long side runs along y; inf and -1 where none fits.

        orientations: whether the long sides of rectangles may run along x, and along y. The narrowest strip is left by
        the rectangle with the largest long side, or the largest short side, of those that fit. The first of equally
        good ones is taken.
        """
        strip, choice = np.inf, -1
        if length < self._least or width < self._least:  # as most sections are in the end
            return strip, choice
        for turned, along, across in ((0, length, width), (len(self.is_free), width, length)):
            if not orientations[turned > 0]:
                continue
            max_along, max_across = along + self._rounding, across + self._rounding
            by_long = self._by_long.largest(max_along, max_across)
            if by_long < 0:
                continue
            for k in (by_long, self._by_short.largest(max_across, max_along)):
                beside, above = along - self._longs[k], across - self._shorts[k]
                found = beside if beside < above else above
                if found < strip or (found == strip and k + turned < choice):
                    strip, choice = found, k + turned
        return strip, choice
