"""What is minimised, and under which constraints, where M and S are optimised together [Pottmann2007, 4.4].

The unknown x (6N,): M from its centroid in mean edge lengths l, then S. A term is (error / tolerated)^2, so its weight
is one over the square of what is tolerated. All weights are without a unit, and none depends on the fineness of the
mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.functionals import (
    CircularFaces,
    CloseToNormals,
    ConicalVertices,
    ConstantCurvature,
    ConvexFaces,
    EdgesAtUnitDistance,
    EdgeStretch,
    FaceNormalCosines,
    FacesAtUnitDistance,
    InsideBalls,
    InsideCones,
    OnCurve,
    OnSmoothSurface,
    ParallelEdges,
    PlanarFaces,
    UprightFaces,
    UprightVertices,
    VerticesAtUnitDistance,
    coordinates,
    strain,
)
from geometry.gauss import Pair
from geometry.mesh import Mesh
from geometry.mesh.polygons import vector_areas
from geometry.meshing import Guides
from geometry.meshing.result_checks import LEAST_CONVEX_TURN
from geometry.meshing.vertex_guides import Indices, MeshGuides, in_edge_lengths
from geometry.optimise import (
    AffineMap,
    Blocks,
    ComposedFunctional,
    Functional,
    Hinge,
    LinearFunctional,
    Remembered,
    SparseMatrix,
    StackedFunctional,
)
from geometry.optimised_pairs.pair_targets import PairTargets
from geometry.surface import Surface

__all__ = ["LARGEST_UPRIGHT_LEAN", "Objective"]

HEIGHT_WEIGHT = 0.01
"""Weight of distances from the origin, times the square of the height error e: for e = 0.01 it is 100."""

PAIR_SURFACE_WEIGHT = 10.0
"""Weight of distances from Phi in mean edge lengths: 3 % of an edge are tolerated."""

BOUNDARY_WEIGHT = 10.0
"""Weight of distances from the boundary as it was. The boundary may be left: boundaries that are fixed collapse edges
beside them."""

LARGEST_BOUNDARY_DISTANCE = 0.2
"""Distance from the boundary as it was, in mean edge lengths, above which the excess has `KEPT_SHAPE_WEIGHT`: few
vertices would leave it by more, beside short or oblique edges."""

STRAIN_WEIGHT, MOVES_WEIGHT = 0.2, 0.01
"""Weights of strains and moves of M as it glides on Phi. Strain keeps a mesh fair, and weighs the same if the mesh is
refined."""

LEAN_WEIGHT = 1.0
"""Weight of the lean of axes in radians. With a larger one, the required distances are not reached."""

LARGEST_UPRIGHT_LEAN = np.radians(15.0)
"""Lean in radians up to which axes count as upright."""

UPRIGHT_MARGIN = np.radians(0.5)
"""Lean in radians below `LARGEST_UPRIGHT_LEAN` from which it is penalised, as a penalty leaves a small excess."""

UPRIGHT_WEIGHT = 100.0
"""Weight of the lean above `LARGEST_UPRIGHT_LEAN` less `UPRIGHT_MARGIN`."""

LEAST_FACE_TURN_COSINE = 0.8
"""Cosine of the turn of a face, below which the turn is penalised. A face that turns further has upright axes on
another shape."""

KEPT_SHAPE_WEIGHT = 100.0
"""Weight of violations of `LARGEST_BOUNDARY_DISTANCE`, `LEAST_FACE_TURN_COSINE`, `LEAST_KEPT_LENGTH` and
`LEAST_KEPT_TURN`."""

LEAST_KEPT_LENGTH = 0.6
"""Length of an edge over its length before, below which it is penalised. An edge without length has no direction,
hence no condition on S, which the optimisation would exploit."""

LEAST_KEPT_TURN = 0.03
"""Turn of a corner that was convex, in mean edge lengths, below which it is penalised; see `functionals.ConvexFaces`. A
penalty leaves a small excess, so it begins above `result_checks.LEAST_CONVEX_TURN`."""

IMAGE_MOVES_WEIGHT = 0.01
"""Weight of the moves of S: enough to determine S where nothing else does."""

VERTEX_AXES_WEIGHT, FACE_AXES_WEIGHT = 100.0, 3.0
"""Weights of the lean of inner vertices and of faces in S where a curvature is required: without them, S tilts until it
has any curvature at all, and means nothing. Vertices are the more accurate. Faces count at the boundary, and where
their normals waver: the mean of those around a vertex does not show that."""

CURVED_STRAIN_WEIGHT, CURVED_MOVES_WEIGHT = 0.005, 1e-4
"""Weights of strains and moves of M where a curvature is required: enough to decide where nothing else does. With ten
times as much, a hyperboloid stops short of the catenoid."""


@dataclass(frozen=True, eq=False)
class Objective:
    """Terms and constraints of one pair M, S under targets; Phi = surface; fixed: vertices of M that do not move."""

    pair: Pair
    targets: PairTargets
    surface: Surface | None
    keep_boundary: bool
    fixed: Indices = ()

    @property
    def mesh(self) -> Mesh:
        return self.pair.mesh

    @cached_property
    def blocks(self) -> Blocks:
        return Blocks({"M": self.mesh.vertices.shape, "S": self.mesh.vertices.shape})

    @cached_property
    def start(self) -> FloatArray:
        return self.blocks.join(M=in_edge_lengths(self.mesh), S=self.pair.gauss_image.vertices)

    @cached_property
    def world(self) -> AffineMap:
        """From M in x to the coordinates of the mesh."""
        return AffineMap.scaling(
            self.mesh.mean_edge_length, np.tile(self.mesh.vertices.mean(axis=0), self.mesh.n_vertices)
        )

    def mesh_at(self, x: FloatArray) -> Mesh:
        return self.mesh.with_vertices(self.world(self.blocks.split(x)["M"].ravel()).reshape(-1, 3))

    def pair_at(self, x: FloatArray) -> Pair:
        """Raises ParallelityError where S is not parallel to M."""
        return Pair(self.mesh_at(x), self.mesh.with_vertices(self.blocks.split(x)["S"]))

    # --- constraints

    @cached_property
    def constraint(self) -> Functional:
        """To be zero."""
        c, of = self.mesh.combinatorics, self.blocks.of
        x = self.blocks.split(self.start)["M"].ravel()
        parts: list[Functional] = [of(ParallelEdges(c), "M", "S"), of(PlanarFaces(c, x), "M")]
        is_fixed = MeshGuides.of(self.mesh, Guides(fixed=self.fixed)).is_fixed
        if is_fixed.any():
            parts.append(self._in_place(is_fixed))
        if self.targets.circular:
            parts.append(of(CircularFaces(c), "M"))
        if self.targets.conical:
            parts.append(of(ConicalVertices(c), "M"))
        if self.targets.mean is not None:
            H = self.targets.mean * self.mesh.mean_edge_length
            parts.append(ConstantCurvature(c, H, (abs(H) or self._bending) * self._areas))
        if self.targets.gaussian is not None:
            K = self.targets.gaussian * self.mesh.mean_edge_length**2
            parts.append(ConstantCurvature(c, -K, (abs(K) or self._bending**2) * self._areas, mixed=False))
        return StackedFunctional(parts)

    @property
    def _areas(self) -> FloatArray:
        """(F,) in l^2."""
        return np.asarray(np.linalg.norm(self.mesh.vector_areas, axis=1) / self.mesh.mean_edge_length**2)

    @property
    def _bending(self) -> float:
        """A curvature of M as given, over 1 / l: what zero is to be compared with."""
        c = self.mesh.combinatorics
        images = np.einsum("fi,fi->f", vector_areas(self.pair.gauss_image.vertices, c), self.mesh.face_normals)
        return float(np.sqrt(np.median(np.abs(images) / self._areas))) or 1.0

    # --- terms

    @cached_property
    def terms(self) -> list[tuple[float, Functional]]:
        return [*self._heights, *self._near, *self._upright, *self._kept]

    @property
    def _heights(self) -> list[tuple[float, Functional]]:
        c, targets, weight = self.mesh.combinatorics, self.targets, HEIGHT_WEIGHT / self.targets.height_error**2
        found: list[tuple[float, Functional]] = []
        if targets.edges:
            found.append((weight, EdgesAtUnitDistance(c)))
        if targets.vertices:
            found.append((weight, self.blocks.of(VerticesAtUnitDistance(c), "S")))
        if targets.faces:
            found.append((weight, FacesAtUnitDistance(c)))
        return found

    @property
    def _near(self) -> list[tuple[float, Functional]]:
        found: list[tuple[float, Functional]] = []
        if self.surface is not None:
            distances = ComposedFunctional(OnSmoothSurface(self.surface, self.mesh.combinatorics), self.world)
            found.append((PAIR_SURFACE_WEIGHT / self.mesh.mean_edge_length**2, self.blocks.of(distances, "M")))
        if self.keep_boundary:
            found += [(BOUNDARY_WEIGHT, functional) for functional, _ in self._on_boundary]
            near = [InsideBalls(functional, size, LARGEST_BOUNDARY_DISTANCE) for functional, size in self._on_boundary]
            found += [(KEPT_SHAPE_WEIGHT, Hinge(each, 0.0)) for each in near]
        return found

    @cached_property
    def _on_boundary(self) -> list[tuple[Functional, int]]:
        """Distances from the curves through the boundary loops as they were, two residuals for each vertex; its corners
        from where they were, three."""
        guides = MeshGuides.of(self.mesh, Guides(keep_boundary=True))
        curves = [OnCurve(curve, sliding, self.mesh.n_vertices) for curve, sliding in guides.curves if len(sliding)]
        sliding_on = [(Remembered(self.blocks.of(curve, "M")), 2) for curve in curves]
        return [*sliding_on, (self._in_place(guides.is_fixed), 3)]

    def _in_place(self, chosen: BoolArray) -> LinearFunctional:
        """Displacements of these vertices of M."""
        columns = coordinates(np.flatnonzero(chosen)).ravel()
        rows = csr_array(csr_array(eye_array(len(self.start)))[columns])
        return LinearFunctional(rows, self.start[columns])

    def boundary_distances(self, x: FloatArray) -> FloatArray:
        """(b,) of the vertices on the boundary from where it was, in l."""
        parts = [np.linalg.norm(on.residual(x).reshape(-1, size), axis=1) for on, size in self._on_boundary]
        return np.concatenate(parts)

    @property
    def _upright(self) -> list[tuple[float, Functional]]:
        c = self.mesh.combinatorics
        if self.surface is None:
            return self._axes if self.targets.curved else []
        found: list[tuple[float, Functional]] = [(LEAN_WEIGHT, CloseToNormals(c, self._normals))]
        if self.targets.upright:
            found.append(
                (UPRIGHT_WEIGHT, Hinge(InsideCones(c, self._normals, LARGEST_UPRIGHT_LEAN - UPRIGHT_MARGIN), 0.0))
            )
        return found

    @property
    def _axes(self) -> list[tuple[float, Functional]]:
        """S along the normals of M, of such a size that the sphere is halfway between its faces and its vertices."""
        mesh, c = self.mesh, self.mesh.combinatorics
        cosines = np.einsum("ci,ci->c", mesh.face_normals[c.corner_face], mesh.vertex_normals[c.corners])
        radius = float(cosines.mean()) ** -0.5
        inside = integers(np.flatnonzero(c.is_used & ~c.is_boundary_vertex))
        return [
            (VERTEX_AXES_WEIGHT, UprightVertices(c, inside, radius)),
            (FACE_AXES_WEIGHT, UprightFaces(c, 1 / radius)),
        ]

    def _normals(self, positions: FloatArray) -> FloatArray:
        """(N, 3) of Phi at the feet of M."""
        assert self.surface is not None
        return self.surface.closest(self.world(positions.ravel()).reshape(-1, 3))[1]

    @property
    def _kept(self) -> list[tuple[float, Functional]]:
        c, of = self.mesh.combinatorics, self.blocks.of
        lengths = self.mesh.edge_lengths / self.mesh.mean_edge_length
        return [
            (KEPT_SHAPE_WEIGHT, of(Hinge(EdgeStretch(c, lengths), float(np.log(LEAST_KEPT_LENGTH))), "M")),
            (KEPT_SHAPE_WEIGHT, Hinge(FaceNormalCosines(c, self.mesh.face_normals), LEAST_FACE_TURN_COSINE)),
            (KEPT_SHAPE_WEIGHT, of(Hinge(ConvexFaces(c, self.convex), LEAST_KEPT_TURN), "M")),
        ]

    @cached_property
    def convex(self) -> IntArray:
        """The faces that are convex in M as given."""
        c = self.mesh.combinatorics
        turns = ConvexFaces(c, np.arange(c.n_faces)).residual(self.blocks.split(self.start)["M"].ravel())
        return integers(np.flatnonzero(np.minimum.reduceat(turns, c.face_starts[:-1]) >= LEAST_CONVEX_TURN))

    def no_longer_convex(self, x: FloatArray) -> IntArray:
        """Those of them that are not any more."""
        c, sizes = self.mesh.combinatorics, self.mesh.combinatorics.face_sizes[self.convex]
        turns = ConvexFaces(c, self.convex).residual(self.blocks.split(x)["M"].ravel())
        return integers(np.unique(np.repeat(self.convex, sizes)[turns < 0]))

    @cached_property
    def metric(self) -> SparseMatrix:
        weights = (CURVED_MOVES_WEIGHT, CURVED_STRAIN_WEIGHT) if self.targets.curved else (MOVES_WEIGHT, STRAIN_WEIGHT)
        n = 3 * self.mesh.n_vertices
        moves = weights[0] * eye_array(n) + weights[1] * strain(self.mesh)
        return csr_array(block_diag([moves, IMAGE_MOVES_WEIGHT * eye_array(n)], format="csr"))

    @cached_property
    def penalties(self) -> list[float]:
        """Of the constraints: from the weights of the terms up."""
        first = max(10.0, max(weight for weight, _ in self.terms) / 10)
        return [first * 10.0**k for k in range(5)]
