"""The engine behind planar, circular and conical meshes: constrained Newton steps of least moves and strain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, floats, integers, short_repr
from geometry.errors import GeometryError
from geometry.functionals import ConvexFaces, OnCurve, OnSurface, PlanarFaces, relative_plane_deviations, strain
from geometry.mesh import Mesh
from geometry.meshing.result_checks import LEAST_CONVEX_TURN, Aim, check_fixed_faces, check_outcome
from geometry.meshing.vertex_guides import Effort, Guides, MeshGuides, in_edge_lengths
from geometry.optimise import (
    AffineMap,
    Blocks,
    ComposedFunctional,
    Functional,
    Reason,
    Solution,
    SparseMatrix,
    StackedFunctional,
    nearest_feasible,
)

__all__ = ["OptimisedMesh", "optimised"]

LONGEST_VERTEX_STEP = 0.6
"""Longest move of a vertex in one step, over the mean edge length: as far as one moves in the mean of all directions
whose largest coordinate moves by a half."""

SURFACE_WEIGHT = 10.0
"""Weight of squared distances from a surface, over that of squared moves. With more, vertices come nearer in the mean,
but glide so far that edges collapse: Newton's steps leave out how constraints curve."""


@dataclass(frozen=True, eq=False)
class OptimisedMesh:
    """A mesh with planar faces, and what it took.

    Planarity is the largest distance of a corner from its face's best plane. The deviation is what a circular or
    conical mesh is off by: the largest circularity of a face or conicality (radians) of a vertex, as the norm of what
    the functional of that name finds; zero where neither is asked. moves (N,): how far each vertex moved, read-only;
    they tell whether the result is the shape that was given. surface_distance: the largest distance of a vertex
    from the surface, None without one. Lengths are parts of the mean edge length l of the mesh as given. `reason` says
    why the method stopped.
    """

    __repr__ = short_repr

    mesh: Mesh
    iterations: int
    planarity_before: float
    planarity_after: float
    deviation_before: float
    deviation_after: float
    largest_move: float
    mean_move: float
    moves: FloatArray
    surface_distance: float | None
    reason: str

    def move_of(self, share: float) -> float:
        """The move that this share of the vertices do not exceed, from 0 to 1; vertices without faces do not count."""
        if not 0 <= share <= 1:
            raise GeometryError(f"the share of the vertices is {share}: a number from 0 to 1 is needed", value=share)
        return float(np.quantile(self.moves[self.mesh.combinatorics.is_used], share))


def optimised(
    mesh: Mesh,
    aim: Aim,
    guides: Guides,
    effort: Effort,
) -> OptimisedMesh:
    """The mesh with planar faces that reaches the aim, near to the one given or on the surface.

    Raises as `MeshGuides.of` does, ConvergenceError where something is off by more than the tolerance,
    and FoldedError where an edge or face folded over on the way.
    """
    task = _Task(mesh, aim, MeshGuides.of(mesh, guides))
    if task.is_done(effort.tolerance):
        return task.record(mesh, 0, "nothing was to be done")
    if task.guides.is_fixed.any():
        check_fixed_faces(mesh, task.guides, effort.tolerance)
    solution = task.solve(effort)
    result = task.mesh_at(solution.x)
    check_outcome(mesh, result, aim, task.guides, solution, effort.tolerance)
    return task.record(result, solution.steps, solution.reason.value)


