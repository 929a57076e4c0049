"""What makes a parallel mesh S a Gauss image of M: nearness to the unit sphere [Pottmann2007, 4.2]."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.functionals.unknowns import coordinates
from geometry.mesh import Mesh
from geometry.optimise.functional import LinearFunctional, SparseMatrix

__all__ = ["close_to_vertex_normals", "unit_face_distances"]


def unit_face_distances(mesh: Mesh) -> LinearFunctional:
    """f_faces: n_F . s_i - 1 for one corner i of each face; where S is parallel, its corners agree."""
    c = mesh.combinatorics
    columns = coordinates(c.corners[c.face_starts[:-1]]).ravel()
    starts = np.arange(0, len(columns) + 1, 3)
    matrix: SparseMatrix = csr_array((mesh.face_normals.ravel(), columns, starts), shape=(c.n_faces, 3 * c.n_vertices))
    return LinearFunctional(matrix, np.ones(c.n_faces))


def close_to_vertex_normals(mesh: Mesh) -> LinearFunctional:
    """f_vert: s_i minus the estimated unit normal at m_i."""
    return LinearFunctional(csr_array(eye_array(3 * mesh.n_vertices)), mesh.vertex_normals.ravel())
