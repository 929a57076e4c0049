"""The support structure against what [Pottmann2007] says of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError, ParallelityError
from geometry.gauss import Pair
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh import Mesh


def cube(scale: float = 1.0) -> Mesh:
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) * scale
    return Mesh.from_faces(
        corners, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    )


def stretched(mesh: Mesh, factors: tuple[float, float, float]) -> Mesh:
    """A cube stretched along its edges is parallel to it."""
    return mesh.with_vertices(mesh.vertices * factors)


factor = st.floats(0.3, 3.0)
shift = st.floats(-0.2, 0.2)


@given(st.tuples(factor, factor, factor), st.tuples(shift, shift, shift))
def test_parallel_meshes_give_axes_without_torsion(
    factors: tuple[float, float, float], offset: tuple[float, float, float]
) -> None:
    gauss_image = stretched(cube(), factors)
    gauss_image = gauss_image.with_vertices(gauss_image.vertices + offset)
    structure = SupportStructure(Pair(cube(700.0), gauss_image), 100.0)
    # Proposition 1: the planes through an edge and the axes at its ends are one
    assert structure.twists.max() < 1e-14 * 10
    along = np.einsum("ek,ek->e", structure.width_directions, structure.mesh.edge_directions)
    assert np.abs(along).max() < 1e-14
    for end in (0, 1):
        axes = structure.axes[structure.mesh.combinatorics.edges[:, end]]
        assert np.abs(np.einsum("ek,ek->e", axes, structure.width_directions)).max() < 1e-14 * 10


def test_heights_are_the_distances_of_the_edges_of_the_gauss_image() -> None:
    structure = SupportStructure(Pair(cube(700.0), cube()), 100.0)
    assert structure.heights == pytest.approx(np.full(12, np.sqrt(2)))
    heights = np.linalg.norm(
        np.cross(structure.quads[:, 3] - structure.quads[:, 0], structure.mesh.edge_directions), axis=1
    )
    assert heights == pytest.approx(structure.heights * 100.0)
    assert structure.offset_mesh.vertices == pytest.approx(cube(800.0).vertices)


def test_width_directions_point_to_the_right_face() -> None:
    structure = SupportStructure(Pair(cube(700.0), cube()), 100.0)
    c = structure.mesh.combinatorics
    centres = np.array([structure.mesh.vertices[c.face(face)].mean(axis=0) for face in range(c.n_faces)])
    middles = structure.mesh.vertices[c.edges].mean(axis=1)
    towards_right = np.einsum("ek,ek->e", structure.width_directions, centres[c.edge_faces[:, 1]] - middles)
    assert towards_right.min() > 0


def test_meshes_that_are_not_parallel_are_refused_with_the_worst_edge() -> None:
    gauss_image = cube()
    moved = gauss_image.vertices.copy()
    moved[3] += [0, 0, 1e-6]
    with pytest.raises(ParallelityError, match=r"is off the direction of its mesh edge by 1\.0e-06") as caught:
        SupportStructure(Pair(cube(700.0), gauss_image.with_vertices(moved)), 100.0)
    assert 3 in cube().combinatorics.edges[caught.value.elements[0]]


def test_other_combinatorics_and_axes_in_edges_are_refused() -> None:
    with pytest.raises(MeshError, match="do not have the same faces"):
        SupportStructure(Pair(cube(700.0), cube().reversed()), 100.0)
    with pytest.raises(GeometryError, match="lie in the edge"):
        SupportStructure(Pair(cube(700.0), cube(0.0)), 100.0)


def test_a_distance_must_be_positive() -> None:
    with pytest.raises(GeometryError, match="must be above 0"):
        SupportStructure(Pair(cube(700.0), cube()), 0.0)
