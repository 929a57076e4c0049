"""Independent loops: as many as homology has, closed, and enough."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.mesh import Mesh, shapes
from geometry.parallel.homology import independent_loops
from tests.geometry.topologies import TORUS, without


@pytest.mark.parametrize(
    ("mesh", "count"),
    [
        (shapes.grid(4, 4), 0),
        (shapes.dodecahedron(), 0),
        (shapes.dome(7, 3), 1),
        (without(shapes.grid(5, 5), 6, 8, 18), 3),
        (TORUS, 2),
        (without(TORUS, 0), 2),
        (without(TORUS, 0, 7, 12), 4),
        (shapes.double_ring(), 4),
        (without(shapes.grid(3, 3), 4, 8), 1),  # a hole, and a corner less
        (without(shapes.grid(2, 2), 1, 2), 0),  # two faces that meet in a vertex
        (without(shapes.grid(3, 3), 1, 3, 4, 5, 7), 0),  # four faces apart from each other
    ],
)
def test_loops_are_independent_closed_and_enough(mesh: Mesh, count: int) -> None:
    c = mesh.combinatorics
    loops = independent_loops(c).toarray()
    assert loops.shape == (count, c.n_edges)
    np.testing.assert_allclose(loops @ mesh.edge_vectors, 0, atol=1e-13)  # rounding
    differences = np.zeros((c.n_edges, c.n_vertices))
    differences[np.arange(c.n_edges), c.edges[:, 1]] = 1
    differences[np.arange(c.n_edges), c.edges[:, 0]] = -1
    around = np.zeros((c.n_faces, c.n_edges))
    around[c.corner_face, c.corner_edge] = np.where(c.runs_along_edge, 1, -1)
    # what sums to zero around faces and along loops is a difference of values at the vertices, and nothing else is
    rank = np.linalg.matrix_rank(np.concatenate([around, loops]))
    assert rank == np.linalg.matrix_rank(around) + count
    assert rank == c.n_edges - np.linalg.matrix_rank(differences)
