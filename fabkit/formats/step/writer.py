"""Composes the text of one STEP file, in batches."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple, TextIO

import numpy as np

from fabkit.errors import OutputError
from fabkit.formats.step.entities import (
    ASSEMBLY_BLOCK,
    CONTEXT,
    DEFINITION,
    DENSITY_OFFSET,
    FIRST_FREE_ID,
    HEADER,
    INSTANCE_BLOCK,
    MATERIAL_BLOCK,
    ORIGIN,
    PART,
    PLACED_BLOCK,
    PLACEMENT_BLOCK,
    PLACEMENT_OFFSET,
    PRACTICE,
    REPRESENTATION,
    SCHEMAS,
    STYLE_BLOCK,
    Schema,
)
from fabkit.formats.step.solid import STEP_ACCURACY_MM, Template, by_template, solid_entities, solid_numbers
from fabkit.formats.step.text import Block, reals, string
from fabkit.parts import Kind, Material, Part, Parts, Zones
from geometry.arrays import FloatArray, IntArray

__all__ = ["Shape", "StepWriter", "instance_name", "product_names", "shapes"]

PARTS_PER_BATCH = 512
"""Number of parts that are put into text together: enough to make array operations worthwhile, few enough for a small
memory."""
_ITEMS_PER_LINE = 16
"""Number of references in a line of a STEP file."""
_FRAME_TOLERANCE = 1e-11
"""Largest deviation of the axes of a placement from orthonormal: it moves a point of a part of 10 m by
STEP_ACCURACY_MM."""


def instance_name(part: Part) -> str:
    """The name of one instance of a mark: the mark, and the number of its mesh edge (e), vertex (v) or face (f),
    counted from 0, such as `B12 e37`. Of several parts of a mark at one mesh element it is the name of the first; for
    all of them see `Parts.piece_names`.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.step import instance_name
    >>> instance_name(built.assembly["beams"][7])
    'B001 e7'
    """
    return f"{part.mark} {part.kind.element[0]}{part.element}"


class Shape(NamedTuple):
    """A mark as it is written. product: its name, by `product_names`; template and numbers: those of its solid."""

    kind: Kind[Any]
    mark: str
    product: str
    material: Material
    template: Template
    numbers: Sequence[str]


@dataclass(frozen=True)
class _Assembly:
    """A product that contains others: its first id, and the ids of their placements."""

    first_id: int
    placements: array[int] = field(default_factory=lambda: array("Q"))


class StepWriter:
    """Writes one file from top to bottom: each method adds text to the stream.

    name: of the structure or the mark of the only part; revision: of the products; the rest is for the header.
    """

    def __init__(
        self,
        stream: TextIO,
        name: str,
        schema: Schema,
        author: str,
        organisation: str,
        revision: str,
        time_stamp: str,
    ) -> None:
        if schema not in SCHEMAS:
            raise OutputError(f"a STEP file cannot be written as {schema!r}; choose AP242 or AP214")
        file_schema, application, protocol = SCHEMAS[schema]
        self._stream = stream
        self._name = name
        self._revision = string(revision)
        self._free_id = FIRST_FREE_ID
        self._materials: dict[Material, int] = {}
        self._styles: dict[tuple[float, float, float], int] = {}
        self._products: dict[str, int] = {}  # first id of the product of each mark
        self._contents: dict[str, int] = {}  # a hash of the part of each mark
        self._zones: dict[str, _Assembly] = {}
        self._groups: dict[tuple[str, str], _Assembly] = {}  # by zone and name
        self._taken: set[str] = set()  # names that no mark may have
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
                tolerance=reals(np.array(STEP_ACCURACY_MM))[0],
            )
        )

    def begin_structure(self, origin_mm: FloatArray, zones: Zones) -> None:
        """The product that contains all others, and the placement of its contents at origin_mm (3,), zone by zone."""
        self._zones_of = zones
        for name in zones.names:
            if name == self._name:
                raise OutputError(f"a structure cannot be called {name!r}, like its zone; give it another name")
        self._taken |= {self._name, *zones.names}
        self._root = self._add_assembly(self._name)
        at = reals(np.concatenate([origin_mm, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        self._root.placements.append(self._add(PLACEMENT_BLOCK, at) + PLACEMENT_OFFSET)

    def write_parts(self, parts: Parts[Any]) -> Iterator[Shape]:
        """Some parts of a group: a product with its solid for each mark that was not written before, which it gives out
        once it is written, and then an instance for each part."""
        if parts.kind.group == self._name:
            raise OutputError(f"a structure cannot be called {self._name!r}, like its group; give it another name")
        self._taken.add(parts.kind.group)
        if parts.kind.group in self._products:
            raise _taken(parts.kind.group)
        self._check_marks(parts)
        new = [k for k, mark in enumerate(parts.mark_names) if mark not in self._products]
        for shape in shapes(parts, parts.firsts[np.array(new, dtype=np.int64)]):
            self.write_shape(shape)
            yield shape
        zone = self._zones_of.of(parts)
        for number in np.unique(zone).tolist():
            rows = np.flatnonzero(zone == number)
            for few in np.split(rows, range(PARTS_PER_BATCH, len(rows), PARTS_PER_BATCH)):
                self._write_instances(parts, few, (*self._zones_of.names, "")[number])

    def write_shape(self, shape: Shape) -> None:
        """The product of a mark, with its solid."""
        kind, mark, product, of, template, numbers = shape
        if mark in self._taken:
            raise _taken(mark)
        name, material, style = string(mark), self._material(of), self._style(kind.colour)
        ids = (str(material), str(material + DENSITY_OFFSET), str(style))
        values = (self._revision, name, string(product), kind.name, *ids, name, *numbers)
        self._products[mark] = self._add(_part_block(template), values)

    def _write_instances(self, parts: Parts[Any], rows: IntArray, zone: str) -> None:
        """These parts at their places, in their group of that zone, or of the structure where there are no zones."""
        key, instances = (zone, parts.kind.group), parts.piece_names
        if zone and zone not in self._zones:
            self._zones[zone] = self._add_assembly(zone, self._root, self._root.placements[0])
        if key not in self._groups:
            parent = self._zones[zone] if zone else self._root
            place = parent.first_id + ORIGIN if zone else self._root.placements[0]
            self._groups[key] = self._add_assembly(" ".join(key).strip(), parent, place)
        group, numbers = self._groups[key], reals(_placements(parts, rows))
        for n, row in enumerate(rows.tolist()):
            placement, product = numbers[9 * n : 9 * n + 9], self._products[parts.mark_names[parts.mark[row]]]
            values = (*placement, str(product + ORIGIN), *self._names(group, product, instances[row]))
            group.placements.append(self._add(INSTANCE_BLOCK, values) + PLACEMENT_OFFSET)

    def end_structure(self) -> None:
        """The contents of the structure, of each zone and group. Raises OutputError if there are no parts."""
        if not self._groups:
            raise OutputError(f"{self._name} has no parts, so there is nothing to write")
        for assembly in (self._root, *self._zones.values(), *self._groups.values()):
            first = assembly.first_id
            self._stream.write(f"#{first + REPRESENTATION}=SHAPE_REPRESENTATION('',(#{first + ORIGIN}")
            for start in range(0, len(assembly.placements), _ITEMS_PER_LINE):
                line = assembly.placements[start : start + _ITEMS_PER_LINE]
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

    def _add_assembly(self, name: str, parent: _Assembly | None = None, place: int = 0) -> _Assembly:
        """A product for others, in a parent at one of its placements, by its id; FreeCAD numbers names anew that end in
        a digit."""
        label = f"{name} structure" if name[-1:].isdigit() else name
        own = _Assembly(self._add(ASSEMBLY_BLOCK, (self._revision, string(name), string(label), "")))
        if parent is not None:
            places = (str(own.first_id + ORIGIN), str(place))
            self._add(PLACED_BLOCK, (*places, *self._names(parent, own.first_id, name)))
        return own

    def _names(self, assembly: _Assembly, product: int, name: str) -> tuple[str, ...]:
        """Ids and names in the entities of an instance of a product in an assembly, after its placement."""
        into = assembly.first_id
        shapes = (str(product + REPRESENTATION), str(into + REPRESENTATION))
        definitions = (str(into + DEFINITION), str(product + DEFINITION))
        return (*shapes, string(name), string(name), *definitions)

    def _check_marks(self, parts: Parts[Any]) -> None:
        """Raise OutputError for a mark that two different parts have."""
        first = parts.firsts[parts.mark]
        differ = (parts.shape != parts.shape[first]) | (parts.material != parts.material[first])
        rows, solids = [*parts.firsts.tolist(), *np.flatnonzero(differ).tolist()], parts.solids
        topologies = [hash((t.corners.tobytes(), t.rounds.tobytes(), t.fillets.tobytes())) for t in solids.topologies]
        topology, starts = solids.topology.tolist(), (3 * solids.vertices.starts).tolist()
        numbers, shapes = solids.vertices.values.ravel(), parts.shape.tolist()
        marks, materials = parts.mark.tolist(), parts.material.tolist()
        for k in rows:
            mark, shape = parts.mark_names[marks[k]], shapes[k]
            vertices = numbers[starts[shape] : starts[shape + 1]].tobytes()
            material = parts.materials[materials[k]]
            content = hash((parts.kind.name, material, topologies[topology[shape]], vertices))
            if self._contents.setdefault(mark, content) != content:
                raise OutputError(
                    f"mark {mark} is that of two different parts, the second of them {instance_name(parts[k])}; "
                    "parts share a mark only where solid, kind and material are equal"
                )

    def _material(self, material: Material) -> int:
        if material not in self._materials:
            density = reals(np.array(material.density_kg_m3 / 1000))
            name = string(material.name)
            self._materials[material] = self._add(MATERIAL_BLOCK, (name, name, *density))
        return self._materials[material]

    def _style(self, colour: tuple[float, float, float]) -> int:
        if colour not in self._styles:
            self._styles[colour] = self._add(STYLE_BLOCK, reals(np.array(colour)))
        return self._styles[colour]


def product_names(parts: Parts[Any]) -> list[str]:
    """The name of the product of each mark: the mark, what the part is made from, and its kind, such as `B001 rhs
    120x60x5 beam`. FreeCAD shows these names, and numbers those anew that end in a digit.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.step import product_names
    >>> [product_names(parts)[0] for parts in built.assembly.groups]
    ['B001 rhs 120x60x5 beam', 'N001 node', 'P001 8.76 mm glass 44.2 panel']
    """
    stock = parts.kind.stock(parts) if parts.kind.stock else [""] * len(parts)
    return [
        " ".join(word for word in (mark, stock[k], parts.kind.name) if word)
        for mark, k in zip(parts.mark_names, parts.firsts.tolist(), strict=True)
    ]


def _check_name(mark: str) -> None:
    """Raise OutputError for a mark that is not a valid name."""
    if not (mark and mark.isascii() and mark.isprintable()):
        raise OutputError(
            f"mark {mark!r} is not printable ASCII, as names in STEP files must be; give the part another mark"
        )


def _taken(mark: str) -> OutputError:
    return OutputError(f"mark {mark} is also the name of the structure or a group or zone; names must be unique")


def shapes(parts: Parts[Any], rows: IntArray) -> Iterator[Shape]:
    """The marks of these parts (k,), in this order. Raises OutputError for a mark that is not a valid name, and where a
    solid cannot be written."""
    names, marks, materials = product_names(parts), parts.mark.tolist(), parts.material.tolist()
    for start in range(0, len(rows), PARTS_PER_BATCH):
        few = rows[start : start + PARTS_PER_BATCH]
        found: dict[int, Shape] = {}
        for template, batch in by_template(parts, few):
            own = few[batch.parts].tolist()
            texts = reals(solid_numbers(template, batch, [parts.mark_names[marks[k]] for k in own]))
            width = len(texts) // len(own)
            for n, k in enumerate(own):
                mark, material, numbers = marks[k], parts.materials[materials[k]], texts[n * width : (n + 1) * width]
                _check_name(parts.mark_names[mark])
                found[k] = Shape(parts.kind, parts.mark_names[mark], names[mark], material, template, numbers)
        yield from (found[k] for k in few.tolist())


@lru_cache(maxsize=256)
def _part_block(template: Template) -> Block:
    """The entities of a part, without its placements."""
    return Block([*PART, *solid_entities(template, len(PART))])


def _placements(parts: Parts[Any], rows: IntArray) -> FloatArray:
    """(k, 9) origin, x axis and z axis of these parts. Raises OutputError where that is not a rigid motion."""
    axes, origins = parts.axes[rows], parts.origins[rows]
    deviations = np.abs(np.cross(axes[:, 0], axes[:, 1]) - axes[:, 2]).max(axis=1)
    deviations = np.maximum(deviations, np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)))
    is_rigid = (deviations <= _FRAME_TOLERANCE) & np.isfinite(origins).all(axis=1)
    if not is_rigid.all():
        worst = int(np.argmin(is_rigid))
        raise OutputError(
            f"the placement of {instance_name(parts[int(rows[worst])])} is not a rigid motion: its origin is "
            f"{origins[worst]}, its axes are {deviations[worst]:.2g} off a right-handed orthonormal frame, allowed "
            f"{_FRAME_TOLERANCE:g}"
        )
    return np.concatenate([origins, axes[:, 0], axes[:, 2]], axis=1)
