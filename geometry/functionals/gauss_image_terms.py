"""Terms that bring a parallel mesh S, the Gauss image of M, near the unit sphere [Pottmann2007, 4.1, 4.2].

Distances from the origin are linear in S where the direction to the nearest point is known: for faces it is their
normal; for edges and vertices it must be estimated.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray, floats
from geometry.functionals.boundary_normals import extrapolated_normals
from geometry.functionals.closeness import close_to
from geometry.functionals.unknowns import coordinates
from geometry.mesh import Mesh
from geometry.optimise import LinearFunctional, SparseMatrix

__all__ = [
    "close_to_vertex_normals",
    "edge_normals",
    "edges_at_unit_distance",
    "faces_at_unit_distance",
    "vertices_at_unit_distance",
]

LEAST_MEAN_NORMAL = 1e-6
"""Length of the mean of the unit normals on both sides of an edge, below which the edge has no normal."""


def faces_at_unit_distance(mesh: Mesh) -> LinearFunctional:
    """f_faces: n_F . s_i - 1 for one corner i of each face; where S is parallel to M, all corners give the same.

    >>> from geometry.mesh import shapes
    >>> box = shapes.box(1, 2, 3)
    >>> cube = shapes.box(2, 2, 2)  # its faces touch the unit sphere
    >>> faces_at_unit_distance(box).residual((cube.vertices - cube.vertices.mean(axis=0)).ravel()).round(12).tolist()
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    c = mesh.combinatorics
    return _unit_distances(mesh.face_normals, c.corners[c.face_starts[:-1]], mesh)


def edges_at_unit_distance(mesh: Mesh, directions: FloatArray) -> LinearFunctional:
    """f_edges: u_e . s_i - 1 for the tail i of each edge; where S is parallel to M, both ends give the same.

    directions (E, 3): u_e, perpendicular to the edges; unit vectors, or zero for an edge without a residual.

    >>> from geometry.mesh import shapes
    >>> box = shapes.box(1, 2, 3)
    >>> cube = shapes.box(2**0.5, 2**0.5, 2**0.5)  # its edges touch the unit sphere
    >>> r = edges_at_unit_distance(box, edge_normals(box))
    >>> abs(r.residual((cube.vertices - cube.vertices.mean(axis=0)).ravel())).max().round(12).item()
    0.0
    """
    return _unit_distances(directions, mesh.combinatorics.edges[:, 0], mesh)


def vertices_at_unit_distance(mesh: Mesh, directions: FloatArray) -> LinearFunctional:
    """n_i . s_i - 1 for each vertex; n_i (N, 3): unit vectors, or zero for a vertex without a residual.

    >>> from geometry.mesh import shapes
    >>> mesh = shapes.dome(8, 3)
    >>> r = vertices_at_unit_distance(mesh, mesh.vertex_normals)
    >>> abs(r.residual(2 * mesh.vertex_normals.ravel())).round(12).max().item()
    1.0
    """
    return _unit_distances(directions, np.arange(mesh.n_vertices), mesh)


def close_to_vertex_normals(mesh: Mesh) -> LinearFunctional:
    """f_vert: s_i minus the unit normal at m_i as estimated by `extrapolated_normals`.

    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(2, 2)
    >>> close_to_vertex_normals(grid).residual(np.tile([0.0, 0.0, 2.0], 9)).reshape(-1, 3)[0].round(12).tolist()
    [0.0, 0.0, 1.0]
    """
    return close_to(extrapolated_normals(mesh))


def edge_normals(mesh: Mesh) -> FloatArray:
    """(E, 3) unit vectors perpendicular to the edges, halfway between the normals of their faces; zero at a sharp fold.

    >>> from geometry.mesh import shapes
    >>> normals = edge_normals(shapes.box(1, 2, 3))
    >>> sorted(set(abs(normals).round(3).ravel().tolist()))
    [0.0, 0.707]
    """
    left, right = mesh.combinatorics.edge_faces.T
    normals = mesh.face_normals
    means = (normals[left] + normals[np.where(right < 0, left, right)]) / 2
    along = mesh.edge_directions
    means -= np.einsum("ek,ek->e", means, along)[:, None] * along
    lengths = np.linalg.norm(means, axis=1, keepdims=True)
    return floats(np.divide(means, lengths, out=np.zeros_like(means), where=lengths > LEAST_MEAN_NORMAL))


def _unit_distances(directions: FloatArray, vertices: IntArray, mesh: Mesh) -> LinearFunctional:
    """directions (m, 3) . s_i - 1 at the vertices i (m,); rows of zero directions are zero."""
    columns = coordinates(vertices).ravel()
    starts = np.arange(0, len(columns) + 1, 3)
    shape = (len(vertices), 3 * mesh.n_vertices)
    matrix: SparseMatrix = csr_array((directions.ravel(), columns, starts), shape=shape)
    return LinearFunctional(matrix, directions.any(axis=1).astype(float))
