"""Polygons to be rendered: of one colour, or the faces of a mesh with a colour for each corner and edge."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.colours import ColourScale
from geometry.mesh import Mesh
from geometry.pictures.rendering import Polygons

__all__ = ["flat_normals", "mesh_polygons"]

FANS_TRIED = 16
"""Corners of a face from which it is tried to divide it into a fan of triangles."""


def mesh_polygons(
    mesh: Mesh,
    colours: FloatArray,
    backs: FloatArray,
    *,
    widths: FloatArray,
    ink: FloatArray,
    opacity: float = 1.0,
    scale: ColourScale | None = None,
) -> list[Polygons]:
    """The faces of a mesh, together where they have as many corners.

    All is given corner by corner: colours (C, 3) of the outside and backs (C, 3) of the inside; widths (C,) in pixels
    and ink (C, 3) of the edge that starts at the corner, of which each of its faces draws its half. With a scale,
    colours and backs are values (C, 1).
    """
    c = mesh.combinatorics
    shapes = []
    for _, corners in c.faces_by_size():
        corners = np.take_along_axis(corners, _starts_of_fans(mesh.vertices[c.corners[corners]]), axis=1)
        points = mesh.vertices[c.corners[corners]]
        front, back, width, line = (values[corners] for values in (colours, backs, widths, ink))
        shapes.append(Polygons(points, flat_normals(points), front, back, width, line, opacity, scale))
    return shapes


def flat_normals(corners: FloatArray) -> FloatArray:
    """(n, k, 3) the unit normal of each polygon (n, k, 3), at all of its corners."""
    ahead = np.roll(corners, -1, axis=1)
    normals = np.cross(corners - corners[:, :1], ahead - corners[:, :1]).sum(axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return np.repeat(normals[:, None], corners.shape[1], axis=1)


def _starts_of_fans(corners: FloatArray) -> IntArray:
    """(n, k) the corners of polygons (n, k, 3) in their order, from the one whose fan of triangles does not fold back.

    At most `FANS_TRIED` corners are tried, so that faces of very many corners take no more than their share.
    """
    k = corners.shape[1]
    starts = np.unique(np.linspace(0, k - 1, min(k, FANS_TRIED)).astype(int))
    turns = (starts[:, None] + np.arange(k)) % k
    arms = corners[:, turns] - corners[:, turns[:, :1]]
    doubled = np.cross(arms[:, :, 1:-1], arms[:, :, 2:])
    normals = doubled.sum(axis=2)
    signed = (
        np.einsum("nsti,nsi->nst", doubled, normals) / np.maximum(np.square(normals).sum(axis=2), 1e-300)[..., None]
    )
    order: IntArray = turns[np.argmax(signed.min(axis=2) > -1e-9, axis=1)]
    return order
