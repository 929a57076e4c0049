"""Reading and writing of polygon meshes (OBJ, OFF, PLY), and reading of triangles from STL, GLB and glTF files."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from stat import S_ISDIR, S_ISREG
from typing import Any, Literal

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.colours import ElementColours, element_colours
from geometry.errors import MeshError, MeshFileError, described, printable
from geometry.files.encoding import decoded
from geometry.files.face_checks import COINCIDENCE_TOLERANCE
from geometry.files.materials import face_materials
from geometry.files.mending import mend_polygons
from geometry.files.obj import obj_text, read_obj
from geometry.files.off import off_text, read_off
from geometry.files.ply import ply_text, read_ply
from geometry.files.raw_polygons import RawPolygons
from geometry.files.triangle_formats import TRIANGLE_SUFFIXES, read_triangles
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.mesh.origin import rounding

__all__ = ["MeshFile", "about", "path_name", "read_mesh", "read_polygons", "write_mesh"]

_WRITERS: dict[str, Callable[[Mesh, ElementColours | None], str]] = {
    ".obj": obj_text,
    ".off": off_text,
    ".ply": ply_text,
}

_LONGEST_NAME = 240
"""Largest number of characters of a path in a message."""


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as read: its path, and a sentence for each thing that was mended.

    origin (3,): it is added to the vertices of `mesh` to get the coordinates of the file. After reading it is zero, and
    the vertices of `mesh` are those of the file; see `near_zero`. sha256: of the bytes of the file; companion_sha256:
    of those of the second file of a pair.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from geometry import read_mesh, write_mesh
    >>> from geometry.mesh import shapes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_mesh(Path(folder, "grid.obj"), shapes.grid(3, 2).translated([5e6, 0, 0]))
    ...     file = read_mesh(Path(folder, "grid.obj"))
    ...
    >>> file.mesh
    Mesh(12 vertices, 6 faces, 17 edges)
    >>> file.near_zero().origin.tolist()
    [5000002.0, 1.0, 0.0]
    """

    __repr__ = short_repr

    path: Path
    mesh: Mesh
    mended: tuple[str, ...]
    sha256: str = ""
    companion_sha256: str = ""
    origin: FloatArray = field(default_factory=lambda: floats(np.zeros(3)))

    @property
    def rounding(self) -> float:
        """The spacing of doubles at the coordinates of the file, if these were rounded; else zero."""
        return rounding(self.mesh.vertices + self.origin)

    def near_zero(self) -> MeshFile:
        """The same with the mesh moved near zero, by whole numbers that are added to the origin, so that nothing is
        rounded.

        Compute with this one, since coordinates far from zero are coarse; then results do not depend on the position of
        the mesh. `write_mesh` adds the origin again. Other geometry at the same position, such as a surface, has to be
        moved by -file.origin, too.
        """
        mesh, origin = self.mesh.near_zero()
        return replace(self, mesh=mesh, origin=floats(self.origin + origin))


def read_mesh(path: str | PathLike[str], *, flip: bool = False, coincidence: float = COINCIDENCE_TOLERANCE) -> MeshFile:
    r"""Read a mesh file (by suffix) and mend it; see `geometry.files.mending.mend`.

    OBJ, OFF and PLY files hold polygons; STL, GLB and glTF files, which trimesh reads, hold triangles.

    `flip` reverses all faces at the end, if the outside came out as the inside. `coincidence`, over the mean edge
    length, is the distance below which vertices coincide. Coordinates stay those of the file, in its unit; if they are
    map coordinates, continue with `MeshFile.near_zero`.
    Raises MeshFileError where the file cannot be read and MeshError where it does not hold a usable mesh. Messages
    begin with the path and count vertices and faces as the file does, and say so: OBJ from 1, PLY from 0, OFF from 0
    unless the indices in the file start at 1. `elements` of the error count from 0, or are numbers of lines.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from geometry import read_mesh
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "roof.obj")
    ...     lines = ["v 0 0 0", "v 2 0 0", "v 2 2 0", "v 0 2 0", "v 9 9 9", "f 1 2 3 4 4"]
    ...     size = path.write_text("\n".join(lines))
    ...     file = read_mesh(path)
    ...
    >>> file.mesh
    Mesh(4 vertices, 1 faces, 4 edges)
    >>> len(file.mended)  # a corner that was written twice, a vertex without a face
    2
    """
    path = _as_path(path, "read_mesh(path)")
    try:
        raw, sha256 = read_polygons(path)
        mesh, mended = mend_polygons(raw, flip=flip, coincidence=coincidence)
    except (MeshFileError, MeshError) as error:
        raise about(path_name(path), error) from error
    return MeshFile(path, mesh, mended, sha256)


