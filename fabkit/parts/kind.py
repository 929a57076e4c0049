"""Kinds of part: their data, columns, measures and labels.

A kind is added as one `Kind` value in fabkit.kinds, with a record of the data of its parts. The code that draws, lists,
checks or writes parts works for all kinds and names none of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any, Generic, Literal, Self, TypeVar

import numpy as np

from fabkit.parts.columns import Column
from fabkit.parts.ragged import Ragged
from fabkit.parts.symmetry import Symmetry
from geometry.arrays import FloatArray, floats

__all__ = ["Details", "Kind", "Measure", "in_layer"]


@dataclass(frozen=True, eq=False)
class Details:
    """Base of the records with the data of parts besides their solids: one record for each kind, with arrays over all n
    parts.

    Fields are arrays (n, ...) or Ragged. details[k] is the record of one part, its fields without the first axis;
    details[chosen], by indices or a mask (n,), that of several parts.

    >>> from dataclasses import dataclass
    >>> from fabkit.parts import Details
    >>> @dataclass(frozen=True, eq=False)
    ... class CableDetails(Details):
    ...     force_kn: np.ndarray
    >>> cables = CableDetails(np.array([12.0, 15.0, 9.0]))
    >>> cables[cables.force_kn > 10].force_kn.tolist()
    [12.0, 15.0]
    """

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray) and value.flags.writeable:
                value = value.copy()
                value.flags.writeable = False
                object.__setattr__(self, each.name, value)

    @classmethod
    def joined(cls, several: Sequence[Self]) -> Self:
        """The records of all these parts, of at least one record."""
        both: dict[str, Any] = {}
        for each in fields(several[0]):
            values = [getattr(record, each.name) for record in several]
            both[each.name] = Ragged.joined(values) if isinstance(values[0], Ragged) else np.concatenate(values)
        return replace(several[0], **both)

    def __getitem__(self, chosen: Any) -> Self:
        return replace(self, **{each.name: getattr(self, each.name)[chosen] for each in fields(self)})


P = TypeVar("P")


@dataclass(frozen=True, eq=False)
class Measure:
    """One number for each part of a group, in the group's order.

    values (n,), NaN where there is none; decimals: number of decimals shown; signed: whether the values are deviations
    of both signs from zero.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> beams = built.assembly["beams"]
    >>> measure = beams.kind.measures(beams)[0]
    >>> measure.title, measure.unit, round(measure.values.max())
    ('Long-point length', 'mm', 2288)
    """

    group: str
    title: str
    unit: str
    decimals: int
    values: FloatArray
    signed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", floats(self.values))


@dataclass(frozen=True, eq=False, kw_only=True)
class Kind(Generic[P]):
    """A kind of part; P is the type of its parts.

    name: of one part; group: name of all parts of the kind; element: the mesh element of a part. letter: first letter
    of the marks. colour: sRGB red, green and blue, 0 to 1. form: what the workshop does with it: bars are cut to
    length, blocks are machined, plates are cut from sheets, pins are bought. empty_details: the record for zero parts.
    symmetry: None for parts without symmetry. one_per_element: whether a mesh element has at most one part. apart_by:
    where it may have several, the fields of the details that tell them apart, whole numbers from 0, if there are such
    fields. layer: word for the layer of beams and nodes that the parts belong to, with which their names begin; empty
    for the first layer, and for parts that belong to none. cure: what to do where a part of this kind shares volume
    with another one, as far as the kind knows it. first_edge: of plates that are cut out of sheets, prisms from z = 0
    upwards, which edge of their outlines is the first, in words; empty for other kinds. frame: where the own frames of
    the parts lie, in a sentence for the legend. directions: normals of the
    faces on which beams stand, one for each place of the ring, unit vectors in the parts' own frames; None where no
    beam does.

    columns: of the cut list, with one cell for each mark. stock: what each part is made from, in a few words;
    finishes: what is done to each besides its shape, in which parts with one mark agree, in words that may be empty.
    faces: names (k, F) of the faces of the solids, all of one topology, of k parts, for STEP files.
    measures: numbers for colours and histograms. labels: one line about each part. The functions for columns and labels
    also take the `Surroundings` of the parts.

    >>> from fabkit.kinds import BEAM
    >>> BEAM.name, BEAM.group, BEAM.element, BEAM.letter
    ('beam', 'beams', 'edge', 'B')
    """

    name: str
    group: str
    element: Literal["vertex", "edge", "face"]
    letter: str
    colour: tuple[float, float, float]
    form: Literal["bar", "block", "plate", "pin"]
    empty_details: Details
    symmetry: Symmetry[P] | None = None
    one_per_element: bool = True
    apart_by: tuple[str, ...] = ()
    layer: str = ""
    cure: str = ""
    first_edge: str = ""
    frame: str = ""
    columns: Callable[[P, Any], Sequence[Column]]
    measures: Callable[[P], Sequence[Measure]]
    labels: Callable[[P, Any], Sequence[str]]
    stock: Callable[[P], Sequence[str]] | None = None
    finishes: Callable[[P], Sequence[str]] | None = None
    faces: Callable[[P, Any], Any] | None = None
    directions: Callable[[P], Ragged] | None = None

    def named(self, name: str) -> str:
        """The name that a kind or a group has in the layer of this kind."""
        return f"{self.layer} {name}".strip()


K = TypeVar("K", bound=Kind[Any])

SHADE_OF_LAYER = 0.72
"""Brightness of the colour of parts of a further layer, over that of the same parts in the first one."""


@cache
def in_layer(kind: K, layer: str) -> K:
    """The kind of the same parts in another layer of beams and nodes; the same object for equal arguments.

    >>> from fabkit.kinds import BEAM
    >>> from fabkit.parts import in_layer
    >>> lower = in_layer(BEAM, "lower")
    >>> lower.group, lower.letter, lower.named("nodes"), in_layer(BEAM, "") is BEAM
    ('lower beams', 'LB', 'lower nodes', True)
    """
    if not layer:
        return kind
    red, green, blue = (SHADE_OF_LAYER * part for part in kind.colour)
    return replace(
        kind,
        name=f"{layer} {kind.name}",
        group=f"{layer} {kind.group}",
        letter=f"{layer[0].upper()}{kind.letter}",
        colour=(red, green, blue),
        layer=layer,
    )
