"""Exact surfaces of STEP, IGES and BREP files, and of build123d and CadQuery: triangles on them, with the surfaces kept
for nearest points and normals. Needs the OCCT kernel that build123d and CadQuery bring."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from fabkit.formats.surfaces.shape_triangles import VANISHING_TANGENT, shape_triangles, tangents
from geometry.arrays import FloatArray, IntArray, floats
from geometry.mesh import Combinatorics, Mesh
from geometry.surface import Surface
from geometry.surface.surface import check_points

if TYPE_CHECKING:
    from OCP.BRepAdaptor import BRepAdaptor_Surface

__all__ = ["ExactSurface", "exact_surface"]

FOOT_STEPS = 2
"""Newton steps to the nearest point, from that of the triangles, which is near: each squares the error."""


@dataclass(frozen=True, eq=False)
class ExactSurface(Surface):
    """Triangles whose vertices lie on exact faces, and these: nearest points and normals are those of the faces.

    mesh: triangles. faces: of the kernel; face (T,) and parameters (T, 3, 2) of each triangle and its corners; sides
    (T,): 1 where the normal of the face is outwards, -1 where inwards. The surface stands at scale times what the
    faces say, plus offset (3,).
    """

    faces: tuple[BRepAdaptor_Surface, ...]
    face: IntArray
    parameters: FloatArray
    sides: FloatArray
    scale: float
    offset: FloatArray

    is_exact: ClassVar[bool] = True

    def closest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Feet (n, 3) of points (n, 3), the nearest points of the exact faces, and unit normals (n, 3) there."""
        points = check_points(points)
        _, triangles, normals, weights = self.locate(points)
        uv = np.einsum("nk,nkp->np", weights, self.parameters[triangles])
        glides = ~(self._is_rim[triangles] & (weights <= 0)).any(axis=1)  # a foot at the boundary stays there
        wanted, face = (points - self.offset) / self.scale, self.face[triangles]
        feet, du, dv = self._tangents(face, uv)
        for _ in range(FOOT_STEPS):
            off = wanted - feet
            uu, mixed, vv = (np.einsum("ni,ni->n", a, b) for a, b in ((du, du), (du, dv), (dv, dv)))
            determinant = uu * vv - mixed**2
            at = np.flatnonzero(glides & (determinant > VANISHING_TANGENT**2 * (uu + vv) ** 2))
            along, across = (np.einsum("ni,ni->n", off, each)[at] for each in (du, dv))
            steps = np.stack([vv[at] * along - mixed[at] * across, uu[at] * across - mixed[at] * along], axis=1)
            moved = uv[at] + steps / determinant[at, None]
            found = self._tangents(face[at], moved)
            nearer = np.linalg.norm(wanted[at] - found[0], axis=1) < np.linalg.norm(off[at], axis=1)
            at, glides = at[nearer], glides & np.isin(np.arange(len(points)), at[nearer])
            uv[at] = moved[nearer]
            feet[at], du[at], dv[at] = (each[nearer] for each in found)
        exact = np.cross(du, dv) * self.sides[triangles][:, None]
        sizes = np.linalg.norm(exact, axis=1, keepdims=True)
        steady = sizes > VANISHING_TANGENT * ((du**2).sum(axis=1) + (dv**2).sum(axis=1))[:, None]
        normals = np.divide(exact, sizes, out=normals.copy(), where=steady)  # at a pole, those of the triangles
        return feet * self.scale + self.offset, normals

    def _tangents(self, face: IntArray, uv: FloatArray) -> FloatArray:
        """(3, n, 3) points of faces (n,) at parameters (n, 2), and their two derivatives."""
        return tangents([self.faces[each] for each in face.tolist()], uv)

    def reversed(self) -> ExactSurface:
        """The surface seen from the other side."""
        c = self.mesh.combinatorics
        turned = c.corners.reshape(-1, 3)[:, ::-1]
        mesh = Mesh(self.mesh.vertices, Combinatorics(c.n_vertices, turned.ravel(), c.face_starts))
        return replace(self, mesh=mesh, parameters=floats(self.parameters[:, ::-1]), sides=floats(-self.sides))

    def distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distances (n,) along the normals at the feet of points (n, 3), and their gradients (n, 3): the normals."""
        feet, normals = self.closest(points)
        return np.einsum("ni,ni->n", points - feet, normals), normals

    def moved(self, scale: float, offset: FloatArray) -> ExactSurface:
        """The surface scaled and then moved by a vector (3,)."""
        mesh = self.mesh.with_vertices(self.mesh.vertices * scale + offset)
        return replace(self, mesh=mesh, scale=self.scale * scale, offset=self.offset * scale + offset)

    @cached_property
    def _is_rim(self) -> Any:
        """(T, 3) whether the side opposite to a corner is at the boundary."""
        c = self.mesh.combinatorics
        return np.roll(c.is_boundary_edge[c.corner_edge].reshape(-1, 3), -1, axis=1)


def exact_surface(shape: Any, edge_length: Callable[[float], float], *, name: str = "the shape") -> ExactSurface:
    """Triangles on the faces of a shape, sewn together.

    shape: of the kernel, or a face, shell or the like of build123d or CadQuery. edge_length: of the triangles, for the
    area of the shape. Raises FabkitError where there is no face, and MeshError where the faces make no surface.

    >>> import build123d
    >>> from fabkit.formats import exact_surface
    >>> from geometry import remesh
    >>> barrel = build123d.Solid.make_cylinder(3000, 9000).faces().filter_by(build123d.GeomType.CYLINDER)[0]
    >>> surface = exact_surface(barrel, lambda area: 500)
    >>> planar = remesh(surface, edge_length=1500)
    >>> bool(planar.mesh.planarity.max() < 1e-12), bool(planar.surface_distances.max() < 60)
    (True, True)
    """
    found = shape_triangles(getattr(shape, "wrapped", shape), edge_length, name)
    starts = 3 * np.arange(len(found.triangles) + 1)
    mesh = Mesh(found.vertices, Combinatorics(len(found.vertices), found.triangles.ravel(), starts))
    return ExactSurface(mesh, found.faces, found.face, found.parameters, found.sides, 1.0, np.zeros(3))
