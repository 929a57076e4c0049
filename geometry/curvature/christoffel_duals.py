"""Christoffel duals: meshes M that are minimal with respect to a given Gauss image S [Pottmann2007, 5].

M is parallel to S, and every face has vanishing mixed area with its image, so H = 0. Both are linear in M: with the
edges of M as unknowns, mu_e u_e in the directions u_e of S, the mixed area (4) of a face is half the sum of h_e mu_e
around it, h_e the signed distance of the edge of S from any point of its plane. Where S is a Koebe polyhedron and that
point is the centre of the face circle, all h_e are equal: then the mu_e of each face sum to zero.

Quads have three equations each and share two edges: only Koenigs nets have a dual, and then one
[BobenkoPottmannWallner2010]. Hexagons have as many equations as edges: there are many duals, about one for each face at
the boundary.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, vstack
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from geometry.arrays import FloatArray, short_repr
from geometry.curvature.fairness import fairness_of_lengths
from geometry.errors import GeometryError, MeshError, RankError, raise_worst
from geometry.gauss import Pair
from geometry.mesh import Mesh, MeshLike, as_gauss_image, as_mesh
from geometry.mesh.polygons import face_centroids, face_sums
from geometry.optimise import ConstrainedQuadratic, ConvergenceError, Reason, Solution, SparseMatrix, apply
from geometry.parallel.edge_closure import EdgeClosure
from geometry.parallel.edge_parallelity import check_planar
from geometry.parallel.sampling import ElementSampler
from geometry.parallel.spectrum import LEAST_SPECTRAL_GAP, Spectrum, least_singular_vectors, zero_threshold

__all__ = ["LEAST_DUAL_EDGE", "ChristoffelDuals", "christoffel_dual", "with_edges"]

LEAST_DUAL_EDGE = 1e-6
"""Length of an edge over the mean edge length, below which it counts as zero: rounding turns shorter edges by more
than the 1e-9 to which meshes count as parallel."""

SHORT_DUAL_EDGE = 0.1
"""Length of an edge over the mean of its faces, below which the fairest dual is turned towards others that are nearly
as fair. On meshes of hexagons two are equally fair, as the associated minimal surfaces are; in one of them three edges
of a hexagon sum to zero as 1 + 1 - 2, in the other as 1 - 1 + 0: then every third edge vanishes."""

VANISHING_DUAL_EDGE = 1e-2
"""The same, below which a dual is refused where there was a choice: its faces have other numbers of corners."""

BLENDED_DUALS = 4
"""Number of fairest duals that are blended with the fairest one."""

BLEND_ANGLES = 720
"""Number of blends that are tried: cos t times one dual plus sin t times another, for t over a half circle."""

FAIRNESS_REGULARISATION = 1e-12
"""Added to the squares of fairness, so that they are definite; it does not change which dual is fairest."""

LANCZOS_VECTORS = 20
"""Number of vectors of Lanczos' method."""

LANCZOS_RESTARTS = 20
"""Most restarts of Lanczos' method from its best vectors; mostly one is enough."""

FAIREST_ACCURACY = 1e-10
"""Relative accuracy of the largest eigenvalue; that of its vector is about the square root."""


