"""Read and write polygon meshes: OBJ, OFF, PLY."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from geometry.errors import MeshError, MeshFileError
from geometry.mesh.checks import COINCIDENCE
from geometry.mesh.mending import mend_soup
from geometry.mesh.mesh import Mesh
from geometry.mesh.obj import obj_text, read_obj
from geometry.mesh.off import off_text, read_off
from geometry.mesh.ply import ply_text, read_ply
from geometry.mesh.soup import PolygonSoup

__all__ = ["MeshFile", "read_mesh", "read_soup", "write_mesh"]

_WRITERS = {".obj": obj_text, ".off": off_text, ".ply": ply_text}


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as read: where from, and a sentence for each thing that was mended on the way.

    sha256: of the bytes it was read from, which are read once; companion_sha256: of those of the second file of a pair.
    """

    path: Path
    mesh: Mesh
    mended: tuple[str, ...]
    sha256: str = ""
    companion_sha256: str = ""


def read_mesh(path: str | PathLike[str], *, flip: bool = False, coincidence: float = COINCIDENCE) -> MeshFile:
    """Read an OBJ, OFF or PLY file (by suffix) and mend it; see `geometry.mesh.mending.mend`.

    `flip` turns all faces round at the end, where outside came out inside. `coincidence`, a part of the mean edge
    length, is the distance below which vertices are one. Lengths stay in the unit of the file.

    Raises MeshFileError where the file cannot be read and MeshError where it does not hold a usable mesh. Sentences
    begin with the path and number vertices and faces as the file does: OBJ from 1, PLY from 0, OFF from 0 unless the
    file's own indices start at 1; they say which. The error's `elements` count from 0, or are numbers of lines.
    """
    path = Path(path)
    try:
        soup, sha256 = read_soup(path)
        mesh, mended = mend_soup(soup, flip=flip, coincidence=coincidence)
    except (MeshFileError, MeshError) as error:
        raise type(error)(
            f"{path}: {error.message}", elements=error.elements, value=error.value, bound=error.bound
        ) from error
    return MeshFile(path, mesh, mended, sha256)


def write_mesh(path: str | PathLike[str], mesh: Mesh) -> None:
    """Write OBJ, OFF or PLY (by suffix), as text from which `read_mesh` gets the same doubles back.

    Raises MeshFileError for another suffix or a folder that does not exist.
    """
    path = Path(path)
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise MeshFileError(f"{path}: {_unknown_suffix(path)}")
    if not path.parent.is_dir():
        raise MeshFileError(f"{path}: there is no folder {path.parent}; make it first")
    path.write_text(writer(mesh), encoding="ascii", newline="\n")


def read_soup(path: Path) -> tuple[PolygonSoup, str]:
    """What a file holds, before anything is mended, and the sha256 of its bytes.

    Raises MeshFileError where it cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise MeshFileError(_unknown_suffix(path))
    try:
        if not path.is_file():
            raise MeshFileError("there is no such file; check the path")
        data = path.read_bytes()
    except OSError as error:
        raise MeshFileError(f"the file cannot be read: {error.strerror or error}") from error
    return _soup(data, suffix), hashlib.sha256(data).hexdigest()


def _soup(data: bytes, suffix: str) -> PolygonSoup:
    if not data.strip():
        raise MeshFileError("the file is empty; export the mesh again")
    if suffix == ".ply":
        return read_ply(data)
    text = data.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return read_obj(text) if suffix == ".obj" else read_off(text)


def _unknown_suffix(path: Path) -> str:
    return f"meshes are read from and written to .obj, .off and .ply, not {path.suffix or 'a name without suffix'}"
