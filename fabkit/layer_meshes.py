"""The parallel meshes of layers that have their own: read from files, and made exactly parallel to M."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fabkit.errors import ProjectError
from fabkit.wording import readable
from geometry.errors import GeometryError
from geometry.files import MeshFile, read_mesh, read_mesh_pair
from geometry.mesh import Mesh
from geometry.parallel import ParallelSpace

__all__ = ["parallel_mesh"]

LARGEST_LAYER_MOVE = 1e-3
"""Largest move of a vertex, over the mean edge length, that makes the mesh of a layer parallel to M: what files lose,
and what M moved when it was made planar."""


def parallel_mesh(layer: int, path: Path, given: Path | None, file: MeshFile, mesh: Mesh, scale: float) -> Mesh:
    """The element of P(M) nearest to the mesh in a file, in mm near zero.

    layer: its number, for errors; given: the file of M, None for one in memory; file: as read; mesh: M in mm; scale: mm
    in a unit of the files. Vertices correspond by their numbers. Raises GeometryError where the file cannot be read,
    and ProjectError where it has other faces, or is not parallel to M.
    """
    name = f"layer {layer} (counted from 0): the mesh in {readable(path.name)}"
    if given is not None:
        vertices = read_mesh_pair(given, path)[1].vertices
    else:
        other = read_mesh(path).mesh
        if not mesh.combinatorics.same_as(other.combinatorics):
            raise ProjectError(
                f"{name} does not have the same vertices and faces as the mesh, so they are not parallel"
            )
        vertices = other.vertices
    shift = (vertices - file.origin) * scale - mesh.vertices
    try:
        moved = (
            ParallelSpace(mesh).project(mesh.with_vertices(shift)).vertices if np.ptp(shift, axis=0).any() else shift
        )
    except GeometryError as error:
        raise ProjectError(f"{name} cannot be made parallel to the mesh: {error}") from error
    moves = np.linalg.norm(moved - shift, axis=1)
    worst, allowed = int(moves.argmax()), LARGEST_LAYER_MOVE * mesh.mean_edge_length
    if not moves[worst] <= allowed:
        raise ProjectError(
            f"{name} is not parallel to the mesh: its vertex {worst} is {moves[worst]:.3g} mm from that of the nearest "
            f"parallel mesh, allowed {allowed:.3g} mm; write an element of P(M), such as one of ParallelSpace(M)"
        )
    return mesh.with_vertices(mesh.vertices + moved)