@dataclass(frozen=True, eq=False)
class ChristoffelDuals:
    """The space of the meshes M parallel to S with area(F, sigma(F)) = 0 for all faces, translations aside.

    The correspondence of edges may reverse their orientation; `geometry.parallel.edge_factors` says which. Raises
    GeometryError where a face of S is not planar (the bound is that of `check_planar`), MeshError for an edge of S
    without length.

    >>> from geometry.edge_offset import enneper_koebe
    >>> duals = ChristoffelDuals(enneper_koebe(4))
    >>> duals.dimension  # quads of a Koebe polyhedron have one
    1
    >>> duals.fairest().n_faces
    16
    """

    __repr__ = short_repr

    gauss_image: Mesh

    def __post_init__(self) -> None:
        object.__setattr__(self, "gauss_image", as_gauss_image(self.gauss_image))

    @cached_property
    def spectrum(self) -> Spectrum:
        """The number of independent duals, and the singular values on either side of the gap that separates them.

        They are those of the equations of `equations`, pure numbers, the largest about 2. Raises RankError
        where no gap tells duals from what only nearly is one.
        """
        values, _ = self._least
        zero = zero_threshold(self.equations.deviation)
        kept = int((values <= zero).sum())
        last = max([self.equations.deviation, *values[:kept][-1:]])
        first = float(values[kept]) if kept < len(values) else np.inf
        if kept and first < LEAST_SPECTRAL_GAP * last:
            raise RankError(
                f"the singular values have no gap that tells duals of the mesh from what only nearly is one: "
                f"{last:.1e} passes for zero, but the next is {first:.1e}, and at least "
                f"{LEAST_SPECTRAL_GAP * last:.1e} is needed; planarise the mesh first",
                value=first,
                bound=LEAST_SPECTRAL_GAP * last,
            )
        rows, columns = self.equations.matrix.shape
        return Spectrum(max(0, columns - rows) + kept, float(last), first)

    @property
    def dimension(self) -> int:
        """How many independent duals there are: 1 for a Koenigs net of quads in one piece, 0 for quads in general."""
        return self.spectrum.dimension

    @cached_property
    def equations(self) -> _DualClosure:
        check_planar(self.gauss_image)
        return _DualClosure(self.gauss_image)

    def fairest(self) -> Mesh:
        """The dual with the least sum of squared deviations of vertices from the mean of their neighbours' neighbours,
        over the sum of its squared edge lengths; see `fairness_of_lengths` for why.

        Where that lets edges vanish, the one whose least edge is longest, over the mean edge of its faces, among those
        between the fairest and the next fairest.

        In each piece, its mean edge length is that of S, its mean is at the origin, and of M and -M it is the one whose
        first edge runs as in S. Raises GeometryError where there is no dual, saying the singular values and the worst
        face, and, naming the edge, where all these duals have edges that vanish; ConvergenceError where the iteration
        does not find the fairest. Of several pieces, elements are numbered in the piece.
        """
        c, parts = self.gauss_image.combinatorics, self.equations.parts
        of_faces = parts[c.corners[c.face_starts[:-1]]]
        if (of_faces != of_faces[0]).any():  # the fairest of all would be a point in all pieces but one
            vertices = np.zeros((c.n_vertices, 3))
            for part in np.unique(of_faces):
                piece = self.gauss_image.part(np.flatnonzero(of_faces == part))
                vertices[parts == part] = ChristoffelDuals(piece).fairest().vertices
            return self.gauss_image.with_vertices(vertices)
        self._check_existence()
        lengths = self._lengths_without_vanishing()
        lengths *= self.gauss_image.mean_edge_length / np.abs(lengths).mean() * (1 if lengths[0] >= 0 else -1)
        return with_edges(self.gauss_image, self._members.positions(lengths[:, None])[0])

    def nearest(self, mesh: MeshLike) -> Mesh:
        """The dual whose edges are nearest to those of a mesh with the faces of S, as a sum of squares.

        Its mean is at the origin, in each piece. Raises as `fairest` does, and MeshError for other faces.
        """
        mesh = as_mesh(mesh)
        if not self.gauss_image.combinatorics.same_as(mesh.combinatorics):
            raise MeshError("the mesh to be near to does not have the faces of the Gauss image")
        self._check_existence()
        return with_edges(self.gauss_image, self._members.nearest(mesh.vertices[None])[0])

    # --- how

    @cached_property
    def _least(self) -> tuple[FloatArray, FloatArray]:
        return least_singular_vectors(self.equations, zero_threshold(self.equations.deviation))

    @cached_property
    def _members(self) -> ElementSampler:
        values, vectors = self._least
        return ElementSampler(self.equations, vectors[:, values <= zero_threshold(self.equations.deviation)])

    def _lengths_without_vanishing(self) -> FloatArray:
        """(E,) the signed lengths of the fairest dual without edges that vanish, up to size."""
        fairest = apply(self.equations.lengths, self._fairest(1)[:, 0])
        if self.dimension == 1 or self._relative(fairest[:, None]).min() >= SHORT_DUAL_EDGE:
            return fairest
        others = np.asarray(self.equations.lengths @ self._fairest(min(BLENDED_DUALS, self.dimension)))
        turns = np.linspace(0, np.pi, BLEND_ANGLES, endpoint=False)
        best: FloatArray = max(
            (np.outer(others[:, 0], np.cos(turns)) + np.outer(other, np.sin(turns)) for other in others.T[1:]),
            key=lambda turned: self._relative(turned).min(axis=0).max(),
        )
        relative = self._relative(best)
        turn = int(relative.min(axis=0).argmax())
        raise_worst(
            relative[:, turn],
            ">=",
            VANISHING_DUAL_EDGE,
            lambda edge, value: (
                f"{self.gauss_image.combinatorics.edge_name(edge)} vanishes in the fairest dual, and in all between it "
                f"and the next fairest some edge does: the best leaves it {value:.1e} of the mean edge "
                f"of its faces, at least {VANISHING_DUAL_EDGE:g} is needed; ask for the nearest to a mesh, or take "
                f"other faces"
            ),
        )
        return np.asarray(best[:, turn])

    def _relative(self, lengths: FloatArray) -> FloatArray:
        """(E, k) how long edges of signed lengths (E, k) are over the mean edge of their faces, of the larger mean."""
        c = self.gauss_image.combinatorics
        sizes = np.abs(lengths)
        means = face_sums(c, sizes[c.corner_edge]) / c.face_sizes[:, None]
        left, right = c.edge_faces.T
        larger = np.maximum(means[left], means[np.where(right < 0, left, right)])
        return np.asarray(np.divide(sizes, larger, out=np.zeros_like(sizes), where=larger > 0))

    def _fairest(self, count: int) -> FloatArray:
        """(n, count) of length 1, the fairest first: by Lanczos' method, the largest eigenvectors of the inverse of
        fairness among duals."""
        B = self.equations.matrix
        n = B.shape[1]
        start = self._closed(np.random.default_rng(0).standard_normal(n))
        if self.dimension == 1:
            return (start / np.linalg.norm(start))[:, None]
        fair = csr_array(fairness_of_lengths(self.gauss_image) @ self.equations.lengths)
        H = csr_array(csr_array(fair.T) @ fair + FAIRNESS_REGULARISATION * eye_array(n))
        quadratic, zero = ConstrainedQuadratic(H, B), np.zeros(B.shape[0])

        def inverse(x: FloatArray) -> FloatArray:
            # only the direction matters, and what the equations leave is taken off afterwards
            return self._closed(quadratic.minimise(self._closed(x), zero, tolerance=np.inf).x)

        operator = LinearOperator((n, n), matvec=inverse, dtype=np.float64)
        try:
            _, vectors = eigsh(
                operator, k=count, v0=start, ncv=min(LANCZOS_VECTORS, n), maxiter=LANCZOS_RESTARTS, tol=FAIREST_ACCURACY
            )
        except ArpackNoConvergence as error:
            raise _undecided(start, self.dimension) from error
        return self._members.closed(vectors[:, ::-1])

    def _closed(self, x: FloatArray) -> FloatArray:
        """(n,) the nearest to x (n,) that is a dual."""
        return self._members.closed(x[:, None])[:, 0]

    def _check_existence(self) -> None:
        if self.dimension:
            return
        values, vectors = self._least
        x = vectors[:, 0] if self.equations.is_overdetermined else apply(self.equations.narrow, vectors[:, 0])
        residuals = np.abs(apply(self.equations.mixed_areas, x / np.linalg.norm(x)))
        face, zero = int(residuals.argmax()), zero_threshold(self.equations.deviation)
        following = "".join(f" (the next is {value:.1e})" for value in values[1:2])  # triangles alone have one in all
        raise GeometryError(
            f"the mesh has no Christoffel dual, so nothing is minimal with respect to it: the least singular value of "
            f"the equations is {values[0]:.1e}, at most {zero:.0e} passes for zero{following}; the nearest mesh "
            f"violates the equation most in face {face}; quads must form a Koenigs net, as Koebe polyhedra do, and "
            f"their dual must "
            "close around holes",
            elements=[face],
            value=float(values[0]),
            bound=zero,
        )


