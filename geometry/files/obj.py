"""Wavefront OBJ: `v` and `f` make the mesh; indices count from 1, negative ones back from the last vertex."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.colours import ElementColours
from geometry.errors import MeshFileError, printable
from geometry.files.materials import Materials
from geometry.files.number_rows import likewise, parse_numbers, whole
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import Mesh

__all__ = ["obj_text", "read_obj"]

_TEXTURE_AND_NORMAL = re.compile(r"(?<=.)/\S*")
_IGNORED = {
    "l": "line",
    "p": "point",
    "curv": "curve",
    "surf": "surface",
}  # shapes of the file that the mesh will not have
_KEYWORDS_WITHOUT_SHAPE = {
    "vt", "vn", "vp", "g", "s", "mg", "o", "usemtl", "mtllib", "usemap", "maplib", "bevel", "c_interp", "d_interp",
    "lod", "shadow_obj", "trace_obj", "cstype", "deg", "bmat", "step", "parm", "trim", "hole", "scrv", "sp", "curv2",
    "end", "con", "ctech", "stech", "call", "csh", "bsp", "bzp", "cdc", "cdp", "res",
}  # fmt: skip
"""Keywords that do not affect the shape of polygons."""


@dataclass
class _Words:
    """The words of all vertices and faces, in flat lists."""

    coordinates: list[str] = field(default_factory=list)  # three a vertex
    vertex_lines: list[int] = field(default_factory=list)
    corners: list[str] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)  # corners of each face
    face_lines: list[int] = field(default_factory=list)
    vertices_above: list[int] = field(default_factory=list)  # number of vertices in the lines above each face
    ignored: Counter[str] = field(default_factory=Counter)
    unknown: list[tuple[int, str]] = field(default_factory=list)  # lines that begin with no keyword of OBJ


def read_obj(text: str) -> RawPolygons:
    """Vertices and faces of all objects and groups of a file together; every other keyword is ignored.

    Keywords may be in capitals. Lines, points and free-form shapes, and lines that begin with no keyword of OBJ, are
    reported. Messages count vertices and faces from 1, in the order of their lines.
    Raises MeshFileError where a coordinate or an index cannot be read.
    """
    words = _sorted(text)
    positions = parse_numbers(words.coordinates, np.repeat(integers(words.vertex_lines), 3)).reshape(-1, 3)
    sizes = integers(words.sizes)
    lines = np.repeat(integers(words.face_lines), sizes)
    given = whole(parse_numbers(words.corners, lines), lines, "a vertex index of a face")
    above = np.repeat(integers(words.vertices_above), sizes)
    _check_indices(given, above, lines)
    ignored = [
        f"{words.ignored[word]} {name} elements ignored" for word, name in _IGNORED.items() if words.ignored[word]
    ]
    if words.unknown:
        line, word = words.unknown[0]
        count = len(words.unknown)
        ignored.append(
            f"{count} line{'s' * (count > 1)} ignored that begin{'s' * (count == 1)} with no keyword of OBJ, such as "
            f"line {line} with '{printable(word)}'"
        )
    corners = np.where(given > 0, given - 1, above + given)
    return RawPolygons.from_arrays(positions, corners, sizes, count_from=1, mended=tuple(ignored))


def obj_text(mesh: Mesh, colours: ElementColours | None = None, materials: Materials | None = None) -> str:
    """A mesh as OBJ, coordinates with the fewest digits that are read back as the same double.

    Colours of vertices follow their coordinates in the same line, where many programs read them; faces have their
    materials.
    """
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    faces = ["f " + " ".join(str(vertex + 1) for vertex in face.tolist()) for face in mesh.faces]
    if materials is not None:
        names = materials.of_faces
        changes = [True, *(name != before for before, name in pairwise(names))]
        faces = [
            f"usemtl {name}\n{face}" if change else face
            for name, change, face in zip(names, changes, faces, strict=True)
        ]
        lines = [f"mtllib {materials.library}", *lines]
    elif colours is not None:
        rgb = colours.rgb.tolist()
        lines = [
            f"{line} {red:.6f} {green:.6f} {blue:.6f}" for line, (red, green, blue) in zip(lines, rgb, strict=True)
        ]
    comment = [f"# {colours.comment}"] if colours and colours.comment else []
    return "\n".join([*comment, *lines, *faces]) + "\n"


def _sorted(text: str) -> _Words:
    found, too_short = _Words(), list[tuple[int, int, int]]()
    for line, words in _statements(text):
        match words[0].lower():
            case "v":
                if len(words) < 4:
                    too_short.append((line, len(found.vertex_lines) + 1, len(words) - 1))
                found.coordinates += words[1:4]
                found.vertex_lines.append(line)
            case "f" | "fo":  # fo in old files
                found.corners += words[1:]
                found.sizes.append(len(words) - 1)
                found.face_lines.append(line)
                found.vertices_above.append(len(found.vertex_lines))
            case keyword if keyword in _IGNORED:
                found.ignored[keyword] += 1
            case keyword if keyword not in _KEYWORDS_WITHOUT_SHAPE:
                found.unknown.append((line, words[0]))
    if too_short:
        line, vertex, count = too_short[0]
        lines = integers([line for line, _, _ in too_short])
        raise MeshFileError(
            f"line {line}: vertex {vertex} has {count} coordinates, 3 are needed (counted from 1); the file is cut off "
            f"or damaged{likewise(lines)}",
            elements=lines.tolist(),
        )
    if "/" in text:
        found.corners = [_TEXTURE_AND_NORMAL.sub("", word) for word in found.corners]
    return found


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and words of each statement; a line that ends in a backslash continues in the next."""
    unfinished = ""
    for number, line in enumerate(text.split("\n"), 1):
        statement = unfinished + line.partition("#")[0].rstrip()
        if statement.endswith("\\"):
            unfinished = statement[:-1] + " "
            continue
        unfinished = ""
        if words := statement.split():
            yield number, words
    if words := unfinished.split():
        yield number, words


def _check_indices(given: IntArray, above: IntArray, lines: IntArray) -> None:
    wrong = np.flatnonzero((given == 0) | (given < -above))
    if not len(wrong):
        return
    line, index, count = int(lines[wrong[0]]), int(given[wrong[0]]), int(above[wrong[0]])
    reason = "OBJ counts vertices from 1" if index == 0 else f"counted back there are {count} vertices above it"
    raise MeshFileError(
        f"line {line}: a face names vertex {index}, but {reason}; correct the index{likewise(lines[wrong])}",
        elements=np.unique(lines[wrong]).tolist(),
        value=index,
    )
