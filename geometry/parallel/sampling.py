"""Random elements of P(M), any number, without a basis: edge lengths with which faces close, then positions."""

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
"""Corrections of edge lengths. Each reduces the gap to FACTOR_SHIFT over a squared singular value: one or two do."""

CLOSURE_ROUNDING = 1e-15
"""Gap over the largest edge length at which corrections end."""


@dataclass(frozen=True, eq=False)
class ElementSampler:
    """Elements of P(M) from edge lengths, with the mean of each connected part at the origin.

    null (n, z): the singular vectors of `closure.narrow` whose singular values count as zero, orthonormal.
    """

    closure: EdgeClosure
    null: FloatArray

    def random(self, count: int, seed: int) -> FloatArray:
        """(count, N, 3) elements of P(M), nearest to normally distributed edge lengths."""
        n = self.closure.matrix.shape[1]
        x = self.closed(np.random.default_rng(seed).standard_normal((n, count)))
        return self.positions(np.asarray(self.closure.lengths @ x))

    def nearest(self, meshes: FloatArray) -> FloatArray:
        """(k, N, 3) elements of P(M) with edge lengths nearest to those of meshes (k, N, 3) along the edges of M."""
        mesh = self.closure.mesh
        i, j = mesh.combinatorics.edges.T
        lengths = np.einsum("kei,ei->ek", meshes[:, j] - meshes[:, i], mesh.edge_directions)
        x = self.closed(np.asarray(self.closure.lengths.T @ lengths))
        return self.positions(np.asarray(self.closure.lengths @ x))

    def closed(self, x: FloatArray) -> FloatArray:
        """(n, k) the nearest to x (n, k) with B x = 0, taking singular values below the threshold as zero."""
        B, null = self.closure.matrix, self.null
        if self.closure.is_overdetermined:
            return null @ (null.T @ x)
        largest = np.abs(x).max(initial=0.0)
        for _ in range(MAX_CLOSURE_CORRECTIONS):
            gaps = np.asarray(B @ x)
            gaps -= null @ (null.T @ gaps)
            if np.abs(gaps).max(initial=0.0) <= CLOSURE_ROUNDING * largest:
                break
            y = self.closure.factor.solve(gaps)
            x = x - B.T @ (y - null @ (null.T @ y))
        return x

    def positions(self, lengths: FloatArray) -> FloatArray:
        """(k, N, 3) positions with s_j - s_i = mu u for edge lengths mu (E, k) with which faces and loops close.

        By least squares over all edges, since rounding would accumulate along a tree.
        """
        mesh = self.closure.mesh
        difference, factor = self._integration
        edges = (lengths[:, :, None] * mesh.edge_directions[:, None, :]).reshape(len(lengths), -1)
        found = factor.solve(np.asarray(difference.T @ edges))
        found += factor.solve(np.asarray(difference.T @ (edges - difference @ found)))
        parts = self.closure.parts
        sums = csr_array((np.ones(len(parts)), (parts, np.arange(len(parts)))))
        found -= (np.asarray(sums @ found) / np.bincount(parts)[:, None])[parts]
        return np.ascontiguousarray(found.reshape(mesh.n_vertices, -1, 3).transpose(1, 0, 2))

    @cached_property
    def _integration(self) -> tuple[SparseMatrix, Factor]:
        """The differences (E, N) along the edges, and the factor of their squares with a vertex of each part fixed."""
        c = self.closure.mesh.combinatorics
        edges, ones = np.arange(c.n_edges), np.ones(c.n_edges)
        places = (np.concatenate([edges, edges]), c.edges.T.ravel())
        difference = csr_array(coo_array((np.concatenate([-ones, ones]), places), shape=(c.n_edges, c.n_vertices)))
        is_fixed = np.zeros(c.n_vertices)
        is_fixed[np.unique(self.closure.parts, return_index=True)[1]] = 1.0
        return difference, factorise(csr_array(difference.T @ difference + diags_array(is_fixed)))