def christoffel_dual(gauss_image: MeshLike, *, near: MeshLike | None = None) -> Pair:
    """S with an M that has H = 0 in all faces with respect to it: `ChristoffelDuals.fairest`, or the nearest to a mesh.

    Koenigs nets of quads have one dual up to size and place. Raises GeometryError where there is none.

    >>> import numpy as np
    >>> from geometry.curvature import face_curvatures
    >>> from geometry.edge_offset import enneper_koebe
    >>> pair = christoffel_dual(enneper_koebe(4))
    >>> bool(np.abs(face_curvatures(pair).mean).max() < 1e-6)
    True
    """
    gauss_image = as_gauss_image(gauss_image)
    duals = ChristoffelDuals(gauss_image)
    return Pair(duals.fairest() if near is None else duals.nearest(near), gauss_image)


def with_edges(gauss_image: Mesh, vertices: FloatArray) -> Mesh:
    """The mesh over the faces of S; raises GeometryError, naming the edge, where one has lost its length."""
    mesh = gauss_image.with_vertices(vertices)
    raise_worst(
        mesh.edge_lengths / (mesh.mean_edge_length or 1.0),
        ">",
        LEAST_DUAL_EDGE,
        lambda edge, value: (
            f"{mesh.combinatorics.edge_name(edge)} of the parallel mesh has a length of {value:.1e} of the mean edge "
            f"length, more than {LEAST_DUAL_EDGE:.0e} is needed: triangles may become points; where there are none, "
            f"ask for "
            "the nearest to another mesh"
        ),
    )
    return mesh