def write_mesh(
    path: str | PathLike[str],
    mesh: MeshLike,
    *,
    values: Any = None,
    colours: Any = None,
    on: Literal["faces", "vertices"] | None = None,
    value_range: tuple[float, float] | None = None,
    origin: Any = (0.0, 0.0, 0.0),
) -> None:
    """Write OBJ, OFF or PLY (by suffix), as text from which `read_mesh` reads the same doubles.

    values: numbers (F,) of faces or (N,) of vertices to be shown as colours, see `geometry.colours.ColourScale`; NaN is
    grey. value_range: the numbers at the two ends of the scale; otherwise the least and the largest, as far below zero
    as above if they have both signs. colours: instead of values, red, green and blue (F, 3) or (N, 3), integers up to
    255 or other numbers up to 1. on: whether they belong to faces or vertices, where the mesh has as many of both.
    OBJ has colours of faces in materials, of `COLOUR_STEPS` values, which are written to a file .mtl of the same name.
    origin (3,): it is added to the vertices, see `MeshFile.near_zero`.

    Raises MeshFileError for another suffix, a folder that does not exist, and where a file cannot be written;
    GeometryError where values or colours fit neither faces nor vertices, or may belong to both.

    >>> import tempfile
    >>> from geometry.mesh import shapes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "grid.ply")
    ...     write_mesh(path, shapes.grid(2, 3), values=[0, 1, 2, 3, 4, 5])
    ...     print(path.read_text().splitlines()[2])
    comment colours show values from 0 to 5, viridis
    """
    path = _as_path(path, "write_mesh(path, mesh)")
    mesh = as_mesh(mesh)
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise MeshFileError(f"{path_name(path)}: {_unknown_suffix(path, 'written to', tuple(_WRITERS))}")
    placed = mesh.translated(origin)
    coloured = element_colours(mesh, values, colours, on=on, value_range=value_range)
    if suffix == ".obj" and coloured and coloured.on == "faces":
        materials = face_materials(coloured, path.with_suffix(".mtl").name)
        _write_text(path.with_suffix(".mtl"), materials.text)
        _write_text(path, obj_text(placed, coloured, materials))
    else:
        _write_text(path, _WRITERS[suffix](placed, coloured))


def _as_path(given: Any, call: str) -> Path:
    """The path that is given. Raises MeshFileError for what is none, such as a mesh in its place."""
    if isinstance(given, (str, PathLike)):
        return Path(given)
    raise MeshFileError(
        f"a path is needed, not {described(given)}: the path comes first, {call}; meshes of other libraries are made "
        "Mesh by as_mesh"
    )


def _write_text(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8", newline="\n")
    except FileNotFoundError as error:
        raise MeshFileError(f"{path_name(path)}: there is no folder {path_name(path.parent)}; make it first") from error
    except (OSError, ValueError) as error:
        raise MeshFileError(f"{path_name(path)}: the file cannot be written: {_reason(error)}") from error


def read_polygons(path: Path) -> tuple[RawPolygons, str]:
    """The polygons of a file before anything is mended, and the sha256 of its bytes.

    Raises MeshFileError where it cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix not in (*_WRITERS, *TRIANGLE_SUFFIXES):
        raise MeshFileError(_unknown_suffix(path, "read from", (*_WRITERS, *TRIANGLE_SUFFIXES)))
    data = _contents(path)
    return _polygons(data, suffix, path.parent), hashlib.sha256(data).hexdigest()


def _polygons(data: bytes, suffix: str, folder: Path) -> RawPolygons:
    if not data.strip():
        raise MeshFileError("the file is empty; export the mesh again")
    if suffix in TRIANGLE_SUFFIXES:
        return read_triangles(data, suffix, folder)
    if suffix == ".ply":
        return read_ply(data)
    text = decoded(data)
    return read_obj(text) if suffix == ".obj" else read_off(text)


def path_name(path: Path) -> str:
    """A path as text for messages, also where its bytes are not printable."""
    return printable(path, _LONGEST_NAME)


def about(name: str, error: MeshFileError | MeshError) -> MeshFileError | MeshError:
    """The same error with a name before its message."""
    return type(error)(f"{name}: {error.message}", elements=error.elements, value=error.value, bound=error.bound)


def _contents(path: Path) -> bytes:
    """All bytes of a file. Raises MeshFileError also for devices and pipes, which may never end."""
    try:
        mode = path.stat().st_mode
        if S_ISREG(mode):
            return path.read_bytes()
    except (FileNotFoundError, NotADirectoryError) as error:
        raise MeshFileError("there is no such file; check the path") from error
    except (OSError, ValueError) as error:
        raise MeshFileError(f"the file cannot be read: {_reason(error)}") from error
    if S_ISDIR(mode):
        raise MeshFileError("there is no such file; check the path, which is that of a folder")
    raise MeshFileError("this is a pipe or a device, not a file; write its output to a file, and give the path of that")


def _reason(error: OSError | ValueError) -> str:
    """The reason that the system gives, without the path."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _unknown_suffix(path: Path, what: str, known: tuple[str, ...]) -> str:
    suffix = printable(path.suffix) or "a name without suffix"
    return f"meshes are {what} {', '.join(known[:-1])} and {known[-1]}, not {suffix}"
