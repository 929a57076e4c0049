"""Numbers in text, line by line, for the OBJ, OFF and PLY readers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import MeshFileError, listed, printable

__all__ = ["NumberRows", "likewise", "parse_numbers", "whole", "word_lines"]

MAX_COUNT_DIGITS = 15
"""Largest number of digits of a number of vertices or faces in a header."""

LARGEST_WHOLE_NUMBER = 2.0**53
"""Largest number in a file that may be an index; up to it a double represents every whole number."""


@dataclass(frozen=True, eq=False)
class NumberRows:
    """All numbers of some lines of text in one array.

    values (n,); starts (rows + 1,): row r has values[starts[r] : starts[r + 1]]; lines (rows,): number of its line.
    """

    values: FloatArray
    starts: IntArray
    lines: IntArray

    @classmethod
    def from_words(cls, rows: Sequence[tuple[int, list[str]]]) -> NumberRows:
        """From line numbers and the words of each line. Raises MeshFileError where a word is not a number."""
        lines = integers([line for line, _ in rows])
        widths = np.array([len(words) for _, words in rows], dtype=np.int64)
        values = parse_numbers(chain.from_iterable(words for _, words in rows), np.repeat(lines, widths))
        return cls(values, integers(np.concatenate([[0], np.cumsum(widths)])), lines)

    @property
    def n_rows(self) -> int:
        return len(self.lines)

    @property
    def widths(self) -> IntArray:
        """(rows,) how many numbers each line holds."""
        return np.diff(self.starts)

    @property
    def value_lines(self) -> IntArray:
        """(n,) the line of each value."""
        return np.repeat(self.lines, self.widths)


def word_lines(text: str, *, first_line: int = 1) -> list[tuple[int, list[str]]]:
    """The number and the words of each line that has any; # begins a comment."""
    split = ((number, line.partition("#")[0].split()) for number, line in enumerate(text.split("\n"), first_line))
    return [(number, words) for number, words in split if words]


def parse_numbers(words: Iterable[str], lines: IntArray) -> FloatArray:
    """(n,) the values of words; lines (n,): their line numbers, for messages. Raises MeshFileError where a word is not
    a number."""
    words = list(words)
    try:
        numbers = np.array(words, dtype=np.float64)
    except ValueError:
        numbers = None
    if numbers is None or any("_" in word for word in words):
        wrong = [place for place, word in enumerate(words) if not _is_number(word)]
        first = wrong[0]
        raise MeshFileError(
            f"line {lines[first]}: '{printable(words[first])}' is not a number; correct it{likewise(lines[wrong])}",
            elements=np.unique(lines[wrong]).tolist(),
        )
    return numbers


def whole(values: FloatArray, lines: IntArray, what: str, place: str = "line") -> IntArray:
    """Numbers (n,) as integers; lines (n,): their line numbers, or numbers of other things that `place` names, for
    messages. Raises MeshFileError where one is not whole."""
    indices = np.where(np.abs(values) < LARGEST_WHOLE_NUMBER, values, 0.0).astype(np.int64)
    wrong = np.flatnonzero(indices != values)
    if len(wrong):
        line, value = int(lines[wrong[0]]), float(values[wrong[0]])
        raise MeshFileError(
            f"{place} {line}: {what} is {value:g}, a whole number is needed{likewise(lines[wrong], place)}",
            elements=np.unique(lines[wrong]).tolist(),
            value=value,
        )
    return indices


def likewise(lines: IntArray, place: str = "line") -> str:
    """The end of a message about the first of lines (n,), which names the others; empty if there are none."""
    others = np.setdiff1d(lines, lines[:1])
    return f"; likewise {place}{'s' * (len(others) != 1)} {listed(others, len(others))}" if len(others) else ""


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word  # Python ignores underscores in numbers
