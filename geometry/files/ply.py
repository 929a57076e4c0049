"""Stanford PLY, as text and in both binary orders: a header that describes its elements, then their data."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import accumulate
from struct import Struct

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.colours import ElementColours
from geometry.errors import MeshFileError, printable
from geometry.files.encoding import decoded, spelled_out
from geometry.files.number_rows import MAX_COUNT_DIGITS, NumberRows, whole, word_lines
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import Mesh

__all__ = ["ply_text", "read_ply"]

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
_FACE_LISTS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    """A value of `type`; or a list of such values after their number, which is of `count_type`."""

    name: str
    type: str
    count_type: str | None = None


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


class _TextData:
    """The numbers of a text body; a place is the position of a number."""

    def __init__(self, body: bytes, first_line: int) -> None:
        self._numbers = NumberRows.from_words(word_lines(decoded(body), first_line=first_line))
        self._values = self._numbers.values.tolist()
        self.end = len(self._values)

    def width(self, type_: str) -> int:
        return 1

    def count(self, place: int, type_: str) -> float:
        value: float = self._values[place]
        return value

    def floats(self, places: IntArray, type_: str) -> FloatArray:
        return self._numbers.values[places]

    def indices(self, places: IntArray, type_: str, faces: IntArray) -> IntArray:
        return whole(self._numbers.values[places], self._numbers.value_lines[places], "a vertex index of a face")


class _BinaryData:
    """The bytes of a binary body; a place is the position of a byte."""

    def __init__(self, body: bytes, order: str) -> None:
        self._bytes = np.frombuffer(body, dtype=np.uint8)
        self._body, self._order = body, order
        self._structs = {name: Struct(order + np.dtype(code).char) for name, code in _TYPES.items()}
        self.end = len(body)

    def width(self, type_: str) -> int:
        return np.dtype(_TYPES[type_]).itemsize

    def count(self, place: int, type_: str) -> float:
        value: float = self._structs[type_].unpack_from(self._body, place)[0]
        return value

    def floats(self, places: IntArray, type_: str) -> FloatArray:
        with np.errstate(invalid="ignore"):  # NaN is refused later
            values: FloatArray = self._gather(places, type_).astype(np.float64)
        return values

    def indices(self, places: IntArray, type_: str, faces: IntArray) -> IntArray:
        return whole(self.floats(places, type_), faces, "a vertex index", "face")

    def _gather(self, places: IntArray, type_: str) -> np.ndarray:
        chosen = self._bytes[places[:, None] + np.arange(self.width(type_))]
        return np.ascontiguousarray(chosen).view(self._order + _TYPES[type_])[:, 0]


_Data = _TextData | _BinaryData


def read_ply(data: bytes) -> RawPolygons:
    """Vertices (x, y, z) and faces (vertex_indices) of a file; all other elements and properties are ignored.
    Words of the header may be in capitals. Messages count vertices and faces from 0.

    Raises MeshFileError where the header cannot be read or lacks these, and where the data end too early.
    """
    data = spelled_out(data)
    format_, elements, body_start, n_header_lines = _header(data)
    _check_elements(elements)
    body = data[body_start:]
    values: _Data = _TextData(body, n_header_lines + 1) if format_ == "ascii" else _BinaryData(body, _ORDERS[format_])
    vertices, corners, sizes = np.empty((0, 3)), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    place = 0
    for element in elements:
        places, counts, place = _walk(element, values, place)
        types = {item.name: item.type for item in element.properties}
        if element.name == "vertex":
            vertices = np.stack([values.floats(places[axis], types[axis]) for axis in "xyz"], axis=1)
        elif element.name == "face":
            lists = {item.name for item in element.properties if item.count_type is not None}
            name = next(name for name in _FACE_LISTS if name in lists)
            sizes = counts[name]
            within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
            starts = np.repeat(places[name], sizes) + within * values.width(types[name])
            corners = values.indices(starts, types[name], np.repeat(np.arange(element.count), sizes))
    return RawPolygons.from_arrays(vertices, corners, sizes)


def ply_text(mesh: Mesh, colours: ElementColours | None = None) -> str:
    """A mesh as PLY text, coordinates with the fewest digits that are read back as the same double; colours in 8
    bits."""
    size_type = "uchar" if mesh.combinatorics.face_sizes.max() < 256 else "uint"
    channels = [f"property uchar {channel}" for channel in ("red", "green", "blue")]
    header = ["ply", "format ascii 1.0"]
    if colours and colours.comment:
        header.append(f"comment {colours.comment}")
    header += [f"element vertex {mesh.n_vertices}", *(f"property double {axis}" for axis in "xyz")]
    vertices = [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    faces = [" ".join(map(str, [len(face), *face.tolist()])) for face in mesh.faces]
    if colours and colours.on == "vertices":
        header += channels
        vertices = _with_columns(vertices, colours)
    header += [f"element face {mesh.n_faces}", f"property list {size_type} int vertex_indices"]
    if colours and colours.on == "faces":
        header += channels
        faces = _with_columns(faces, colours)
    return "\n".join([*header, "end_header", *vertices, *faces]) + "\n"


def _with_columns(lines: list[str], colours: ElementColours) -> list[str]:
    rgb = colours.eight_bits.tolist()
    return [f"{line} {red} {green} {blue}" for line, (red, green, blue) in zip(lines, rgb, strict=True)]


def _header(data: bytes) -> tuple[str, list[_Element], int, int]:
    """Format, elements, the position of the first byte of the body, and the number of lines of the header."""
    start = re.match(rb"\s*ply[ \t]*(\r\n|\n|\r)", data, re.IGNORECASE)
    if start is None:
        raise MeshFileError("a PLY file begins with a line 'ply', this one does not")
    end = re.compile(rb"[\r\n]end_header[ \t]*(?:%b|$)" % start[1], re.IGNORECASE).search(data)
    if end is None:
        raise MeshFileError("the PLY header does not end: there is no line 'end_header'; the file is cut off")
    lines = data[: end.end()].decode("ascii", errors="replace").splitlines()
    format_, elements = "", list[_Element]()
    for number, line in enumerate(lines, 1):
        match line.lower().split():
            case ["format", ("ascii" | "binary_little_endian" | "binary_big_endian") as found, "1.0"]:
                format_ = found
            case ["element", name, count] if count.isdecimal() and len(count) <= MAX_COUNT_DIGITS:
                elements.append(_Element(name, int(count)))
            case ["property", "list", count_type, type_, name] if elements and {count_type, type_} <= _TYPES.keys():
                elements[-1].properties.append(_Property(name, type_, count_type))
            case ["property", type_, name] if elements and type_ in _TYPES:
                elements[-1].properties.append(_Property(name, type_))
            case [] | ["ply"] | ["end_header"] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise MeshFileError(
                    f"line {number}: '{printable(line)}' is not a line of a PLY header", elements=[number]
                )
    if not format_:
        raise MeshFileError("the PLY header does not say its format: ascii, binary_little_endian or binary_big_endian")
    return format_, elements, end.end(), len(lines)


def _check_elements(elements: list[_Element]) -> None:
    """Raise MeshFileError unless the header has all needed elements and properties, each once."""
    for element in elements:
        if element.name in ("vertex", "face") and sum(other.name == element.name for other in elements) > 1:
            raise MeshFileError(f"the PLY header describes its elements '{element.name}' twice: write the file again")
        needed = {"vertex": ("x", "y", "z"), "face": _FACE_LISTS}.get(element.name, ())
        for name in needed:
            if sum(item.name == name for item in element.properties) > 1:
                raise MeshFileError(
                    f"the PLY header gives its elements '{element.name}' two properties '{name}': write the file again"
                )
        scalars = {item.name for item in element.properties if item.count_type is None}
        lists = {item.name for item in element.properties if item.count_type is not None}
        if element.name == "vertex" and not scalars >= {"x", "y", "z"}:
            raise MeshFileError("the PLY header gives its vertices no x, y and z: three coordinates are needed")
        if element.name == "face" and not lists & set(_FACE_LISTS):
            raise MeshFileError("the PLY header gives its faces no list vertex_indices: they have no corners")


def _walk(element: _Element, data: _Data, place: int) -> tuple[dict[str, IntArray], dict[str, IntArray], int]:
    """For each property the places where its values begin in each row, and their numbers; and the place after the last
    row."""
    widths = [data.width(item.type) for item in element.properties]
    if not element.properties:
        return {}, {}, place
    if all(item.count_type is None for item in element.properties):
        stride = sum(widths)
        end = place + stride * element.count
        if end > data.end:
            raise _cut_off(element, (data.end - place) // stride)
        first = place + stride * np.arange(element.count)
        offsets = accumulate(widths, initial=0)
        starts = {item.name: first + offset for item, offset in zip(element.properties, offsets, strict=False)}
        return starts, {item.name: np.ones(element.count, dtype=np.int64) for item in element.properties}, end
    places = [list[int]() for _ in element.properties]
    counts = [list[int]() for _ in element.properties]
    for row in range(element.count):
        for index, item in enumerate(element.properties):
            count = 1
            if item.count_type is not None:
                if place + data.width(item.count_type) > data.end:
                    raise _cut_off(element, row)
                count = _count(data.count(place, item.count_type), element, row)
                place += data.width(item.count_type)
            places[index].append(place)
            counts[index].append(count)
            place += count * widths[index]
        if place > data.end:
            raise _cut_off(element, row)
    names = [item.name for item in element.properties]
    found = [
        {name: np.array(row, dtype=np.int64) for name, row in zip(names, rows, strict=True)}
        for rows in (places, counts)
    ]
    return found[0], found[1], place


def _count(value: float, element: _Element, row: int) -> int:
    if not (value >= 0 and float(value).is_integer()):
        raise MeshFileError(
            f"{printable(element.name)} {row} announces a list of {value:g} values: a whole number, not negative, is "
            "needed (counted from 0)"
        )
    return int(value)


def _cut_off(element: _Element, row: int) -> MeshFileError:
    return MeshFileError(
        f"the file is cut off: its header announces {element.count} elements '{printable(element.name)}', "
        f"and number {row} (counted from 0) is not complete",
        elements=[row],
        value=row,
        bound=element.count,
    )
