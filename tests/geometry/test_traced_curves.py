"""Curves traced on surfaces, beside the formulas of these curves; how far apart they are; where they end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from geometry import GeometryError, Mesh, Surface, TracedCurves, trace_curves
from geometry.arrays import FloatArray
from geometry.traced_curves import curve_tracing
from geometry.traced_curves.line_fields import LineField
from geometry.traced_curves.walks import walk
from tests.geometry.bent_meshes import rotation
from tests.geometry.design_surfaces import ball, chart, cylinder, disc, monkey_saddle, plate, sphere_cap, torus
from tests.geometry.topologies import together

AXES = (3.0, 2.0, 1.2)


def elliptic_coordinates(points: FloatArray) -> FloatArray:
    """(n, 2) the parameters of the two other quadrics through points of an ellipsoid that are confocal with it: along
    each of its lines of curvature one of them is constant."""
    squares, axes = points**2, np.square(AXES)
    sums = axes.sum() - squares.sum(axis=1)
    products = axes[0] * axes[1] + axes[1] * axes[2] + axes[2] * axes[0] - squares @ (axes.sum() - axes)
    root = np.sqrt(np.maximum(sums**2 - 4 * products, 0))
    return np.stack([(-sums - root) / 2, (-sums + root) / 2], axis=1)


def orders(name: str, errors: list[float]) -> FloatArray:
    found = np.log2(np.array(errors[:-1]) / errors[1:])
    print(f"{name}: errors {np.array(errors)}, orders {found.round(2)}")
    return np.asarray(found)


def test_curves_of_an_ellipsoid_tend_to_its_lines_of_curvature() -> None:
    """Along each of them an elliptic coordinate is constant; from seeds away from the umbilics, at y = 0, x = 2.3."""
    turn, height = (each.ravel() for each in np.meshgrid(np.arange(0.4, 6.5, 0.61), [-0.5, 0.1, 0.6]))
    across = np.sqrt(1 - height**2)
    seeds = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1) * AXES
    seeds = seeds[np.abs(seeds[:, 1]) > 0.6]
    errors = []
    for n in (16, 32, 64):
        surface = zone(n)
        _, triangles, _, weights = surface.locate(seeds)
        field = LineField.of(surface.mesh, None, is_asymptotic=False)
        corners = surface.mesh.vertices[surface.mesh.combinatorics.corners.reshape(-1, 3)]
        for family in (0, 1):
            families = np.full(len(seeds), family)
            walks = walk(field, triangles, weights, families, spacing=0.3, longest=4.0)
            points = np.einsum("nk,nki->ni", walks.weights, corners[walks.triangles])
            points /= np.sqrt((points**2 / np.square(AXES)).sum(axis=1, keepdims=True))
            parts = np.split(elliptic_coordinates(points)[:, 1 - family], walks.starts[1:-1])
            errors.append(float(np.mean([np.ptp(part) for part in parts])))
    assert orders("ellipsoid, larger curvature", errors[::2])[-1] > 1.5  # the first zone is coarse
    assert orders("ellipsoid, smaller curvature", errors[1::2])[-1] > 1.5
    assert max(errors[-2:]) < 0.003 * (AXES[0] ** 2 - AXES[2] ** 2)


def zone(n: int) -> Surface:
    """Of an ellipsoid, between two parallels."""

    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        turn, height = 2 * np.pi * u, 2.2 * v - 1.1
        return (
            AXES[0] * np.cos(turn) * np.cos(height),
            AXES[1] * np.sin(turn) * np.cos(height),
            AXES[2] * np.sin(height),
        )

    return chart(3 * n, n, point, rings="u")


def test_curves_of_a_torus_are_its_circles() -> None:
    errors = []
    for n in (20, 40, 80):
        curves = trace_curves(torus(3 * n, n + 6), spacing=0.6)
        for family, lines in enumerate(curves.by_family):
            around = [np.ptp(np.unwrap(np.arctan2(x[:, 1], x[:, 0]))) for x in lines]
            across = [np.ptp(np.unwrap(np.arctan2(x[:, 2], np.hypot(x[:, 0], x[:, 1]) - 3))) for x in lines]
            if family == 0:  # outwards is the larger curvature 0 .. -1/4, along the parallels
                errors.append(float(max(across)))
            else:
                assert max(around) < 0.1
    assert orders("torus", errors).min() > 1.5
    closed = curves.lengths[curves.is_closed & (curves.families == 1)]
    assert closed == pytest.approx(2 * np.pi, rel=1e-3)
    assert len(closed) > 10


def helicoid(n: int) -> Surface:
    return chart(n, n, lambda u, v: ((2 * v - 1) * np.cos(3 * u), (2 * v - 1) * np.sin(3 * u), 3 * u))


def test_asymptotic_curves_of_a_helicoid_are_rulings_and_helices() -> None:
    level, radial = [], []
    for n in (16, 32, 64):
        rulings, helices = trace_curves(helicoid(n), spacing=0.25, kind="asymptotic").by_family
        level.append(float(max(np.ptp(line[:, 2]) for line in rulings)))
        radial.append(float(max(np.ptp(np.hypot(line[:, 0], line[:, 1])) for line in helices)))
        assert len(rulings) > 8
        assert len(helices) > 5
    assert orders("rulings", level).min() > 1
    assert orders("helices", radial).min() > 1.5


def test_curves_of_a_cylinder_are_rulings_and_circles() -> None:
    curves = trace_curves(cylinder(), spacing=0.25)
    rulings, arcs = curves.by_family
    off = [np.ptp(np.arctan2(line[:, 1], line[:, 0])) for line in rulings] + [np.ptp(line[:, 2]) for line in arcs]
    assert max(off) < 1e-5  # triangles this way and that: the normals of the curved ones are off by as much
    assert curves.lengths[curves.families == 0] == pytest.approx(2.5, abs=1e-9)
    assert curves.lengths[curves.families == 1] == pytest.approx(np.pi, rel=2e-4)  # in 60 chords: 1.1e-4 less
    assert len(rulings) == pytest.approx(np.pi / 0.25, abs=2)
    assert len(arcs) == pytest.approx(2.5 / 0.25, abs=2)


def distances_to_others(lines: tuple[FloatArray, ...], points: FloatArray) -> FloatArray:
    """(n,) distances of points from the nearest of finely sampled lines."""
    fine = []
    for line in lines:
        arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = np.linspace(0, arc[-1], max(int(arc[-1] / 0.01), 2))
        fine.append(np.stack([np.interp(at, arc, each) for each in line.T], axis=1))
    return np.asarray(KDTree(np.concatenate(fine)).query(points)[0])


@pytest.mark.parametrize("make", [monkey_saddle, torus, lambda: ball(4, AXES), lambda: roof_like(20)])
def test_curves_are_evenly_spaced(make: object) -> None:
    surface = make()  # type: ignore[operator]
    spacing = float(np.sqrt(np.linalg.norm(surface.triangulated.vector_areas, axis=1).sum() / 300))
    curves = trace_curves(surface, spacing=spacing)
    mesh = surface.triangulated
    centres = mesh.vertices[mesh.combinatorics.corners.reshape(-1, 3)].mean(axis=1)
    for lines in curves.by_family:
        far = distances_to_others(lines, centres)
        assert np.quantile(far, 0.95) < 0.85 * spacing  # half the spacing between two curves; up to one beside ends
        assert far.max() < 1.6 * spacing
        for k, line in enumerate(lines):
            others = (*lines[:k], *lines[k + 1 :])
            assert distances_to_others(others, line).min() > 0.5 * spacing  # 0.6, up to chords and samples


def roof_like(n: int) -> Surface:
    return disc(n, lambda x, y: 0.3 * x**2 + 0.1 * y**2 + 0.1 * np.sin(3 * x) * y)


def test_conjugate_curves_are_conjugate() -> None:
    """II(u, v) = 0 for the directions of the two families at one point; the surface is z = x^2 / 2 - y^2 / 4."""
    surface = disc(40, lambda x, y: x**2 / 2 - y**2 / 4)
    curves = trace_curves(surface, spacing=0.1, affine=np.array([[1.0, 0.5, 0], [0, 1, 0], [0, 0, 2]]))
    points, tangents = [], []
    assert min(np.linalg.norm(np.diff(line, axis=0), axis=1).min() for line in curves.polylines) > 1e-9 * 0.1
    for lines in curves.by_family:
        points.append(np.concatenate([(line[1:] + line[:-1]) / 2 for line in lines]))
        steps = np.concatenate([np.diff(line, axis=0) for line in lines])
        tangents.append(steps / np.linalg.norm(steps, axis=1, keepdims=True))
    near, other = KDTree(points[1]).query(points[0])
    inside = (near < 0.02) & (np.linalg.norm(points[0][:, :2], axis=1) < 0.8)
    u, v = tangents[0][inside], tangents[1][other[inside]]
    assert inside.sum() > 100
    assert np.median(np.abs(u[:, 0] * v[:, 0] - u[:, 1] * v[:, 1] / 2)) < 0.01
    right = np.abs(np.einsum("ni,ni->n", u, v))
    assert np.median(right) > 0.1  # these are not lines of curvature


def test_curves_end_at_the_boundary_and_at_umbilics() -> None:
    curves = trace_curves(monkey_saddle(), spacing=0.08)
    ends = np.array([line[[0, -1]] for line in curves.polylines]).reshape(-1, 3)
    radius = np.hypot(ends[:, 0], ends[:, 1])
    at_rim = radius > 1 - 1e-3
    assert at_rim.mean() > 0.6  # the others end beside another curve
    nearest = [np.hypot(*line[:, :2].T).argmin() in (0, len(line) - 1) for line in curves.polylines if near(line)]
    assert nearest
    assert all(nearest)  # triangles have edges of 1/32, and curves end a triangle away


def near(line: FloatArray) -> bool:
    return bool(np.hypot(line[:, 0], line[:, 1]).min() < 0.05)


def test_points_are_on_the_smooth_surface() -> None:
    surface = ball(4, AXES)
    points = np.concatenate(trace_curves(surface, spacing=0.5).polylines)
    off = np.abs((points**2 / np.square(AXES)).sum(axis=1) - 1)
    flat = surface.triangulated.vertices[surface.triangulated.combinatorics.edges].mean(axis=1)
    assert off.max() < 0.05 * np.abs((flat**2 / np.square(AXES)).sum(axis=1) - 1).max()


@given(st.integers(0, 2**32 - 1), st.integers(-3, 3))
@settings(max_examples=4)
def test_place_and_unit_do_not_matter(seed: int, decades: int) -> None:
    rng = np.random.default_rng(seed)
    surface, size, turn = roof_like(10), 10.0**decades, rotation(seed)
    move = np.round(rng.normal(size=3) * 1e3) * size
    moved = Surface(surface.mesh.with_vertices(surface.mesh.vertices @ turn.T * size + move))
    here, there = (trace_curves(each, spacing=s) for each, s in ((surface, 0.3), (moved, 0.3 * size)))
    assert there.lengths.sum() / size == pytest.approx(here.lengths.sum(), rel=0.1)  # seeds may differ by rounding
    back = [(line - move) / size @ turn for line in there.polylines]
    for line in back:
        assert np.linalg.norm(surface.closest(line)[0] - line, axis=1).max() < 0.01


def test_several_pieces_are_covered() -> None:
    left = roof_like(12).triangulated
    both = Surface(together(left, left.translated([5, 0, 0])))
    curves = trace_curves(both, spacing=0.25)
    for lines in curves.by_family:
        sides = [line[:, 0].mean() > 2.5 for line in lines]
        assert 0.3 < np.mean(sides) < 0.7


def test_all_curves_go_a_triangle_further_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of steps grows with the number of triangles along a curve, not with that of curves."""
    counts = []
    across = curve_tracing.walk.__globals__["_across"]
    monkeypatch.setitem(
        curve_tracing.walk.__globals__, "_across", lambda *given: (counts.append(len(given[1])), across(*given))[1]
    )
    trace_curves(monkey_saddle(24), spacing=0.05)
    assert len(counts) < 1500
    assert sum(counts) > 10 * len(counts)


