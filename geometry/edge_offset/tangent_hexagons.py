"""Hexagonal meshes that touch a surface: the face planes of S, moved until they touch it [Pottmann2007, end of 3.3].

Here, hexagonal means that three faces meet at each vertex, whatever their numbers of corners. Then each face plane can
be moved freely, and the mesh with the moved planes is parallel to S; if S is a Koebe polyhedron, this mesh has edge
offsets. As in the paper, the result may intersect itself; `TangentMesh` says which faces do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, triu, vstack

from geometry.arrays import FloatArray, IntArray, floats, integers, short_repr
from geometry.edge_offset.points_of_contact import touching_points
from geometry.errors import GeometryError
from geometry.functionals import coordinates
from geometry.mesh import Combinatorics, Mesh, MeshLike, as_gauss_image
from geometry.mesh.intersections import intersecting_faces, self_crossing_faces
from geometry.optimise import (
    ConvergenceError,
    LinearFunctional,
    Reason,
    Solution,
    SparseMatrix,
    apply,
    max_norm,
    minimise_semidefinite,
    normal_equations,
)
from geometry.parallel import edge_factors
from geometry.parallel.constraints import FactorBounds
from geometry.parallel.edge_parallelity import check_planar
from geometry.parallel.face_unknowns import FaceUnknowns
from geometry.parallel.minimising import ELEMENT_TOLERANCE, SOLVER_TARGET_RATIO, check_solved, restore_parallelity
from geometry.surface import Surface

__all__ = ["TangentMesh", "mesh_with_planes", "tangent_mesh"]

PARALLEL_EDGE_POWER = 8
"""Power of the cosine of the angle between two edges, which weighs how parallel they are."""


@dataclass(frozen=True, eq=False)
class TangentMesh:
    """M in P(S) whose face planes touch a surface, and its defects.

    touching (F, 3): the points where the face planes touch; they are in the planes, and as far from the triangles of
    the surface as these are from the smooth surface. missing (k,): the faces whose normal occurs nowhere on the
    surface; their points are NaN, and their planes follow from the other faces. reversed_edges (k,) run the other way
    than in S, as some have to where the surface is curved negatively. reversed_faces (k,) are clockwise seen along the
    normals of S: all or none are, unless M folds over. self_crossing_faces (k,) and intersecting_faces (k, 2) are those
    of `geometry.mesh.intersections.meeting_faces`.

    >>> import numpy as np
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh import shapes, tilings
    >>> S = koebe(tilings.hexagon_patch(4, 4), coverage=0.05).mesh
    >>> x, y, _ = (shapes.grid(12, 12).vertices.T - 6) / 10
    >>> cap = Surface(shapes.grid(12, 12).with_vertices(np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=1)))
    >>> found = tangent_mesh(S, cap)
    >>> found.is_embedded, len(found.reversed_edges)
    (True, 0)
    >>> print(found.report)
    16 of 16 faces touch the surface; 0 of 63 edges run against those of S
    """

    __repr__ = short_repr

    mesh: Mesh
    touching: FloatArray
    missing: IntArray
    reversed_edges: IntArray
    reversed_faces: IntArray
    self_crossing_faces: IntArray
    intersecting_faces: IntArray

    @property
    def is_embedded(self) -> bool:
        """Whether M does not intersect itself."""
        return not len(self.self_crossing_faces) and not len(self.intersecting_faces)

    @property
    def report(self) -> str:
        """The defects in one sentence."""
        n = self.mesh.n_faces
        found = [f"{n - len(self.missing)} of {n} faces touch the surface"]
        if len(self.missing):
            found.append(f"the normals of faces {_enumerated(self.missing)} do not occur on it")
        found.append(f"{len(self.reversed_edges)} of {self.mesh.n_edges} edges run against those of S")
        if 0 < len(self.reversed_faces) < n:
            fewer = self.reversed_faces
            if 2 * len(fewer) > n:
                fewer = np.setdiff1d(np.arange(n), fewer)
            found.append(f"it folds over at faces {_enumerated(fewer)}")
        if len(self.self_crossing_faces):
            found.append(f"faces {_enumerated(self.self_crossing_faces)} cross themselves")
        if len(self.intersecting_faces):
            pairs = [f"{i} and {j}" for i, j in self.intersecting_faces.tolist()]
            found.append(f"faces {_enumerated(pairs)} intersect")
        return "; ".join(found)


def _enumerated(names: IntArray | list[str], count: int = 5) -> str:
    shown = ", ".join(str(name) for name in names[:count])
    return shown + (f" and {len(names) - count} more" if len(names) > count else "")


def tangent_mesh(gauss_image: MeshLike, surface: Surface, *, curvature: int = 0) -> TangentMesh:
    """The mesh parallel to S whose face planes touch a surface Phi where it has their normals.

    Normals are those on the outside of S and of Phi. Where Phi has several points with one normal, the one on the part
    of Phi is taken that has most of the normals of S; a part is connected and curved positively or negatively
    throughout. Normals that this part does not have are taken from elsewhere on Phi, next to the points of neighbouring
    faces. curvature: 1 or -1 for positively or for negatively curved points only. What the planes do not
    determine is as in `mesh_with_planes`.

    Planes and points are computed from the normals at the vertices of Phi. Where Phi approximates a smooth surface by
    even triangles, the error of the planes is of the third order in the edge length and that of the points of the
    second; with uneven triangles, of the second and first. Faces with more corners are cut into triangles from their
    first corners.

    Raises GeometryError where a vertex of S has more than 3 faces, where a face of S is not planar, and where no face
    can touch. Self-intersections are no error; the result reports them.

    >>> import numpy as np
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh import shapes, tilings
    >>> S = koebe(tilings.hexagon_patch(4, 4), coverage=0.05).mesh
    >>> x, y, _ = (shapes.grid(12, 12).vertices.T - 6) / 10
    >>> cap = Surface(shapes.grid(12, 12).with_vertices(np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=1)))
    >>> found = tangent_mesh(S, cap)
    >>> len(found.missing), found.touching.shape
    (0, (16, 3))
    """
    gauss_image = as_gauss_image(gauss_image)
    _check_valence(gauss_image)
    touching, heights = touching_points(surface, gauss_image, curvature)
    mesh = mesh_with_planes(gauss_image, heights)
    areas = np.einsum("fi,fi->f", mesh.vector_areas, gauss_image.face_normals)
    return TangentMesh(
        mesh,
        touching,
        integers(np.flatnonzero(np.isnan(heights))),
        integers(np.flatnonzero(edge_factors(gauss_image, mesh) < 0)),
        integers(np.flatnonzero(areas < 0)),
        integers(self_crossing_faces(mesh)),
        integers(intersecting_faces(mesh)),
    )


def mesh_with_planes(gauss_image: Mesh, heights: FloatArray) -> Mesh:
    """The mesh parallel to S with its face planes at n_F . x = heights (F,); n_F: the face normals of S.

    They touch a surface with the support function h for the heights h(n_F). NaN leaves a plane free. Where the planes
    do not determine the mesh, which is mostly at the boundary, nearby edges that are nearly parallel get nearly the
    same edge factors (1), so that the mesh continues as it does inside. Edges are parallel, and planes at the given
    heights, within `ELEMENT_TOLERANCE` times the largest coordinate.

    Raises GeometryError where a vertex has more than 3 faces, where a face is not planar, for heights of another shape
    or infinite or NaN throughout, and where planes contradict each other, as they may at boundary edges between
    vertices with 3 faces; ConvergenceError where the solver does not reach that accuracy.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import cube
    >>> mesh_with_planes(cube(), np.full(6, 2.0)).edge_lengths.round(6).max().item()
    4.0
    """
    _check_valence(gauss_image)
    check_planar(gauss_image)
    given = _checked_heights(gauss_image, heights)
    faces = np.flatnonzero(~np.isnan(given))
    planes = _heights_of(gauss_image, faces)
    unknowns = FaceUnknowns(gauss_image)
    A: SparseMatrix = csr_array(vstack([unknowns.constraints, planes @ unknowns.matrix]))
    b = np.concatenate([np.zeros(unknowns.constraints.shape[0]), given[faces]])
    H, g = unknowns.objective(*normal_equations([(1.0, _factor_differences(gauss_image))]))
    solution = minimise_semidefinite(H, g, A, b, np.zeros(len(g)), accuracy=SOLVER_TARGET_RATIO * ELEMENT_TOLERANCE)
    if solution.reason is not Reason.INFEASIBLE:
        solution = restore_parallelity(solution.x, A, b)
    found = gauss_image.with_vertices(apply(unknowns.matrix, solution.x).reshape(-1, 3))
    plane_deviations = np.abs(apply(planes, found.vertices.ravel()) - given[faces])
    bound = ELEMENT_TOLERANCE * max_norm(found.vertices)
    if plane_deviations.max() > bound or solution.reason is Reason.INFEASIBLE:
        raise _planes_missed(int(faces[plane_deviations.argmax()]), float(plane_deviations.max()), bound, solution)
    check_solved(gauss_image, found, solution, max_norm(found.vertices))
    return found


def _heights_of(mesh: Mesh, faces: IntArray) -> SparseMatrix:
    """(k, 3N) rows: the heights n_F . x of the first corners x of faces (k,), with the face normals n_F of the mesh."""
    columns = coordinates(mesh.combinatorics.corners[mesh.combinatorics.face_starts[faces]])
    starts, shape = np.arange(0, columns.size + 1, 3), (len(faces), 3 * mesh.n_vertices)
    return csr_array((mesh.face_normals[faces].ravel(), columns.ravel(), starts), shape=shape)


def _checked_heights(mesh: Mesh, heights: FloatArray) -> FloatArray:
    given = floats(heights)
    if given.shape != (mesh.n_faces,):
        raise GeometryError(f"the heights of the face planes have shape {given.shape}, there are {mesh.n_faces} faces")
    infinite = np.flatnonzero(np.isinf(given))
    if len(infinite):
        raise GeometryError(f"the height of face {infinite[0]} is infinite", elements=infinite.tolist())
    if np.isnan(given).all():
        raise GeometryError("no face plane has a height: give one at least, and NaN only where a plane is free")
    return given


def _planes_missed(face: int, value: float, bound: float, solution: Solution) -> GeometryError:
    if solution.reason is Reason.INFEASIBLE:
        return GeometryError(
            f"the heights contradict each other: face {face} is {value:.1e} off its plane, allowed "
            f"{bound:.1e}; where a boundary edge joins two vertices with 3 faces, leave one of these planes free (NaN)",
            elements=[face],
            value=value,
            bound=bound,
        )
    return ConvergenceError(
        f"face {face} is {value:.1e} off its plane, allowed {bound:.1e}: the solver stopped because "
        f"{solution.reason.value}",
        solution=solution,
        elements=[face],
        value=value,
        bound=bound,
    )


def _factor_differences(mesh: Mesh) -> LinearFunctional:
    """Differences of the factors of nearby edges, times their mean length and a weight that is small unless the edges
    are nearly parallel."""
    first, second = _nearby_edges(mesh.combinatorics).T
    cosines = np.einsum("ki,ki->k", mesh.edge_directions[first], mesh.edge_directions[second])
    weights = np.abs(cosines) ** PARALLEL_EDGE_POWER * np.sqrt(mesh.edge_lengths[first] * mesh.edge_lengths[second])
    pairs = np.arange(len(first))
    places = (np.concatenate([pairs, pairs]), np.concatenate([first, second]))
    differences = coo_array((np.concatenate([weights, -weights]), places), shape=(len(first), mesh.n_edges))
    factors = diags_array(1 / mesh.edge_lengths) @ FactorBounds.of(mesh, (0.0, 0.0)).rows(mesh)
    return LinearFunctional(csr_array(differences @ factors), np.zeros(len(first)))


def _nearby_edges(combinatorics: Combinatorics) -> IntArray:
    """(P, 2) pairs of edges that belong to one face or are joined by an edge."""
    c = combinatorics
    edges, ones = np.arange(c.n_edges), np.ones(2 * c.n_edges)
    at_vertices = csr_array(coo_array((ones, (c.edges.T.ravel(), np.tile(edges, 2))), shape=(c.n_vertices, c.n_edges)))
    in_faces = coo_array((np.ones(c.n_corners), (c.corner_face, c.corner_edge)), shape=(c.n_faces, c.n_edges)).tocsr()
    nearby = triu(at_vertices.T @ c.adjacency @ at_vertices + in_faces.T @ in_faces, k=1).tocoo()
    return np.stack([nearby.row, nearby.col], axis=1)


def _check_valence(mesh: Mesh) -> None:
    c = mesh.combinatorics
    n_faces = np.bincount(c.corners, minlength=c.n_vertices)
    overfull = np.flatnonzero(n_faces > 3)
    if len(overfull):
        vertex = int(overfull[0])
        raise GeometryError(
            f"vertex {vertex} has {n_faces[vertex]} faces, whose planes cannot move freely: at most 3 are allowed"
            f" ({len(overfull)} such vertices); take a mesh of valence 3, such as the dual of triangles",
            elements=overfull.tolist(),
            value=float(n_faces[vertex]),
            bound=3,
        )
