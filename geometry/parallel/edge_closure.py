"""The edge lengths of a parallel mesh as unknowns, with the equations that its faces and loops close.

A mesh parallel to M has the edges mu_e u_e, with the unit directions u_e of M. For any signed lengths mu (E,) with
which all faces close, and all loops around holes and handles, there is exactly one such mesh up to translations. These
equations contain one derivative less than equation (2), so that small singular values are larger; and there are fewer
of them, two for each face, in its plane.

A triangle closes only as a multiple of itself, so that the edges of connected triangles are one unknown.
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
"""Added to squared singular values: well above their rounding, and below the squares of values that are not zero."""

SLIVER_HEIGHT_RATIO = 1e-3
"""Height of a triangle over its longest edge, below which its edges are separate unknowns: the edges of a triangle
without height can change their lengths independently."""


@dataclass(frozen=True, eq=False)
class EdgeClosure:
    """The closure equations of a mesh. Raises MeshError for an edge without length."""

    mesh: Mesh

    @cached_property
    def parts(self) -> IntArray:
        """(N,) number of the connected part of the mesh that a vertex belongs to; a vertex without edges is a part."""
        return integers(connected_components(self.mesh.combinatorics.adjacency, directed=False)[1])

    @cached_property
    def lengths(self) -> SparseMatrix:
        """(E, n): mu from the n unknowns; columns are orthonormal."""
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
        """B (m, n): the edges close where B x = 0. Two rows for each face, three for each loop."""
        c, normals, directions = self.mesh.combinatorics, self.mesh.face_normals, self.mesh.edge_directions
        second = np.cross(normals, directions[c.corner_edge[c.face_starts[:-1]]])
        second /= np.linalg.norm(second, axis=1, keepdims=True)
        loops = independent_loops(c)
        longer = np.sqrt(np.maximum(np.diff(loops.indptr), 1))  # so that long loops have the weight of faces
        along = csr_array(diags_array(1 / longer) @ loops)
        parts = [self._face_rows(np.cross(second, normals)), self._face_rows(second)]
        parts += [csr_array(along @ diags_array(directions[:, k])) for k in range(3)]
        return csr_array(csr_array(vstack(parts)) @ self.lengths)

    @property
    def is_overdetermined(self) -> bool:
        """Whether there are more equations than unknowns, as with many triangles beside larger faces."""
        return self.matrix.shape[0] > self.matrix.shape[1]

    @cached_property
    def narrow(self) -> SparseMatrix:
        """B or its transpose, whichever has fewer columns: they have the same singular values, except for zeros."""
        return self.matrix if self.is_overdetermined else csr_array(self.matrix.T)

    @cached_property
    def factor(self) -> Factor:
        """The factor of narrow^T narrow + FACTOR_SHIFT."""
        normal = csr_array(self.narrow.T) @ self.narrow
        return factorise(csr_array(normal + FACTOR_SHIFT * eye_array(self.narrow.shape[1])))

    @cached_property
    def deviation(self) -> float:
        """Bound for the norm of the omitted equations, the closure of faces perpendicular to their planes."""
        off: SparseMatrix = abs(self._face_rows(self.mesh.face_normals))
        return float(np.sqrt(off.sum(axis=1).max(initial=0.0) * off.sum(axis=0).max(initial=0.0)))

    @cached_property
    def _is_rigid(self) -> BoolArray:
        """(F,) whether a face is a triangle that is not a sliver."""
        c = self.mesh.combinatorics
        longest = np.maximum.reduceat(self.mesh.edge_lengths[c.corner_edge], c.face_starts[:-1])
        areas = np.linalg.norm(self.mesh.vector_areas, axis=1)
        rigid: BoolArray = (c.face_sizes == 3) & (2 * areas > SLIVER_HEIGHT_RATIO * longest**2)
        return rigid

    def _face_rows(self, vectors: FloatArray) -> SparseMatrix:
        """(., E) for each face that is not rigid: the sum of mu_e u_e around it, times its row of vectors (F, 3)."""
        c = self.mesh.combinatorics
        corners = np.flatnonzero(~self._is_rigid[c.corner_face])
        faces, edges = c.corner_face[corners], c.corner_edge[corners]
        row_of_face: IntArray = np.cumsum(~self._is_rigid) - 1
        values = np.einsum("ck,ck->c", vectors[faces], self.mesh.edge_directions[edges])
        values *= np.where(c.runs_along_edge[corners], 1.0, -1.0)
        shape = (int((~self._is_rigid).sum()), c.n_edges)
        return csr_array(coo_array((values, (row_of_face[faces], edges)), shape=shape))
