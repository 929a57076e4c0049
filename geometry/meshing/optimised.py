"""The solver for planar, circular and conical meshes: constrained Newton steps that minimise moves and strain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, floats, integers, short_repr
from geometry.errors import GeometryError, described
from geometry.functionals import ConvexFaces, OnCurve, OnSurface, PlanarFaces, relative_plane_deviations, strain
from geometry.mesh import Mesh
from geometry.meshing.result_checks import (
    LEAST_CONVEX_TURN,
    Requirement,
    check_fixed_faces,
    check_free_vertices,
    check_result,
)
from geometry.meshing.vertex_guides import Effort, Guides, MeshGuides, in_edge_lengths
from geometry.optimise import (
    AffineMap,
    Blocks,
    ComposedFunctional,
    Functional,
    Hinge,
    Remembered,
    Solution,
    SparseMatrix,
    StackedFunctional,
    nearest_feasible,
)

__all__ = ["OptimisedMesh", "optimised"]

LONGEST_VERTEX_STEP = 0.6
"""Longest move of a vertex in one step, over the mean edge length. Longer steps leave the range of linearisation."""

SURFACE_WEIGHT = 10.0
"""Weight of squared distances from a surface, over the weight of squared moves. With more, vertices come nearer on
average but glide so far that edges collapse, since Newton's steps neglect the curvature of the constraints."""

FREE_SURFACE_DISTANCE = 0.05
"""Distance from a surface, in mean edge lengths, beyond which a vertex is attracted more strongly: it is half of what a
mesh may be off its surface."""

FAR_SURFACE_WEIGHT = 100.0
"""Weight of the squares of what distances exceed this by, over the weight of squared moves: 100 and 300 differ by a
hundredth of an edge, and neither changes the moves."""

BOUNDARY_CURVE_WEIGHT = 30.0
"""Weight of squared distances from the boundary as it was, where vertices glide on a surface, over the weight of
squared moves."""

KEPT_TURN = 0.35
"""Turn of a corner on a surface, see `ConvexFaces`, below which it is kept from becoming straight, in mean edge
lengths: 20 degrees between two edges of mean length. Without it single corners became straight and edges collapsed."""

KEPT_TURN_WEIGHT = 30.0
"""Weight of the squared shortfall of such a turn, over the weight of squared moves: 30 and 100 give the same meshes."""


@dataclass(frozen=True, eq=False)
class OptimisedMesh:
    """A mesh with planar faces, and figures about the optimisation.

    plane_deviation_before, _after: largest distance of a corner from the best plane of its face. residual_before,
    _after: largest residual of a face (`make_circular`) or of a vertex (`make_conical`, in radians), zero for
    `planarise`. moves (N,): how far each vertex moved, read-only; they show whether the result still has the given
    shape. surface_distance: the largest distance of a vertex from the surface, None without one. Lengths are relative
    to the mean edge length of the given mesh. `reason` says why the solver stopped.

    >>> import geometry
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(6, 6)
    >>> shell = grid.with_vertices([(x, y, -0.05 * (x * x + x * y / 4 + y * y)) for x, y, _ in grid.vertices])
    >>> result = geometry.planarise(shell)
    >>> result.moves.shape, result.iterations > 0, result.reason
    ((49,), True, 'the constraints hold')
    >>> result.move_of(0.95) < result.largest_move < 0.1
    True
    """

    __repr__ = short_repr

    mesh: Mesh
    iterations: int
    plane_deviation_before: float
    plane_deviation_after: float
    residual_before: float
    residual_after: float
    largest_move: float
    mean_move: float
    moves: FloatArray
    surface_distance: float | None
    reason: str

    def move_of(self, share: float) -> float:
        """The move that a share, 0 to 1, of the vertices do not exceed; vertices without faces do not count."""
        if not 0 <= share <= 1:
            raise GeometryError(f"the share of the vertices is {share}: a number from 0 to 1 is needed", value=share)
        return float(np.quantile(self.moves[self.mesh.combinatorics.is_used], share))


