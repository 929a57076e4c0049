"""Systems of equations with the weighted Laplacian of a graph, up to a million nodes.

Nodes with few neighbours, no two of which are linked, are eliminated first. In the graph of the vertices and faces of a
triangulation these are the faces, so that a third of the unknowns remains. The reduced system is factored or, where it
is large, solved by conjugate gradients preconditioned by algebraic multigrid.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, csr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.optimise.functional import SparseMatrix, apply
from geometry.optimise.saddle_point import Factor, factorise

__all__ = ["GroundedLaplacian"]

MAX_ELIMINATED_NEIGHBOURS = 6
"""Largest number of neighbours of an eliminated node; they all become neighbours of each other, which costs time."""

MAX_DIRECT_UNKNOWNS = 20_000
"""Number of unknowns up to which a factor is as fast as multigrid; with 80 000 it takes a third longer."""

MAX_MULTIGRID_ITERATIONS = 200
"""Conjugate gradient steps with multigrid; 10 to 30 are usual."""


class GroundedLaplacian:
    """The quadratic form sum of w (x_a - x_b)^2 over the links (a, b) of a connected graph.

    links (m, 2): the nodes at both ends, -1 where the end is grounded, that is x = 0; weights (m,), positive. Where no
    end is grounded, the node with most links is grounded, and its equation is left out.

    >>> links, weights = np.array([[-1, 0], [0, 1], [1, 2]]), np.ones(3)  # a path of three nodes from the ground
    >>> GroundedLaplacian(3, links, weights).solve(np.array([0.0, 0.0, 1.0]), accuracy=1e-9).round(6).tolist()
    [1.0, 2.0, 3.0]
    """

    def __init__(self, n_nodes: int, links: IntArray, weights: FloatArray) -> None:
        if (links >= 0).all():
            links = np.where(links == np.argmax(np.bincount(links.ravel())), -1, links)
        self.n_nodes, self._links, self._weights = n_nodes, links, weights

    def solve(self, right: FloatArray, *, accuracy: float) -> FloatArray:
        """x (n,) or (n, k) with L x = right; the norm of the residual is at most `accuracy` times that of `right`."""
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
        """(n,) whether a node has a link; elsewhere x is 0."""
        linked = np.zeros(self.n_nodes, dtype=bool)
        linked[self._links[self._links >= 0]] = True
        return linked

    @cached_property
    def _eliminated(self) -> BoolArray:
        """(n,) nodes with few neighbours, no two of which are linked: all first ends of links, or all second ends."""
        sides = []
        for end, other in (self._links.T, self._links.T[::-1]):
            degrees = np.bincount(end[end >= 0], minlength=self.n_nodes)
            elsewhere = np.zeros(self.n_nodes, dtype=bool)
            elsewhere[other[other >= 0]] = True
            sides.append((degrees > 0) & (degrees <= MAX_ELIMINATED_NEIGHBOURS) & ~elsewhere)
        return max(sides, key=np.count_nonzero)

    @cached_property
    def _coupling(self) -> SparseMatrix:
        """(eliminated, kept) the rows of eliminated nodes and the columns of kept nodes of L."""
        return csr_array(self.matrix[self._eliminated][:, ~self._eliminated])

    @cached_property
    def _factor(self) -> Factor:
        return factorise(self._reduced)

    @cached_property
    def _multigrid(self) -> LinearOperator:
        import pyamg  # takes long to import

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
        # where this accuracy is not reached, the Newton step is less accurate, and the caller checks its result
        found, _ = cg(self._reduced, right, rtol=accuracy, maxiter=MAX_MULTIGRID_ITERATIONS, M=self._multigrid)
        return np.asarray(found)
