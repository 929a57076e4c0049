"""A surface covered by hexagons: S turned towards its normals, what touches, and the patch of it that can be built.

[Pottmann2007, end of 3.3].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, short_repr
from geometry.edge_offset.buildability import largest_buildable_patch, largest_connected_patch
from geometry.edge_offset.tangent_hexagons import TangentMesh, tangent_mesh
from geometry.mesh import Mesh, MeshLike, as_gauss_image
from geometry.surface import Surface

__all__ = ["SurfaceCover", "mean_normal", "surface_cover"]


@dataclass(frozen=True, eq=False)
class SurfaceCover:
    """S as it was turned, the mesh parallel to it that touches the surface, and which faces of both are kept.

    kept (k,): those that are connected and can be built.
    times: how often the normals of the surface, where its curvature has the required sign, cover the faces of S that
    touch it: 1 where each normal occurs once.

    >>> import numpy as np
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh import shapes, tilings
    >>> S = koebe(tilings.hexagon_patch(4, 4), coverage=0.05).mesh
    >>> x, y, _ = (shapes.grid(12, 12).vertices.T - 6) / 10
    >>> cap = Surface(shapes.grid(12, 12).with_vertices(np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=1)))
    >>> cover = surface_cover(cap, S)
    >>> len(cover.kept), 0 < cover.fitness <= 1
    (16, True)
    """

    __repr__ = short_repr

    gauss_image: Mesh
    found: TangentMesh
    kept: IntArray
    times: float

    @property
    def fitness(self) -> float:
        """Shortest edge over the mean one, times the part of the faces that is kept."""
        lengths = self.found.mesh.part(self.kept).edge_lengths
        return float(lengths.min() / lengths.mean() * len(self.kept) / self.gauss_image.n_faces)


def surface_cover(surface: Surface, gauss_image: MeshLike, angle: float = 0.0, *, curvature: int = 0) -> SurfaceCover:
    """The mesh parallel to S that touches the surface, with S, about the z axis, turned by an angle in radians about it
    and then by the shortest way to the mean normal of the surface.

    Faces of S whose normals the surface does not have are left out. curvature: as in `tangent_mesh`. Raises as that
    does.

    >>> import numpy as np
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh import shapes, tilings
    >>> S = koebe(tilings.hexagon_patch(4, 4), coverage=0.05).mesh
    >>> x, y, _ = (shapes.grid(12, 12).vertices.T - 6) / 10
    >>> cap = Surface(shapes.grid(12, 12).with_vertices(np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=1)))
    >>> cover = surface_cover(cap, S, np.radians(30))
    >>> len(cover.found.missing)
    0
    """
    gauss_image = as_gauss_image(gauss_image)
    axis, _ = mean_normal(surface.mesh)
    turned = gauss_image.with_vertices(gauss_image.vertices @ _turned_to(axis, angle).T)
    found = tangent_mesh(turned, surface, curvature=curvature)
    times = _times_over(surface.mesh, curvature, turned, found)
    turned = turned.part(largest_connected_patch(turned, np.setdiff1d(np.arange(turned.n_faces), found.missing)))
    found = tangent_mesh(turned, surface, curvature=curvature)
    kept = largest_buildable_patch(found.mesh, largest_connected_patch(turned, _of_main_orientation(found)))
    return SurfaceCover(turned, found, kept, times)


def mean_normal(mesh: Mesh) -> tuple[FloatArray, float]:
    """(3,) the unit mean of the vertex normals, and the largest angle of one with it in radians.

    >>> from geometry.mesh.shapes import grid
    >>> normal, largest_angle = mean_normal(grid(2, 2))
    >>> normal.tolist(), largest_angle
    ([0.0, 0.0, 1.0], 0.0)
    """
    normals = mesh.vertex_normals[mesh.combinatorics.is_used]
    mean = normals.mean(axis=0)
    mean = mean / max(float(np.linalg.norm(mean)), np.finfo(float).tiny)
    return floats(mean), float(np.arccos(np.clip((normals @ mean).min(), -1.0, 1.0)))


def _times_over(surface: Mesh, curvature: int, gauss_image: Mesh, found: TangentMesh) -> float:
    normals = surface.with_vertices(surface.vertex_normals)
    covered = np.einsum("fk,fk->f", normals.vector_areas, surface.face_normals)
    required = np.abs(covered[np.sign(covered) == curvature] if curvature else covered).sum()
    touching = np.setdiff1d(np.arange(gauss_image.n_faces), found.missing)
    return float(required / np.linalg.norm(gauss_image.vector_areas[touching], axis=1).sum())


def _turned_to(axis: FloatArray, angle: float) -> FloatArray:
    """(3, 3) the rotation by an angle about the z axis, then by the shortest way from there to a unit axis."""
    c, s = np.cos(angle), np.sin(angle)
    about = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    x, y, z = axis
    if z <= -1 + 1e-12:
        return np.asarray(np.diag([1.0, -1.0, -1.0]) @ about)
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    return np.asarray((np.eye(3) + cross + cross @ cross / (1 + z)) @ about)


def _of_main_orientation(found: TangentMesh) -> IntArray:
    """The faces with the orientation that most faces have."""
    other = np.setdiff1d(np.arange(found.mesh.n_faces), found.reversed_faces)
    return max(found.reversed_faces, other, key=len)
