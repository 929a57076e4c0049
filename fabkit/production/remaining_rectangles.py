"""Rectangles that are still to be laid, of which the one that fits a section best is found without a look at all."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from geometry.arrays import FloatArray

__all__ = ["RemainingRectangles"]


class _Sorted:
    """Rectangles by one of their measures, with the least other measure of any run of them: a tree in a list."""

    def __init__(self, measure: FloatArray, other: FloatArray) -> None:
        order = np.lexsort((-np.arange(len(measure)), measure))  # of equal ones the first is the last
        self._rectangles: list[int] = order.tolist()
        self._measures: list[float] = measure[order].tolist()
        self._places: list[int] = np.argsort(order).tolist()
        self._others: list[float] = other.tolist()
        self._half = 1 << len(order).bit_length()  # more places than rectangles
        levels = [np.full(self._half, np.inf)]
        levels[0][: len(order)] = other[order]
        while len(levels[-1]) > 1:
            levels.append(levels[-1].reshape(-1, 2).min(axis=1))
        self._least: list[float] = [np.inf, *np.concatenate(levels[::-1]).tolist()]

    def largest(self, at_most: float, others_at_most: float) -> int:
        """The rectangle left with the largest measure up to a bound, and the other measure up to one; -1 if none."""
        least, half = self._least, self._half
        node = bisect_right(self._measures, at_most) + half
        while node > 1:
            if node & 1 and least[node - 1] <= others_at_most:
                node -= 1
                while node < half:
                    node += node + 1
                    if least[node] > others_at_most:
                        node -= 1
                return self._rectangles[node - half]
            node >>= 1
        return -1

    def set(self, rectangle: int, left: bool) -> None:
        least, node = self._least, self._half + self._places[rectangle]
        value = self._others[rectangle] if left else np.inf
        while node and least[node] != value:
            least[node] = value
            value = min(value, least[node ^ 1])
            node >>= 1


class RemainingRectangles:
    """Rectangles sizes (m, 2), the longer side first, each left or taken."""

    def __init__(self, sizes: FloatArray, rounding: float) -> None:
        """rounding: what may be missing where a rectangle fits exactly."""
        self.left = [True] * len(sizes)
        self._longs, self._shorts = sizes[:, 0].tolist(), sizes[:, 1].tolist()
        self._by_long, self._by_short = _Sorted(sizes[:, 0], sizes[:, 1]), _Sorted(sizes[:, 1], sizes[:, 0])
        self._rounding = rounding

    def take(self, rectangle: int) -> None:
        self._set(rectangle, False)

    def put_back(self, rectangle: int) -> None:
        self._set(rectangle, True)

    def _set(self, rectangle: int, left: bool) -> None:
        self.left[rectangle] = left
        self._by_long.set(rectangle, left)
        self._by_short.set(rectangle, left)

    def extents(self, choice: int) -> tuple[float, float]:
        """Along x and y; m is added to the number where it is turned."""
        turned, k = divmod(choice, len(self.left))
        return (self._shorts[k], self._longs[k]) if turned else (self._longs[k], self._shorts[k])

    def best(self, length: float, width: float, ways: tuple[bool, bool]) -> tuple[float, int]:
        """The narrowest strip that a rectangle leaves beside it in a section, and which one it is, m added where it is
        turned; inf where none fits. ways: whether rectangles may lie along the section and stand across it.

        The narrowest strip is left by the largest of those that fit, by one of their measures. A tie goes to the first.
        """
        strip, choice = np.inf, -1
        for turned, along, across in ((0, length, width), (len(self.left), width, length)):
            if not ways[turned > 0]:
                continue
            along_most, across_most = along + self._rounding, across + self._rounding
            by_long = self._by_long.largest(along_most, across_most)
            if by_long < 0:
                continue
            for k in (by_long, self._by_short.largest(across_most, along_most)):
                found = min(along - self._longs[k], across - self._shorts[k])
                if found < strip or (found == strip and k + turned < choice):
                    strip, choice = found, k + turned
        return strip, choice
