"""Curvature of a design surface: tensor, principal and asymptotic directions, umbilics.

II(X, Y) is the second fundamental form: II(X, X) is the curvature of the surface in the direction of a unit tangent
vector X, positive where the surface bends towards its normal; two directions with II(X, Y) = 0 are conjugate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import MeshError
from geometry.mesh import Mesh, MeshLike, as_mesh

__all__ = ["Curvature", "Umbilics"]

QUADRIC_RINGS = 3
"""Number of rings of neighbours to which a quadric is fitted: two rings are sensitive to noise, five or more biased."""

LEAST_QUADRIC_NEIGHBOURS = 5
"""Least number of points that determine the quadric z = a x + b y + c x^2 + d x y + e y^2 through a vertex."""

LEAST_QUADRIC_SINGULAR_VALUE = 1e-6
"""Singular value over the largest one, below which points do not determine a quadric."""


@dataclass(frozen=True, eq=False)
class Umbilics:
    """Points with equal principal curvatures: their triangles (n,), and the indices (n,) of the principal lines there.

    The index is 1/2 or -1/2; an umbilic of higher order appears as several of these. On a sphere or a plane, where all
    points are umbilics, none or very many are found.

    >>> import trimesh
    >>> from geometry import Curvature, as_mesh
    >>> ball = as_mesh(trimesh.creation.icosphere(subdivisions=3))
    >>> umbilics = Curvature.of(ball.with_vertices(ball.vertices * [1.0, 1.5, 2.2])).umbilics
    >>> sorted(umbilics.indices.tolist())  # of an ellipsoid
    [0.5, 0.5, 0.5, 0.5]
    """

    __repr__ = short_repr

    triangles: IntArray
    indices: FloatArray


@dataclass(frozen=True, eq=False)
class Curvature:
    """Curvature at the vertices of triangles. normals (N, 3) unit; tensors (N, 3, 3): II as a bilinear form in space.

    >>> import trimesh
    >>> from geometry import Curvature, as_mesh
    >>> curvature = Curvature.of(as_mesh(trimesh.creation.icosphere(subdivisions=3, radius=2.0)))
    >>> curvature
    Curvature(642 vertices, 1280 faces, 1920 edges)
    >>> curvature.principal_curvatures.mean(axis=0).round(1).tolist()  # of a ball of radius 2
    [-0.5, -0.5]
    """

    __repr__ = short_repr

    mesh: Mesh
    normals: FloatArray
    tensors: FloatArray

    @classmethod
    def of(cls, mesh: MeshLike) -> Curvature:
        """The curvature of a triangle mesh, from the quadric through each vertex that best fits the vertices up to
        three edges away. Quadrics are graphs over the tangent planes [CazalsPouget2003]. Raises MeshError where a
        vertex has fewer than five such neighbours.
        """
        mesh = as_mesh(mesh)
        rows, columns = _neighbours(mesh)
        normals = mesh.vertex_normals
        first, second = _tangents(normals)
        offsets = mesh.vertices[columns] - mesh.vertices[rows]
        counts = np.bincount(rows, minlength=mesh.n_vertices)
        x, y, z = (np.einsum("pi,pi->p", offsets, axis[rows]) for axis in (first, second, normals))
        sizes = np.sqrt(np.bincount(rows, x**2 + y**2, mesh.n_vertices) / np.maximum(counts, 1))
        sizes[sizes == 0] = 1.0
        x, y, z = x / sizes[rows], y / sizes[rows], z / sizes[rows]
        terms = np.stack([x, y, x**2 / 2, x * y, y**2 / 2])
        normal_matrix = np.empty((mesh.n_vertices, 5, 5))
        for i in range(5):
            for j in range(i, 5):
                normal_matrix[:, i, j] = np.bincount(rows, terms[i] * terms[j], mesh.n_vertices)
                normal_matrix[:, j, i] = normal_matrix[:, i, j]
        right = np.stack([np.bincount(rows, term * z, mesh.n_vertices) for term in terms], axis=1)
        inverse = np.linalg.pinv(normal_matrix, rcond=LEAST_QUADRIC_SINGULAR_VALUE**2, hermitian=True)
        slope_x, slope_y, xx, xy, yy = np.einsum("nij,nj->in", inverse, right)
        root = np.sqrt(1 + slope_x**2 + slope_y**2)
        form = np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2) / (root * sizes)[:, None, None]
        axes = np.stack([first, second], axis=1)
        fitted = (normals - slope_x[:, None] * first - slope_y[:, None] * second) / root[:, None]
        return cls(mesh, floats(fitted), floats(np.einsum("nai,nab,nbj->nij", axes, form, axes)))

    @cached_property
    def _principal(self) -> tuple[FloatArray, FloatArray]:
        first, second = _tangents(self.normals)
        axes = np.stack([first, second], axis=1)
        values, vectors = np.linalg.eigh(np.einsum("nai,nij,nbj->nab", axes, self.tensors, axes))
        return floats(values), floats(np.einsum("nab,nai->nbi", vectors, axes))

    @property
    def principal_curvatures(self) -> FloatArray:
        """(N, 2) the smaller one first."""
        return self._principal[0]

    @property
    def principal_directions(self) -> FloatArray:
        """(N, 2, 3) unit vectors; any two perpendicular ones at an umbilic."""
        return self._principal[1]

    @cached_property
    def asymptotic_directions(self) -> FloatArray:
        """(N, 2, 3) the two unit tangent vectors with II(X, X) = 0; nan where both curvatures have one sign."""
        low, high = self.principal_curvatures.T
        with np.errstate(invalid="ignore", divide="ignore"):
            angle = np.arctan2(np.sqrt(-low), np.sqrt(high))
        first, second = self.principal_directions.swapaxes(0, 1)
        along, across = np.cos(angle)[:, None] * first, np.sin(angle)[:, None] * second
        return floats(np.stack([along + across, along - across], axis=1))

    @cached_property
    def triangle_tensors(self) -> FloatArray:
        """(F, 3, 3) II of the triangles: the mean of those at the corners."""
        return floats(self.tensors[self.mesh.combinatorics.corners.reshape(-1, 3)].mean(axis=1))

    @cached_property
    def umbilics(self) -> Umbilics:
        """The zeros of the traceless part of II, which is interpolated linearly in each triangle. Raises MeshError for
        faces with more than three corners."""
        c = self.mesh.combinatorics
        if c.face_sizes.max() > 3:
            raise MeshError(
                f"umbilics are found in triangles, but face {c.face_sizes.argmax()} has {c.face_sizes.max()} corners: "
                "take Curvature.of(Surface(mesh).triangulated)",
                elements=[int(c.face_sizes.argmax())],
            )
        first, second = _tangents(self.mesh.face_normals)
        corners = self.tensors[c.corners.reshape(-1, 3)]
        xx, xy, yy = (
            np.einsum("fi,fkij,fj->fk", a, corners, b) for a, b in ((first, first), (first, second), (second, second))
        )
        traceless = (xx - yy) / 2 + 1j * xy
        turn = np.angle(np.roll(traceless, -1, axis=1) * traceless.conj()).sum(axis=1)
        windings = np.rint(turn / (2 * np.pi))
        triangles = np.flatnonzero(windings)
        return Umbilics(integers(triangles), floats(windings[triangles] / 2))


def _neighbours(mesh: Mesh) -> tuple[IntArray, IntArray]:
    """Pairs (p,), (p,) of vertices joined by up to QUADRIC_RINGS edges. Raises MeshError where there are too few."""
    c = mesh.combinatorics
    step = csr_array(c.adjacency + eye_array(c.n_vertices, format="csr"))
    reach = step
    for _ in range(QUADRIC_RINGS - 1):
        reach = csr_array(reach @ step)
    pairs = reach.tocoo()
    rows, columns = pairs.coords
    is_other = rows != columns
    rows, columns = rows[is_other].astype(np.int64), columns[is_other].astype(np.int64)
    counts = np.bincount(rows, minlength=c.n_vertices)
    with_too_few = np.flatnonzero(c.is_used & (counts < LEAST_QUADRIC_NEIGHBOURS))
    if len(with_too_few):
        cure = "divide the triangles into smaller ones, or leave out separate parts of a few triangles"
        if (mesh.vertices == mesh.vertices[with_too_few[0]]).all(axis=1).sum() > 1:
            cure = "other vertices are in the same place; make them one by geometry.files.mend(vertices, faces)"
        raise MeshError(
            f"vertex {with_too_few[0]} of the surface has {counts[with_too_few[0]]} others within {QUADRIC_RINGS} "
            f"edges, its curvature needs {LEAST_QUADRIC_NEIGHBOURS}: {cure}",
            elements=with_too_few.tolist(),
            value=float(counts[with_too_few[0]]),
            bound=LEAST_QUADRIC_NEIGHBOURS,
        )
    return rows, columns


def _tangents(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (n, 3) perpendicular to each normal (n, 3) and to each other, right-handed with it."""
    least_aligned_axis = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least_aligned_axis)
    first = first / np.maximum(np.linalg.norm(first, axis=1, keepdims=True), np.finfo(float).tiny)
    return first, np.cross(normals, first)
