"""The space P(M) of the meshes parallel to a mesh M [Pottmann2007, 2.2]."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, IntArray, floats, short_repr
from geometry.errors import GeometryError, MeshError, finite_number
from geometry.functionals import parallel_to
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.optimise import ConstrainedQuadratic, LinearFunctional, SparseMatrix
from geometry.parallel.blending import weight_ranges
from geometry.parallel.constraints import FactorBounds, FixedVertices, Objective
from geometry.parallel.edge_closure import EdgeClosure
from geometry.parallel.edge_parallelity import check_parallel, check_planar, edge_factors, parallelity
from geometry.parallel.face_unknowns import FaceUnknowns
from geometry.parallel.minimising import ELEMENT_TOLERANCE, minimising_mesh
from geometry.parallel.optimality import optimal_mesh
from geometry.parallel.sampling import ElementSampler
from geometry.parallel.spectrum import Spectrum, least_singular_vectors, null_dimension, zero_threshold

__all__ = ["ParallelSpace"]

MAX_BASIS_NUMBERS = 50_000_000
"""Largest number of floats in a basis: 0.4 GB."""

INDEPENDENCE_TOLERANCE = 1e-10
"""Component of a random element perpendicular to those before it, over the largest one; a smaller one is rounding."""

REORTHONORMALISATION_RATIO = 1e-2
"""The same component, below which elements lose digits of parallelity when made orthonormal, so it is restored."""


@dataclass(frozen=True, eq=False)
class ParallelSpace:
    """P(M): the meshes S over the same combinatorics whose edges are parallel to those of M.

    `dimension`, `spectrum` and `expected_dimension` take any mesh; everything else needs planar faces and raises
    GeometryError for a face off its plane by more than `PLANARITY_TOLERANCE`. Everything raises MeshError for an edge
    of M without length, and for another mesh that does not have the faces of M. Factors are kept for the next call.

    >>> from geometry.mesh import shapes
    >>> box = shapes.box(1, 2, 3)
    >>> space = ParallelSpace(box)
    >>> space.dimension, space.contains(shapes.box(2, 2, 7)), len(space.elements(2))
    (6, True, 2)
    >>> space.blend([0.5, 0.5], [box, shapes.box(3, 2, 3)]).edge_lengths.max().item()
    3.0
    >>> wider = space.minimise(linear=-box.vertices, factor_bounds=(1, 2))  # as large as the bounds allow
    >>> (wider.edge_lengths / box.edge_lengths).round(6).tolist() == [2.0] * 12
    True
    """

    __repr__ = short_repr

    mesh: Mesh

    def __post_init__(self) -> None:
        object.__setattr__(self, "mesh", as_mesh(self.mesh))

    @cached_property
    def matrix(self) -> SparseMatrix:
        """A (2E, 3N): s is in P(M) where A s = 0."""
        return parallel_to(self.mesh).matrix

    # --- dimension

    @property
    def expected_dimension(self) -> int:
        """E - 2F + 3 chi, an estimate: the true dimension is often larger, seldom smaller.

        The paper's E - 2F + 3 holds for discs; each independent loop around a hole or handle adds three equations.
        """
        mesh = self.mesh
        return mesh.n_edges - 2 * mesh.n_faces + 3 * mesh.combinatorics.euler_characteristic

    @property
    def dimension(self) -> int:
        """The dimension that the gap in `spectrum` shows, translations included."""
        return self.spectrum.dimension

    def free_dimension(self, fixed: Sequence[int] | IntArray) -> int:
        """The dimension that remains where some vertices are fixed: 0 where no other vertex can move within P(M).

        fixed (k,): vertices. It is the dimension of the meshes in P(M) with these vertices at the origin. Computes a
        basis, so raises as `basis` does; GeometryError for a vertex that does not exist; and RankError, with the
        singular values, where rounding decides about the dimension.

        >>> from geometry import ParallelSpace
        >>> from geometry.mesh import shapes
        >>> grid = shapes.grid(4, 3)
        >>> space, boundary = ParallelSpace(grid), grid.combinatorics.is_boundary_vertex.nonzero()[0]
        >>> space.dimension, space.free_dimension([0]), space.free_dimension([0, 19]), space.free_dimension(boundary)
        (10, 7, 5, 0)
        """
        vertices = np.unique(np.asarray(fixed, dtype=np.int64))
        wrong = vertices[(vertices < 0) | (vertices >= self.mesh.n_vertices)]
        if len(wrong):
            raise GeometryError(
                f"fixed names vertex {wrong[0]}, but there are {self.mesh.n_vertices} vertices",
                elements=wrong.tolist(),
                value=float(wrong[0]),
                bound=self.mesh.n_vertices - 1,
            )
        return null_dimension(self.basis[:, vertices].reshape(self.dimension, -1).T)

    @cached_property
    def spectrum(self) -> Spectrum:
        """The singular values around the gap, by inverse iteration on few vectors, for up to a million faces.

        Vertices that belong to no face do not count. Raises RankError, with the singular values, where they have no
        gap, mostly because faces are not planar enough; and GeometryError where very many singular values are zero and
        the mesh is large.
        """
        closure = self._closure
        equations, unknowns = closure.matrix.shape
        extra = max(0, unknowns - equations) + 3 * self._n_parts
        return Spectrum.of(self._least[0], extra, closure.deviation)

    @cached_property
    def _closure(self) -> EdgeClosure:
        return EdgeClosure(self.mesh)

    @cached_property
    def _least(self) -> tuple[FloatArray, FloatArray]:
        return least_singular_vectors(self._closure, zero_threshold(self._closure.deviation))

    @cached_property
    def _sampler(self) -> ElementSampler:
        check_planar(self.mesh)
        values, vectors = self._least
        return ElementSampler(self._closure, vectors[:, values <= zero_threshold(self._closure.deviation)])

    @property
    def _n_parts(self) -> int:
        return len(np.unique(self._closure.parts[self.mesh.combinatorics.is_used]))

    # --- elements

    @cached_property
    def basis(self) -> FloatArray:
        """(dimension, N, 3), read-only: orthonormal as vectors (3N,). Translations come first.

        Vertices that belong to no face are at the origin. Raises RankError where the dimension is uncertain, and
        GeometryError where the basis has more than `MAX_BASIS_NUMBERS` numbers; use `elements` then.
        """
        check_planar(self.mesh)
        numbers = 3.0 * self.mesh.n_vertices * self.dimension
        if numbers > MAX_BASIS_NUMBERS:
            raise GeometryError(
                f"a basis of P(M) takes {self.dimension} meshes of {self.mesh.n_vertices} vertices, {numbers:.1e} "
                f"numbers; at most {MAX_BASIS_NUMBERS:.0e} are allowed; take some `elements`, or minimise without a "
                "basis",
                value=numbers,
                bound=MAX_BASIS_NUMBERS,
            )
        others = self._orthonormal(self.dimension - 3 * self._n_parts, seed=0)
        return floats(np.concatenate([self._translations(), others]))

    def elements(self, count: int, *, seed: int = 0) -> list[Mesh]:
        """Random elements of P(M), orthonormal as vectors (3N,), with the mean of each connected part at the origin.

        Another seed gives others. For meshes of any size, with one factor of a matrix of twice the number of faces.
        Raises GeometryError where `count` is above the dimension of P(M) without translations.
        """
        if count < 1:
            raise GeometryError(f"the number of elements is {count}: it must be 1 or more", value=count, bound=1)
        return [self.mesh.with_vertices(vertices) for vertices in self._orthonormal(count, seed)]

    def project(self, mesh: MeshLike) -> Mesh:
        """The element of P(M) nearest to a mesh: the sum of squared distances of the vertices is least.

        It is parallel to M within `ELEMENT_TOLERANCE` times the size of the given mesh. Raises ConvergenceError where
        that is not reached, and RankError, naming edges and singular values, where rounding decides which element is
        the nearest.
        """
        mesh = as_mesh(mesh)
        if not self.mesh.combinatorics.same_as(mesh.combinatorics):
            raise MeshError("the two meshes do not have the same faces, so they cannot be parallel")
        centre = mesh.vertices.mean(axis=0)  # translations are in P(M), so that rounding need not see them
        target = (mesh.vertices - centre).ravel()
        size = float(np.abs(target).max())
        found = optimal_mesh(
            self._unknowns,
            self._nearest,
            self._unknowns.of(target),
            origin=np.zeros(len(target)),
            size=size,
            bounds=(ELEMENT_TOLERANCE * size, ELEMENT_TOLERANCE * size),
            what="the projection",
        )
        return found.with_vertices(found.vertices + centre)

    def contains(self, mesh: MeshLike) -> bool:
        """Whether a mesh is parallel to M, within `ELEMENT_TOLERANCE` times its largest coordinate."""
        mesh = as_mesh(mesh)
        return bool(parallelity(self.mesh, mesh).max() <= self._allowed(mesh))

    def blend(self, weights: Sequence[float], meshes: Sequence[Mesh]) -> Mesh:
        """The linear combination of meshes in P(M) [Pottmann2007, Fig. 5]; `blend_ranges` limits the weights.

        Raises ParallelityError, naming the edge, for a mesh that is not in P(M), and GeometryError where
        weights are not finite or not as many as meshes.
        """
        self._check_blend(weights, meshes)
        vertices = np.einsum("k,kni->ni", np.asarray(weights, dtype=np.float64), [m.vertices for m in meshes])
        return self.mesh.with_vertices(vertices)

    def blend_ranges(self, weights: Sequence[float], meshes: Sequence[Mesh]) -> FloatArray:
        """(k, 2) lower and upper limits of each weight of a blend, the others unchanged, at which an edge collapses.

        Beyond a limit that edge runs opposite to its direction in the blend; infinite where no edge sets a limit.
        Raises as `blend` does, and GeometryError, naming the edge, for an edge without length in the blend.

        >>> from geometry import ParallelSpace
        >>> from geometry.mesh import shapes
        >>> box = shapes.box(1, 2, 3)
        >>> wider, higher = shapes.box(2, 2, 3), shapes.box(1, 2, 4)
        >>> ParallelSpace(box).blend_ranges([1, 0, 0], [box, wider, higher]).tolist()
        [[0.0, inf], [-0.5, inf], [-0.75, inf]]
        """
        self._check_blend(weights, meshes)
        factors = np.stack([edge_factors(self.mesh, mesh) for mesh in meshes])
        return weight_ranges(np.asarray(weights, dtype=np.float64), factors)

    def _check_blend(self, weights: Sequence[float], meshes: Sequence[Mesh]) -> None:
        if len(weights) != len(meshes) or not len(meshes):
            raise GeometryError(f"{len(weights)} weights are given for {len(meshes)} meshes: give one for each mesh")
        for place, (weight, mesh) in enumerate(zip(weights, meshes, strict=True)):
            finite_number(f"the weight of mesh {place}", weight)
            check_parallel(self.mesh, mesh, self._allowed(mesh), what=f"mesh {place}")

    def minimise(
        self,
        quadratic: Iterable[tuple[float, LinearFunctional]] = (),
        *,
        linear: Any = None,
        fixed: Mapping[int, Any] | None = None,
        factor_bounds: tuple[Any, Any] | None = None,
    ) -> Mesh:
        """The element of P(M) with the least sum of weight |r(x)|^2 over the quadratic terms plus linear . x.

        quadratic: weights and functionals of all coordinates x (3N,); linear (3N,) or (N, 3): a gradient; fixed:
        positions of some vertices; factor_bounds: lower and upper bounds of the edge factors (1), numbers or arrays
        (E,), infinite where there is no bound. Signs of edges are the bounds (0, inf) and (-inf, 0)
        [Pottmann2007, Fig. 11].

        Of several minimisers the result is the nearest to M: if the objective is fairness alone, the mesh shrinks to a
        point at the centroid of M. With bounds it may be any of the minimisers.

        Edges are parallel and fixed vertices in place within `ELEMENT_TOLERANCE` times the largest coordinate; bounds
        hold within `FACTOR_BOUND_TOLERANCE` times that. Raises GeometryError where fixed vertices or bounds contradict
        each other or leave nothing free (see `free_dimension`), where there is no least value, and for values that are
        not finite or of the wrong shape; ConvergenceError where the solver does not reach that accuracy, or not the
        minimum; RankError, naming edges and singular values, where rounding decides about the minimum.
        """
        return minimising_mesh(
            self._unknowns,
            Objective.of(self.mesh, quadratic, linear),
            FixedVertices.of(self.mesh, fixed),
            None if factor_bounds is None else FactorBounds.of(self.mesh, factor_bounds),
        )

    # --- solving

    @cached_property
    def _unknowns(self) -> FaceUnknowns:
        check_planar(self.mesh)
        return FaceUnknowns(self.mesh)

    @cached_property
    def _nearest(self) -> ConstrainedQuadratic:
        A = self._unknowns.constraints
        return ConstrainedQuadratic(csr_array(eye_array(A.shape[1])), A)

    def _orthonormal(self, count: int, seed: int) -> FloatArray:
        """(count, N, 3) orthonormal elements, each part with its mean at the origin."""
        sampler = self._sampler
        columns, sizes = _orthonormalised(sampler.random(count, seed))
        if sizes.min() < INDEPENDENCE_TOLERANCE * sizes.max():
            rank = int((sizes >= INDEPENDENCE_TOLERANCE * sizes.max()).sum())
            raise GeometryError(
                f"{count} independent elements are asked for, but P(M) has {rank} dimensions only, beside translations",
                value=count,
                bound=rank,
            )
        if sizes.min() < REORTHONORMALISATION_RATIO * sizes.max():
            columns, _ = _orthonormalised(sampler.nearest(columns.T.reshape(count, -1, 3)))
        return columns.T.reshape(count, -1, 3)

    def _allowed(self, mesh: Mesh) -> float:
        return ELEMENT_TOLERANCE * float(np.abs(mesh.vertices).max())

    def _translations(self) -> FloatArray:
        """(3 parts, N, 3) orthonormal translations of the connected parts."""
        parts = self._closure.parts
        used = np.unique(parts[self.mesh.combinatorics.is_used])
        inside = (parts == used[:, None]) / np.sqrt(np.bincount(parts)[used])[:, None]
        return np.asarray(np.einsum("cn,ik->cink", inside, np.eye(3)).reshape(-1, self.mesh.n_vertices, 3))


def _orthonormalised(meshes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Columns (3N, k) with the span of meshes (k, N, 3), and the size of what each adds to the span before it (k,)."""
    columns, triangle = np.linalg.qr(meshes.reshape(len(meshes), -1).T)
    return columns, np.abs(np.diag(triangle))
