"""From a design surface to a planar mesh: what is kept, options for lines, and the study of networks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import KDTree

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.layout import boundary_lengths, lay_quads
from geometry.mesh import Mesh
from geometry.remeshing import affine_stretches, remesh, study_networks
from geometry.surface import Curvature, Surface
from tests.geometry.design_surfaces import chart, cylinder, disc, jagged_hole, sphere_cap, waves


def saddle() -> Surface:
    return disc(20, lambda x, y: x**2 / 2 - y**2 / 4)


def vault() -> Surface:
    """Of parabolas: the curvature at the ridge is 30 times that at the eaves, and rulings can have any distances."""
    return chart(60, 40, lambda u, v: (2 * u - 1, 2 * v, -1.5 * (2 * u - 1) ** 2))


def bowl() -> Surface:
    return disc(30, lambda x, y: 1.5 * x**2 + 0.5 * y**2)


def square_saddle() -> Surface:
    return chart(20, 20, lambda u, v: (2 * u - 1, 2 * v - 1, (2 * u - 1) ** 2 / 2 - (2 * v - 1) ** 2 / 4))


def eccentric_ring() -> Surface:
    """On a sphere, where any lines are principal, between two circles about different axes."""

    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        radius, shift = 0.35 + 0.65 * v, 0.25 * (1 - v)
        x, y = radius * np.cos(2 * np.pi * u) + shift, radius * np.sin(2 * np.pi * u)
        return x, y, np.sqrt(4 - x**2 - y**2)

    return chart(60, 20, point, rings="u")


def from_boundary(mesh: Mesh, surface: Surface) -> FloatArray:
    """Distances of the vertices at the boundary from that of the surface, in mean edge lengths."""
    triangles = surface.triangulated
    ends = triangles.vertices[triangles.combinatorics.edges[triangles.combinatorics.is_boundary_edge]]
    points = np.concatenate([ends[:, 0] + share * (ends[:, 1] - ends[:, 0]) for share in np.linspace(0, 1, 9)])
    at = mesh.vertices[mesh.combinatorics.is_boundary_vertex]
    return np.asarray(KDTree(points).query(at)[0] / mesh.mean_edge_length)


@pytest.mark.parametrize("boundary", ["open", "aligned"])
def test_the_mesh_is_planar_and_has_the_boundary_of_the_surface(boundary: str) -> None:
    result = remesh(saddle(), n_faces=300, boundary=boundary)  # type: ignore[arg-type]
    assert result.mesh.planarity.max() < 1e-12
    assert result.surface_distances.max() < 0.1 * result.mesh.mean_edge_length
    assert from_boundary(result.mesh, result.surface).max() < 0.05
    assert result.mesh.combinatorics.euler_characteristic == 1


def test_a_hole_cut_along_triangles_is_kept() -> None:
    given = jagged_hole()
    result = remesh(given, n_faces=200)
    triangle = given.mesh.mean_edge_length / result.mesh.mean_edge_length
    assert result.mesh.planarity.max() < 1e-12
    assert np.quantile(result.planarised.moves, 0.95) < 0.08
    assert result.surface_distances.max() < 0.1 * result.mesh.mean_edge_length
    assert result.mesh.combinatorics.euler_characteristic == 0
    assert from_boundary(result.mesh, given).max() < 0.2 * triangle  # on the zigzag, not across its teeth


def test_no_vertex_is_far_from_the_surface() -> None:
    """Single ones were, by 0.1 edges, where lines are not conjugate: here because they follow the boundary."""
    result = remesh(waves(), n_faces=150, boundary="aligned")
    assert result.surface_distances.max() < 0.08 * result.mesh.mean_edge_length


def test_rigid_motions_and_scales_change_nothing() -> None:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    given = saddle()
    moved = Surface(given.mesh.with_vertices(1000 * given.mesh.vertices @ turn.T + [5.0, -7.0, 3.0]))
    first, second = remesh(given, n_faces=200).mesh, remesh(moved, n_faces=200).mesh
    assert first.combinatorics.same_as(second.combinatorics)
    back = (second.vertices - [5.0, -7.0, 3.0]) @ turn / 1000
    assert np.abs(back - first.vertices).max() < 1e-5  # curvature is a second difference of rounded coordinates


@pytest.mark.parametrize("turn", [0.2, 0.6, 1.3])
def test_lines_follow_a_stroke(turn: float) -> None:
    """On a sphere all directions are principal, so that lines can follow any stroke."""
    along = np.array([np.cos(turn), np.sin(turn), 0.0])
    steps = np.linspace(-0.8, 0.8, 30)[:, None] * along
    stroke = steps + [0, 0, 1] * np.sqrt(2 - (steps**2).sum(axis=1, keepdims=True))
    mesh = lay_quads(sphere_cap(), n_faces=400, strokes=[stroke]).mesh
    middles = mesh.vertices[mesh.combinatorics.edges].mean(axis=1)
    near = (KDTree(stroke).query(middles)[0] < 0.05) & ~mesh.combinatorics.is_boundary_edge
    seen_from_above = mesh.edge_vectors[near, :2] / np.linalg.norm(mesh.edge_vectors[near, :2], axis=1, keepdims=True)
    off = np.degrees(np.arccos(np.abs(seen_from_above @ along[:2]).clip(max=1)))
    lengthwise = off < 45
    assert lengthwise.sum() > 10
    assert np.median(off[lengthwise]) < 3
    assert np.median(90 - off[~lengthwise]) < 6


def by_curvature(mesh: Mesh, surface: Surface) -> tuple[float, float]:
    """Mean lengths of the quarters of the edges where the surface is flattest and where it curves most."""
    curvatures = np.linalg.norm(Curvature.of(surface.triangulated).tensors, axis=(1, 2))
    middles = mesh.vertices[mesh.combinatorics.edges].mean(axis=1)
    lengths = mesh.edge_lengths[np.argsort(curvatures[KDTree(surface.triangulated.vertices).query(middles)[1]])]
    quarter = len(lengths) // 4
    return float(lengths[:quarter].mean()), float(lengths[-quarter:].mean())


@pytest.mark.parametrize(("make", "gain"), [(vault, 1.5), (bowl, 1.2)])
def test_edges_are_shorter_where_the_surface_curves_more(make: Any, gain: float) -> None:
    """On surfaces whose lines can have very different distances."""
    surface = make()
    ratios = []
    for ratio in (1.0, 4.0):
        result = remesh(surface, n_faces=500, finer_where_curved=ratio)
        flat, curved = by_curvature(result.mesh, surface)
        ratios.append(flat / curved)
        assert result.mesh.planarity.max() < 1e-12
        assert abs(result.mesh.n_faces - 500) < 60
        assert np.quantile(result.planarised.moves, 0.95) < 0.08
        assert result.surface_distances.max() < 0.1 * result.mesh.mean_edge_length
        assert (np.diff(result.laid.quality.length_shares) > 0).all()
    print(ratios)
    assert ratios[1] > gain * ratios[0]


@pytest.mark.parametrize("make", [cylinder, sphere_cap])
def test_constant_curvature_asks_for_one_length(make: Any) -> None:
    surface = make()
    one, graded = (lay_quads(surface, n_faces=400, finer_where_curved=ratio) for ratio in (1, 4))
    assert one.mesh.combinatorics.same_as(graded.mesh.combinatorics)
    moves = np.linalg.norm(one.mesh.vertices - graded.mesh.vertices, axis=1) / one.mesh.mean_edge_length
    assert moves.max() < 0.1
    assert graded.network.sizes == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize("ratio", [0.5, 11, float("nan")])
def test_ratios_of_lengths_are_bounded(ratio: float) -> None:
    with pytest.raises(GeometryError, match="finer_where_curved is"):
        lay_quads(saddle(), n_faces=100, finer_where_curved=ratio)


def regular_shares(surface: Surface, boundary: object) -> tuple[float, float]:
    """Of the vertices on the outer and the inner loop, those where one line ends, as on a boundary that is a line."""
    mesh = lay_quads(surface, n_faces=300, boundary=boundary).mesh  # type: ignore[arg-type]
    c = mesh.combinatorics
    loops = sorted(c.boundary_loops, key=lambda loop: float(np.linalg.norm(mesh.vertices[loop], axis=1).min()))
    outer, inner = sorted(loops, key=len, reverse=True)
    return float((c.vertex_degrees[outer] == 3).mean()), float((c.vertex_degrees[inner] == 3).mean())


def test_each_boundary_loop_has_its_own_word() -> None:
    ring = eccentric_ring()
    lengths = boundary_lengths(ring)
    assert lengths[0] > lengths[1]
    assert lengths == pytest.approx([2 * np.pi, 0.7 * np.pi], rel=0.02)
    outer, inner = regular_shares(ring, ["aligned", "open"])
    assert outer > 0.95 > inner
    outer, inner = regular_shares(ring, ["open", "aligned"])
    assert inner > 0.95 > outer


def test_wrong_words_and_strokes_are_one_sentence() -> None:
    with pytest.raises(GeometryError, match=r"3 boundaries are given .* 2 boundary loops .* longest first"):
        lay_quads(eccentric_ring(), n_faces=100, boundary=["open"] * 3)
    with pytest.raises(GeometryError, match="the boundary is 'closed': it is 'open' or 'aligned'"):
        lay_quads(cylinder(), n_faces=100, boundary="closed")  # type: ignore[arg-type]
    with pytest.raises(GeometryError, match="stroke 1 has no direction"):
        lay_quads(cylinder(), n_faces=100, strokes=[[[0, 0, 0], [1, 0, 0]], [[1, 1, 1]]])


def test_principal_lines_are_the_best_network_of_a_saddle() -> None:
    shares: list[float] = []
    trials = study_networks(
        square_saddle(), maps=[np.diag([1, 1, 0.5]), np.eye(3), np.diag([1, 3, 1])], n_faces=200, progress=shares.append
    )
    assert (trials[0].affine == np.eye(3)).all()
    assert np.degrees(trials[0].crossing_angles) == pytest.approx([90, 90])
    assert all(trial.crossing_angles[0] < np.radians(85) for trial in trials[1:])
    spreads = [trial.height_spread for trial in trials]
    assert spreads == sorted(spreads)
    assert shares == pytest.approx([1 / 3, 2 / 3, 1])


def test_a_map_without_a_mesh_comes_last_with_its_reason() -> None:
    trials = study_networks(saddle(), maps=[np.zeros((3, 3)), np.eye(3)], n_faces=100)
    assert trials[0].pair is not None
    assert trials[1].pair is None
    assert "an invertible matrix" in trials[1].reason


def test_stretches_are_different_up_to_turns_and_scale() -> None:
    forms = []
    for affine in affine_stretches(saddle()):
        form = affine.T @ affine
        forms.append(form / np.cbrt(np.linalg.det(form)))
    apart = np.abs(np.array(forms)[:, None] - np.array(forms)).max(axis=(2, 3)) + np.eye(len(forms))
    assert len(forms) == 27
    assert apart.min() > 0.1


def test_corners_stay_convex_and_edges_do_not_collapse() -> None:
    """Beside a bump on a shallow shell, where vertices glide far: an edge shrank to a hundredth."""
    shell = chart(
        50,
        50,
        lambda u, v: (
            *(x := 2 * u - 1, y := 2 * v - 1),
            0.1 * np.exp(-12 * (x**2 + y**2)) - 0.15 * (x**2 + 2 * y**2),
        ),
    )
    result = remesh(shell, n_faces=1000)
    corners = np.degrees(result.mesh.corner_angles)
    assert corners.min() > 8
    assert corners.max() < 172


def hyperbolic(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """Lines of curvature cross the boundary at 45 degrees, asymptotic lines run along it."""
    return 2 * u - 1, 2 * v - 1, 0.6 * (2 * u - 1) * (2 * v - 1)


def helicoid(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    return (0.4 + v) * np.cos(4 * u), (0.4 + v) * np.sin(4 * u), 1.5 * u


def elliptic_ring(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    x, y = (0.4 + 0.6 * v) * np.cos(2 * np.pi * u), (0.4 + 0.6 * v) * np.sin(2 * np.pi * u)
    return x, y, 0.5 * x**2 - 0.2 * y**2


def test_rims_have_no_slender_triangles_at_the_corners_of_the_surface() -> None:
    """An edge of .07 beside a corner remained, since it had been refused beside others that went later."""
    shell = chart(
        60,
        50,
        lambda u, v: (*(x := 2.4 * u - 1.2, y := 2 * v - 1), 0.6 - 0.3 * x**2 - 0.2 * y**2 + 0.1 * x * y**2),
    ).mesh
    noise = np.random.default_rng(5).standard_normal(shell.vertices.shape)
    noisy = Surface(shell.with_vertices(shell.vertices + 0.01 * shell.mean_edge_length * noise))
    for n_faces in (500, 1000, 1500):
        assert np.degrees(lay_quads(noisy, n_faces=n_faces).quality.corner_angles.min()) > 15


@pytest.mark.parametrize(("point", "rings"), [(hyperbolic, ""), (helicoid, ""), (elliptic_ring, "u")])
@pytest.mark.parametrize("n_faces", [300, 1000])
def test_a_boundary_that_crosses_the_lines_costs_no_large_moves(point: Any, rings: str, n_faces: int) -> None:
    result = remesh(chart(48, 32, point, rings=rings), n_faces=n_faces)
    assert result.mesh.planarity.max() < 1e-12
    assert result.planarised.largest_move < 0.1
    assert result.surface_distances.max() < 0.03 * result.mesh.mean_edge_length
    assert from_boundary(result.mesh, result.surface).max() < 0.08
    corners = np.degrees(result.mesh.corner_angles)
    assert corners.min() > 15
    assert corners.max() < 165
