"""Geomview OFF: counts, vertices, faces as one stream of numbers, or one element a line with extra columns."""

from __future__ import annotations

import re

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.colours import ElementColours
from geometry.errors import MeshFileError, printable
from geometry.files.number_rows import MAX_COUNT_DIGITS, NumberRows, likewise, whole, word_lines
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import Mesh

__all__ = ["off_text", "read_off"]

_HEADER = re.compile(r"(ST)?C?N?(?P<homogeneous>4)?(?P<any>n)?OFF")


def read_off(text: str) -> RawPolygons:
    """Vertices and faces of a file whose header is OFF, STOFF, COFF, NOFF, 4OFF or a mixture of these, or missing.

    The header may be in small letters. Faces may extend over several lines or share a line. If the numbers of the file
    do not fit exactly, each vertex and each face is read from a separate line, and further numbers (colours, normals,
    texture) are ignored. If no index is 0 and the largest one is the number of vertices, indices count from 1. Raises
    MeshFileError where the header cannot be read, a word is not a number, or the file ends too early.
    """
    rows = word_lines(text)
    homogeneous, plain, rows = _header(rows)
    n_vertices, n_faces, line = _counts(rows)
    rest = [(line, rows[0][1][3:])] if rows[0][1][3:] else []
    numbers = NumberRows.from_words(rest + rows[1:])
    found = _stream(numbers, n_vertices, n_faces) if plain else None
    vertices, corners, sizes = found or _lines(numbers, n_vertices, n_faces, line, 4 if homogeneous else 3)
    if homogeneous:
        at_infinity = np.flatnonzero(vertices[:, 3] == 0)
        if len(at_infinity):
            raise MeshFileError(
                f"vertex {at_infinity[0]} of the 4OFF file is at infinity: its fourth coordinate is "
                f"0{likewise(at_infinity, 'vertex')} (vertices counted from 0)",
                elements=at_infinity.tolist(),
            )
        with np.errstate(over="ignore", invalid="ignore"):  # infinity and NaN are refused later
            vertices = vertices[:, :3] / vertices[:, 3:]
    if len(corners) and corners.min() >= 1 and corners.max() == n_vertices:
        sentence = "face indices started at 1; counted from 0"
        return RawPolygons.from_arrays(vertices, corners - 1, sizes, count_from=1, mended=(sentence,))
    return RawPolygons.from_arrays(vertices, corners, sizes)


