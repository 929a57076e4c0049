"""Systems of equations with the weighted Laplacian of a graph, up to a million nodes.

Nodes of few neighbours that have no neighbour among themselves are eliminated first: of a triangulation and its
faces, the faces, which leaves a third of the unknowns. What remains is factored, or, where it is large, solved by
conjugate gradients preconditioned by algebraic multigrid.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pyamg
from scipy.sparse import coo_array, csr_array, csr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.saddle_point import Factor, factorise

__all__ = ["GroundedLaplacian"]

MAX_ELIMINATED_NEIGHBOURS = 6
"""Neighbours of a node that is eliminated; they become neighbours of each other, so that many would cost more."""

MAX_DIRECT_UNKNOWNS = 20_000
"""Unknowns up to which a factor is as quick as multigrid, as measured; with 80 000 it takes a third longer."""

MAX_MULTIGRID_ITERATIONS = 200
"""Of conjugate gradients; with multigrid 10 to 30 do."""


class GroundedLaplacian:
    """The quadratic form sum of w (x_a - x_b)^2 over the links (a, b) of a graph.

    links (m, 2): nodes at either end, -1 where the end is grounded, x = 0; weights (m,), positive. The graph is
    connected. Where no end is grounded, the node with most links is; its equation is left out.
    """

    def __init__(self, n_nodes: int, links: IntArray, weights: FloatArray) -> None:
        if (links >= 0).all():
            links = np.where(links == np.argmax(np.bincount(links.ravel())), -1, links)
        self.n_nodes, self._links, self._weights = n_nodes, links, weights

    def solve(self, right: FloatArray, *, accuracy: float) -> FloatArray:
        """x (n,) or (n, k) with L x = right, the residual at most `accuracy` times as long as `right`."""
        out, kept, L = self._eliminated, ~self._eliminated, self.matrix
        right = np.where(self._linked.reshape(-1, *[1] * (right.ndim - 1)), right, 0.0)
        pivots = L.diagonal()[out].reshape(-1, *[1] * (right.ndim - 1))
        x = np.zeros_like(right)
        if kept.any():
            short = right[kept] - apply(csr_array(self._coupling.T), right[out] / pivots)
            x[kept] = np.apply_along_axis(self._solve_reduced, 0, short, accuracy)
        x[out] = (right[out] - apply(self._coupling, x[kept])) / pivots
        return x

    @cached_property
    def matrix(self) -> SparseMatrix:
        """(n, n) L."""
        a, b = self._links.T
        both, w = (a >= 0) & (b >= 0) & (a != b), self._weights
        diagonal = (~self._linked).astype(np.float64)
        for end in (a, b):
            diagonal += np.bincount(end[end >= 0], w[end >= 0], minlength=self.n_nodes)
        a, b, w, nodes = a[both], b[both], w[both], np.arange(self.n_nodes)
        entries = np.concatenate([diagonal, -w, -w])
        places = (np.concatenate([nodes, a, b]), np.concatenate([nodes, b, a]))
        return coo_array((entries, places), shape=(self.n_nodes, self.n_nodes)).tocsr()

    @cached_property
    def _linked(self) -> BoolArray:
        """(n,) whether a node has a link; x is 0 where not."""
        linked = np.zeros(self.n_nodes, dtype=bool)
        linked[self._links[self._links >= 0]] = True
        return linked

    @cached_property
    def _eliminated(self) -> BoolArray:
        """(n,) nodes of few neighbours, no two of them linked, as the first ends or as the second ends of links."""
        sides = []
        for end, other in (self._links.T, self._links.T[::-1]):
            degrees = np.bincount(end[end >= 0], minlength=self.n_nodes)
            elsewhere = np.zeros(self.n_nodes, dtype=bool)
            elsewhere[other[other >= 0]] = True
            sides.append((degrees > 0) & (degrees <= MAX_ELIMINATED_NEIGHBOURS) & ~elsewhere)
        return max(sides, key=np.count_nonzero)

    @cached_property
    def _coupling(self) -> SparseMatrix:
        """(eliminated, kept) that part of L."""
        return csr_array(self.matrix[self._eliminated][:, ~self._eliminated])

    @cached_property
    def _factor(self) -> Factor:
        return factorise(self._reduced)

    @cached_property
    def _multigrid(self) -> LinearOperator:
        solver: LinearOperator = pyamg.ruge_stuben_solver(csr_matrix(self._reduced)).aspreconditioner()
        return solver

    @cached_property
    def _reduced(self) -> SparseMatrix:
        """(kept, kept) the Schur complement."""
        out, C = self._eliminated, self._coupling
        L = self.matrix
        return csr_array(L[~out][:, ~out] - C.T @ (diags_array(1 / L.diagonal()[out]) @ C))

    def _solve_reduced(self, right: FloatArray, accuracy: float) -> FloatArray:
        if self._reduced.shape[0] <= MAX_DIRECT_UNKNOWNS:
            return self._factor.solve(right)
        # where it does not get there, the Newton step is less good: whoever asked looks at what it leads to
        found, _ = cg(self._reduced, right, rtol=accuracy, maxiter=MAX_MULTIGRID_ITERATIONS, M=self._multigrid)
        return np.asarray(found)
