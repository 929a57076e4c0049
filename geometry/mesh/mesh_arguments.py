"""What functions accept as a mesh: a Mesh, an object that holds one as `.mesh`, or a mesh of another library.

Meshes of other libraries are recognised by what they offer, so that none of these libraries is needed.
"""

from __future__ import annotations

from os import PathLike
from typing import Any, Protocol, TypeAlias

import numpy as np

from geometry.errors import MeshError, described, listed, printable
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh

__all__ = ["CombinatoricsLike", "HasMesh", "MeshLike", "as_combinatorics", "as_gauss_image", "as_mesh"]


class HasMesh(Protocol):
    """An object that holds a mesh: MeshFile, OptimisedMesh, KoebePolyhedron, LaidMesh, Pair, Surface, or your own
    class.

    >>> from geometry import planarise
    >>> from geometry.mesh.solids import cube
    >>> class Roof:
    ...     mesh = cube()
    >>> planarise(Roof()).mesh.n_faces
    6
    """

    @property
    def mesh(self) -> Mesh: ...


MeshLike: TypeAlias = "Mesh | HasMesh"
"""A mesh, or an object that holds one as `.mesh`."""

CombinatoricsLike: TypeAlias = "Combinatorics | Mesh | HasMesh"
"""Combinatorics, or a mesh that has them."""


def as_mesh(given: Any) -> Mesh:
    """The mesh of an argument; every function of this package with an argument for a mesh calls this.

    A Mesh is returned as it is; for an object that holds one as `.mesh`, that mesh is returned (for a `Pair`, M). A
    tuple (vertices, faces), and meshes of trimesh, compas and meshio become a new Mesh: with the vertices and faces in
    their order, the faces with their orientation, the coordinates as doubles, and nothing else, such as colours. Points
    and lines of meshio are left out, volumes refused. Files are read by `read_mesh`. Meshes with gaps, or with faces of
    different orientations, are mended by `geometry.files.mend`.

    Raises MeshError for anything else, with the cure, and for faces that make no mesh.

    >>> import trimesh
    >>> from geometry import as_mesh
    >>> mesh = as_mesh(trimesh.creation.box())
    >>> mesh
    Mesh(8 vertices, 12 faces, 18 edges)
    >>> as_mesh((mesh.vertices, mesh.faces)).n_edges
    18
    """
    if isinstance(given, Mesh):
        return given
    if isinstance(held := getattr(given, "mesh", None), Mesh):
        return held
    arrays = given if isinstance(given, tuple) and len(given) == 2 else _of_other_library(given)
    if arrays is None:
        raise MeshError(_refusal(given))
    return Mesh.from_faces(*arrays)


def as_gauss_image(given: Any) -> Mesh:
    """The Gauss image S of an argument: S of a `Pair` or of an object that holds one; of all else the mesh, by
    `as_mesh`.

    >>> from geometry import Pair
    >>> from geometry.mesh.solids import cube
    >>> S = cube()
    >>> as_gauss_image(Pair(S * 700.0, S)) is S
    True
    """
    return as_mesh(getattr(given, "gauss_image", given))


def as_combinatorics(given: Any) -> Combinatorics:
    """The combinatorics of an argument: those given, or those of a mesh, see `as_mesh`.

    >>> from geometry.mesh.solids import cube
    >>> as_combinatorics(cube()).n_edges
    12
    """
    return given if isinstance(given, Combinatorics) else as_mesh(given).combinatorics


def _refusal(given: Any) -> str:
    """The message for an argument that is no mesh: what it is, and the cure."""
    if isinstance(given, (str, PathLike)):
        return f"a mesh is needed, not the path {printable(given)}: read the file by read_mesh(path)"
    if isinstance(given, Combinatorics):
        return "a mesh is needed, not a Combinatorics: give it vertices by Mesh(vertices, combinatorics)"
    if isinstance(given, (np.ndarray, list)):
        return (
            f"a mesh is needed, not {described(given)}: positions become one by Mesh.from_faces(vertices, faces), or "
            "by mesh.with_vertices(vertices) over the faces of another mesh"
        )
    if hasattr(given, "to_mesh"):
        return f"a mesh is needed, not {described(given)}: a scene of trimesh becomes one mesh by scene.to_mesh()"
    return (
        f"a mesh is needed, not {described(given)}: give a Mesh, an object that holds one as `.mesh`, a tuple "
        "(vertices, faces), or a mesh of trimesh, compas or meshio"
    )


# --- other libraries

FACE_CELLS = ("triangle", "quad", "polygon")
"""Types of cells of meshio that are faces. A digit after "triangle" or "quad" means a curved cell, which is refused."""

IGNORED_CELLS = ("vertex", "line")
"""Types of cells of meshio that are ignored beside faces."""


def _of_other_library(given: Any) -> tuple[Any, Any] | None:
    """The positions and the faces of a mesh of another library; None for anything else."""
    if callable(getattr(given, "to_vertices_and_faces", None)):  # compas
        vertices, faces = given.to_vertices_and_faces()
        return vertices, faces
    if hasattr(given, "points") and isinstance(getattr(given, "cells", None), list):  # meshio
        return given.points, _faces_of_cells(given.cells)
    if hasattr(given, "vertices") and hasattr(given, "faces") and not callable(given.vertices):  # trimesh
        return given.vertices, given.faces
    return None


def _faces_of_cells(cells: list[Any]) -> list[list[int]]:
    """The faces of blocks of cells, each with a type and rows of vertices. Raises MeshError for other cells."""
    faces: list[list[int]] = []
    unknown = []
    for block in cells:
        if block.type in FACE_CELLS:
            faces += block.data.tolist()
        elif block.type not in IGNORED_CELLS:
            unknown.append(block.type)
    if unknown:
        raise MeshError(
            f"the mesh has cells of type {listed(unknown, len(unknown))}: faces are of type {listed(FACE_CELLS, 3)}; "
            "take the surface of volumes, and the flat cells of curved ones"
        )
    return faces
