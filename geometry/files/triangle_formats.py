"""Triangle formats that are read by trimesh: STL, GLB and glTF."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np

from geometry.errors import MeshFileError, printable
from geometry.files.raw_polygons import RawPolygons

__all__ = ["TRIANGLE_SUFFIXES", "read_triangles"]

TRIANGLE_SUFFIXES = (".stl", ".glb", ".gltf")

_Y_UP_SUFFIXES = (".glb", ".gltf")
"""Formats that define +Y as upwards."""


def read_triangles(data: bytes, suffix: str, folder: Path) -> RawPolygons:
    """All triangles of a file, at their positions in its scene; folder: where other files that it names are searched.

    Raises MeshFileError where trimesh cannot read it, and where there is no triangle.
    """
    import trimesh  # takes half a second
    from trimesh.resolvers import FilePathResolver

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(
                io.BytesIO(data), file_type=suffix[1:], resolver=FilePathResolver(str(folder)), process=False
            )
            meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
    except Exception as error:  # readers of another library may raise anything for a damaged file
        raise MeshFileError(
            f"this is not a readable {suffix[1:].upper()} file ({type(error).__name__}: {printable(error)}); "
            "export it again, or as OBJ, OFF or PLY"
        ) from error
    if not meshes:
        raise MeshFileError("there are no triangles; export the surface as a mesh")
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = np.concatenate([np.asarray(mesh.vertices, dtype=np.float64) for mesh in meshes])
    faces = np.concatenate([np.asarray(mesh.faces) + first for mesh, first in zip(meshes, firsts[:-1], strict=True)])
    mended: tuple[str, ...] = ()
    if suffix in _Y_UP_SUFFIXES:
        vertices = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
        mended = ("turned from +Y upwards, as the format defines it, to +Z upwards",)
    return RawPolygons.from_arrays(vertices, faces.ravel(), np.full(len(faces), 3), mended=mended)
