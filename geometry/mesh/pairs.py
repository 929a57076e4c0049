"""Read two files that hold combinatorially equivalent meshes, such as M and its Gauss image."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import NoReturn

import numpy as np

from geometry.arrays import IntArray
from geometry.errors import MeshError, MeshFileError
from geometry.mesh.checks import COINCIDENCE, check_indices
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.files import MeshFile, read_soup
from geometry.mesh.mending import drop_closing_corners, mended_soup
from geometry.mesh.mesh import Mesh
from geometry.mesh.soup import PolygonSoup

__all__ = ["read_mesh_pair"]


def read_mesh_pair(
    path: str | PathLike[str], other: str | PathLike[str], *, coincidence: float = COINCIDENCE
) -> tuple[MeshFile, Mesh]:
    """The mesh in the first file, mended as `read_mesh` does, and the mesh over the same combinatorics in the second.

    Vertices correspond by their number in the files, counted from the first one of each, whatever the formats. Only
    the first mesh is judged and mended: the second may have edges without length, faces without area and overfoldings,
    and takes over vertices, faces and orientation of the first. Both files must list the same faces; their order, the
    corners they start with and the way they run do not matter.

    Raises MeshFileError where a file cannot be read; MeshError where the first does not hold a usable mesh, where
    the second has other vertices or faces or coordinates that are not finite, and where vertices that become one in
    the first are apart in the second.
    """
    first, second = Path(path), Path(other)
    (soup, sha256), (companion, of_second) = _soup(first), _soup(second)
    try:
        _check_equivalent(soup, companion)
        mended = mended_soup(replace(soup, companion=companion.vertices), coincidence)
    except MeshError as error:
        raise MeshError(
            f"{first} with {second.name}: {error.message}",
            elements=error.elements,
            value=error.value,
            bound=error.bound,
        ) from error
    mesh = Mesh(mended.vertices, Combinatorics(mended.n_vertices, mended.corners, mended.face_starts))
    assert mended.companion is not None
    return MeshFile(first, mesh, mended.mended, sha256, of_second), mesh.with_vertices(mended.companion)


def _soup(path: Path) -> tuple[PolygonSoup, str]:
    try:
        soup, sha256 = read_soup(path)
        check_indices(soup)
        return drop_closing_corners(soup), sha256
    except (MeshFileError, MeshError) as error:
        raise type(error)(
            f"{path}: {error.message}", elements=error.elements, value=error.value, bound=error.bound
        ) from error


def _check_equivalent(soup: PolygonSoup, other: PolygonSoup) -> None:
    """The same number of vertices and the same faces, each as a ring of vertices that may run either way."""
    counts, others = (f"{s.n_vertices} vertices and {s.n_faces} faces" for s in (soup, other))
    if counts != others:
        raise MeshError(
            f"the two do not have the same faces: the first has {counts}, the second {others}; write both from one "
            "model, with the same numbers of vertices"
        )
    for size in np.unique(soup.face_sizes):  # as there are equally many faces, these are all sizes
        (faces, rings), (_, known) = _rings(soup, size), _rings(other, size)
        order = np.lexsort(rings.T[::-1])
        if len(rings) != len(known) or not np.array_equal(rings[order], known[np.lexsort(known.T[::-1])]):
            _raise_other_face(soup, faces, rings, known)


def _raise_other_face(soup: PolygonSoup, faces: IntArray, rings: IntArray, known: IntArray) -> NoReturn:
    of_second = set(map(tuple, known.tolist()))
    for face, ring in zip(faces.tolist(), rings.tolist(), strict=True):
        if tuple(ring) not in of_second:
            names = ", ".join(soup.vertex_name(vertex) for vertex in soup.corners[soup.corner_face == face])
            raise MeshError(
                f"the two do not have the same faces: face {soup.face_name(face)} of the first, with the vertices "
                f"{names}, is not in the second; write both from one model, with the same numbers of vertices "
                f"{soup.counting}",
                elements=[face],
            )
    size = known.shape[1]
    raise MeshError(
        f"the two do not have the same faces: the first has {len(rings)} with {size} corners, the second {len(known)}; "
        "write both from one model, with the same numbers of vertices"
    )


def _rings(soup: PolygonSoup, size: int) -> tuple[IntArray, IntArray]:
    """The faces (n,) with so many corners, and their vertices (n, size) from the least one on towards the lesser of
    its neighbours."""
    faces = np.flatnonzero(soup.face_sizes == size)
    rings = soup.corners[soup.face_starts[faces][:, None] + np.arange(size)]
    rows, steps = np.arange(len(rings))[:, None], np.arange(size)
    start = rings.argmin(axis=1)[:, None]
    turned: IntArray = rings[rows, (start + steps) % size]
    back = turned[:, 1] > turned[:, -1]
    turned[back, 1:] = turned[back, :0:-1]
    return faces, turned
