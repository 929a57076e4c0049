"""Elements of P(M) at random, as many as are wanted, without a basis: edge lengths that close, then positions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from geometry.arrays import FloatArray
from geometry.optimise import Factor, SparseMatrix, factorise
from geometry.parallel.edge_closure import EdgeClosure

__all__ = ["ElementSampler"]

MAX_CLOSURE_CORRECTIONS = 10
"""At most; each takes FACTOR_SHIFT over a squared singular value off what does not close yet, so one or two do."""

CLOSURE_ROUNDING = 1e-15
"""What does not close, over the largest edge length, where corrections end."""


@dataclass(frozen=True, eq=False)
class ElementSampler:
    """Positions with their mean at the origin, in each component, for edge lengths that close.

    null (n, z): the singular vectors of `closing.narrow` whose singular values pass for zero, orthonormal.
    """

    closing: EdgeClosure
    null: FloatArray

    def random(self, count: int, seed: int) -> FloatArray:
        """(count, N, 3) members of P(M): normally distributed edge lengths, made to close as is nearest to them."""
        n = self.closing.matrix.shape[1]
        x = self.closed(np.random.default_rng(seed).standard_normal((n, count)))
        return self.positions(np.asarray(self.closing.lengths @ x))

    def nearest(self, meshes: FloatArray) -> FloatArray:
        """(k, N, 3) what meshes (k, N, 3) become when their edges are made parallel to M and to close."""
        mesh = self.closing.mesh
        i, j = mesh.combinatorics.edges.T
        lengths = np.einsum("kei,ei->ek", meshes[:, j] - meshes[:, i], mesh.edge_directions)
        x = self.closed(np.asarray(self.closing.lengths.T @ lengths))
        return self.positions(np.asarray(self.closing.lengths @ x))

    def closed(self, x: FloatArray) -> FloatArray:
        """(n, k) the nearest to x (n, k) with B x = 0, where singular values that pass for zero are zero."""
        B, null = self.closing.matrix, self.null
        if self.closing.is_overdetermined:
            return null @ (null.T @ x)
        largest = np.abs(x).max(initial=0.0)
        for _ in range(MAX_CLOSURE_CORRECTIONS):
            open_by = np.asarray(B @ x)
            open_by -= null @ (null.T @ open_by)
            if np.abs(open_by).max(initial=0.0) <= CLOSURE_ROUNDING * largest:
                break
            y = self.closing.factor.solve(open_by)
            x = x - B.T @ (y - null @ (null.T @ y))
        return x

    def positions(self, lengths: FloatArray) -> FloatArray:
        """(k, N, 3) for edge lengths (E, k) that close: s_j - s_i = mu u, as nearly as can be.

        Least squares over all edges: along a tree, rounding would add up.
        """
        mesh = self.closing.mesh
        difference, factor = self._integration
        edges = (lengths[:, :, None] * mesh.edge_directions[:, None, :]).reshape(len(lengths), -1)
        found = factor.solve(np.asarray(difference.T @ edges))
        found += factor.solve(np.asarray(difference.T @ (edges - difference @ found)))
        parts = self.closing.parts
        sums = csr_array((np.ones(len(parts)), (parts, np.arange(len(parts)))))
        found -= (np.asarray(sums @ found) / np.bincount(parts)[:, None])[parts]
        return np.ascontiguousarray(found.reshape(mesh.n_vertices, -1, 3).transpose(1, 0, 2))

    @cached_property
    def _integration(self) -> tuple[SparseMatrix, Factor]:
        """The differences (E, N) along the edges, and the factor of their squares with a vertex of each part held."""
        c = self.closing.mesh.combinatorics
        edges, ones = np.arange(c.n_edges), np.ones(c.n_edges)
        places = (np.concatenate([edges, edges]), c.edges.T.ravel())
        difference = csr_array(coo_array((np.concatenate([-ones, ones]), places), shape=(c.n_edges, c.n_vertices)))
        held = np.zeros(c.n_vertices)
        held[np.unique(self.closing.parts, return_index=True)[1]] = 1.0
        return difference, factorise(csr_array(difference.T @ difference + diags_array(held)))
