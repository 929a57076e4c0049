"""STEP files (ISO 10303-21, AP242 or AP214) of parts with planar and round faces, written without a CAD kernel.

One product and one MANIFOLD_SOLID_BREP for each mark, placed as often as it is used, in the tree structure / group /
part, or structure / zone / group / part; no loose faces; p-curves only where a round bar ends obliquely. One placement,
which the groups share, moves the structure to the coordinates of the mesh file; the parts are placed near zero within
it. A product has the name of its mark, an instance of it that in `Parts.piece_names`. Each product carries its volume,
surface area and centroid as geometric validation properties, its material and density, and the colour of its kind on
its solid.

Text is written in batches, so memory grows only by a few integers for each mark and one for each part.
The same parts and arguments give the same bytes.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from fabkit.errors import OutputError
from fabkit.formats.step.entities import Schema
from fabkit.formats.step.solid import Template
from fabkit.formats.step.text import string
from fabkit.formats.step.writer import Shape, StepWriter, instance_name, product_names, shapes
from fabkit.parts import Assembly, Kind, Material, Part, Parts, Zones
from geometry.arrays import FloatArray

__all__ = [
    "instance_name",
    "product_names",
    "stream_step",
    "write_part_step",
    "write_part_steps",
    "write_step",
]

MARK_HERE, NAME_HERE = "{mark of the part}", "{name of the product}"
"""Stand-ins for the mark of a part and the name of its product in the template of its file."""
_NUMBER_HERE = "\0"
"""Stand-in for a number of its solid: no name in a STEP file has this character."""
NO_TIME = "1970-01-01T00:00:00"
"""Time stamp of the files of a project that states no date: they are the same each time."""


_Head = tuple[Schema, str, str, str, str]
"""Schema, author, organisation, revision and time stamp of a file."""


def write_step(
    target: Path | str | TextIO,
    assembly: Assembly,
    *,
    parts_folder: Path | None = None,
    schema: Schema = "AP242",
    author: str = "",
    organisation: str = "",
    revision: str = "",
    time_stamp: str = NO_TIME,
) -> None:
    """Write all parts of an assembly, placed, to a file or an open text stream.

    parts_folder: an empty folder for a file of each mark, as by `write_part_steps`, but in less time. author,
    organisation, time_stamp (as in ISO 8601): of the header; revision: of the products. Names beyond ASCII are encoded,
    but marks must be ASCII.
    Raises OutputError where the file cannot be written (a file that was there stays as it was), there are no parts,
    one mark stands for different parts, a mark is not ASCII or is the name of the structure, a zone or a group, a
    placement is not a rigid motion, or a solid has an edge too short or a face not plane to 1e-7 mm.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.step import write_step
    >>> write_step("roof.step", built.assembly)
    >>> text = Path("roof.step").read_text()
    >>> text.count("=MANIFOLD_SOLID_BREP("), text.count("=NEXT_ASSEMBLY_USAGE_OCCURRENCE(")
    (10, 63)
    """
    stream_step(
        target,
        assembly.name,
        assembly.groups,
        origin_mm=assembly.origin_mm,
        zones=assembly.zones,
        parts_folder=parts_folder,
        schema=schema,
        author=author,
        organisation=organisation,
        revision=revision,
        time_stamp=time_stamp,
    )


def stream_step(
    target: Path | str | TextIO,
    name: str,
    groups: Iterable[Parts[Any]],
    *,
    origin_mm: FloatArray | None = None,
    zones: Zones | None = None,
    parts_folder: Path | None = None,
    schema: Schema = "AP242",
    author: str = "",
    organisation: str = "",
    revision: str = "",
    time_stamp: str = NO_TIME,
) -> None:
    """Write parts from an iterator, some of a group at a time; otherwise as `write_step`, which has all parts in
    memory.

    name: of the structure. origin_mm (3,): where its zero is placed. zones: of their mesh, none by default.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.step import stream_step
    >>> halves = (parts[k : k + 9] for parts in built.assembly.groups for k in range(0, len(parts), 9))
    >>> stream_step("roof.step", "roof", halves)
    >>> Path("roof.step").read_text().count("=MANIFOLD_SOLID_BREP(")
    10
    """
    head = (schema, author, organisation, revision, time_stamp)
    with _opened(target) as stream:
        writer = StepWriter(stream, name, *head)
        writer.begin_structure(np.zeros(3) if origin_mm is None else origin_mm, zones or Zones())
        for parts in groups:
            for shape in writer.write_parts(parts):
                if parts_folder is not None:
                    _write_file(parts_folder, head, shape)
        writer.end_structure()


def write_part_step(
    target: Path | str | TextIO,
    part: Part,
    *,
    schema: Schema = "AP242",
    author: str = "",
    organisation: str = "",
    revision: str = "",
    time_stamp: str = NO_TIME,
) -> None:
    """Write one part in its own frame, as one product without any assembly; otherwise as `write_step`.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.step import write_part_step
    >>> write_part_step("node.step", built.assembly["nodes"][0])
    >>> Path("node.step").read_text().count("=MANIFOLD_SOLID_BREP(")
    1
    """
    with _opened(target) as stream:
        writer = StepWriter(stream, part.mark, schema, author, organisation, revision, time_stamp)
        for shape in shapes(Parts.of(part.kind, [part]), np.zeros(1, dtype=np.int64)):
            writer.write_shape(shape)
        writer.end()


def write_part_steps(
    folder: Path,
    groups: Iterable[Parts[Any]],
    *,
    schema: Schema = "AP242",
    author: str = "",
    organisation: str = "",
    revision: str = "",
    time_stamp: str = NO_TIME,
) -> None:
    """Write a file for each mark, named like the mark, into an empty folder; otherwise as `write_part_step`.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.step import write_part_steps
    >>> write_part_steps(Path(), built.assembly.groups)
    >>> len(list(Path().glob("*.step")))
    10
    """
    head = (schema, author, organisation, revision, time_stamp)
    for parts in groups:
        for shape in shapes(parts, parts.firsts):
            _write_file(folder, head, shape)


def _write_file(folder: Path, head: _Head, shape: Shape) -> None:
    """Write the file of a mark. Those of parts that differ only in the vertices of their solids have one template."""
    kind, mark, product, material, template, numbers = shape
    tokens = _file_template(head, kind, material, template, len(numbers)).copy()
    tokens[0] = tokens[0].replace(MARK_HERE, string(mark)).replace(NAME_HERE, string(product))
    tokens[1::2] = numbers
    with open(os.path.join(folder, f"{mark}.step"), "wb") as stream:
        stream.write("".join(tokens).encode("ascii"))


@lru_cache(maxsize=256)
def _file_template(head: _Head, kind: Kind[Any], material: Material, of: Template, n_numbers: int) -> list[str]:
    """The text of the file of one part in pieces: every second one is a number of its solid; the first one has
    stand-ins for its names."""
    stream = StringIO()
    writer = StepWriter(stream, MARK_HERE, *head)
    writer.write_shape(Shape(kind, MARK_HERE, NAME_HERE, material, of, [_NUMBER_HERE] * n_numbers))
    writer.end()
    return re.split(f"({_NUMBER_HERE})", stream.getvalue())


@contextmanager
def _opened(target: Path | str | TextIO) -> Iterator[TextIO]:
    """The stream itself, or a draft beside the file, which replaces it if no error is raised."""
    if not isinstance(target, Path | str):
        yield target
        return
    path = Path(target)
    if not path.parent.is_dir():
        raise OutputError(f"the folder {path.parent} in which {path.name} should appear does not exist; make it first")
    draft = path.with_name(f".{path.name}.draft")
    try:
        with draft.open("w", encoding="ascii", newline="\n") as stream:
            yield stream
        draft.replace(path)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error
    finally:
        draft.unlink(missing_ok=True)