@dataclass(frozen=True, eq=False)
class _Task:
    """The unknown x (3N,): vertices as `in_edge_lengths` has them."""

    mesh: Mesh
    aim: Aim
    guides: MeshGuides

    @cached_property
    def start(self) -> FloatArray:
        return in_edge_lengths(self.mesh).ravel()

    @cached_property
    def world(self) -> AffineMap:
        """From x to the coordinates of the mesh."""
        centre = self.mesh.vertices.mean(axis=0)
        return AffineMap.scaling(self.mesh.mean_edge_length, np.tile(centre, self.mesh.n_vertices))

    def mesh_at(self, x: FloatArray) -> Mesh:
        moved = self.world(x).reshape(-1, 3)
        return self.mesh.with_vertices(np.where(self.guides.is_fixed[:, None], self.mesh.vertices, moved))

    def is_done(self, tolerance: float) -> bool:
        """Whether the mesh may stay as it is."""
        convex = self.guides.convex
        return (
            self.planarity_before <= tolerance
            and self.deviation_before <= tolerance
            and (not len(convex) or float(self.turns.residual(self.start).min()) >= LEAST_CONVEX_TURN - tolerance)
            and (self.surface_distance(self.mesh) or 0.0) <= tolerance
        )

    @cached_property
    def planarity_before(self) -> float:
        return float(relative_plane_deviations(self.mesh).max())

    @cached_property
    def deviation_before(self) -> float:
        return float(self.aim.deviations(self.mesh).max(initial=0.0))

    # --- what is asked

    @cached_property
    def constraint(self) -> Functional:
        """To be zero."""
        n = self.mesh.n_vertices
        planar = PlanarFaces(self.mesh.combinatorics, self.start)
        aims = [] if self.aim.functional is None else [self.aim.functional]
        curves = [OnCurve(curve, vertices, n) for curve, vertices in self.guides.curves if len(vertices)]
        return StackedFunctional([planar, *aims, *curves]) if aims or curves else planar

    @cached_property
    def turns(self) -> ConvexFaces:
        """To be at least `LEAST_CONVEX_TURN`."""
        return ConvexFaces(self.mesh.combinatorics, self.guides.convex)

    @cached_property
    def soft_terms(self) -> list[tuple[float, Functional]]:
        """To be small, with their weights."""
        surface = self.guides.surface
        if surface is None:
            return []
        vertices = integers(np.flatnonzero(self.mesh.combinatorics.is_used))
        distances = ComposedFunctional(OnSurface(surface, vertices, self.mesh.n_vertices), self.world)
        return [(SURFACE_WEIGHT / self.mesh.mean_edge_length**2, distances)]

    @cached_property
    def metric(self) -> SparseMatrix:
        """Of moves."""
        return csr_array(eye_array(len(self.start)) + self.guides.fairness * strain(self.mesh))

    def solve(self, effort: Effort) -> Solution:
        """By the entries that are free: those of fixed vertices are eliminated. In the solution, x has all of them."""
        fixed = np.repeat(self.guides.is_fixed, 3)
        if fixed.all():
            violation = float(np.abs(self.constraint.residual(self.start)).max(initial=0.0))
            return Solution(self.start, np.zeros(0), violation, 0, Reason.STALLED)
        some, rest = bool(fixed.any()), AffineMap.fixing(self.start, fixed)

        def of_free(functional: Functional) -> Functional:
            return ComposedFunctional(functional, rest) if some else functional

        free = np.flatnonzero(~fixed)
        found = nearest_feasible(
            of_free(self.constraint),
            self.start[free],
            csr_array(self.metric[free][:, free]) if some else self.metric,
            soft_terms=[(weight, of_free(functional)) for weight, functional in self.soft_terms],
            inequality=of_free(self.turns) if len(self.guides.convex) else None,
            least=LEAST_CONVEX_TURN,
            tolerance=effort.tolerance / 4,  # a corner's distance is at most its face's residuals' norm
            longest_step=LONGEST_VERTEX_STEP,
            blocks=Blocks({"free vertices": (len(free) // 3, 3)}),
            anchored_steps=self.aim.anchored_steps if effort.anchored_steps is None else effort.anchored_steps,
            max_steps=effort.max_steps,
        )
        return Solution(rest(found.x), found.multipliers, found.violation, found.steps, found.reason)

    # --- what came of it

    def surface_distance(self, mesh: Mesh) -> float | None:
        """Largest distance of a vertex from the surface, in mean edge lengths of the mesh as given."""
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
            planarity_before=self.planarity_before,
            planarity_after=float(relative_plane_deviations(result).max()),
            deviation_before=self.deviation_before,
            deviation_after=float(self.aim.deviations(result).max(initial=0.0)),
            largest_move=float(moves.max()),
            mean_move=float(moves.mean()),
            moves=floats(moves),
            surface_distance=self.surface_distance(result),
            reason=reason,
        )
