"""Faces of very many corners: checked and made planar in as many numbers as they have, with the same answers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.files import meeting_outlines as outlines
from geometry.files import mend
from geometry.files.face_checks import FOLD_CLEARANCE
from geometry.functionals import planar_faces
from geometry.functionals.planar_faces import PlanarFaces
from geometry.gauss import nearest_parallel_pair
from geometry.mesh import Mesh, shapes
from geometry.meshing import planarise
from geometry.optimise.constrained_quadratic import ConstrainedQuadratic

seeds = st.integers(0, 2**32 - 1)
KINDS = ["star", "on a raster", "two exchanged", "corner on an edge", "comb", "anywhere"]


def outline(kind: str, k: int, rng: np.random.Generator) -> FloatArray:
    """(1, k, 2) in its mean edge lengths: simple for the first kind; the others often are not."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, k))
    points = rng.uniform(0.2, 1, k)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    i, j = rng.choice(k, 2, replace=False)
    match kind:
        case "on a raster":
            points = np.round(6 * points)
        case "two exchanged":
            points[[i, j]] = points[[j, i]]
        case "corner on an edge":
            share = rng.random()
            points[i] = points[j] * (1 - share) + points[(j + 1) % k] * share
        case "comb":
            teeth = k // 2
            points = np.stack([np.repeat(np.arange(teeth), 2), np.tile([0, 5, 5, 0], teeth)[: 2 * teeth]], axis=1)
            points = np.concatenate([points, [[teeth, 0], [teeth, -1], [-1, -1], [-1, 0]]]).astype(float)
            points[rng.integers(len(points))] += rng.integers(-1, 2, 2)
        case "anywhere":
            points = rng.normal(size=(k, 2))
    points = points - points.mean(axis=0)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    points = points[lengths > 0]  # the edges of a mended mesh have lengths
    return (points / lengths.mean())[None]


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=60, deadline=None)
@given(seed=seeds, k=st.integers(6, 60))
def test_strips_find_what_comparing_all_edges_finds(kind: str, seed: int, k: int) -> None:
    points = outline(kind, k, np.random.default_rng(seed))
    found = []
    with pytest.MonkeyPatch.context() as patch:
        for large in (10**9, 2):
            patch.setattr(outlines, "STRIP_SEARCH_CORNERS", large)
            folds, crossings = outlines.meetings(points, FOLD_CLEARANCE)
            found.append((bool(folds), bool(folds or crossings)))
    assert found[0] == found[1]


def spikes(n: int) -> list[list[float]]:
    """n spikes side by side, from x = 0 at heights from -0.4 to 0.4 to x = 3 or so."""
    feet = np.linspace(-0.4, 0.4, 2 * n + 1).tolist()
    return [
        point
        for k in range(n)
        for point in ([0, feet[2 * k]], [3 + 0.01 * k, feet[2 * k] + 0.1 / n], [0, feet[2 * k + 1]])
    ]


@pytest.mark.parametrize("n", [1, 2, 5, 20])
@pytest.mark.parametrize("turn", [0, 1, 2, 3])
def test_edges_that_cross_behind_what_lies_between_them_are_found(n: int, turn: int) -> None:
    """No end of the one is beside the other: they are neighbours only where the spikes between them have ended."""
    between = np.array(spikes(n))
    points = np.concatenate([between, [[0, 1], [10, -0.5], [10, 0.5], [0, -1]]])
    points = np.stack([points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outlines, "STRIP_SEARCH_CORNERS", 2)
        folds, crossings = outlines.meetings(points, FOLD_CLEARANCE)
    assert (folds, len(crossings)) == ([], 1)
    assert (crossings[0].corner, crossings[0].edge) == (3 * n, 3 * n + 2)


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
@pytest.mark.parametrize("other", ["edge", "tip"])
def test_tips_that_only_just_reach_the_other_side_are_found(quarters: int, other: str) -> None:
    """An edge upright before a tip spans no strip that the tip lies in; two tips may share none either way."""
    gap = FOLD_CLEARANCE / 10
    far = [[1 + gap, -3], [1 + gap, 3]] if other == "edge" else [[3, 0.5], [1 + gap, gap], [3, 3]]
    points = np.array([[0, -3], [3, -3.5], *far, [3, 3.5], [-3, 3.5], [-1, -0.5], [1, 0], [0, -1]], dtype=float)
    points = np.linalg.matrix_power(np.array([[0, 1], [-1, 0]]), quarters) @ points.T
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outlines, "STRIP_SEARCH_CORNERS", 2)
        folds, _ = outlines.meetings(points.T[None], FOLD_CLEARANCE)
    assert folds[0].distance < FOLD_CLEARANCE