def optimised(
    mesh: Mesh,
    requirement: Requirement,
    guides: Guides,
    effort: Effort,
) -> OptimisedMesh:
    """A mesh with planar faces that meets the requirement, near the given mesh or on the surface of the guides.

    Raises as `MeshGuides.of` does, ConvergenceError where a residual is larger than the tolerance, and FoldedError
    where an edge or face folds over.
    """
    if not isinstance(guides, Guides):
        raise GeometryError(f"the guides are {described(guides)}: write Guides(fairness=0.3, fixed=[0])")
    if not isinstance(effort, Effort):
        raise GeometryError(f"the effort is {described(effort)}: write Effort(max_steps=100)")
    mesh_guides = MeshGuides.of(mesh, guides)
    problem = _Problem(mesh, _with_advice(mesh, requirement, mesh_guides), mesh_guides)
    if problem.is_solved(effort.tolerance):
        return problem.record(mesh, 0, "the given mesh meets all requirements")
    if problem.guides.is_fixed.any():
        check_fixed_faces(mesh, problem.guides, effort.tolerance)
        check_free_vertices(mesh, problem.requirement, problem.guides)
    solution = problem.solve(effort)
    result = problem.mesh_at(solution.x)
    check_result(mesh, result, problem.requirement, problem.guides, solution, effort.tolerance)
    return problem.record(result, solution.steps, solution.reason.value)


def _with_advice(mesh: Mesh, requirement: Requirement, guides: MeshGuides) -> Requirement:
    """The requirement, with the advice to fix fewer vertices where planar faces make more equations than there are free
    coordinates."""
    dimension = guides.expected_dimension(mesh)
    if dimension >= 0 or not guides.is_fixed.any():
        return requirement
    n_free = int(guides.is_free(mesh).sum())
    advice = (
        f"planar faces make {-dimension} more equations than the {n_free} free vertices have coordinates: fix fewer"
    )
    return replace(requirement, advice=advice)


