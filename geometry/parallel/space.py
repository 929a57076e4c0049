"""The space P(M) of the meshes parallel to a mesh M [Pottmann2007, 2.2]."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, IntArray, floats, short_repr
from geometry.errors import GeometryError, MeshError
from geometry.functionals import parallel_to
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.optimise import ConstrainedQuadratic, LinearFunctional, SparseMatrix
from geometry.parallel.blending import weight_ranges
from geometry.parallel.constraints import FactorBounds, Fixed, Objective
from geometry.parallel.edge_closure import EdgeClosure
from geometry.parallel.edge_parallelity import check_parallel, check_planar, edge_factors, parallelity
from geometry.parallel.face_unknowns import FaceUnknowns
from geometry.parallel.minimising import ELEMENT_TOLERANCE, minimum
from geometry.parallel.optimality import optimum
from geometry.parallel.sampling import ElementSampler
from geometry.parallel.spectrum import Spectrum, least_singular_vectors, null_dimension, zero_threshold

__all__ = ["ParallelSpace"]

MAX_BASIS_NUMBERS = 50_000_000
"""Numbers in a basis: 0.4 GB."""

INDEPENDENCE_TOLERANCE = 1e-10
"""What a random member adds to the span of those before it, over the largest: less is rounding."""

REORTHONORMALISATION_RATIO = 1e-2
"""The same: less costs digits of parallelity when members are made orthonormal, so they are mended afterwards."""


@dataclass(frozen=True, eq=False)
class ParallelSpace:
    """P(M): the meshes S over the same combinatorics whose edges are parallel to those of M.

    `dimension`, `spectrum` and `expected_dimension` take any mesh; everything else needs planar faces and raises
    GeometryError for a face off its plane by more than `PLANARITY_TOLERANCE`. Everything raises MeshError for an edge
    of M without length, and for another mesh that does not have the faces of M. Factors are kept for the next call.
    """

    __repr__ = short_repr

    mesh: Mesh

    def __post_init__(self) -> None:
        object.__setattr__(self, "mesh", as_mesh(self.mesh))

    @cached_property
    def matrix(self) -> SparseMatrix:
        """A (2E, 3N): A s = 0 says that s is in P(M)."""
        return parallel_to(self.mesh).matrix

    # --- dimension

    @property
    def expected_dimension(self) -> int:
        """E - 2F + 3 chi: a guide. The true dimension is often more, seldom less.

        The paper's E - 2F + 3 is meant for discs; each further loop of a mesh that is not simply connected closes
        by three more equations.
        """
        mesh = self.mesh
        return mesh.n_edges - 2 * mesh.n_faces + 3 * mesh.combinatorics.euler_characteristic

    @property
    def dimension(self) -> int:
        """The dimension that the gap in `spectrum` shows, translations included."""
        return self.spectrum.dimension

    def free_dimension(self, fixed: Sequence[int] | IntArray) -> int:
        """What is left of the dimension when some vertices are fixed: 0 where nothing else can move within P(M).

        fixed (k,): vertices. That of the meshes in P(M) that have these vertices at the origin. Takes a basis, so
        raises as `basis` does; GeometryError for a vertex that does not exist; and RankError, with the singular values,
        where rounding decides about the dimension.

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
                f"vertex {wrong[0]} is to be fixed, but there are {self.mesh.n_vertices} vertices",
                elements=wrong.tolist(),
                value=float(wrong[0]),
                bound=self.mesh.n_vertices - 1,
            )
        return null_dimension(self.basis[:, vertices].reshape(self.dimension, -1).T)

    @cached_property
    def spectrum(self) -> Spectrum:
        """Found by inverse iteration on few vectors, for up to a million faces.

        Vertices that belong to no face do not count. Raises RankError, saying the singular values, where
        they have no gap: mostly since the faces are not planar enough; and GeometryError where very many singular
        values are zero and the mesh is large.
        """
        closing = self._closing
        equations, unknowns = closing.matrix.shape
        spare = max(0, unknowns - equations) + 3 * self._n_parts
        return Spectrum.of(self._least[0], spare, closing.deviation)

    @cached_property
    def _closing(self) -> EdgeClosure:
        return EdgeClosure(self.mesh)

    @cached_property
    def _least(self) -> tuple[FloatArray, FloatArray]:
        return least_singular_vectors(self._closing, zero_threshold(self._closing.deviation))

    @cached_property
    def _members(self) -> ElementSampler:
        check_planar(self.mesh)
        values, vectors = self._least
        return ElementSampler(self._closing, vectors[:, values <= zero_threshold(self._closing.deviation)])

    @property
    def _n_parts(self) -> int:
        return len(np.unique(self._closing.parts[self.mesh.combinatorics.is_used]))

    # --- members

    @cached_property
    def basis(self) -> FloatArray:
        """(dimension, N, 3), read-only: orthonormal as vectors (3N,). Translations come first.

        Vertices that belong to no face stay at the origin. Raises RankError where the dimension cannot be told, and
        GeometryError where the basis has more than `MAX_BASIS_NUMBERS` numbers: take `elements` then.
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
        members = self._orthonormal(self.dimension - 3 * self._n_parts, seed=0)
        return floats(np.concatenate([self._translations(), members]))

    def elements(self, count: int, *, seed: int = 0) -> list[Mesh]:
        """Random members of P(M), orthonormal as vectors (3N,), each part with its mean at the origin.

        Others for another seed. For any size, with one factor of a matrix of twice the number of faces.
        Raises GeometryError where P(M) has not so many dimensions, beside translations.
        """
        if count < 1:
            raise GeometryError(f"{count} elements are asked for, it must be 1 or more", value=count, bound=1)
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
        centre = mesh.vertices.mean(axis=0)  # translations are members: they can be kept out of rounding
        wanted = (mesh.vertices - centre).ravel()
        size = float(np.abs(wanted).max())
        found = optimum(
            self._unknowns,
            self._nearest,
            self._unknowns.of(wanted),
            origin=np.zeros(len(wanted)),
            size=size,
            bounds=(ELEMENT_TOLERANCE * size, ELEMENT_TOLERANCE * size),
            what="the projection",
        )
        return found.with_vertices(found.vertices + centre)

    def contains(self, mesh: MeshLike) -> bool:
        """Whether a mesh is parallel to M, within `ELEMENT_TOLERANCE` times its largest coordinate."""
        mesh = as_mesh(mesh)
        return bool(parallelity(self.mesh, mesh).max() <= self._allowed(mesh))

    def blend(self, weights: Sequence[float], members: Sequence[Mesh]) -> Mesh:
        """The linear combination of members of P(M) [Pottmann2007, Fig. 5]; `blend_ranges` says how far weights may go.

        Raises ParallelityError, naming the edge, for a mesh that is no member, and GeometryError where
        weights are not finite or not as many as members.
        """
        self._check_blend(weights, members)
        vertices = np.einsum("k,kni->ni", np.asarray(weights, dtype=np.float64), [m.vertices for m in members])
        return self.mesh.with_vertices(vertices)

    def blend_ranges(self, weights: Sequence[float], members: Sequence[Mesh]) -> FloatArray:
        """(k, 2) from where to where each weight of a blend may go, the others unchanged, until an edge collapses.

        Beyond these limits the edge runs the other way than in the blend; infinite where no edge sets a limit. Raises
        as `blend` does, and GeometryError, naming the edge, where one has no length in the blend.

        >>> from geometry import ParallelSpace
        >>> from geometry.mesh import shapes
        >>> box = shapes.box(1, 2, 3)
        >>> wider, higher = shapes.box(2, 2, 3), shapes.box(1, 2, 4)
        >>> ParallelSpace(box).blend_ranges([1, 0, 0], [box, wider, higher]).tolist()
        [[0.0, inf], [-0.5, inf], [-0.75, inf]]
        """
        self._check_blend(weights, members)
        factors = np.stack([edge_factors(self.mesh, member) for member in members])
        return weight_ranges(np.asarray(weights, dtype=np.float64), factors)

    def _check_blend(self, weights: Sequence[float], members: Sequence[Mesh]) -> None:
        if len(weights) != len(members) or not len(members):
            raise GeometryError(f"{len(weights)} weights are given for {len(members)} members: one each is needed")
        for place, (weight, member) in enumerate(zip(weights, members, strict=True)):
            if not np.isfinite(weight):
                raise GeometryError(f"the weight of member {place} is {weight}", elements=[place], value=weight)
            check_parallel(self.mesh, member, self._allowed(member), what=f"member {place}")

    def minimise(
        self,
        quadratic: Iterable[tuple[float, LinearFunctional]] = (),
        *,
        linear: Any = None,
        fixed: Mapping[int, Any] | None = None,
        factor_bounds: tuple[Any, Any] | None = None,
    ) -> Mesh:
        """The member of P(M) at which the sum of weight |r(x)|^2 and of linear . x is least.

        quadratic: weights and functionals of all coordinates x (3N,); linear (3N,) or (N, 3): a gradient;
        fixed: positions of some vertices; factor_bounds: lower and upper bounds of the edge factors (1), numbers or
        arrays (E,), infinite where there is none. Signs are the bounds (0, inf) and (-inf, 0): [Pottmann2007, Fig. 11].

        What all this leaves open is as in M, as nearly as can be: if only fairness is asked for, the mesh shrinks to a
        point, and that is the centroid of M. With bounds, any of the minimisers may be found.

        Edges are parallel and fixed vertices in place within `ELEMENT_TOLERANCE` times the largest coordinate; bounds
        hold within `FACTOR_BOUND_TOLERANCE` times that. Raises GeometryError where fixed vertices or bounds contradict
        each other or leave nothing free (see `free_dimension`), where there is no least value, and for values that are
        not finite or of the wrong shape; ConvergenceError where the solver does not reach that accuracy, or not the
        minimum; RankError, naming edges and singular values, where rounding decides about the minimum.
        """
        return minimum(
            self._unknowns,
            Objective.of(self.mesh, quadratic, linear),
            Fixed.of(self.mesh, fixed),
            None if factor_bounds is None else FactorBounds.of(self.mesh, factor_bounds),
        )

    # --- how

    @cached_property
    def _unknowns(self) -> FaceUnknowns:
        check_planar(self.mesh)
        return FaceUnknowns(self.mesh)

    @cached_property
    def _nearest(self) -> ConstrainedQuadratic:
        A = self._unknowns.constraints
        return ConstrainedQuadratic(csr_array(eye_array(A.shape[1])), A)

    def _orthonormal(self, count: int, seed: int) -> FloatArray:
        """(count, N, 3) orthonormal members, each part with its mean at the origin."""
        members = self._members
        columns, sizes = _orthonormalised(members.random(count, seed))
        if sizes.min() < INDEPENDENCE_TOLERANCE * sizes.max():
            rank = int((sizes >= INDEPENDENCE_TOLERANCE * sizes.max()).sum())
            raise GeometryError(
                f"{count} independent elements are asked for, but P(M) has {rank} dimensions only, beside translations",
                value=count,
                bound=rank,
            )
        if sizes.min() < REORTHONORMALISATION_RATIO * sizes.max():
            columns, _ = _orthonormalised(members.nearest(columns.T.reshape(count, -1, 3)))
        return columns.T.reshape(count, -1, 3)

    def _allowed(self, member: Mesh) -> float:
        return ELEMENT_TOLERANCE * float(np.abs(member.vertices).max())

    def _translations(self) -> FloatArray:
        """(3 parts, N, 3) orthonormal."""
        parts = self._closing.parts
        used = np.unique(parts[self.mesh.combinatorics.is_used])
        inside = (parts == used[:, None]) / np.sqrt(np.bincount(parts)[used])[:, None]
        return np.asarray(np.einsum("cn,ik->cink", inside, np.eye(3)).reshape(-1, self.mesh.n_vertices, 3))


def _orthonormalised(meshes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Columns (3N, k) that span the same as meshes (k, N, 3), and what each added to those before (k,)."""
    columns, triangle = np.linalg.qr(meshes.reshape(len(meshes), -1).T)
    return columns, np.abs(np.diag(triangle))