@dataclass(frozen=True, eq=False)
class _DualClosure(EdgeClosure):
    """The edges of a dual as unknowns: they close, and the mixed area of each face vanishes."""

    @cached_property
    def matrix(self) -> SparseMatrix:
        """Two rows a face and three a loop for closing, one a face for the mixed area."""
        return csr_array(vstack([super().matrix, self.mixed_areas]))

    @cached_property
    def mixed_areas(self) -> SparseMatrix:
        """(F, n) rows of unit length: the mixed area with S, over a length."""
        c, mesh = self.mesh.combinatorics, self.mesh
        arms = mesh.vertices[c.corners] - face_centroids(mesh.vertices, c)[c.corner_face]
        across = np.cross(arms, mesh.edge_directions[c.corner_edge])
        values = np.einsum("ck,ck->c", across, mesh.face_normals[c.corner_face])
        values *= np.where(c.runs_along_edge, 1.0, -1.0)  # the distance of the edge line, positive where convex
        values /= np.sqrt(face_sums(c, values**2))[c.corner_face]
        rows = csr_array(coo_array((values, (c.corner_face, c.corner_edge)), shape=(c.n_faces, c.n_edges)))
        return csr_array(rows @ self.lengths)


def _undecided(x: FloatArray, dimension: int) -> ConvergenceError:
    solution = Solution(x, np.zeros(0), np.inf, LANCZOS_RESTARTS * LANCZOS_VECTORS, Reason.STEP_LIMIT)
    return ConvergenceError(
        f"the fairest of {dimension} independent duals is not found to {FAIREST_ACCURACY:.0e} after "
        f"{LANCZOS_RESTARTS * LANCZOS_VECTORS} steps: "
        "several are nearly equally fair; ask for the `nearest` to some mesh",
        solution=solution,
        value=float(dimension),
        bound=1.0,
    )
