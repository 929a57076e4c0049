"""The space P(M) of the meshes parallel to a mesh M: who belongs to it, edge factors, dimension."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError, RankError
from geometry.functionals.parallelity import parallel_to
from geometry.mesh import Mesh
from geometry.optimise.constrained import factorise
from geometry.optimise.functional import SparseMatrix

__all__ = ["ParallelSpace", "Spectrum", "edge_factors", "parallelity"]

GAP = 100.0
"""Least ratio of the first singular value that is not zero to the largest one that passes for zero."""

ZERO = 1e-9
"""Singular values up to this pass for zero, where faces are planar; faces planar to p leave up to about 10 p."""

LARGEST_ZERO = 1e-3
"""Where faces are less planar than a tenth of this, no gap is to be found, so none is looked for."""

SHIFT = 1e-10
"""Added to A^T A for inverse iteration: well above rounding, so that the factor is good, and below squared gaps."""

LARGEST_BASIS = 50_000_000
"""Numbers in the vectors of the inverse iteration: 0.4 GB."""


def parallelity(mesh: Mesh, other: Mesh) -> FloatArray:
    """(E,) how far s_j - s_i is off the direction of m_j - m_i, in the unit of S = `other`; zero where parallel.

    Raises MeshError where the meshes do not have the same faces, and for an edge of `mesh` without length.
    """
    _, across = _along_and_across(mesh, other)
    return np.asarray(np.linalg.norm(across, axis=1))


def edge_factors(mesh: Mesh, other: Mesh) -> FloatArray:
    """(E,) the factors lambda of s_j - s_i = lambda (m_j - m_i), by projection [Pottmann2007, (1)].

    Negative where the correspondence of the edges reverses their orientation. Raises as `parallelity` does.
    """
    along, _ = _along_and_across(mesh, other)
    return along / mesh.edge_lengths


def _along_and_across(mesh: Mesh, other: Mesh) -> tuple[FloatArray, FloatArray]:
    """(E,) and (E, 3): the edges of the other mesh, split by the edge directions of the mesh."""
    if not mesh.combinatorics.same_as(other.combinatorics):
        raise MeshError("the two meshes do not have the same faces, so they cannot be parallel")
    directions = mesh.edge_directions
    along = np.einsum("ei,ei->e", other.edge_vectors, directions)
    return along, other.edge_vectors - along[:, None] * directions


@dataclass(frozen=True)
class Spectrum:
    """The dimension of P(M), and the singular values of (2) on either side of the gap that shows it."""

    dimension: int
    last_kept: float
    first_dropped: float


@dataclass(frozen=True, eq=False)
class ParallelSpace:
    """P(M): the meshes S over the same combinatorics whose edges are parallel to those of M [Pottmann2007, 2.2]."""

    mesh: Mesh

    @cached_property
    def matrix(self) -> SparseMatrix:
        """A (2E, 3N): A s = 0 says that s is in P(M). Raises MeshError for an edge without length."""
        return parallel_to(self.mesh).matrix

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

    @cached_property
    def spectrum(self) -> Spectrum:
        """Found without a dense singular value decomposition, for up to some ten thousand vertices.

        Vertices that belong to no face do not count. Raises RankError, saying the singular values, where
        they have no gap: mostly since the faces are not planar enough; and GeometryError for meshes too large.
        """
        used = np.repeat(self.mesh.combinatorics.is_used, 3)
        matrix = csr_array(self.matrix[:, np.flatnonzero(used)])
        zero = min(max(ZERO, 10 * float(self.mesh.planarity.max())), LARGEST_ZERO)
        count = max(self.expected_dimension, 4) + 20
        values = _least_singular_values(matrix, count)
        while values[-1] <= zero and len(values) < matrix.shape[1]:
            values = _least_singular_values(matrix, 2 * len(values))
        return _spectrum(values, zero)


def _spectrum(values: FloatArray, zero: float) -> Spectrum:
    """values: ascending; zero: what passes for zero."""
    dimension = int((values <= zero).sum())
    last = float(values[dimension - 1])
    first = float(values[dimension]) if dimension < len(values) else np.inf
    if first < GAP * zero:
        raise RankError(
            f"the singular values have no gap that shows the dimension of P(M): {dimension} are up to {last:.1e}, the "
            f"next is {first:.1e}, and at least {GAP * zero:.1e} is needed; planarise the mesh first",
            value=first,
            bound=GAP * zero,
        )
    return Spectrum(dimension, last, first)


def _least_singular_values(matrix: SparseMatrix, count: int) -> FloatArray:
    """The `count` least singular values of A (m, n), ascending, or all n where that is easier.

    Inverse iteration on a block of vectors with the factor of A^T A + shift; then A times the Ritz vectors, whose
    norms are good to rounding, not only to its root as eigenvalues of A^T A are.
    """
    n = matrix.shape[1]
    if count > n // 3:
        if n * n > LARGEST_BASIS:
            raise _too_large(n, n)
        values = np.linalg.svd(matrix.toarray(), compute_uv=False)
        return np.sort(np.concatenate([values, np.zeros(max(0, n - len(values)))]))
    if n * count > LARGEST_BASIS:
        raise _too_large(n, count)
    factor = factorise(csr_array(csr_array(matrix.T) @ matrix + SHIFT * eye_array(n)))
    vectors = np.random.default_rng(0).standard_normal((n, count))
    for _ in range(2):  # each takes 1e-10 over a squared singular value off what is not near the null space
        vectors = np.linalg.qr(factor.solve(vectors))[0]
    images = np.asarray(matrix @ vectors)
    rotation = np.linalg.eigh(images.T @ images)[1]
    return np.sort(np.linalg.norm(images @ rotation, axis=0))


def _too_large(n: int, count: int) -> GeometryError:
    return GeometryError(
        f"the dimension of P(M) needs {count} vectors of {n} numbers, at most {LARGEST_BASIS:.0e} numbers in all are "
        "allowed; go by `expected_dimension`, or look at a part of the mesh",
        value=float(n) * count,
        bound=LARGEST_BASIS,
    )
