"""Faces as unknowns of P(M): disjoint faces, and what they span."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import MeshError
from geometry.functionals.parallel_edges import parallel_to
from geometry.mesh import Mesh, shapes
from geometry.mesh.independent_faces import disjoint_faces
from geometry.parallel.face_unknowns import MAX_UNKNOWN_CORNERS, FaceUnknowns
from tests.geometry.topologies import by_equation_2, meshes, projected

ROUNDING = 1e-12  # directions of edges down to a hundredth of the size, in sums over a face


def uses(mesh: Mesh, faces: list[int]) -> list[int]:
    return np.concatenate([mesh.combinatorics.face(face) for face in faces]).tolist()


@given(mesh=meshes)
def test_disjoint_faces_share_no_vertex_and_none_can_be_added(mesh: Mesh) -> None:
    chosen = disjoint_faces(mesh.combinatorics).tolist()
    taken = uses(mesh, chosen)
    assert len(set(taken)) == len(taken)
    assert all(set(taken) & set(mesh.combinatorics.face(face).tolist()) for face in range(mesh.n_faces))


@given(nx=st.integers(1, 12), ny=st.integers(1, 12))
def test_on_a_grid_every_second_face_of_every_second_row_is_taken(nx: int, ny: int) -> None:
    chosen = disjoint_faces(shapes.grid(nx, ny).combinatorics)
    assert len(chosen) == ((nx + 1) // 2) * ((ny + 1) // 2)  # no more squares of 2 x 2 vertices have room


@settings(deadline=None)
@given(mesh=meshes, seed=st.integers(0, 99))
def test_unknowns_span_p_of_m_and_their_constraints_are_all_that_is_missing(mesh: Mesh, seed: int) -> None:
    mesh = projected(mesh, seed)
    unknowns = FaceUnknowns(mesh)
    N = unknowns.matrix.toarray()
    np.testing.assert_allclose(N.T @ N, np.eye(N.shape[1]), atol=ROUNDING)
    basis = by_equation_2(mesh)
    np.testing.assert_allclose(N @ (N.T @ basis), basis, atol=1e-9)  # the basis has lost as much where edges are short
    used = np.repeat(mesh.combinatorics.is_used, 3)
    reached = N[used] @ null_space(unknowns.constraints.toarray())
    assert np.linalg.matrix_rank(reached, tol=1e-6) == basis.shape[1]


def null_space(matrix: np.ndarray) -> np.ndarray:
    _, values, directions = np.linalg.svd(matrix)
    return directions[int((values > 1e-9).sum()) :].T  # as in by_equation_2


@settings(deadline=None)
@given(mesh=meshes, seed=st.integers(0, 99))
def test_whatever_the_unknowns_are_edges_of_their_faces_are_parallel(mesh: Mesh, seed: int) -> None:
    unknowns = FaceUnknowns(projected(mesh, seed))
    y = np.random.default_rng(seed).normal(size=unknowns.matrix.shape[1])
    off = np.abs(parallel_to(unknowns.mesh).matrix @ (unknowns.matrix @ y))
    still = np.abs(unknowns.constraints @ y)
    assert np.sort(off)[: len(off) - len(still)].max(initial=0.0) < ROUNDING
    np.testing.assert_allclose(np.sort(off)[len(off) - len(still) :], np.sort(still), atol=ROUNDING)


def test_quads_leave_five_unknowns_for_four_vertices() -> None:
    unknowns = FaceUnknowns(shapes.grid(9, 9))
    assert unknowns.matrix.shape == (300, 125)
    assert unknowns.constraints.shape == (2 * (180 - 4 * 25), 125)


def test_slender_and_very_large_faces_are_no_unknowns() -> None:
    slender = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [2, 1e-4, 0], [1, 1e-4, 0]], [[0, 1, 2, 3]])
    assert FaceUnknowns(slender).matrix.shape == (12, 12)
    around = np.linspace(0, 2 * np.pi, MAX_UNKNOWN_CORNERS + 1, endpoint=False)
    large = Mesh.from_faces(
        np.stack([np.cos(around), np.sin(around), 0 * around], axis=1), [range(MAX_UNKNOWN_CORNERS + 1)]
    )
    assert FaceUnknowns(large).matrix.shape == (3 * (MAX_UNKNOWN_CORNERS + 1), 3 * (MAX_UNKNOWN_CORNERS + 1))


def test_an_edge_without_length_is_refused() -> None:
    mesh = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]], [[0, 1, 2, 3]])
    with pytest.raises(MeshError, match="edge 3"):
        FaceUnknowns(mesh).matrix  # noqa: B018