REFUSED = {
    "the surface is a Mesh": lambda: trace_curves(ball(1, AXES).mesh, spacing=1),  # type: ignore[arg-type]
    "the spacing of curves is 0: a number above 0": lambda: trace_curves(torus(), spacing=0),
    "the spacing of curves is 100 on a surface": lambda: trace_curves(torus(), spacing=100),
    "the spacing of curves is 1e-05 on a surface": lambda: trace_curves(torus(), spacing=1e-5),
    "the kind of curves is 'bent'": lambda: trace_curves(torus(), spacing=1, kind="bent"),  # type: ignore[arg-type]
    "the same under all affine maps": lambda: trace_curves(torus(), spacing=1, kind="asymptotic", affine=np.eye(3)),
    "an invertible matrix of 3 rows": lambda: trace_curves(torus(), spacing=1, affine=np.zeros((3, 3))),
    "plane or spherical, so that all its lines are principal": lambda: trace_curves(
        disc(8, lambda x, y: 0 * x), spacing=0.2
    ),
    "nowhere saddle-shaped": lambda: trace_curves(ball(3, AXES), spacing=0.5, kind="asymptotic"),
}


@pytest.mark.parametrize("says", REFUSED)
def test_refusals(says: str) -> None:
    with pytest.raises(GeometryError, match=says):
        REFUSED[says]()


def test_flat_parts_have_no_curves() -> None:
    curves = trace_curves(plate(), spacing=0.1)
    assert isinstance(curves, TracedCurves)
    inside = [np.hypot(line[:, 0], line[:, 1]).min() for line in curves.polylines]
    assert min(inside) > 0.35  # flat within 0.5; curvature is found from three rings of triangles


def test_a_spherical_cap_has_no_principal_curves_of_its_own() -> None:
    with pytest.raises(GeometryError, match="plane or spherical"):
        trace_curves(sphere_cap(), spacing=0.2)
    with pytest.raises(GeometryError, match="divide the triangles"):
        trace_curves(Surface(Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])), spacing=0.2)
