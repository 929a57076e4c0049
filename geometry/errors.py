"""The errors of geometry: a message in one sentence, with the numbers behind it as attributes."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:  # so that errors do not import numpy
    from geometry.arrays import FloatArray, IntArray

__all__ = [
    "FoldedError",
    "GeometryError",
    "MeshError",
    "MeshFileError",
    "ParallelityError",
    "RankError",
    "described",
    "finite_number",
    "listed",
    "printable",
    "raise_worst",
]

MAX_NAMED_FINDINGS = 10
"""Largest number of findings of one kind that a message names; it gives the number of the others."""

MAX_QUOTED_CHARACTERS = 40
"""Largest number of characters of a damaged word or line that a message quotes."""


class GeometryError(ValueError):
    """Base of all errors of this package.

    `message` names element, value, bound and cure. `elements` are the indices of the vertices, edges or faces
    concerned (the message says which), `value` is what was found, `bound` is what is allowed.

    >>> import geometry
    >>> try:
    ...     geometry.Effort(tolerance=-1e-9)
    ... except GeometryError as error:
    ...     error.message, error.value, error.bound
    ('tolerance is -1e-09: a number from 0 upwards is needed', -1e-09, 0)
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
    """The mesh itself cannot be used: it is not manifold, not finite, or has a degenerate edge or face.

    >>> import geometry
    >>> mesh = geometry.Mesh.from_faces([(0, 0, 0), (1, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    >>> try:
    ...     geometry.planarise(mesh)
    ... except MeshError as error:
    ...     error.message
    'edge 1 from vertex 1 to vertex 2 has no length: make its two vertices one'
    """


class MeshFileError(GeometryError):
    """A file does not hold a mesh that can be read.

    >>> import geometry
    >>> try:
    ...     geometry.read_mesh("roof.3dm")
    ... except MeshFileError as error:
    ...     "roof.3dm" in error.message
    True
    """


class FoldedError(GeometryError):
    """A face or an edge turned over while a mesh was optimised. problem: the message without its advice.

    >>> error = FoldedError("face 3 folded over", "lay the mesh along other lines", elements=[3], value=-1, bound=0)
    >>> error.problem, error.message
    ('face 3 folded over', 'face 3 folded over; lay the mesh along other lines')
    """

    def __init__(self, problem: str, advice: str, *, elements: Sequence[int], value: float, bound: float) -> None:
        super().__init__(f"{problem}; {advice}", elements=elements, value=value, bound=bound)
        self.problem = problem


class ParallelityError(GeometryError):
    """Two meshes that have to be parallel are not.

    >>> import geometry
    >>> M = geometry.Mesh.from_faces([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    >>> try:
    ...     geometry.Pair(M, M.with_vertices(M.vertices + [(0, 0, 0), (0, 1, 0), (0, 0, 0), (0, 0, 0)]))
    ... except ParallelityError as error:
    ...     error.elements
    (0,)
    """


class RankError(GeometryError):
    """Rounding decides about the result: singular values have no gap, or equations nearly depend on each other.

    >>> import geometry
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(4, 4)
    >>> saddle = grid.with_vertices([(x, y, x * y / 4) for x, y, _ in grid.vertices])  # faces are not planar
    >>> try:
    ...     geometry.ParallelSpace(saddle).dimension
    ... except RankError as error:
    ...     error.message.endswith("planarise the mesh first")
    True
    """


COMPARISONS = {"<=": operator.le, ">=": operator.ge, ">": operator.gt}
"""Comparisons of values with a bound; NaN meets none of them."""


def raise_worst(
    values: FloatArray,
    demand: Literal["<=", ">=", ">"],
    bound: float,
    message: Callable[[int, float], str],
    *,
    elements: IntArray | None = None,
    error: Callable[..., GeometryError] = GeometryError,
    **more: Any,
) -> None:
    """Raise an error that names the worst element, unless all values (m,) compare with the bound as demanded.

    The worst value is the largest for "<=", otherwise the least, the first one of several; NaN is worse than any
    number. message: a function of the element and its value. elements (m,): the elements that the values belong to, 0
    to m - 1 if not given. error: the class, called with the message, `elements`, `value`, `bound` and the arguments
    `more`.

    >>> import numpy as np
    >>> raise_worst(np.array([0.1, 0.4]), "<=", 0.2, lambda face, value: f"face {face} is off by {value}, allowed 0.2")
    Traceback (most recent call last):
    geometry.errors.GeometryError: face 1 is off by 0.4, allowed 0.2
    """
    if not len(values):
        return
    worst = int(values.argmax() if demand == "<=" else values.argmin())  # both return the first NaN, if there is one
    value = float(values[worst])
    if COMPARISONS[demand](value, bound):
        return
    element = worst if elements is None else int(elements[worst])
    raise error(message(element, value), elements=[element], value=value, bound=bound, **more)


def listed(names: Iterable[object], count: int) -> str:
    """The first of `count` names, and the number of the others, as part of a sentence. Only these names are generated.

    >>> listed([1, 2, 3], 3), listed(iter(range(1000)), 1000)
    ('1, 2 and 3', '0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 990 more')
    """
    first = [str(name) for _, name in zip(range(min(count, MAX_NAMED_FINDINGS)), names, strict=False)]
    if count > len(first):
        return f"{', '.join(first)} and {count - len(first)} more"
    return " and ".join(part for part in (", ".join(first[:-1]), first[-1]) if part)


def described(given: object) -> str:
    """An argument of a wrong type as part of a sentence."""
    shape = getattr(given, "shape", None)
    if isinstance(given, type):
        return f"the class {given.__name__}"
    return f"an array of shape {shape}" if isinstance(shape, tuple) else f"a value of type {type(given).__name__}"


def finite_number(subject: str, given: Any) -> float:
    """An argument as a float; GeometryError, saying of what, where it is none: a text, a mesh, an array, NaN.

    >>> finite_number("the distance", "0.2")
    Traceback (most recent call last):
    geometry.errors.GeometryError: the distance is '0.2': a finite number is needed
    """
    is_number = hasattr(given, "__float__") and not getattr(given, "shape", ())
    number = float(given) if is_number else math.nan
    if math.isfinite(number):
        return number
    named = repr(printable(given)) if isinstance(given, str) else number if is_number else described(given)
    raise GeometryError(f"{subject} is {named}: a finite number is needed", value=number if is_number else None)


def printable(text: object, length: int = MAX_QUOTED_CHARACTERS) -> str:
    r"""Text from a file or a user as a message quotes it: on one line, printable everywhere, at most `length` long.

    Bytes of a file name that are not UTF-8 are written as escapes. Of longer text the middle is left out, since the
    ends of file names distinguish them.

    >>> printable("v 1 2\n"), printable("face" * 20, 12)
    ('v 1 2\\n', 'facefa...ceface')
    """
    plain = "".join(c if c.isprintable() else _escaped(c) for c in str(text))
    if len(plain) <= length:
        return plain
    return f"{plain[: length // 2]}...{plain[-(length - length // 2) :]}"


def _escaped(letter: str) -> str:
    byte = ord(letter) - 0xDC00  # Python decodes a byte of a file name that is not UTF-8 to 0xDC00 + byte
    return f"\\x{byte:02x}" if 0x80 <= byte <= 0xFF else letter.encode("unicode_escape").decode("ascii")
