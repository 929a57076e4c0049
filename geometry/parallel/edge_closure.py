"""The edges of a parallel mesh as unknowns: which edge lengths close around all faces and loops.

A mesh parallel to M has the edges mu_e u_e, u_e the unit directions of M. For any mu (E,) that closes around each face
and along each loop that faces do not fill, there is one, up to translations. This takes one derivative less than
equation (2), so small singular values are larger, and there are fewer equations: two a face, in its plane.

A triangle closes only as a multiple of itself, so the edges of triangles that hang together are one unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array, vstack
from scipy.sparse.csgraph import connected_components

from geometry.arrays import BoolArray, FloatArray, IntArray, integers
from geometry.mesh import Mesh
from geometry.optimise import Factor, SparseMatrix, factorise
from geometry.parallel.homology import independent_loops

__all__ = ["FACTOR_SHIFT", "EdgeClosure"]

FACTOR_SHIFT = 1e-13
"""Added to squared singular values: well above rounding, so that the factor is good, and below squared gaps."""

SLIVER_HEIGHT_RATIO = 1e-3
"""Height of a triangle over its longest edge, below which its edges are not taken for one unknown: if it has no
height, they are free to slide along each other."""


@dataclass(frozen=True, eq=False)
class EdgeClosure:
    """Raises MeshError for an edge without length."""

    mesh: Mesh

    @cached_property
    def parts(self) -> IntArray:
        """(N,) which part of the mesh a vertex belongs to; a vertex without edges is a part of its own."""
        return integers(connected_components(self.mesh.combinatorics.adjacency, directed=False)[1])

    @cached_property
    def lengths(self) -> SparseMatrix:
        """(E, n): mu from n unknowns; orthonormal columns."""
        c = self.mesh.combinatorics
        first = c.face_starts[:-1][self._is_rigid]
        linked = c.corner_edge[np.concatenate([[first, first + 1], [first + 1, first + 2]], axis=1)]
        graph = coo_array((np.ones(linked.shape[1]), linked), shape=(c.n_edges, c.n_edges))
        _, unknown = connected_components(graph, directed=False)
        squares = np.bincount(unknown, np.square(self.mesh.edge_lengths))
        values = self.mesh.edge_lengths / np.sqrt(squares[unknown])
        return csr_array(coo_array((values, (np.arange(c.n_edges), unknown)), shape=(c.n_edges, len(squares))))

    @cached_property
    def matrix(self) -> SparseMatrix:
        """B (m, n): B x = 0 says that the edges close. Two rows a face, three a loop."""
        c, normals, directions = self.mesh.combinatorics, self.mesh.face_normals, self.mesh.edge_directions
        second = np.cross(normals, directions[c.corner_edge[c.face_starts[:-1]]])
        second /= np.linalg.norm(second, axis=1, keepdims=True)
        loops = independent_loops(c)
        longer = np.sqrt(np.maximum(np.diff(loops.indptr), 1))  # so that long loops weigh what faces do
        along = csr_array(diags_array(1 / longer) @ loops)
        parts = [self._face_rows(np.cross(second, normals)), self._face_rows(second)]
        parts += [csr_array(along @ diags_array(directions[:, k])) for k in range(3)]
        return csr_array(csr_array(vstack(parts)) @ self.lengths)

    @property
    def is_overdetermined(self) -> bool:
        """Whether there are more equations than unknowns, as with many triangles among larger faces."""
        return self.matrix.shape[0] > self.matrix.shape[1]

    @cached_property
    def narrow(self) -> SparseMatrix:
        """B or its transpose, whichever has fewer columns: their singular values agree, but for zeros."""
        return self.matrix if self.is_overdetermined else csr_array(self.matrix.T)

    @cached_property
    def factor(self) -> Factor:
        """Of narrow^T narrow + FACTOR_SHIFT: of B B^T mostly."""
        normal = csr_array(self.narrow.T) @ self.narrow
        return factorise(csr_array(normal + FACTOR_SHIFT * eye_array(self.narrow.shape[1])))

    @cached_property
    def deviation(self) -> float:
        """Bound for the norm of what the equations leave out, the closing of faces across their planes."""
        off: SparseMatrix = abs(self._face_rows(self.mesh.face_normals))
        return float(np.sqrt(off.sum(axis=1).max(initial=0.0) * off.sum(axis=0).max(initial=0.0)))

    @cached_property
    def _is_rigid(self) -> BoolArray:
        """(F,) whether a face is a triangle that is no sliver."""
        c = self.mesh.combinatorics
        longest = np.maximum.reduceat(self.mesh.edge_lengths[c.corner_edge], c.face_starts[:-1])
        areas = np.linalg.norm(self.mesh.vector_areas, axis=1)
        rigid: BoolArray = (c.face_sizes == 3) & (2 * areas > SLIVER_HEIGHT_RATIO * longest**2)
        return rigid

    def _face_rows(self, vectors: FloatArray) -> SparseMatrix:
        """(., E) for each face that is not rigid, with its vector of vectors (F, 3): the sum of mu_e u_e along it."""
        c = self.mesh.combinatorics
        corners = np.flatnonzero(~self._is_rigid[c.corner_face])
        faces, edges = c.corner_face[corners], c.corner_edge[corners]
        row_of_face: IntArray = np.cumsum(~self._is_rigid) - 1
        values = np.einsum("ck,ck->c", vectors[faces], self.mesh.edge_directions[edges])
        values *= np.where(c.runs_along_edge[corners], 1.0, -1.0)
        shape = (int((~self._is_rigid).sum()), c.n_edges)
        return csr_array(coo_array((values, (row_of_face[faces], edges)), shape=shape))
