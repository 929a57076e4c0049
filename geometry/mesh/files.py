"""Read and write polygon meshes: OBJ, OFF, PLY."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.errors import MeshError, MeshFileError
from geometry.mesh.checks import COINCIDENCE
from geometry.mesh.mending import mend_soup
from geometry.mesh.mesh import Mesh
from geometry.mesh.obj import obj_text, read_obj
from geometry.mesh.off import off_text, read_off
from geometry.mesh.origin import rounding
from geometry.mesh.ply import ply_text, read_ply
from geometry.mesh.soup import PolygonSoup

__all__ = ["MeshFile", "read_mesh", "read_soup", "write_mesh"]

_WRITERS = {".obj": obj_text, ".off": off_text, ".ply": ply_text}


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as read: where from, and a sentence for each thing that was mended on the way.

    origin (3,): what is taken out of the coordinates, which are those of `mesh` plus the origin in the file. As read it
    is zero: the mesh stands where the file has it, and nothing is to be put back.
    """

    path: Path
    mesh: Mesh
    mended: tuple[str, ...]
    origin: FloatArray = field(default_factory=lambda: floats(np.zeros(3)))

    @property
    def rounding(self) -> float:
        """How far doubles are apart where the file has the mesh, if its coordinates were rounded to them; else zero."""
        return rounding(self.mesh.vertices + self.origin)

    def near_zero(self) -> MeshFile:
        """The same with the mesh near zero, by whole numbers that go into the origin, so that nothing is rounded.

        Compute with this one, since far from zero coordinates are coarse: then it does not matter where a mesh lies.
        `write_mesh` puts the origin back. What belongs to the same place, such as a surface beside a mesh, has to be
        moved with it: `surface.translated(-file.origin)`.
        """
        mesh, origin = self.mesh.near_zero()
        return replace(self, mesh=mesh, origin=floats(self.origin + origin))


def read_mesh(path: str | PathLike[str], *, flip: bool = False, coincidence: float = COINCIDENCE) -> MeshFile:
    """Read an OBJ, OFF or PLY file (by suffix) and mend it; see `geometry.mesh.mending.mend`.

    `flip` turns all faces round at the end, where outside came out inside. `coincidence`, a part of the mean edge
    length, is the distance below which vertices are one. Coordinates stay those of the file, in its unit; where they
    are map coordinates, go on with `MeshFile.near_zero`.

    Raises MeshFileError where the file cannot be read and MeshError where it does not hold a usable mesh. Sentences
    begin with the path and number vertices and faces as the file does: OBJ from 1, PLY from 0, OFF from 0 unless the
    file's own indices start at 1; they say which. The error's `elements` count from 0, or are numbers of lines.
    """
    path = Path(path)
    try:
        mesh, mended = mend_soup(read_soup(path), flip=flip, coincidence=coincidence)
    except (MeshFileError, MeshError) as error:
        raise type(error)(
            f"{path}: {error.message}", elements=error.elements, value=error.value, bound=error.bound
        ) from error
    return MeshFile(path, mesh, mended)


def write_mesh(path: str | PathLike[str], mesh: Mesh, *, origin: Any = (0.0, 0.0, 0.0)) -> None:
    """Write OBJ, OFF or PLY (by suffix), as text from which `read_mesh` gets the same doubles back.

    origin (3,): what was taken out of the mesh and is put back, see `MeshFile.near_zero`.

    Raises MeshFileError for another suffix or a folder that does not exist.
    """
    path = Path(path)
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise MeshFileError(f"{path}: {_unknown_suffix(path)}")
    if not path.parent.is_dir():
        raise MeshFileError(f"{path}: there is no folder {path.parent}; make it first")
    path.write_text(writer(mesh.translated(origin)), encoding="ascii", newline="\n")


def read_soup(path: Path) -> PolygonSoup:
    """What a file holds, before anything is mended. Raises MeshFileError where it cannot be read."""
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise MeshFileError(_unknown_suffix(path))
    if not path.is_file():
        raise MeshFileError("there is no such file; check the path")
    data = path.read_bytes()
    if not data.strip():
        raise MeshFileError("the file is empty; export the mesh again")
    if suffix == ".ply":
        return read_ply(data)
    text = data.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return read_obj(text) if suffix == ".obj" else read_off(text)


def _unknown_suffix(path: Path) -> str:
    return f"meshes are read from and written to .obj, .off and .ply, not {path.suffix or 'a name without suffix'}"
