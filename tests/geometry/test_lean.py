"""Leaning axes: zero along normals, the angle by which they are turned, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geometry.errors import MeshError
from geometry.functionals.boundary_normals import extrapolated_normals
from geometry.gauss import Pair, axis_lean
from geometry.mesh import Combinatorics, Mesh, shapes, solids

PLATONIC = ["tetrahedron", "cube", "octahedron", "dodecahedron", "icosahedron"]

seeds = st.integers(0, 2**32 - 1)


@given(st.sampled_from(PLATONIC), st.floats(0, np.pi), seeds)
def test_axes_lean_by_the_angle_by_which_they_are_turned(name: str, angle: float, seed: int) -> None:
    """Vertices of these solids point along their normals; each is turned about some direction across it."""
    solid = getattr(solids, name)()
    normals = solid.vertices / np.linalg.norm(solid.vertices, axis=1, keepdims=True)
    rng = np.random.default_rng(seed)
    across = np.cross(normals, rng.normal(size=normals.shape))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turned = solid.with_vertices(Rotation.from_rotvec(angle * across).apply(np.array(solid.vertices)))
    placed = (rng.uniform(0.1, 10) * solid).translated(rng.uniform(-5, 5, 3))
    # acos and atan2 of sums of about ten products; the sizes of turned axes do not matter
    np.testing.assert_allclose(axis_lean(placed, rng.uniform(0.1, 10) * turned.vertices), angle, rtol=0, atol=1e-13)


def test_axes_of_a_flat_mesh_lean_by_the_shift_of_its_gauss_image() -> None:
    """Boundary and corners too, and no lean is reported for a vertex without a face or without an axis."""
    grid = shapes.grid(3, 2)
    flat = Mesh(np.concatenate([grid.vertices, [[9, 9, 9]]]), Combinatorics.from_faces(13, grid.combinatorics.faces))
    image = flat.with_vertices(np.tile([1.0, 0.0, 1.0], (13, 1)))
    leans = Pair(flat, image).leans
    np.testing.assert_allclose(leans[:12], np.pi / 4, rtol=0, atol=1e-15)
    assert np.isnan(leans[12])
    gone = image.vertices.copy()
    gone[4] = 0
    assert np.flatnonzero(np.isnan(axis_lean(flat, gone))).tolist() == [4, 12]


def test_at_the_boundary_the_nearer_of_two_normals_counts() -> None:
    """The mean of the faces lags behind on a coarse cap of a sphere, and the extrapolated normal is not sure."""
    cap = shapes.dome(12, 4)
    at_rim = cap.combinatorics.is_boundary_vertex
    for image in (cap.with_vertices(cap.vertex_normals), cap.with_vertices(extrapolated_normals(cap))):
        np.testing.assert_allclose(axis_lean(cap, image.vertices), 0, atol=1e-7)  # acos and atan2 of rounding
    leans = axis_lean(cap, cap.vertices)  # vertices on the sphere are its normals
    assert leans[at_rim].max() < 0.5 * np.radians(70 / 4) / 2  # the mean of the faces is half a face behind


def test_axes_of_other_vertices_are_refused() -> None:
    with pytest.raises(MeshError, match="one vector a vertex is needed"):
        axis_lean(shapes.cube(), shapes.octahedron().vertices)
