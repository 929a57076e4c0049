"""The parts of one kind as arrays, and single parts for scripts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Generic, TypeVar, overload

import numpy as np

from fabkit.parts.frame import Frame
from fabkit.parts.kind import Details, Kind
from fabkit.parts.material import Material
from fabkit.parts.ragged import Ragged
from fabkit.parts.shapes import Solid, SolidArray
from fabkit.parts.solids import Solids
from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers

__all__ = ["Part", "Parts"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """A single part: its solid in its own frame, and its placement.

    mark: the name that equal parts share; ASCII. element: number of its mesh edge, vertex or face, counted from 0.
    details: the record of its kind for this part, such as `part.details.long_point_mm` of a beam.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> beam = built.assembly["beams"][0]
    >>> beam.mark, beam.element, beam.solid.topology.n_faces, round(beam.mass_kg)
    ('B001', 0, 10, 30)
    """

    kind: Kind[Any]
    mark: str
    solid: Solid
    placement: Frame
    material: Material
    element: int
    details: Any

    @property
    def mass_kg(self) -> float:
        return self.material.mass_kg(self.solid.volume_mm3)


D = TypeVar("D", bound=Details)


@dataclass(frozen=True, eq=False, kw_only=True)
class Parts(Sequence[Part], Generic[D]):
    """All n parts of one kind, as arrays; also a sequence of `Part`, each made on access.

    elements (n,): the mesh edge, vertex or face of each part. solids: the different solids, in the parts' own frames;
    shape (n,): index into them, as equal parts share a solid. origins (n, 3) in mm, axes (n, 3, 3): placements, as in
    `Frame`. materials: the different materials; material (n,): index into them. mark_names: the different marks; mark
    (n,): index into them. models (m,): the part of each mark whose solid and sizes the mark has; by default the first.
    hidden_mm (n, 2): how far the corners of each part lie from those of the solid that it shares, and so the far ends
    of the beams at its facets, at most, in each coordinate; by default not at all. turned_over (n,): whether the outer
    side of a part is that below in its own frame, as it shares the mark of its mirror image; by default not.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> beams = built.assembly["beams"]
    >>> len(beams), beams.mark_names, beams.counts.tolist(), round(beams.masses_kg.sum())
    (30, ('B001', 'B002', 'B003', 'B004', 'B005'), [6, 6, 6, 6, 6], 540)
    >>> beams
    Parts(30 beams, 5 marks)
    >>> beams.take(beams.details.long_point_mm > 2000).marks
    ['B001', 'B001', 'B001', 'B001', 'B001', 'B001']
    """

    kind: Kind[Any]
    elements: IntArray
    solids: Solids
    shape: IntArray
    origins: FloatArray
    axes: FloatArray
    materials: tuple[Material, ...]
    material: IntArray
    mark_names: tuple[str, ...]
    mark: IntArray
    details: D
    models: IntArray | None = None
    hidden_mm: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    turned_over: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))

    def __repr__(self) -> str:
        return f"Parts({len(self)} {self.kind.group}, {len(self.mark_names)} marks)"

    def __post_init__(self) -> None:
        for name in ("elements", "shape", "material", "mark"):
            object.__setattr__(self, name, integers(getattr(self, name)))
        if not len(self.hidden_mm):
            object.__setattr__(self, "hidden_mm", np.zeros((len(self), 2)))
        if not len(self.turned_over):
            object.__setattr__(self, "turned_over", np.zeros(len(self), dtype=bool))
        for name in ("origins", "axes", "hidden_mm"):
            object.__setattr__(self, name, floats(getattr(self, name)))

    @classmethod
    def of(cls, kind: Kind[Parts[D]], parts: Iterable[Part] = ()) -> Parts[D]:
        """Parts that were made one by one, as arrays."""
        given = list(parts)
        solids = {id(part.solid): part.solid for part in given}
        return cls(
            kind=kind,
            elements=np.array([part.element for part in given], dtype=np.int64),
            solids=Solids.of(solids.values()),
            shape=_numbered(solids, [id(part.solid) for part in given]),
            origins=np.array([part.placement.origin for part in given]).reshape(-1, 3),
            axes=np.array([part.placement.axes for part in given]).reshape(-1, 3, 3),
            materials=tuple(dict.fromkeys(part.material for part in given)),
            material=_numbered(dict.fromkeys(part.material for part in given), [part.material for part in given]),
            mark_names=tuple(dict.fromkeys(part.mark for part in given)),
            mark=_numbered(dict.fromkeys(part.mark for part in given), [part.mark for part in given]),
            details=_stacked(kind.empty_details, [part.details for part in given]),
        )

    @classmethod
    def each_its_own(
        cls,
        kind: Kind[Parts[D]],
        elements: IntArray,
        solids: Solids,
        origins: FloatArray,
        axes: FloatArray,
        material: Material,
        details: D,
    ) -> Parts[D]:
        """Parts of one material, each with its own solid, and with a mark from the number of its mesh element, or from
        its own number where an element may have several parts."""
        n = len(elements)
        numbers = elements if kind.one_per_element else np.arange(n)
        return cls(
            kind=kind,
            elements=elements,
            solids=solids,
            shape=np.arange(n),
            origins=origins,
            axes=axes,
            materials=(material,),
            material=np.zeros(n, dtype=np.int64),
            mark_names=tuple(f"{kind.letter}{number}" for number in numbers.tolist()),
            mark=np.arange(n),
            details=details,
        )

    # --- one part, some parts

    def __len__(self) -> int:
        return len(self.elements)

    @overload
    def __getitem__(self, chosen: int) -> Part: ...
    @overload
    def __getitem__(self, chosen: slice) -> Parts[D]: ...
    def __getitem__(self, chosen: int | slice) -> Part | Parts[D]:
        if isinstance(chosen, slice):
            return self.take(np.arange(len(self))[chosen])
        return Part(
            kind=self.kind,
            mark=self.mark_names[self.mark[chosen]],
            solid=self.solids[int(self.shape[chosen])],
            placement=Frame(self.origins[chosen], self.axes[chosen]),
            material=self.materials[self.material[chosen]],
            element=int(self.elements[chosen]),
            details=self.details[chosen],
        )

    def __iter__(self) -> Iterator[Part]:
        return (self[k] for k in range(len(self)))

    def take(self, chosen: BoolArray | IntArray) -> Parts[D]:
        """The parts chosen by a mask or by indices, with the solids and marks that they need."""
        shapes, shape = np.unique(self.shape[chosen], return_inverse=True)
        marks, first, mark = np.unique(self.mark[chosen], return_index=True, return_inverse=True)
        place = np.full(len(self), -1, dtype=np.int64)
        place[chosen] = np.arange(len(mark))
        models = place[self.firsts[marks]]
        return replace(
            self,
            elements=self.elements[chosen],
            solids=self.solids.take(shapes),
            shape=shape,
            origins=self.origins[chosen],
            axes=self.axes[chosen],
            material=self.material[chosen],
            mark_names=tuple(self.mark_names[k] for k in marks.tolist()),
            mark=mark,
            details=self.details[chosen],
            models=np.where(models < 0, first, models),
            hidden_mm=self.hidden_mm[chosen],
            turned_over=self.turned_over[chosen],
        )

    def find(self, elements: IntArray) -> IntArray:
        """Position of the part of each of these mesh elements (...), -1 where there is none."""
        return _positions(self.elements, elements)

    def find_alike(self, parts: IntArray, elements: IntArray) -> IntArray:
        """(k,) position of the part on each of these mesh elements (k,), -1 where there is none, that agrees with the
        part at the position given (k,) in all that tells apart the parts of one element: the panel of the same layer
        and pane on another face."""
        keys, wanted = self.elements, elements
        n_elements = int(np.concatenate([keys, wanted]).max(initial=0)) + 1
        base = np.zeros(len(self), dtype=np.int64)
        for name in self.kind.apart_by:
            values = getattr(self.details, name)
            base = base * (int(values.max(initial=0)) + 1) + values
        found = _positions(base * n_elements + keys, base[parts] * n_elements + wanted)
        return np.where(wanted < 0, -1, found)

    # --- marks

    @property
    def marks(self) -> list[str]:
        """The mark of each part."""
        return [self.mark_names[k] for k in self.mark.tolist()]

    @cached_property
    def piece_names(self) -> list[str]:
        """A name for each part, which no other one has: its mark, and its mesh edge (e), vertex (v) or face (f),
        counted from 0. Where more than one part of a mark has the same mesh element, the second is `B12 e37.2`."""
        keys = self.mark * (int(self.elements.max(initial=0)) + 1) + self.elements
        order = np.argsort(keys, kind="stable")
        begins = np.concatenate([[True], np.diff(keys[order]) != 0])[: len(order)]
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order)) - np.flatnonzero(begins)[np.cumsum(begins) - 1]
        letter = self.kind.element[0]
        rows = zip(self.marks, self.elements.tolist(), rank.tolist(), strict=True)
        return [f"{mark} {letter}{element}" + (f".{n + 1}" if n else "") for mark, element, n in rows]

    @cached_property
    def firsts(self) -> IntArray:
        """(m,) the part of each mark whose solid and sizes the mark has: its model, or its first part."""
        return integers(np.unique(self.mark, return_index=True)[1] if self.models is None else self.models)

    @cached_property
    def counts(self) -> IntArray:
        """(m,) number of parts of each mark."""
        return integers(np.bincount(self.mark, minlength=len(self.mark_names)))

    # --- measures

    @property
    def volumes_mm3(self) -> FloatArray:
        """(n,)"""
        return self.solids.volumes[self.shape]

    @cached_property
    def masses_kg(self) -> FloatArray:
        """(n,)"""
        densities = np.array([material.density_kg_m3 for material in self.materials])
        return floats(densities[self.material] * self.volumes_mm3 * 1e-9)

    @cached_property
    def centres_mm(self) -> FloatArray:
        """(n, 3) centres of mass of the placed parts."""
        centroids = self.solids.centroids[self.shape]
        return floats(self.origins + (centroids[:, None] @ self.axes)[:, 0])

    def placed(self) -> list[SolidArray]:
        """The parts in world coordinates, by topology; SolidArray.parts: positions in the group."""
        return [
            replace(batch, vertices=self.origins[batch.parts, None] + batch.vertices @ self.axes[batch.parts])
            for batch in self.solids.by_topology(self.shape)
        ]


def _positions(numbers: IntArray, wanted: IntArray) -> IntArray:
    """The last position of each wanted number (...), -1 where there is none."""
    if not len(numbers):
        return np.full(np.shape(wanted), -1, dtype=np.int64)
    order = np.argsort(numbers, kind="stable")
    place = np.searchsorted(numbers[order], wanted, side="right") - 1
    found: IntArray = np.where(numbers[order[place]] == wanted, order[place], -1)
    return found


def _numbered(known: Iterable[Any], given: list[Any]) -> IntArray:
    """Which one each of the given things is of those known."""
    numbers = {each: number for number, each in enumerate(known)}
    return np.array([numbers[each] for each in given], dtype=np.int64)


def _stacked(nothing: D, records: list[D]) -> D:
    """The records of single parts as one, whose arrays are like those of no parts."""
    stacked: dict[str, Any] = {}
    for each in fields(nothing):
        like, values = getattr(nothing, each.name), [getattr(record, each.name) for record in records]
        if isinstance(like, Ragged):
            stacked[each.name] = Ragged.of(values, dtype=like.values.dtype, shape=like.values.shape[1:])
        else:
            stacked[each.name] = np.array(values, dtype=like.dtype).reshape(len(values), *like.shape[1:])
    return replace(nothing, **stacked)
