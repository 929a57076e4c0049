"""STEP files of a finished folder against each other, against their own figures, and against the tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from fabkit.formats.finished.part_geometry import REFERENCE, PartSolid, measured
from fabkit.formats.step.entities import FIRST_FREE_ID
from fabkit.parts import Ragged, blanks
from fabkit.production import MARK_POINTS
from geometry.arrays import FloatArray

__all__ = ["PartFile", "check_centres", "check_mark_points", "check_model", "check_part", "part_file"]

COORDINATE_TOLERANCE_MM, DIRECTION_TOLERANCE = 0.0011, 2e-9
"""Largest difference of what is written in tables with 3 decimals, in mm, and of unit vectors with 9 decimals."""
POINT_TOLERANCE_MM = 1e-8
"""Largest difference in mm of a corner with 9 decimals from that of a part file."""
LEAST_CORNERS = 4
"""Number of points that are written of a mark at least: of a round bar both rims and their centres."""
MASS_TOLERANCE_KG = 0.00051
"""Largest difference in kg of a mass with 3 decimals."""
_INSTANCE = re.compile(
    r"^#\d+=CARTESIAN_POINT\('',\(([^)]*)\)\);\n#\d+=DIRECTION\('',\(([^)]*)\)\);\n#\d+=DIRECTION\('',\(([^)]*)\)\);\n"
    r"#\d+=AXIS2[^\n]*\n#\d+=ITEM[^\n]*\n[^\n]*\n#\d+=NEXT_ASSEMBLY_USAGE_OCCURRENCE\('([^']*)','([^']*)','',#\d+,#(\d+),\$\);$",
    re.MULTILINE,
)
_END = "\nENDSEC;\nEND-ISO-10303-21;\n"

_STATED = re.compile(r"(?:_MEASURE\(|'centre point',\()([^()]*)\)")
STATED_ROUNDING = 1e-11
"""Largest difference of a stated volume, area or coordinate of a centre from the same in another file, over 1 and over
its size: sums that are added up in another order, as parts are written together with others."""

Block = tuple[str, bytes, FloatArray]
"""Entities without their references and stated measures, those references, counted from the first entity, and the
measures."""


@dataclass(frozen=True)
class PartFile:
    """A part file as read. block: its product; around: all other entities, without references; header; solid."""

    mark: str
    block: Block
    around: frozenset[str]
    header: str
    solid: PartSolid

    @property
    def blank(self) -> FloatArray:
        """(k, 2) the outline from which a panel is cut."""
        return blanks(*(Ragged.of([side], shape=(2,)) for side in (self.solid.outline, self.solid.upper))).values


def part_file(contents: Contents, name: str) -> PartFile:
    """Read a part file; its figures are checked against its own faces. Raises FolderError with what is wrong."""
    text, mark = contents.text(name), name.removeprefix("parts/").removesuffix(".step")
    head, found, data = text.partition("DATA;\n")
    if not found or not data.endswith(_END):
        raise FolderError(f"{name} is no complete STEP file")
    before, first, block = data.partition("=PRODUCT_DEFINITION('design'")
    if not first or f"PRODUCT('{mark}'," not in text or f"MANIFOLD_SOLID_BREP('{mark}'," not in text:
        raise FolderError(f"{name} does not hold the part {mark}")
    try:
        solid = measured(name, data.removesuffix(_END).replace(f"'{mark}", "'"))
    except (ValueError, KeyError, IndexError):
        raise FolderError(f"{name} has an entity that cannot be read") from None
    around, _, number = before.rpartition("\n#")
    own = _relative(f"#{number}{first}{block.removesuffix(_END)}", int(number))
    others = frozenset(REFERENCE.sub("#", around).splitlines())
    return PartFile(mark, own, others, head.replace(f"'{mark}'", "''"), solid)


def _relative(block: str, first: int) -> Block:
    """References counted from the first entity of the block; those to what files number differently are alike."""
    texts = REFERENCE.split(block)
    numbers = np.array(texts[1::2], dtype=np.int64)
    last = first + block.count("\n")
    inside = (numbers >= first) & (numbers <= last)
    counted = np.where(inside, numbers - first, np.where(numbers < FIRST_FREE_ID, -2 - numbers, -1))
    bare = "#".join(texts[::2])
    stated = [float(number) for found in _STATED.findall(bare) for number in found.split(",")]
    return _STATED.sub("", bare), counted.tobytes(), np.array(stated)


def _same(one: Block, other: Block) -> bool:
    return one[:2] == other[:2] and np.allclose(one[2], other[2], rtol=STATED_ROUNDING, atol=STATED_ROUNDING)


def check_part(contents: Contents, part: PartFile, row: dict[str, str]) -> Iterator[str]:
    """A part against its row in the table of marks."""
    if abs(part.solid.mass_kg - float(row["Mass each (kg)"])) > MASS_TOLERANCE_KG:
        yield f"parts/{part.mark}.step has {part.solid.mass_kg:.3f} kg, its table {row['Mass each (kg)']} kg"


def check_model(contents: Contents, parts: dict[str, PartFile]) -> Iterator[str]:
    """model.step against the part files and the table of placements."""
    text = contents.text("model.step")
    if not text.endswith("ENDSEC;\nEND-ISO-10303-21;\n"):
        yield "model.step is no complete STEP file"
        return
    texts = REFERENCE.split(text)
    defined = [number for number, after in zip(texts[1::2], texts[2::2], strict=True) if after.startswith("=")]
    if len(set(defined)) != len(defined):
        yield "model.step has a number twice"
    missing = set(texts[1::2]) - set(defined)
    if missing:
        yield f"model.step refers to #{min(map(int, missing))}, which it does not have"
    lines = text.splitlines()
    bare = set("#".join(texts[::2]).splitlines())
    marks: dict[int, str] = {}
    for number, line in enumerate(lines):
        if "=PRODUCT_DEFINITION('design'" not in line:
            continue
        named = re.search(r"=PRODUCT\('([^']*)'", "\n".join(lines[number : number + 6]))
        first, mark = int(line[1:].partition("=")[0]), named[1] if named else ""
        marks[first] = mark
        if mark in parts:
            count = parts[mark].block[0].count("\n") + 1
            if not _same(_relative("\n".join(lines[number : number + count]), first), parts[mark].block):
                yield f"the part {mark} in model.step is not that of parts/{mark}.step"
            if not parts[mark].around <= bare:
                yield f"material, units or colour of parts/{mark}.step are not those of model.step"
    yield from _check_instances(contents, text, marks)
    for mark in parts.keys() - marks.values():
        yield f"model.step lacks the part {mark}"


def check_centres(contents: Contents, parts: dict[str, PartFile]) -> Iterator[str]:
    """The centres of mass in the table of placements against those that the part files state."""
    rows = [row for row in contents.table("placements") if row["Mark"] in parts]
    if not rows:
        return
    own = np.array([parts[row["Mark"]].solid.centre for row in rows])
    origins, x, z, centres = (
        np.array([_vector(row, name, unit) for row in rows])
        for name, unit in (("Origin", " (mm)"), ("X axis", ""), ("Z axis", ""), ("Centre", " (mm)"))
    )
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    off = np.abs(origins + np.einsum("pi,pik->pk", own, axes) - centres).max(axis=1)
    for k in np.flatnonzero(off > 2 * COORDINATE_TOLERANCE_MM + DIRECTION_TOLERANCE * np.abs(own).max()).tolist():
        yield f"the centre of {rows[k]['Piece']} in placements.csv is {off[k]:.3f} mm off that of its part file"


def check_mark_points(contents: Contents, parts: dict[str, PartFile]) -> Iterator[str]:
    """The points by which marks are recognised against the corners and faces of the part files."""
    tables = {row["Mark"]: (group, row) for group, table in contents.tables_of_marks() for row in table}
    points: dict[str, dict[str, list[list[float]]]] = {mark: {what: [] for what in MARK_POINTS} for mark in tables}
    earlier: Counter[str] = Counter()  # of marks that no piece has any more
    for number, row in enumerate(contents.table("mark_points"), start=2):
        point = [float(row[axis]) for axis in "xyz"]
        if row["Mark"] not in tables:
            earlier[row["Mark"]] += 1
        if row["Mark"] in tables:
            points[row["Mark"]][row["Point"]].append(point)
            group, own = tables[row["Mark"]]
            wanted = ", ".join(own[column] for column in ("Material", "Section") if own.get(column))
            is_alike = row["Material"] == wanted if "Section" in own else row["Material"].startswith(wanted)
            if row["Group"] != group or not is_alike:
                said = f"{row['Group']} of {row['Material']}"
                yield f"row {number} of mark_points.csv has {said}, and {row['Mark']} is one of {group} of {wanted}"
    for mark, count in earlier.items():
        if count < LEAST_CORNERS:
            yield f"mark_points.csv has {count} points of {mark}, which no table has"
    for mark, found in points.items():
        if mark not in parts:
            continue
        corners, directions, *first = (np.array(each).reshape(-1, 3) for each in found.values())
        solid = parts[mark].solid
        if first[0].size and [each.shape for each in first] != [corners.shape, directions.shape]:
            yield f"mark_points.csv lacks points of the first shape of {mark}"
        if len(solid.rounds):
            is_whole = _are_of_round(corners, solid)
        else:
            is_whole = corners.shape == solid.corners.shape and bool(
                np.abs(corners - solid.corners).max() <= POINT_TOLERANCE_MM
            )
        if not is_whole:
            yield f"mark_points.csv does not have the corners of {mark}"
        off = np.abs(np.linalg.norm(directions, axis=1) - 1)
        if not len(solid.rounds) and len(directions):
            off = np.maximum(off, np.abs(directions[:, None] - solid.normals).max(axis=2).min(axis=1))
        if off.max(initial=0.0) > 2 * POINT_TOLERANCE_MM:
            yield f"mark_points.csv does not have the directions of the facets of {mark}"
        n_facets = int(tables[mark][1].get("Valence") or 0)
        if len(directions) != n_facets:
            yield f"mark_points.csv has {len(directions)} directions of {mark}, which has {n_facets} facets"


def _are_of_round(points: FloatArray, solid: PartSolid) -> bool:
    """Whether the points of a solid with rounds are its corners, or not farther from the axis of a round than the sharp
    corner that it replaces."""
    if not len(points):
        return False
    near = np.abs(points[:, None] - solid.corners).max(axis=2).min(axis=1, initial=np.inf) <= POINT_TOLERANCE_MM
    from_axis = np.cross(points[:, None] - solid.rounds[:, :3], solid.rounds[:, 3:6])
    near |= (np.linalg.norm(from_axis, axis=2) <= np.sqrt(2) * solid.rounds[:, 6] + POINT_TOLERANCE_MM).any(axis=1)
    return bool(near.all())


def _check_instances(contents: Contents, text: str, marks: dict[int, str]) -> Iterator[str]:
    placements = {row["Piece"]: row for row in contents.table("placements")}
    origin = np.array(contents.manifest["origin"]["mm"], dtype=float)
    seen: Counter[str] = Counter()
    for point, x, z, name, same, product in _INSTANCE.findall(text):
        row = placements.get(name)
        seen[name] += 1
        if row is None or name != same or marks.get(int(product)) != row["Mark"]:
            yield f"model.step has a piece {name}, which the tables do not have with that mark"
            continue
        frame = [np.array([float(number) for number in words.split(",")]) for words in (point, x, z)]
        tables = [_vector(row, "Origin", " (mm)") - origin, _vector(row, "X axis"), _vector(row, "Z axis")]
        bounds = (COORDINATE_TOLERANCE_MM, DIRECTION_TOLERANCE, DIRECTION_TOLERANCE)
        if any(np.abs(one - other).max() > bound for one, other, bound in zip(frame, tables, bounds, strict=True)):
            yield f"{name} is not where placements.csv has it"
    for name in placements:
        if seen[name] != 1:
            yield f"model.step has {name} {seen[name]} times"


def _vector(row: dict[str, str], name: str, unit: str = "") -> FloatArray:
    return np.array([float(row[f"{name} {axis}{unit}"]) for axis in "xyz"])
