"""Hexagonal edge offset meshes that touch a given surface [Pottmann2007, end of 3.3]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fabkit.designs.koebe import Tiles
from fabkit.designs.pair import EdgeOffsetDesign, largest_piece
from fabkit.errors import ProjectError
from geometry.arrays import FloatArray, IntArray
from geometry.edge_offset.koebe import koebe
from geometry.edge_offset.tangent_hexagons import TangentMesh, tangent_mesh
from geometry.mesh import Mesh, Surface, read_mesh

__all__ = ["hexagons_design"]

ROOM = 1.3
"""Part of the sphere that S covers at first over that within the widest turn of the normals: a patch is not round."""

WIDEST_DEG = 90.0
"""Turn of the normals from their mean, beyond which a patch does not cover them all."""


def hexagons_design(
    surface: Path, *, count: int = 12, curvature: int = 0, turn_deg: float = 0.0, flip: bool = False
) -> EdgeOffsetDesign:
    """A mesh of hexagons, parallel to a Koebe polyhedron S, whose face planes touch a surface.

    surface: the file of a finely meshed surface. count: hexagons across the part of the sphere that its normals fill.
    curvature: 1 or -1 for those parts of the surface only. turn_deg: by how much S is turned about the mean normal.
    flip: sees the surface from its other side. S ends where the surface has no more normals; faces that cross
    themselves or fold over, as they do at the rim of saddles, are cut off both meshes. M is in the unit of the surface.

    Raises GeometryError where nothing can touch, for surfaces that are not usable and numbers out of range.
    """
    phi = Surface(read_mesh(surface, flip=flip).mesh)
    axis, widest = _mean_normal(phi.mesh)
    if not widest < WIDEST_DEG:
        raise ProjectError(
            f"the normals of {surface.name} turn by {widest:.0f} degrees from their mean, and less than {WIDEST_DEG:g} "
            "is needed: cut the surface into parts"
        )
    coverage = min(1.0, ROOM * (1 - np.cos(np.radians(widest))) / 2)
    image = koebe(Tiles.HEXAGONS.patch(count), coverage=coverage).mesh
    image = image.with_vertices(image.vertices @ _turned_to(axis, np.radians(turn_deg)).T)
    found = tangent_mesh(image, phi, curvature=curvature)
    image = image.part(largest_piece(image, np.setdiff1d(np.arange(image.n_faces), found.missing)))
    found = tangent_mesh(image, phi, curvature=curvature)
    kept = largest_piece(image, _sound(found))
    mesh, image = found.mesh.part(kept), image.part(kept)
    told = {"surface": surface.name, "count": count, "curvature": curvature, "turn_deg": turn_deg, "flip": flip}
    design = EdgeOffsetDesign.of("hexagons", mesh, image, told)
    return replace(design, notes=(_note(found, kept),), has_unit=True)


def _note(found: TangentMesh, kept: IntArray) -> str:
    n = found.mesh.n_faces
    touching = int(np.isin(kept, found.missing, invert=True).sum())
    cut = (
        f"; {n - len(kept)} at the rim were cut off, as they crossed themselves or folded over" if len(kept) < n else ""
    )
    return f"{touching} of {len(kept)} faces touch the surface{cut}"


def _mean_normal(mesh: Mesh) -> tuple[FloatArray, float]:
    """The unit mean of the vertex normals, and the largest angle of one with it in degrees."""
    normals = mesh.vertex_normals[mesh.combinatorics.is_used]
    mean = normals.mean(axis=0)
    mean = mean / max(float(np.linalg.norm(mean)), np.finfo(float).tiny)
    return mean, float(np.degrees(np.arccos(np.clip((normals @ mean).min(), -1.0, 1.0))))


def _turned_to(axis: FloatArray, angle: float) -> FloatArray:
    """(3, 3) the rotation by an angle about the z axis, then by the shortest way from there to a unit axis."""
    c, s = np.cos(angle), np.sin(angle)
    about = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    x, y, z = axis
    if z <= -1 + 1e-12:
        return np.asarray(np.diag([1.0, -1.0, -1.0]) @ about)
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    return np.asarray((np.eye(3) + cross + cross @ cross / (1 + z)) @ about)


def _sound(found: TangentMesh) -> IntArray:
    """The faces that do not cross themselves and run as most of them do; all where there are none."""
    faces = np.arange(found.mesh.n_faces)
    other = np.setdiff1d(faces, found.reversed_faces)
    running = max(found.reversed_faces, other, key=len)
    sound = np.setdiff1d(running, found.self_crossing_faces)
    return np.asarray(sound if len(sound) else faces)
