"""STEP files of a finished folder against each other, against their own figures, and against the tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from fabkit.formats.step.entities import FIRST_FREE_ID
from fabkit.parts import Ragged, blanks
from geometry.arrays import FloatArray

__all__ = ["PartFile", "check_model", "check_part", "part_file"]

VOLUME_TOLERANCE, FACE_TOLERANCE_MM = 1e-9, 1e-6
"""Largest relative difference of a stated volume or area, and largest distance in mm of a corner from its face, that
is put down to rounding."""
COORDINATE_TOLERANCE_MM, DIRECTION_TOLERANCE = 0.0011, 2e-9
"""Largest difference of what is written in tables with 3 decimals, in mm, and of unit vectors with 9 decimals."""
MASS_TOLERANCE_KG = 0.00051
"""Largest difference in kg of a mass with 3 decimals."""
_ENTITY = re.compile(r"^#(\d+)=(.*);$", re.MULTILINE)
_REFERENCE = re.compile(r"#(\d+)")
_NUMBERS = re.compile(r"-?\d+\.\d*(?:E-?\d+)?")
_INSTANCE = re.compile(
    r"^#\d+=CARTESIAN_POINT\('',\(([^)]*)\)\);\n#\d+=DIRECTION\('',\(([^)]*)\)\);\n#\d+=DIRECTION\('',\(([^)]*)\)\);\n"
    r"#\d+=AXIS2[^\n]*\n#\d+=ITEM[^\n]*\n[^\n]*\n#\d+=NEXT_ASSEMBLY_USAGE_OCCURRENCE\('([^']*)','([^']*)','',#\d+,#(\d+),\$\);$",
    re.MULTILINE,
)


@dataclass(frozen=True)
class PartFile:
    """A part file as read. block: its product with numbers counted from its first entity; around: all other entities,
    without references, and the header; outline: points (k, 2) of its corners at z = 0, in their order; upper: of a
    plate, those of its other side."""

    mark: str
    block: str
    around: frozenset[str]
    header: str
    mass_kg: float
    outline: FloatArray
    upper: FloatArray

    @property
    def blank(self) -> FloatArray:
        """(k, 2) the outline from which a panel is cut."""
        return blanks(*(Ragged.of([side], shape=(2,)) for side in (self.outline, self.upper))).values


def part_file(contents: Contents, name: str) -> PartFile:
    """Read a part file; its figures are checked against its own faces. Raises FolderError with what is wrong."""
    text, mark = contents.text(name), name.removeprefix("parts/").removesuffix(".step")
    head, found, data = text.partition("DATA;\n")
    entities = {int(number): entity for number, entity in _ENTITY.findall(data)}
    lines = data.splitlines()
    if not found or len(entities) != len(lines) - 2 or lines[-2:] != ["ENDSEC;", "END-ISO-10303-21;"]:
        raise FolderError(f"{name} is no complete STEP file")
    referred = {int(number) for entity in entities.values() for number in _REFERENCE.findall(entity)}
    if not referred <= entities.keys():
        raise FolderError(f"{name} refers to #{min(referred - entities.keys())}, which it does not have")
    first = next((number for number, entity in entities.items() if entity.startswith("PRODUCT_DEFINITION('design'")), 0)
    own = {number: entity for number, entity in entities.items() if number >= first}
    if not first or f"PRODUCT('{mark}'," not in text or f"MANIFOLD_SOLID_BREP('{mark}'," not in text:
        raise FolderError(f"{name} does not hold the part {mark}")
    try:
        mass, outline, upper = _measured(name, entities)
    except (ValueError, KeyError, IndexError):
        raise FolderError(f"{name} has an entity that cannot be read") from None
    others = frozenset(_REFERENCE.sub("#", entity) for number, entity in entities.items() if number < first)
    block = _relative("\n".join(own.values()), first, len(own))
    return PartFile(mark, block, others, head.replace(f"'{mark}'", "''"), mass, outline, upper)


def _relative(block: str, first: int, count: int) -> str:
    """References counted from the first entity of the block; those to what files number differently are alike."""

    def counted(found: re.Match[str]) -> str:
        number = int(found[1])
        return f"#+{number - first}" if first <= number < first + count else found[0] if number < FIRST_FREE_ID else "#"

    return _REFERENCE.sub(counted, block)


def _measured(name: str, entities: dict[int, str]) -> tuple[float, FloatArray, FloatArray]:
    """Mass in kg from the stated volume and density, and the outlines of both sides; after comparing volume, area and
    planes."""

    def refs(number: int) -> list[int]:
        return [int(found) for found in _REFERENCE.findall(entities[number])]

    def numbers(number: int) -> FloatArray:
        return np.array([float(found) for found in _NUMBERS.findall(entities[number])])

    stated: dict[str, float] = {}
    for entity in entities.values():
        if entity.startswith("MEASURE_REPRESENTATION_ITEM"):
            stated[entity.split("'")[1]] = float(_NUMBERS.findall(entity)[0])
    volume = area = 0.0
    is_plane = not any(entity.startswith("CYLINDRICAL_SURFACE") for entity in entities.values())
    for entity in list(entities.values()) if is_plane else []:
        if not entity.startswith("ADVANCED_FACE"):
            continue
        *bounds, plane = [int(found) for found in _REFERENCE.findall(entity)]
        normal = numbers(refs(refs(plane)[0])[1])
        vector = np.zeros(3)
        for bound in bounds:
            ring = []
            for oriented in refs(refs(bound)[0]):
                (edge,) = refs(oriented)
                start, end, line = refs(edge)
                tail = start if entities[oriented].endswith(".T.)") else end
                ring.append(numbers(refs(tail)[0]))
                through, pointing = refs(line)
                along = numbers(refs(end)[0]) - numbers(refs(start)[0])
                unit = numbers(refs(pointing)[0])
                if through != refs(start)[0] or np.abs(np.cross(along, unit)).max() > FACE_TOLERANCE_MM:
                    raise FolderError(f"{name}: an edge is off its line")
                if float(_NUMBERS.findall(entities[pointing])[0]) != 1.0 or abs(unit @ unit - 1) > VOLUME_TOLERANCE:
                    raise FolderError(f"{name}: the direction of an edge is no unit vector")
            points = np.array(ring)
            vector += np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) / 2
            off = np.abs((points - numbers(refs(refs(plane)[0])[0])) @ normal).max()
            if off > FACE_TOLERANCE_MM or abs(normal @ normal - 1) > VOLUME_TOLERANCE:
                raise FolderError(f"{name}: a face is {off:.3g} mm off its plane")
        area += float(vector @ normal)
        volume += float(points[0] @ normal) * float(vector @ normal) / 3
    for key, found in (("volume measure", volume), ("surface area measure", area)):
        if is_plane and abs(found - stated[key]) > VOLUME_TOLERANCE * abs(stated[key]):
            raise FolderError(f"{name} states a {key} of {stated[key]:.6g}, its faces have {found:.6g}")
    mass = stated["volume measure"] * stated["density measure"] * 1e-6
    vertices = [number for number, entity in entities.items() if entity.startswith("VERTEX_POINT")]
    points = np.array([numbers(refs(number)[0]) for number in vertices]).reshape(-1, 3)
    lower, upper = (points[points[:, 2] == level, :2] for level in (0.0, points[:, 2].max()))
    is_plate = len(points) == 2 * len(lower) == 2 * len(upper)
    return mass, lower, upper if is_plate else lower


def check_part(contents: Contents, part: PartFile, row: dict[str, str]) -> Iterator[str]:
    """A part against its row in the table of marks."""
    if abs(part.mass_kg - float(row["Mass each (kg)"])) > MASS_TOLERANCE_KG:
        yield f"parts/{part.mark}.step has {part.mass_kg:.3f} kg, its table {row['Mass each (kg)']} kg"


def check_model(contents: Contents, parts: dict[str, PartFile]) -> Iterator[str]:
    """model.step against the part files and the table of placements."""
    text = contents.text("model.step")
    if not text.endswith("ENDSEC;\nEND-ISO-10303-21;\n"):
        yield "model.step is no complete STEP file"
        return
    defined = [int(number) for number in re.findall(r"^#(\d+)=", text, re.MULTILINE)]
    if len(set(defined)) != len(defined):
        yield "model.step has a number twice"
    missing = {int(number) for number in _REFERENCE.findall(text)} - set(defined)
    if missing:
        yield f"model.step refers to #{min(missing)}, which it does not have"
    lines = text.splitlines()
    bare = {_REFERENCE.sub("#", line.partition("=")[2][:-1]) for line in lines}
    marks: dict[int, str] = {}
    for number, line in enumerate(lines):
        if "=PRODUCT_DEFINITION('design'" not in line:
            continue
        named = re.search(r"=PRODUCT\('([^']*)'", "\n".join(lines[number : number + 6]))
        first, mark = int(line[1:].partition("=")[0]), named[1] if named else ""
        marks[first] = mark
        if mark in parts:
            count = parts[mark].block.count("\n") + 1
            block = "\n".join(line.partition("=")[2][:-1] for line in lines[number : number + count])
            if _relative(block, first, count) != parts[mark].block:
                yield f"the part {mark} in model.step is not that of parts/{mark}.step"
            if not parts[mark].around <= bare:
                yield f"material, units or colour of parts/{mark}.step are not those of model.step"
    yield from _check_instances(contents, text, marks)
    for mark in parts.keys() - marks.values():
        yield f"model.step lacks the part {mark}"


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
