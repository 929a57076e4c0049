"""Fairness of minimal and constant mean curvature meshes."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array, vstack

from geometry.mesh import Mesh
from geometry.optimise import SparseMatrix

__all__ = ["fairness_of_lengths"]

BOUNDARY_FAIRNESS_WEIGHT = 1e-3
"""Weight of the residuals of boundary vertices, which have neighbours on one side only: enough to decide where there
are no others, as in a single row of faces."""


def fairness_of_lengths(mesh: Mesh) -> SparseMatrix:
    """(3N, E) m_i minus the mean of its neighbours' neighbours, from edge lengths in the directions of the mesh.

    Not f_Laplacian, which takes the neighbours themselves [Pottmann2007, (3)]: where three edges meet in a minimal
    mesh, some reverse their orientation, so no smooth one is fair by it, and those that waver are as good. The mean
    over the neighbours' neighbours is over vertices of the same kind. Boundary vertices count next to nothing.
    """
    c = mesh.combinatorics
    i, j = c.edges.T
    edges = np.arange(c.n_edges)
    mean = diags_array(1 / np.maximum(c.vertex_degrees, 1))
    # with P the mean over neighbours, 1 - P^2 = (1 + P) (1 - P), and 1 - P has the edges alone
    weights = diags_array(np.where(c.is_boundary_vertex, BOUNDARY_FAIRNESS_WEIGHT, 1.0))
    further = csr_array(weights @ (eye_array(c.n_vertices) + mean @ c.adjacency))
    parts = []
    for k in range(3):
        along = mesh.edge_directions[:, k]
        places = (np.concatenate([i, j]), np.concatenate([edges, edges]))
        rows = csr_array(coo_array((np.concatenate([-along, along]), places), shape=(c.n_vertices, c.n_edges)))
        parts.append(csr_array(further @ csr_array(mean @ rows)))
    return csr_array(vstack(parts))