def off_text(mesh: Mesh, colours: ElementColours | None = None) -> str:
    """A mesh as OFF, coordinates with the fewest digits that are read back as the same double.
    Colours of vertices make it a COFF file, with red, green, blue and opacity from 0 to 255 after the coordinates.
    Colours of faces follow their corners as fractions, which cannot be mistaken for the number of corners of a face.
    """
    vertices = [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    faces = [" ".join(map(str, [len(face), *face.tolist()])) for face in mesh.faces]
    header = "OFF"
    if colours and colours.on == "vertices":
        header, rgb = "COFF", colours.eight_bits.tolist()
        vertices = [f"{line} {red} {green} {blue} 255" for line, (red, green, blue) in zip(vertices, rgb, strict=True)]
    elif colours:
        fractions = colours.rgb.tolist()
        faces = [f"{line} {r:.6f} {g:.6f} {b:.6f}" for line, (r, g, b) in zip(faces, fractions, strict=True)]
    comment = [f"# {colours.comment}"] if colours and colours.comment else []
    counts = f"{mesh.n_vertices} {mesh.n_faces} {mesh.n_edges}"
    return "\n".join([header, *comment, counts, *vertices, *faces]) + "\n"


Rows = list[tuple[int, list[str]]]
Elements = tuple[FloatArray, IntArray, IntArray]  # vertices, corners, face sizes


def _header(rows: Rows) -> tuple[bool, bool, Rows]:
    """Whether vertices have a fourth coordinate, whether they have no further columns, and the rows from the counts
    on."""
    if not rows:
        raise MeshFileError("the file is empty: there is no OFF header and no mesh")
    line, words = rows[0]
    word = words[0] if words[0].endswith("nOFF") else words[0].upper()  # n: dimensions, N: normals
    header = _HEADER.fullmatch(word)
    if header is None:
        if not words[0].isdecimal():
            raise MeshFileError(
                f"line {line}: an OFF file begins with OFF, this one with '{printable(words[0])}'", elements=[line]
            )
        return False, True, rows
    binary = len(words) > 1 and words[1].upper() == "BINARY"
    if header["any"] or binary:
        kind = "binary" if binary else "n-dimensional"
        raise MeshFileError(f"line {line}: this OFF file is {kind}; save it as a plain one", elements=[line])
    rest = [(line, words[1:])] if words[1:] else []
    return header["homogeneous"] is not None, word == "OFF", rest + rows[1:]


def _counts(rows: Rows) -> tuple[int, int, int]:
    """Numbers of vertices and faces, and the number of their line."""
    if not rows:
        raise MeshFileError("the file ends after its header: the numbers of vertices and faces are missing")
    line, words = rows[0]
    if len(words) < 2 or not all(word.isdecimal() and len(word) <= MAX_COUNT_DIGITS for word in words[:3]):
        raise MeshFileError(
            f"line {line} should give the numbers of vertices, faces and edges, but is '{printable(' '.join(words))}'",
            elements=[line],
        )
    return int(words[0]), int(words[1]), line


def _stream(numbers: NumberRows, n_vertices: int, n_faces: int) -> Elements | None:
    """Elements that follow each other regardless of lines; None where this does not use all the numbers exactly."""
    values = numbers.values[3 * n_vertices :].tolist()
    sizes, position = [], 0
    for _ in range(n_faces):
        if position >= len(values) or not 0 <= values[position] < len(values):
            return None
        sizes.append(int(values[position]))
        position += sizes[-1] + 1
    if position != len(values) or 3 * n_vertices > len(numbers.values):
        return None
    size_array = np.array(sizes, dtype=np.int64)
    heads = 3 * n_vertices + np.cumsum(size_array + 1) - size_array - 1
    if not np.array_equal(numbers.values[heads], size_array):
        return None
    places = np.delete(np.arange(3 * n_vertices, len(numbers.values)), heads - 3 * n_vertices)
    vertices = numbers.values[: 3 * n_vertices].reshape(-1, 3)
    return vertices, _indices(numbers, places), size_array


def _lines(numbers: NumberRows, n_vertices: int, n_faces: int, header_line: int, n_columns: int) -> Elements:
    """Elements on one line each; numbers after the coordinates and after the corners are ignored."""
    if numbers.n_rows != n_vertices + n_faces:
        raise MeshFileError(
            f"line {header_line} announces {n_vertices} vertices and {n_faces} faces, but {numbers.n_rows} lines of "
            f"numbers follow: the file is {'cut off' if numbers.n_rows < n_vertices + n_faces else 'too long'}, or its "
            "header is wrong",
            value=numbers.n_rows,
            bound=n_vertices + n_faces,
        )
    starts, widths, lines = numbers.starts[:-1], numbers.widths, numbers.lines
    too_short = np.flatnonzero(widths[:n_vertices] < n_columns)
    if len(too_short):
        raise MeshFileError(
            f"line {lines[too_short[0]]}: vertex {too_short[0]} has {widths[too_short[0]]} coordinates, {n_columns} "
            f"are needed (counted from 0){likewise(lines[too_short])}",
            elements=lines[too_short].tolist(),
        )
    vertices = numbers.values[starts[:n_vertices, None] + np.arange(n_columns)]
    sizes = whole(numbers.values[starts[n_vertices:]], lines[n_vertices:], "the number of corners of a face")
    cut = np.flatnonzero((sizes < 0) | (sizes >= widths[n_vertices:]))
    if len(cut):
        face, row = int(cut[0]), int(cut[0]) + n_vertices
        raise MeshFileError(
            f"line {lines[row]}: face {face} should have {sizes[face]} corners, the line holds {widths[row] - 1}; "
            f"the file is cut off or damaged{likewise(lines[n_vertices + cut])} (faces counted from 0)",
            elements=lines[n_vertices + cut].tolist(),
        )
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return vertices, _indices(numbers, np.repeat(starts[n_vertices:] + 1, sizes) + within), sizes


def _indices(numbers: NumberRows, places: IntArray) -> IntArray:
    """The vertex indices at positions (n,) of the numbers."""
    return whole(numbers.values[places], numbers.value_lines[places], "a vertex index of a face")
