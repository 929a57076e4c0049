"""Wavefront OBJ: `v` and `f` make the mesh; indices count from 1, negative ones back from the last vertex."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import IntArray, integers
from geometry.errors import MeshFileError
from geometry.mesh.mesh import Mesh
from geometry.mesh.number_rows import parse_numbers, whole
from geometry.mesh.soup import PolygonSoup

__all__ = ["obj_text", "read_obj"]

_TEXTURE_AND_NORMAL = re.compile(r"/\S*")
_IGNORED = {"l": "line", "p": "point"}  # what a mesh might be missing without; other keywords say nothing of shape


@dataclass
class _Words:
    """The words of all vertices and faces, in flat lists."""

    coordinates: list[str] = field(default_factory=list)  # three a vertex
    vertex_lines: list[int] = field(default_factory=list)
    corners: list[str] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)  # corners of each face
    face_lines: list[int] = field(default_factory=list)
    above: list[int] = field(default_factory=list)  # vertices above each face
    ignored: Counter[str] = field(default_factory=Counter)


def read_obj(text: str) -> PolygonSoup:
    """Vertices and faces of all objects and groups of a file together; every other keyword is passed over.

    Sentences count vertices and faces from 1, in the order of their lines.
    Raises MeshFileError where a coordinate or an index cannot be read.
    """
    words = _sorted(text)
    positions = parse_numbers(words.coordinates, np.repeat(integers(words.vertex_lines), 3)).reshape(-1, 3)
    sizes = integers(words.sizes)
    lines = np.repeat(integers(words.face_lines), sizes)
    given = whole(parse_numbers(words.corners, lines), lines, "a vertex index of a face")
    above = np.repeat(integers(words.above), sizes)
    _check_indices(given, above, lines)
    ignored = [
        f"{words.ignored[word]} {name} elements ignored" for word, name in _IGNORED.items() if words.ignored[word]
    ]
    corners = np.where(given > 0, given - 1, above + given)
    return PolygonSoup.from_arrays(positions, corners, sizes, count_from=1, mended=tuple(ignored))


def obj_text(mesh: Mesh) -> str:
    """A mesh as OBJ, coordinates in as many digits as give back the same double."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in mesh.combinatorics.faces()]
    return "\n".join(lines) + "\n"


def _sorted(text: str) -> _Words:
    found = _Words()
    for line, words in _statements(text):
        match words[0]:
            case "v":
                if len(words) < 4:
                    raise MeshFileError(
                        f"line {line}: vertex {len(found.vertex_lines) + 1} has {len(words) - 1} coordinates, "
                        "3 are needed; the file is cut off or damaged",
                        elements=[line],
                    )
                found.coordinates += words[1:4]
                found.vertex_lines.append(line)
            case "f":
                found.corners += words[1:]
                found.sizes.append(len(words) - 1)
                found.face_lines.append(line)
                found.above.append(len(found.vertex_lines))
            case keyword:
                found.ignored[keyword] += 1
    if "/" in text:
        found.corners = [_TEXTURE_AND_NORMAL.sub("", word) for word in found.corners]
    return found


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and words of each statement; a line that ends in a backslash goes on in the next."""
    begun = ""
    for number, line in enumerate(text.split("\n"), 1):
        statement = begun + line.partition("#")[0].rstrip()
        if statement.endswith("\\"):
            begun = statement[:-1] + " "
            continue
        begun = ""
        if words := statement.split():
            yield number, words
    if words := begun.split():
        yield number, words


def _check_indices(given: IntArray, above: IntArray, lines: IntArray) -> None:
    wrong = np.flatnonzero((given == 0) | (given < -above))
    if not len(wrong):
        return
    line, index, count = int(lines[wrong[0]]), int(given[wrong[0]]), int(above[wrong[0]])
    reason = "OBJ counts vertices from 1" if index == 0 else f"counted back there are {count} vertices above it"
    raise MeshFileError(
        f"line {line}: a face names vertex {index}, but {reason}; correct the index", elements=[line], value=index
    )
