"""Puts the text of one STEP file together, batch by batch."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TextIO

import numpy as np

from fabkit.errors import OutputError
from fabkit.formats.step.entities import (
    ASSEMBLY_BLOCK,
    CONTEXT,
    DEFINITION,
    DENSITY,
    FIRST_FREE_ID,
    HEADER,
    INSTANCE_BLOCK,
    MATERIAL_BLOCK,
    ORIGIN,
    PART,
    PLACED_BLOCK,
    PLACEMENT,
    PLACEMENT_BLOCK,
    PRACTICE,
    REPRESENTATION,
    SCHEMAS,
    STYLE_BLOCK,
    Schema,
)
from fabkit.formats.step.solid import TOLERANCE_MM, solid_entities, solid_numbers
from fabkit.formats.step.text import Block, reals, string
from fabkit.parts import Material, Part, Topology
from fabkit.parts.palette import PALETTE
from geometry.arrays import FloatArray

__all__ = ["StepWriter", "check_name", "instance_name", "solid_texts"]

_GROUPS = {"beam": "beams", "node": "nodes", "panel": "panels"}
_ELEMENTS = {"beam": "e", "node": "v", "panel": "f"}
_ITEMS_A_LINE = 16
_FRAME_TOLERANCE = 1e-11  # moves a point of a part of 10 m by TOLERANCE_MM


def instance_name(part: Part) -> str:
    """The name of one instance of a mark: the mark, and the mesh edge (e), vertex (v) or face (f) it stands for:
    `B12 e37`."""
    return f"{part.mark} {_ELEMENTS[part.kind]}{part.element}"


@dataclass(frozen=True)
class _Assembly:
    """A product that holds others: its first id, and the ids of their placements."""

    first_id: int
    placements: array[int] = field(default_factory=lambda: array("Q"))


class StepWriter:
    """Writes one file from top to bottom: each method adds text to the stream.

    name: of the structure or the mark of the only part; the rest is for the header.
    """

    def __init__(
        self, stream: TextIO, name: str, schema: Schema, author: str, organisation: str, time_stamp: str
    ) -> None:
        if schema not in SCHEMAS:
            raise OutputError(f"a STEP file cannot be written as {schema!r}; choose AP242 or AP214")
        file_schema, application, protocol = SCHEMAS[schema]
        self._stream = stream
        self._name = name
        self._free_id = FIRST_FREE_ID
        self._materials: dict[Material, int] = {}
        self._styles: dict[str, int] = {}
        self._products: dict[str, int] = {}  # first id of the product of each mark
        self._contents: dict[str, int] = {}  # a hash of what each mark stands for
        self._taken: tuple[str, ...] = ()  # names that no mark may have
        stream.write(
            HEADER.format(
                name=string(name),
                practice=PRACTICE,
                time_stamp=string(time_stamp),
                author=string(author),
                organisation=string(organisation),
                schema=file_schema,
                application=application,
                protocol=protocol,
                tolerance=reals(np.array(TOLERANCE_MM))[0],
            )
        )

    def begin_structure(self, origin_mm: FloatArray) -> None:
        """The product that holds all others, and the placement of what is in it; origin_mm (3,): of that."""
        self._taken = (self._name, *_GROUPS.values())
        if self._name in _GROUPS.values():
            raise OutputError(f"a structure cannot be called {self._name!r}, like its group; give it another name")
        self._root = self._add_assembly(self._name)
        at = reals(np.concatenate([origin_mm, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        self._root.placements.append(self._add(PLACEMENT_BLOCK, at) + PLACEMENT)
        self._groups: dict[str, _Assembly] = {}

    def write_shapes(self, parts: Sequence[Part]) -> None:
        """A product with its solid for each mark that was not written before."""
        new: dict[str, Part] = {}
        for part in parts:
            self._check_mark(part)
            if part.mark not in self._products:
                new.setdefault(part.mark, part)
        for part, numbers in zip(new.values(), solid_texts(list(new.values())), strict=True):
            self.write_shape(part.mark, part.kind, part.material, part.solid.topology, numbers)

    def write_shape(self, mark: str, kind: str, material: Material, topology: Topology, numbers: Sequence[str]) -> None:
        """The product of a mark; numbers: what `solid_texts` says of its solid."""
        name, first, style = string(mark), self._material(material), self._style(kind)
        values = (name, name, kind, str(first), str(first + DENSITY), str(style), name, *numbers)
        self._products[mark] = self._add(_part_block(topology), values)

    def write_instances(self, parts: Sequence[Part]) -> None:
        """Each part, placed in the group of its kind; shapes come first."""
        numbers = reals(_placements(parts))
        for n, part in enumerate(parts):
            if part.kind not in self._groups:
                self._groups[part.kind] = group = self._add_assembly(_GROUPS[part.kind])
                place = (str(group.first_id + ORIGIN), str(self._root.placements[0]))
                self._add(PLACED_BLOCK, (*place, *self._names(self._root, group.first_id, _GROUPS[part.kind])))
            placement = numbers[9 * n : 9 * n + 9]
            group, product = self._groups[part.kind], self._products[part.mark]
            values = (*placement, str(product + ORIGIN), *self._names(group, product, instance_name(part)))
            group.placements.append(self._add(INSTANCE_BLOCK, values) + PLACEMENT)

    def end_structure(self) -> None:
        """What the structure and each group hold. Raises OutputError where that is nothing."""
        if not self._groups:
            raise OutputError(f"{self._name} has no parts, so there is nothing to write")
        for assembly in (self._root, *self._groups.values()):
            first = assembly.first_id
            self._stream.write(f"#{first + REPRESENTATION}=SHAPE_REPRESENTATION('',(#{first + ORIGIN}")
            for start in range(0, len(assembly.placements), _ITEMS_A_LINE):
                line = assembly.placements[start : start + _ITEMS_A_LINE]
                self._stream.write(",\n" + ",".join(f"#{item}" for item in line))
            self._stream.write(f"),#{first + CONTEXT});\n")
        self.end()

    def end(self) -> None:
        self._stream.write("ENDSEC;\nEND-ISO-10303-21;\n")

    def _add(self, block: Block, values: Sequence[str]) -> int:
        """Write the block; its first id."""
        first_id = block.first_id(self._free_id)
        self._stream.write(block.text(first_id, values))
        self._free_id = first_id + block.n_ids
        return first_id

    def _add_assembly(self, name: str) -> _Assembly:
        return _Assembly(self._add(ASSEMBLY_BLOCK, (string(name), string(name), "")))

    def _names(self, assembly: _Assembly, product: int, name: str) -> tuple[str, ...]:
        """What an instance of a product in an assembly says of both, after its placement."""
        into = assembly.first_id
        shapes = (str(product + REPRESENTATION), str(into + REPRESENTATION))
        definitions = (str(into + DEFINITION), str(product + DEFINITION))
        return (*shapes, string(name), string(name), *definitions)

    def _check_mark(self, part: Part) -> None:
        """Raise OutputError for a mark that is no name, or stands for something else as well."""
        solid = part.solid
        content = hash((part.kind, part.material, solid.topology.corners.tobytes(), solid.vertices.tobytes()))
        known = self._contents.setdefault(part.mark, content)
        if known != content:
            raise OutputError(
                f"mark {part.mark} stands for two different parts, the second of them {instance_name(part)}; "
                "parts share a mark only where solid, kind and material are equal"
            )
        if part.mark in self._products:
            return
        check_name(part.mark)
        if part.mark in self._taken:
            raise OutputError(f"mark {part.mark} is also the name of the structure or a group; names must be unique")

    def _material(self, material: Material) -> int:
        if material not in self._materials:
            density = reals(np.array(material.density_kg_m3 / 1000))
            name = string(material.name)
            self._materials[material] = self._add(MATERIAL_BLOCK, (name, name, *density))
        return self._materials[material]

    def _style(self, kind: str) -> int:
        if kind not in self._styles:
            self._styles[kind] = self._add(STYLE_BLOCK, reals(np.array(PALETTE[kind])))
        return self._styles[kind]


def check_name(mark: str) -> None:
    """Raise OutputError for a mark that is no name."""
    if not (mark and mark.isascii() and mark.isprintable()):
        raise OutputError(f"mark {mark!r} is not printable ASCII, which names in STEP files should be")


def solid_texts(parts: Sequence[Part]) -> list[list[str]]:
    """Measures and numbers of the solid of each part, as text; worked out for all of one topology at once."""
    members: dict[Topology, list[int]] = {}
    for n, part in enumerate(parts):
        members.setdefault(part.solid.topology, []).append(n)
    rows: list[list[str]] = [[]] * len(parts)
    for topology, chosen in members.items():
        names = [parts[n].mark for n in chosen]
        vertices = np.stack([parts[n].solid.vertices for n in chosen])
        texts = reals(solid_numbers(vertices, topology, names))
        width = len(texts) // len(chosen)
        for row, n in enumerate(chosen):
            rows[n] = texts[row * width : (row + 1) * width]
    return rows


@lru_cache(maxsize=256)
def _part_block(topology: Topology) -> Block:
    """What is written for a part, but for its placements."""
    return Block([*PART, *solid_entities(topology, len(PART))])


def _placements(parts: Sequence[Part]) -> FloatArray:
    """(k, 9) origin, x axis and z axis of each part. Raises OutputError where that is not a rigid motion."""
    axes = np.stack([part.placement.axes for part in parts])
    origins = np.stack([part.placement.origin for part in parts])
    off = np.abs(np.cross(axes[:, 0], axes[:, 1]) - axes[:, 2]).max(axis=1)
    off = np.maximum(off, np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)))
    fine = (off <= _FRAME_TOLERANCE) & np.isfinite(origins).all(axis=1)
    if not fine.all():
        worst = int(np.argmin(fine))
        raise OutputError(
            f"the placement of {instance_name(parts[worst])} is not a rigid motion: its origin is {origins[worst]}, "
            f"its axes are {off[worst]:.2g} off a right-handed orthonormal frame, allowed {_FRAME_TOLERANCE:g}"
        )
    return np.concatenate([origins, axes[:, 0], axes[:, 2]], axis=1)
