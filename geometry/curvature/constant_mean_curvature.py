"""Meshes of constant mean curvature with respect to a given Gauss image, by Newton's method in P(S) [Pottmann2007, 5].

H_F = H for all faces says that H area(F) + area(F, sigma(F)) = 0, which is quadratic in M. The unknowns are the edges
of M in the directions of S, as in `geometry.curvature.christoffel_duals`; H = 0 is the Christoffel dual. With M, the
parallel mesh M + S / H has the mean curvature -H, and is a Christoffel dual of M.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array

from geometry.arrays import FloatArray, IntArray
from geometry.curvature.christoffel_duals import with_edges
from geometry.curvature.fairness import fairness_of_lengths
from geometry.errors import GeometryError, MeshError
from geometry.gauss import Pair
from geometry.mesh import Mesh, MeshLike, as_gauss_image, as_mesh
from geometry.mesh.polygons import face_mean_edge_lengths
from geometry.optimise import (
    ConvergenceError,
    LinearFunctional,
    Solution,
    SparseMatrix,
    StackedFunctional,
    apply,
    nearest_feasible,
)
from geometry.parallel.edge_closure import EdgeClosure
from geometry.parallel.edge_parallelity import check_planar
from geometry.parallel.sampling import ElementSampler

__all__ = ["ConstantMean", "constant_mean"]

CONSTANT_MEAN_TOLERANCE = 1e-11
"""Largest residual of the equations, in mean edge lengths: a few digits more than rounding takes."""

LONGEST_EDGE_CHANGE = 0.5
"""Longest change of an edge in one step, over the mean edge length."""

LEAST_SIZE_SHARE = 1e-3
"""Mean edge length over that of the start, below which the result counts as a point: no useful start is that far
off."""

CONSTANT_MEAN_ANCHORED_STEPS = 8
"""First steps that also minimise the distance from the start."""

MAX_CONSTANT_MEAN_STEPS = 100
"""Most Newton steps; ten are mostly enough."""


def constant_mean(
    gauss_image: MeshLike,
    mean: float,
    start: MeshLike,
    *,
    fairness: float = 1.0,
    tolerance: float = CONSTANT_MEAN_TOLERANCE,
) -> Pair:
    """S with the M in P(S) that has H_F = mean in every face with respect to it, near to a mesh with the same faces.

    mean: H, one over the unit of M; negative where M bulges to the side to which S points, as a sphere does. start: of
    its edges, only the components along those of S count. Near: the sum of the squared changes of edge lengths, and
    `fairness` times the squared changes of the deviations of vertices from the mean of their neighbours' neighbours, is
    small; this chooses one of the solutions. Meshes of hexagons have many. Quads have as many equations more as there
    are faces inside: they have solutions beside -S / H, which is a sphere if S is, only where S is special, as in
    rotational meshes.

    M has the mean of its vertices at the origin, in each piece. `tolerance`: how far edges may be from closure, and
    H area(F) + area(F, sigma(F)) over the mean edge length of sigma(F) from 0, in mean edge lengths of the start.

    Raises MeshError where the faces differ, an edge of S has no length or the start is a point; GeometryError where a
    face of S is not planar, for numbers out of range, and where M or an edge of it shrank to a point; ConvergenceError,
    with the worst face, where the method does not converge: there may be no such M near the start.

    >>> import numpy as np
    >>> from geometry.curvature import face_curvatures
    >>> from geometry.edge_offset import koebe
    >>> from geometry.mesh.tilings import hexagon_patch
    >>> S = koebe(hexagon_patch(3, 3), coverage=0.3).mesh
    >>> pair = constant_mean(S, -0.5, S * 1.9)
    >>> bool(np.abs(face_curvatures(pair).mean + 0.5).max() < 1e-6)
    True
    """
    gauss_image = as_gauss_image(gauss_image)
    start = as_mesh(start)
    for name, number in [("mean curvature", mean), ("fairness", fairness), ("tolerance", tolerance)]:
        if not np.isfinite(number) or (number < 0 and name != "mean curvature"):
            raise GeometryError(
                f"the {name} is {number}: a number is needed, from 0 upwards if no curvature", value=number
            )
    if not gauss_image.combinatorics.same_as(start.combinatorics):
        raise MeshError("the mesh to start from does not have the faces of the Gauss image")
    if start.mean_edge_length == 0:
        raise MeshError("the mesh to start from is a point: begin with one of about the size that is wanted", value=0.0)
    check_planar(gauss_image)
    closure, size = EdgeClosure(gauss_image), start.mean_edge_length
    functional = ConstantMean(closure, mean * size)
    begin = functional.lengths_of(start) / size
    fair = csr_array(fairness_of_lengths(gauss_image) @ closure.lengths)
    n = len(begin)
    solution = nearest_feasible(
        StackedFunctional([LinearFunctional(closure.matrix, np.zeros(closure.matrix.shape[0])), functional]),
        begin,
        csr_array(eye_array(n) + fairness * csr_array(csr_array(fair.T) @ fair)),
        tolerance=tolerance,
        longest_step=LONGEST_EDGE_CHANGE,
        anchored_steps=CONSTANT_MEAN_ANCHORED_STEPS,
        max_steps=MAX_CONSTANT_MEAN_STEPS,
    )
    if not solution.violation <= tolerance:
        raise _not_reached(functional, solution, tolerance)
    lengths = apply(closure.lengths, solution.x)
    _check_size(float(np.abs(lengths).mean()), mean)
    vertices = ElementSampler(closure, np.zeros((n, 0))).positions(size * lengths[:, None])[0]
    return Pair(with_edges(gauss_image, vertices), gauss_image)


@dataclass(frozen=True, eq=False)
class ConstantMean:
    """H area(F) + area(F, sigma(F)) over the mean edge length of sigma(F), for each face; x (n,) as in `EdgeClosure`.

    The edges of M are those of x in the directions of S = closure.mesh; where they do not close around a face, its area
    is that of the polygon of all but the closure side. H is one over the unit of x.
    """

    closure: EdgeClosure
    mean: float

    def residual(self, x: FloatArray) -> FloatArray:
        lengths = apply(self.closure.lengths, x)
        found = np.empty(self.closure.mesh.n_faces)
        for faces, edges, forms in self._forms:
            of_mesh, of_gauss_image = lengths[edges], self.closure.mesh.edge_lengths[edges]
            found[faces] = np.einsum("fi,fij,fj->f", self.mean * of_mesh + of_gauss_image, forms, of_mesh) / 2
        return found

    def jacobian(self, x: FloatArray) -> SparseMatrix:
        lengths = apply(self.closure.lengths, x)
        parts: list[tuple[FloatArray, IntArray, IntArray]] = []
        for faces, edges, forms in self._forms:
            slopes = self.mean * lengths[edges] + self.closure.mesh.edge_lengths[edges] / 2
            values = np.einsum("fij,fj->fi", forms, slopes)
            parts.append((values.ravel(), np.repeat(faces, edges.shape[1]), edges.ravel()))
        values, rows, columns = (np.concatenate(column) for column in zip(*parts, strict=True))
        c = self.closure.mesh.combinatorics
        by_edges = csr_array(coo_array((values, (rows, columns)), shape=(c.n_faces, c.n_edges)))
        return csr_array(by_edges @ self.closure.lengths)

    def lengths_of(self, mesh: Mesh) -> FloatArray:
        """x (n,) of the mesh, its edges projected to the directions of S."""
        along = np.einsum("ek,ek->e", mesh.edge_vectors, self.closure.mesh.edge_directions)
        return apply(csr_array(self.closure.lengths.T), along)

    @cached_property
    def _forms(self) -> list[tuple[IntArray, IntArray, FloatArray]]:
        """Faces (f,) of k corners, their edges (f, k), and W (f, k, k): l W l / 2 is the area for lengths l (f, k).

        Over the mean edge length of the face in S.
        """
        mesh, c = self.closure.mesh, self.closure.mesh.combinatorics
        sizes = face_mean_edge_lengths(mesh.vertices, c)
        groups = []
        for faces, corners in c.faces_by_size():
            along = mesh.corner_directions[corners]
            across = np.cross(mesh.face_normals[faces, None], along)
            turns = np.triu(np.einsum("fjk,fik->fij", along, across), 1)  # det(n, d_i, d_j) for i < j
            forms = (turns + turns.swapaxes(1, 2)) / (2 * sizes[faces, None, None])
            groups.append((faces, c.corner_edge[corners], forms))
        return groups


def _check_size(relative: float, mean: float) -> None:
    """Raise GeometryError where what was found is a point, which solves the equations too."""
    if relative < LEAST_SIZE_SHARE:
        raise GeometryError(
            f"what was found has shrunk to a point, to {relative:.0e} of the mean edge length of the start, at least "
            f"{LEAST_SIZE_SHARE:.0e} is needed: begin with a mesh whose mean curvatures are nearer to {mean:g}",
            value=relative,
            bound=LEAST_SIZE_SHARE,
        )


def _not_reached(functional: ConstantMean, solution: Solution, tolerance: float) -> ConvergenceError:
    residuals = np.abs(functional.residual(solution.x))
    face = int(residuals.argmax())
    return ConvergenceError(
        f"no mesh of this mean curvature is found near the start: {solution.reason.value}, after {solution.steps} "
        f"steps; edges or curvatures are off by {solution.violation:.1e}, allowed {tolerance:.0e}; curvature is off "
        f"most in face {face}, by {residuals[face]:.1e}; start nearer to such a mesh, or take a Gauss image with more "
        "freedom: hexagons, or a rotational mesh of quads",
        solution=solution,
        elements=[face],
        value=solution.violation,
        bound=tolerance,
    )
