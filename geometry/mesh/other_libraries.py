"""Meshes for other libraries, which are imported only when such a function is called."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from geometry.errors import GeometryError
from geometry.mesh.mesh_arguments import MeshLike, as_mesh
from geometry.mesh.triangulation import triangulated

__all__ = ["to_compas", "to_meshio", "to_trimesh"]


def to_trimesh(mesh: MeshLike) -> Any:
    """A trimesh.Trimesh with the same vertices in their order; faces with more corners are cut into triangles.

    Triangles have the orientation of their faces; `metadata["face"]` (T,) is the face of each, ascending. Convex faces
    become fans about their first corner, others constrained Delaunay triangulations; no vertex is added, none is
    merged.

    Raises GeometryError where trimesh is not installed, and MeshError for a face whose outline crosses itself.

    >>> from geometry import to_trimesh
    >>> from geometry.mesh.solids import cube
    >>> box = to_trimesh(cube())
    >>> box.faces.shape, round(box.volume.item(), 9), box.metadata["face"].tolist()[:4]
    ((12, 3), 8.0, [0, 0, 1, 1])
    """
    trimesh = _library("trimesh", "trimesh")
    mesh = as_mesh(mesh)
    triangles, faces = triangulated(mesh)
    return trimesh.Trimesh(mesh.vertices.copy(), triangles.copy(), process=False, metadata={"face": faces.copy()})


def to_compas(mesh: MeshLike) -> Any:
    """A compas.datastructures.Mesh with the same vertices and faces, numbered and oriented as here.

    Raises GeometryError where compas is not installed.

    >>> from geometry import as_mesh, to_compas
    >>> from geometry.mesh.solids import dodecahedron
    >>> mesh = to_compas(dodecahedron())
    >>> mesh.number_of_faces(), as_mesh(mesh).combinatorics.same_as(dodecahedron().combinatorics)
    (12, True)
    """
    structures = _library("compas", "compas.datastructures")
    mesh = as_mesh(mesh)
    return structures.Mesh.from_vertices_and_faces(mesh.vertices.tolist(), [face.tolist() for face in mesh.faces])


def to_meshio(mesh: MeshLike) -> Any:
    """A meshio.Mesh with the same vertices; its blocks are the triangles, the quads and so on, in this order.

    Faces keep their order within a block; `cell_data["face"]` has their numbers in this mesh.

    Raises GeometryError where meshio is not installed.

    >>> from geometry import to_meshio
    >>> from geometry.mesh.solids import cuboctahedron
    >>> [(block.type, len(block.data)) for block in to_meshio(cuboctahedron()).cells]
    [('triangle', 8), ('quad', 6)]
    """
    meshio = _library("meshio", "meshio")
    mesh = as_mesh(mesh)
    by_size = mesh.combinatorics.faces_by_size()
    names = {3: "triangle", 4: "quad"}
    cells = [(names.get(corners.shape[1], "polygon"), mesh.combinatorics.corners[corners]) for _, corners in by_size]
    return meshio.Mesh(mesh.vertices.copy(), cells, cell_data={"face": [faces for faces, _ in by_size]})


def _library(name: str, module: str) -> Any:
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise GeometryError(f"{name} is not installed: install it by pip install {name}") from error
