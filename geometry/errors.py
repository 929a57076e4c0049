"""What geometry says when it cannot do what was asked: a sentence, with the numbers behind it as attributes."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:  # numpy is not needed to say what is wrong
    from geometry.arrays import FloatArray, IntArray

__all__ = [
    "FoldedError",
    "GeometryError",
    "MeshError",
    "MeshFileError",
    "ParallelityError",
    "RankError",
    "described",
    "listed",
    "raise_worst",
    "shown",
]

MAX_NAMED_FINDINGS = 10
"""Findings of one kind that a sentence names; it counts the rest."""

MAX_QUOTED_CHARACTERS = 40
"""Characters of a damaged word or line that a sentence repeats."""


class GeometryError(ValueError):
    """Base of all errors of this package.

    `message` names element, value, bound and what to do. `elements` are the indices of the vertices, edges or
    faces concerned (the message says which), `value` what was found, `bound` what was allowed.
    """

    def __init__(
        self,
        message: str,
        *,
        elements: Sequence[int] = (),
        value: float | None = None,
        bound: float | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.elements = tuple(int(element) for element in elements)
        self.value = value
        self.bound = bound


class MeshError(GeometryError):
    """The mesh itself cannot be used: not manifold, a degenerate edge or face, not finite."""


class MeshFileError(GeometryError):
    """A file does not hold a mesh that can be read."""


class FoldedError(GeometryError):
    """A face or an edge turned over while a mesh was optimised. happened: the message without what to do."""

    def __init__(self, happened: str, advice: str, *, elements: Sequence[int], value: float, bound: float) -> None:
        super().__init__(f"{happened}; {advice}", elements=elements, value=value, bound=bound)
        self.happened = happened


class ParallelityError(GeometryError):
    """Two meshes that should be parallel are not."""


class RankError(GeometryError):
    """The singular values have no gap, so that the dimension of a space cannot be told."""


COMPARISONS = {"<=": operator.le, ">=": operator.ge, ">": operator.gt}
"""What may be demanded of values; NaN is nothing of it."""


def raise_worst(
    values: FloatArray,
    demand: Literal["<=", ">=", ">"],
    bound: float,
    say: Callable[[int, float], str],
    *,
    elements: IntArray | None = None,
    error: Callable[..., GeometryError] = GeometryError,
    **more: Any,
) -> None:
    """Raise an error that names the worst element, where not all values (m,) are as demanded of them.

    The worst is the largest for "<=", else the least, the first one of several; NaN is worse than any number.
    say: the sentence, from the element and its value. elements (m,): what the values belong to; their numbers without.
    error: the class, called with the sentence, `elements`, `value`, `bound` and what `more` it asks for.

    >>> import numpy as np
    >>> raise_worst(np.array([0.1, 0.4]), "<=", 0.2, lambda face, value: f"face {face} is off by {value}, allowed 0.2")
    Traceback (most recent call last):
    geometry.errors.GeometryError: face 1 is off by 0.4, allowed 0.2
    """
    if not len(values):
        return
    worst = int(values.argmax() if demand == "<=" else values.argmin())  # either is the first NaN, if there is one
    value = float(values[worst])
    if COMPARISONS[demand](value, bound):
        return
    element = worst if elements is None else int(elements[worst])
    raise error(say(element, value), elements=[element], value=value, bound=bound, **more)


def listed(names: Iterable[object], count: int) -> str:
    """ "1, 2 and 3", or "1, 2, 3 and 37 more": the first of `count` names, which need not all be made."""
    first = [str(name) for _, name in zip(range(min(count, MAX_NAMED_FINDINGS)), names, strict=False)]
    if count > len(first):
        return f"{', '.join(first)} and {count - len(first)} more"
    return " and ".join(part for part in (", ".join(first[:-1]), first[-1]) if part)


def described(given: object) -> str:
    """What an argument of a wrong type is, in a sentence."""
    shape = getattr(given, "shape", None)
    if isinstance(given, type):
        return f"the class {given.__name__}"
    return f"an array of shape {shape}" if isinstance(shape, tuple) else f"a value of type {type(given).__name__}"


def shown(text: object, length: int = MAX_QUOTED_CHARACTERS) -> str:
    """Text from outside as a sentence may repeat it: on one line, printable everywhere, no longer than that.

    Bytes of a file's name that are not UTF-8 are told as such. The middle is left out, not the end, which tells file
    names apart.
    """
    plain = "".join(c if c.isprintable() else _escaped(c) for c in str(text))
    if len(plain) <= length:
        return plain
    return f"{plain[: length // 2]}...{plain[-(length - length // 2) :]}"


def _escaped(letter: str) -> str:
    byte = ord(letter) - 0xDC00  # how Python keeps it in a name
    return f"\\x{byte:02x}" if 0x80 <= byte <= 0xFF else letter.encode("unicode_escape").decode("ascii")
