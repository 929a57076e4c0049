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

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from fabkit.errors import OutputError
from fabkit.formats.step.entities import Schema
from fabkit.formats.step.solid import Template, by_template, solid_numbers
from fabkit.formats.step.text import reals, string
from fabkit.formats.step.writer import PARTS_PER_BATCH, StepWriter, check_name, instance_name, product_names
from fabkit.parts import Assembly, Kind, Material, Part, Parts, SolidArray, Zones
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
NO_TIME = "1970-01-01T00:00:00"
"""Time stamp of the files of a project that states no date: they are the same each time."""


_Head = tuple[Schema, str, str, str, str]
"""Schema, author, organisation, revision and time stamp of a file."""


def write_step(
    target: Path | str | TextIO,
    assembly: Assembly,
    *,
    schema: Schema = "AP242",
    author: str = "",
    organisation: str = "",
    revision: str = "",
    time_stamp: str = NO_TIME,
) -> None:
    """Write all parts of an assembly, placed, to a file or an open text stream.

    author, organisation, time_stamp (as in ISO 8601): of the header; revision: of the products. Names beyond ASCII are
    encoded, but marks must be ASCII.
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
    with _opened(target) as stream:
        writer = StepWriter(stream, name, schema, author, organisation, revision, time_stamp)
        writer.begin_structure(np.zeros(3) if origin_mm is None else origin_mm, zones or Zones())
        for parts in groups:
            writer.write_parts(parts)
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
        writer.write_shapes(Parts.of(part.kind, [part]), np.zeros(1, dtype=np.int64))
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
        names, materials = product_names(parts), parts.material[parts.firsts]
        for number, material in enumerate(parts.materials):
            own = np.flatnonzero(materials == number)
            for template, solids in by_template(parts, parts.firsts[own]):
                for start in range(0, len(solids.parts), PARTS_PER_BATCH):
                    batch = solids[start : start + PARTS_PER_BATCH]
                    named = {parts.mark_names[k]: names[k] for k in own[batch.parts].tolist()}
                    _write_solids(folder, head, named, parts.kind, material, template, batch)


def _write_solids(
    folder: Path,
    head: _Head,
    names: dict[str, str],
    kind: Kind[Any],
    material: Material,
    of: Template,
    batch: SolidArray,
) -> None:
    """Write a file for each mark, whose products have these names, of parts that differ only in the vertices of their
    solids; so one text serves as the template of all.
    """
    marks = list(names)
    numbers = solid_numbers(of, batch, marks)
    width, texts = numbers.shape[1], reals(numbers)
    template = _file_template(head, kind, material, of, width)
    for n, mark in enumerate(marks):
        check_name(mark)
        text = template % tuple(texts[n * width : (n + 1) * width])
        text = text.replace(MARK_HERE, string(mark)).replace(NAME_HERE, string(names[mark]))
        (folder / f"{mark}.step").write_bytes(text.encode("ascii"))


@lru_cache(maxsize=256)
def _file_template(head: _Head, kind: Kind[Any], material: Material, of: Template, n_numbers: int) -> str:
    """The text of the file of one part, with %s in place of each of its numbers, and with stand-ins for its names."""
    stream = StringIO()
    schema, *texts = head
    writer = StepWriter(stream, MARK_HERE, schema, *(text.replace("%", "%%") for text in texts))
    material = replace(material, name=material.name.replace("%", "%%"))
    writer.write_shape(kind, MARK_HERE, NAME_HERE, material, of, ["%s"] * n_numbers)
    writer.end()
    return stream.getvalue()


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
