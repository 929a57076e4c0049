"""Reading of two files with combinatorially equivalent meshes, such as M and its Gauss image."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import NoReturn

import numpy as np

from geometry.arrays import IntArray
from geometry.errors import MeshError, MeshFileError, printable
from geometry.files.face_checks import COINCIDENCE_TOLERANCE
from geometry.files.face_rings import rings_by_size
from geometry.files.mending import mended_polygons, tidied
from geometry.files.mesh_files import MeshFile, about, path_name, read_polygons
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import Combinatorics, Mesh

__all__ = ["read_mesh_pair"]


def read_mesh_pair(
    path: str | PathLike[str], other: str | PathLike[str], *, coincidence: float = COINCIDENCE_TOLERANCE
) -> tuple[MeshFile, Mesh]:
    """The mesh in the first file, mended as `read_mesh` does, and the mesh over the same combinatorics in the second.

    Vertices correspond by their number in the files, counted from the first one of each, whatever the formats. Only
    the first mesh is checked and mended. The second may have edges without length, faces without area and folds; its
    vertices and faces are merged, removed and reversed as those of the first. Both files must list the same faces;
    their order, first corners and orientations do not matter.

    Raises MeshFileError where a file cannot be read; MeshError where the first does not hold a usable mesh, where
    the second has other vertices or faces or coordinates that are not finite, and where vertices that are merged
    in the first are apart in the second.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from geometry import Pair, read_mesh_pair, write_mesh
    >>> from geometry.mesh import solids
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_mesh(Path(folder, "M.obj"), solids.cube() * 700.0)
    ...     write_mesh(Path(folder, "S.obj"), solids.cube())
    ...     file, S = read_mesh_pair(Path(folder, "M.obj"), Path(folder, "S.obj"))
    ...
    >>> Pair(file, S)
    Pair(8 vertices, 6 faces, 12 edges)
    """
    first, second = Path(path), Path(other)
    (raw, sha256), (companion, second_sha256) = _polygons(first), _polygons(second)
    try:
        _check_equivalent(raw, companion)
        mended = mended_polygons(replace(raw, companion=companion.vertices), coincidence)
    except MeshError as error:
        raise about(f"{path_name(first)} with {printable(second.name)}", error) from error
    mesh = Mesh(mended.vertices, Combinatorics(mended.n_vertices, mended.corners, mended.face_starts))
    assert mended.companion is not None
    return MeshFile(first, mesh, mended.mended, sha256, second_sha256), mesh.with_vertices(mended.companion)


def _polygons(path: Path) -> tuple[RawPolygons, str]:
    try:
        raw, sha256 = read_polygons(path)
        return tidied(raw), sha256
    except (MeshFileError, MeshError) as error:
        raise about(path_name(path), error) from error


def _check_equivalent(raw: RawPolygons, other: RawPolygons) -> None:
    """Raise MeshError unless both have equally many vertices and the same faces, as rings of vertices of either
    orientation."""
    counts, others = (f"{s.n_vertices} vertices and {s.n_faces} faces" for s in (raw, other))
    if counts != others:
        raise MeshError(
            f"the two do not have the same faces: the first has {counts}, the second {others}; write both from one "
            "model, with the same numbers of vertices"
        )
    known = {rings.shape[1]: rings for _, rings in rings_by_size(other.corners, other.face_starts)}
    for faces, rings in rings_by_size(raw.corners, raw.face_starts):
        size = rings.shape[1]
        other_rings = known.get(size, np.zeros((0, size), dtype=np.int64))
        same = np.unique(np.concatenate([other_rings, rings]), axis=0, return_inverse=True)[1].ravel()
        missing = faces[~np.isin(same[len(other_rings) :], same[: len(other_rings)])]
        if len(missing):
            _raise_other_faces(raw, missing)
        if len(rings) != len(other_rings):
            raise MeshError(
                f"the two do not have the same faces: the first has {len(rings)} with {size} corners, the second "
                f"{len(other_rings)}; write both from one model, with the same numbers of vertices"
            )


def _raise_other_faces(raw: RawPolygons, missing: IntArray) -> NoReturn:
    raise MeshError(
        f"the two do not have the same faces: face {raw.face_name(missing[0])} of the first, with the vertices "
        f"{raw.corner_names(missing[0])}, is not in the second; write both from one model, with the same numbers of "
        f"vertices{raw.likewise(missing[1:])} {raw.counting}",
        elements=raw.faces_of_file(missing),
    )
