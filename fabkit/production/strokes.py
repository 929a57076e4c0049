"""A single-stroke alphabet for marking: cutting machines follow curves and know no fonts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabkit.errors import OutputError
from fabkit.parts import Curves
from geometry.arrays import FloatArray, IntArray, floats, integers

__all__ = ["ARROW", "text_strokes", "text_widths"]

ARROW = ">"
"""Character that is drawn as an arrow to the right."""

GLYPHS = {
    "0": "10,01,05,16,36 36,45,41,30,10 12,34",
    "1": "05,26,20 00,40",
    "2": "05,16,36,45,44,00,40",
    "3": "05,16,36,45,44,33,13 33,42,41,30,10,01",
    "4": "30,36,02,42",
    "5": "46,06,03,33,42,41,30,10,01",
    "6": "45,36,16,05,01,10,30,41,42,33,03",
    "7": "06,46,10",
    "8": "13,04,05,16,36,45,44,33,13,02,01,10,30,41,42,33",
    "9": "43,13,04,05,16,36,45,41,30,10,01",
    "A": "00,26,40 13,33",
    "B": "03,33,44,45,36,06,00,30,41,42,33",
    "C": "45,36,16,05,01,10,30,41",
    "D": "00,06,26 26,44,42,20,00",
    "E": "46,06,00,40 03,33",
    "F": "46,06,00 03,33",
    "G": "45,36,16,05,01,10,30,41,43,23",
    "H": "00,06 40,46 03,43",
    "I": "20,26 10,30 16,36",
    "J": "46,41,30,10,01",
    "K": "00,06 46,03,40",
    "L": "06,00,40",
    "M": "00,06,23,46,40",
    "N": "00,06,40,46",
    "O": "10,01,05,16,36 36,45,41,30,10",
    "P": "00,06,36,45,44,33,03",
    "Q": "10,01,05,16,36 36,45,41,30,10 22,40",
    "R": "00,06,36,45,44,33,03 23,40",
    "S": "45,36,16,05,04,13,33,42,41,30,10,01",
    "T": "06,46 20,26",
    "U": "06,01,10,30,41,46",
    "V": "06,20,46",
    "W": "06,10,23,30,46",
    "X": "00,46 06,40",
    "Y": "06,23,46 23,20",
    "Z": "06,46,00,40",
    "-": "13,33",
    ARROW: "03,93 75,93,71",
}
"""Strokes of each character on a grid 4 wide (the arrow: 9) and 6 high: "00,26,40" runs from (0, 0) through (2, 6) to
(4, 0). All strokes are open, since machines take closed curves for contours."""

GLYPH_HEIGHT, GLYPH_SPACE = 6, 2
"""Height of the grid of characters, and space between two of them, in grid units."""


_STROKES = Curves.of(
    [
        floats([[int(point[0]), int(point[1])] for point in stroke.split(",")])
        for strokes in GLYPHS.values()
        for stroke in strokes.split()
    ]
)
"""Strokes of all glyphs, one after the other, in grid units."""
_FIRST_STROKE = np.cumsum([0, *(len(strokes.split()) for strokes in GLYPHS.values())])
"""Index of the first stroke of each glyph in `_STROKES`, and their number at the end."""
_ADVANCE = np.array([(9 if character == ARROW else 4) + GLYPH_SPACE for character in GLYPHS])
"""Width of each glyph with the space after it, in grid units."""
_GLYPH = {character: number for number, character in enumerate(GLYPHS)}
"""Number of each character's glyph."""


def text_widths(texts: Sequence[str]) -> FloatArray:
    """(m,) widths of texts over their height."""
    glyph, starts = _glyphs(texts)
    ends = np.concatenate([[0], np.cumsum(_ADVANCE[glyph])])[starts]
    widths: FloatArray = (np.diff(ends) - GLYPH_SPACE) / GLYPH_HEIGHT
    return widths


def text_strokes(texts: Sequence[str]) -> tuple[Curves, IntArray]:
    """Open polylines of texts of height 1, and (k,) the text of each polyline. The lower left corner of each text is
    the origin, and its line runs along x.

    Raises OutputError for a character that is not a capital letter, a digit, a hyphen or ARROW.
    """
    glyph, starts = _glyphs(texts)
    text = np.repeat(np.arange(len(texts)), np.diff(starts))
    x = np.concatenate([[0], np.cumsum(_ADVANCE[glyph])])
    x = x[:-1] - x[starts][text]
    counts = np.diff(_FIRST_STROKE)[glyph]
    character = np.repeat(np.arange(len(glyph)), counts)
    firsts = np.cumsum(counts) - counts
    curves = _STROKES[np.arange(len(character)) + (_FIRST_STROKE[glyph] - firsts)[character]]
    right = np.stack([x[character[curves.row]], np.zeros(len(curves.values))], axis=1)
    return Curves((curves.values + right) / GLYPH_HEIGHT, curves.starts), integers(text[character])


def _glyphs(texts: Sequence[str]) -> tuple[IntArray, IntArray]:
    """The glyph of each character, text after text; (m + 1,) where each text starts in it, and where the last ends."""
    try:
        glyph = integers([_GLYPH[character] for text in texts for character in text])
    except KeyError:
        text = next(text for text in texts if not set(text) <= set(GLYPHS))
        unknown = sorted(set(text) - set(GLYPHS))
        raise OutputError(
            f"the mark {text!r} cannot be drawn: the alphabet has no {' or '.join(map(repr, unknown))}; "
            "use capital letters, digits and hyphens"
        ) from None
    return glyph, integers(np.cumsum([0, *map(len, texts)]))