def gear(k: int, *, depth: float = 0.5) -> FloatArray:
    """(k, 3) teeth around a circle: long edges close to each other."""
    angles = 2 * np.pi * np.arange(k) / k
    radii = np.where(np.arange(k) % 2, 1.0, 1 - depth)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(k)], axis=1)


@pytest.mark.parametrize("k", [300, 8_000])
def test_one_fault_among_many_corners_is_found(k: int) -> None:
    points = gear(k)
    assert mend(points, [range(k)])[0].n_faces == 1
    crossed = points.copy()
    crossed[[k // 3, k // 3 + 2]] = points[[k // 3 + 2, k // 3]]
    with pytest.raises(MeshError, match="face 0 crosses itself") as caught:
        mend(crossed, [range(k)])
    assert caught.value.elements == (0,)
    pinched = points.copy()
    pinched[k // 2] = (points[k // 2 + 1] + points[k // 2 + 2]) / 2
    with pytest.raises(MeshError, match=f"face 0 folds back on itself: its vertex {k // 2} lies"):
        mend(pinched, [range(k)])


# --- planarity


def prism(k: int, seed: int, amount: float) -> Mesh:
    mesh = shapes.regular_prism(k)
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape) * mesh.mean_edge_length
    return mesh.with_vertices(mesh.vertices + amount * noise)


@given(st.integers(13, 40), seeds, st.floats(-4, -1))
def test_distances_of_many_corners_vanish_with_those_from_the_best_plane(k: int, seed: int, decade: float) -> None:
    """Their squares add up to at least those from the best plane, and to no more than what the shares make of them."""
    mesh = prism(k, seed, 10**decade)
    x = mesh.vertices.ravel()
    large = PlanarFaces(mesh.combinatorics)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planar_faces, "MAX_FRAMED_CORNERS", k)
        small = PlanarFaces(mesh.combinatorics).residual(x)
        assert len(small) == len(large.residual(x))
    square, best = float((large.residual(x) ** 2).sum()), float((small**2).sum())
    assert best * (1 - 1e-9) <= square <= 10 * k * best


@given(st.integers(13, 40), seeds, st.floats(-4, -1))
def test_derivatives_of_large_faces_are_exact(k: int, seed: int, decade: float) -> None:
    mesh = prism(k, seed, 10**decade)
    x = mesh.vertices.ravel()
    functional = PlanarFaces(mesh.combinatorics, x)
    step = np.random.default_rng(seed + 1).normal(size=len(x)) * 1e-6
    difference = (functional.residual(x + step) - functional.residual(x - step)) / 2
    expected = functional.jacobian(x) @ step
    # quads are exact at planar faces only; they come first
    quads = k
    np.testing.assert_allclose(difference[quads:], expected[quads:], rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("k", [100, 300])
def test_large_faces_become_planar_and_their_factor_stays_sparse(k: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers in the factor grow as the corners do: which needs one pattern in all steps."""
    sizes = []
    factor = ConstrainedQuadratic._factor.func

    def counted(self: ConstrainedQuadratic) -> object:
        found = factor(self)
        sizes.append(found.lu.L.nnz)
        return found

    monkeypatch.setattr(ConstrainedQuadratic, "_factor", property(counted))
    found = planarise(prism(k, 1, 1e-3))
    assert found.plane_deviation_after <= 1e-12
    assert found.largest_move < 0.1
    assert max(sizes) < 300 * k  # about 190; a full one has 4.5 k for each corner


def test_a_pair_of_meshes_with_large_faces_becomes_exact() -> None:
    mesh = shapes.regular_prism(200)
    image = mesh.with_vertices(mesh.vertices / np.linalg.norm(mesh.vertices, axis=1).mean())
    rounded = mesh.with_vertices(mesh.vertices.round(6)), image.with_vertices(image.vertices.round(8))
    found = nearest_parallel_pair(*rounded)
    exact, parallel = found.mesh, found.gauss_image
    assert exact.plane_deviations.max() < 1e-12 * exact.mean_edge_length * 200  # that is how large the faces are
    assert np.linalg.norm(exact.vertices - mesh.vertices, axis=1).max() < 1e-4
    assert parallel.n_faces == mesh.n_faces