@dataclass(frozen=True, eq=False)
class _Problem:
    """The unknown x (3N,): the vertices as given by `in_edge_lengths`."""

    mesh: Mesh
    requirement: Requirement
    guides: MeshGuides

    @cached_property
    def start(self) -> FloatArray:
        return in_edge_lengths(self.mesh).ravel()

    @cached_property
    def coordinates_of(self) -> AffineMap:
        """The map from x to the coordinates of the mesh."""
        centre = self.mesh.vertices.mean(axis=0)
        return AffineMap.scaling(self.mesh.mean_edge_length, np.tile(centre, self.mesh.n_vertices))

    def mesh_at(self, x: FloatArray) -> Mesh:
        moved = self.coordinates_of(x).reshape(-1, 3)
        return self.mesh.with_vertices(np.where(self.guides.is_fixed[:, None], self.mesh.vertices, moved))

    def is_solved(self, tolerance: float) -> bool:
        """Whether the given mesh meets all requirements."""
        convex = self.guides.convex
        return (
            self.plane_deviation_before <= tolerance
            and self.residual_before <= tolerance
            and (not len(convex) or float(self.turns.residual(self.start).min()) >= LEAST_CONVEX_TURN - tolerance)
            and (self.surface_distance(self.mesh) or 0.0) <= tolerance
        )

    @cached_property
    def plane_deviation_before(self) -> float:
        return float(relative_plane_deviations(self.mesh).max())

    @cached_property
    def residual_before(self) -> float:
        return float(self.requirement.deviations(self.mesh).max(initial=0.0))

    # --- constraints and soft terms

    @cached_property
    def constraint(self) -> Functional:
        """Zero where faces are planar, the requirement is met and vertices are on their curves."""
        n = self.mesh.n_vertices
        planar = PlanarFaces(self.mesh.combinatorics, self.start)
        extra = [] if self.requirement.functional is None else [self.requirement.functional]
        curves = [OnCurve(curve, vertices, n) for curve, vertices in self.guides.curves if len(vertices)]
        return StackedFunctional([planar, *extra, *curves]) if extra or curves else planar

    @cached_property
    def turns(self) -> ConvexFaces:
        """The turns of the corners of convex faces, which have to be at least `LEAST_CONVEX_TURN`."""
        return ConvexFaces(self.mesh.combinatorics, self.guides.convex)

    @cached_property
    def soft_terms(self) -> list[tuple[float, Functional]]:
        """The functionals that are minimised, with their weights."""
        surface = self.guides.surface
        if surface is None:
            return []
        vertices = integers(np.flatnonzero(self.mesh.combinatorics.is_used))
        on_surface = Remembered(OnSurface(surface, vertices, self.mesh.n_vertices))
        distances = ComposedFunctional(on_surface, self.coordinates_of)
        length = self.mesh.mean_edge_length
        far = Hinge(distances, -FREE_SURFACE_DISTANCE * length, FREE_SURFACE_DISTANCE * length)
        found: list[tuple[float, Functional]] = [
            (SURFACE_WEIGHT / length**2, distances),
            (FAR_SURFACE_WEIGHT / length**2, far),
        ]
        boundary = [OnCurve(curve, sliding, self.mesh.n_vertices) for curve, sliding in self.guides.boundary]
        found.append((KEPT_TURN_WEIGHT, self._kept_turns))
        return [*found, *((BOUNDARY_CURVE_WEIGHT, curve) for curve in boundary if len(curve.vertices))]

    @property
    def _kept_turns(self) -> Functional:
        """How far the turns of corners are below `KEPT_TURN`, or below those in the given mesh where these are less."""
        c = self.mesh.combinatorics
        turns = ConvexFaces(c, integers(np.arange(c.n_faces)))
        return Hinge(turns, np.minimum(KEPT_TURN, turns.residual(self.start)))

    @cached_property
    def metric(self) -> SparseMatrix:
        """(3N, 3N) of squared moves plus fairness times strain."""
        return csr_array(eye_array(len(self.start)) + self.guides.fairness * strain(self.mesh))

    def solve(self, effort: Effort) -> Solution:
        """Solved for the coordinates of free vertices only; x of the solution holds those of all vertices."""
        fixed = np.repeat(self.guides.is_fixed, 3)
        some_fixed, all_from_free = bool(fixed.any()), AffineMap.fixing(self.start, fixed)

        def of_free(functional: Functional) -> Functional:
            return ComposedFunctional(functional, all_from_free) if some_fixed else functional

        free = np.flatnonzero(~fixed)
        found = nearest_feasible(
            of_free(self.constraint),
            self.start[free],
            csr_array(self.metric[free][:, free]) if some_fixed else self.metric,
            soft_terms=[(weight, of_free(functional)) for weight, functional in self.soft_terms],
            inequality=of_free(self.turns) if len(self.guides.convex) else None,
            lower_bound=LEAST_CONVEX_TURN,
            tolerance=effort.tolerance / 4,  # the distance of a corner is at most the norm of the residuals of its face
            longest_step=LONGEST_VERTEX_STEP,
            blocks=Blocks({"free vertices": (len(free) // 3, 3)}),
            anchored_steps=self.requirement.anchored_steps if effort.anchored_steps is None else effort.anchored_steps,
            max_steps=effort.max_steps,
        )
        return Solution(all_from_free(found.x), found.multipliers, found.violation, found.steps, found.reason)

    # --- the result

    def surface_distance(self, mesh: Mesh) -> float | None:
        """Largest distance of a vertex from the surface, in mean edge lengths of the given mesh."""
        if self.guides.surface is None:
            return None
        points = mesh.vertices[mesh.combinatorics.is_used]
        feet = self.guides.surface.closest(points)[0]
        return float(np.linalg.norm(points - feet, axis=1).max()) / self.mesh.mean_edge_length

    def record(self, result: Mesh, iterations: int, reason: str) -> OptimisedMesh:
        moves = np.linalg.norm(result.vertices - self.mesh.vertices, axis=1) / self.mesh.mean_edge_length
        return OptimisedMesh(
            mesh=result,
            iterations=iterations,
            plane_deviation_before=self.plane_deviation_before,
            plane_deviation_after=float(relative_plane_deviations(result).max()),
            residual_before=self.residual_before,
            residual_after=float(self.requirement.deviations(result).max(initial=0.0)),
            largest_move=float(moves.max()),
            mean_move=float(moves.mean()),
            moves=floats(moves),
            surface_distance=self.surface_distance(result),
            reason=reason,
        )
