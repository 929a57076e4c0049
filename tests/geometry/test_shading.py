"""Shade by fins: closed forms, rays, shapely, and the translation with most shade against a grid of them."""

from __future__ import annotations

import sys
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError
from geometry.gauss import Pair, approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.shading import Fins, Suns, cast_shadows, most_shade, suns_at
from geometry.shading.covered_areas import covered_areas

from .bent_meshes import rotation, vault
from .shadow_rays import shaded_shares

HOW_TO = Path(__file__).parents[2] / "docs" / "howto" / "shading.md"


def upright(mesh: Mesh, lower: float, upper: float) -> Fins:
    """Fins perpendicular to a mesh in the plane z = 0."""
    return Fins(Pair(mesh, mesh.with_vertices(0 * mesh.vertices + [0, 0, 1])), lower, upper)


def l_shaped() -> Mesh:
    corners = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
    return Mesh.from_faces([[x, y, 0] for x, y in corners], [range(6)])


def some_suns(n: int) -> Suns:
    """A day of n hours, high and low ones."""
    hours = np.linspace(-1.25, 1.3, n)
    height = np.radians(12 + 45 * np.cos(hours) ** 2)
    level = np.stack([np.sin(hours), -np.cos(hours)]) * np.cos(height)
    return Suns(np.stack([*level, np.sin(height)], axis=1), weights=1 + 0.5 * np.cos(hours))


# --- closed forms


@pytest.mark.parametrize(
    ("sun", "lower", "upper", "area"),
    [
        ([1, 0, 1], 0.0, 0.3, 0.3),  # one fin, its shadow as long as it is high; fins along the light cast none
        ([1, 0, 1], 0.2, 0.5, 0.3),  # it begins away from the edge
        ([1, 0, 1], 0.8, 1.4, 0.2),  # and leaves the panel
        ([1, 0, 1], 1.1, 1.4, 0.0),
        ([1, 0, 2], 0.0, 0.3, 0.15),
        ([1, 0, 1], -0.4, 0.3, 0.3),  # what is behind the panel casts no shadow on it
        ([1, 1, 1], 0.0, 0.3, 1 - 0.7**2),  # two fins, whose shadows overlap
        ([1, 0.5, 1], 0.0, 0.4, 1 - 0.6 * 0.8),
        ([0, 0, 1], 0.0, 0.3, 0.0),
        ([1, 0, 1], 0.0, 5.0, 1.0),
    ],
)
def test_shadow_on_a_square(sun: list[float], lower: float, upper: float, area: float) -> None:
    shading = cast_shadows(upright(shapes.grid(1, 1), lower, upper), Suns([sun]))
    assert shading.shadow_areas == pytest.approx(area, abs=1e-12)


def test_shadows_reach_the_panels_behind_and_count_once() -> None:
    shading = cast_shadows(upright(shapes.grid(4, 1), 0.6, 1.2), Suns([[1, 0, 1]]))
    # the fin at x = 4 shades 2.8 to 3.4; each panel but the last one gets two parts, of two fins
    assert shading.shadow_areas[0] == pytest.approx([0.6, 0.6, 0.6, 0.4], abs=1e-12)
    assert cast_shadows(upright(shapes.grid(4, 1), 0, 3), Suns([[1, 0, 1]])).shares == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize(("height", "area"), [(0.5, 1.0), (1.5, 2.5), (2.0, 3.0)])
def test_panels_need_not_be_convex(height: float, area: float) -> None:
    assert cast_shadows(upright(l_shaped(), 0, height), Suns([[1, 0, 1]])).total == pytest.approx(area, abs=1e-12)


def test_totals_are_means_by_weight() -> None:
    shading = cast_shadows(upright(shapes.grid(1, 1), 0, 0.2), Suns([[1, 0, 1], [1, 0, 2]], weights=[1, 3]))
    assert shading.total == pytest.approx(0.25 * 0.2 + 0.75 * 0.1)
    assert shading.share == pytest.approx(shading.total)
    assert shading.shadow_per_fin_area == pytest.approx(shading.total / 0.8)
    light = np.array([1 * np.sqrt(1 / 2), 3 * np.sqrt(4 / 5)])
    assert shading.blocked_light == pytest.approx(light @ [0.2, 0.1] / light.sum())


def test_panels_that_face_away_are_not_counted() -> None:
    dome = shapes.dome(12, 3)
    shading = cast_shadows(Fins(Pair(dome, dome), 0, 0.2), Suns([[1, 0, 0.1]]))
    away = dome.face_normals @ shading.suns.directions[0] < 0
    assert 0 < away.sum() < dome.n_faces
    assert (np.isnan(shading.shares[0]) == away).all()
    assert (shading.shadow_areas[0, away] == 0).all()
    assert shading.share == pytest.approx(shading.total / shading.panel_areas[~away].sum())


def test_opaque_panels_leave_less_to_fins() -> None:
    """A wall .5 high and a floor behind it, fins that lean over the floor; a sun behind the wall."""
    corners = [[0, 0, 0.5], [0, 1, 0.5], [0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]]
    mesh = Mesh.from_faces(corners, [[0, 2, 3, 1], [2, 4, 5, 3]])
    fins = Fins(Pair(mesh, mesh.with_vertices(0 * mesh.vertices + [1, 0, 1])), 0.0, 0.14)
    sun = Suns([[-1, 0, 1]])
    glass, opaque = cast_shadows(fins, sun), cast_shadows(fins, sun, opaque=True)
    assert glass.shadow_areas[0] == pytest.approx([0, 0.56], abs=1e-12)  # 0 to .28 and .5 to .78
    assert opaque.panel_shadows[0] == pytest.approx([0, 0.5], abs=1e-12)
    assert opaque.shadow_areas[0] == pytest.approx([0, 0.28], abs=1e-12)
    assert opaque.shares[0, 1] == pytest.approx(0.28 / 0.5)
    assert np.isnan(opaque.shares[0, 0])
    assert opaque.share == opaque.blocked_light == pytest.approx(0.56)
    assert opaque.table[:, :3].tolist() == pytest.approx(np.array([[0, 1, 0.5]]))
    assert (glass.panel_shadows == 0).all()


def test_a_panel_that_no_sun_reaches_has_no_share() -> None:
    corners = [[0, 0, 2], [0, 1, 2], [0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [4, 0, 0], [4, 1, 0]]
    mesh = Mesh.from_faces(corners, [[0, 2, 3, 1], [2, 4, 5, 3], [4, 6, 7, 5]])
    fins = Fins(Pair(mesh, mesh.with_vertices(0 * mesh.vertices + [1, 0, 1])), 0.0, 0.1)
    shading = cast_shadows(fins, Suns([[-1, 0, 1]]), opaque=True)
    assert np.isnan(shading.shares[0, :2]).all()
    assert shading.shares[0, 2] == pytest.approx(0.2 / 2)
    assert most_shade(fins, Suns([[-1, 0, 1]]), opaque=True).after.share > 0.2 / 2


# --- against other programs


@pytest.mark.parametrize("lower", [-0.1, 0.0, 0.15])
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.3, -0.5, 0.4)])
@pytest.mark.parametrize("mesh", [vault(), shapes.hexagonal_paraboloid(3, 3)], ids=["quads", "hexagons"])
def test_shadows_are_those_of_rays(mesh: Mesh, shift: tuple[float, float, float], lower: float) -> None:
    fins = Fins(approximate_pair(mesh).tilted(shift), lower, 0.5)
    shading = cast_shadows(fins, some_suns(4))
    rays = shaded_shares(mesh, fins.quads, shading.suns.directions, 500)
    counted = ~np.isnan(rays)
    assert (counted == shading.facing).all()
    assert np.abs(shading.shares - rays)[counted].max() < 0.01
    by_rays = np.nansum(rays * shading.panel_areas, axis=1)
    assert shading.shadow_areas.sum(axis=1) == pytest.approx(by_rays, rel=2e-3)


def waves(nx: int, ny: int) -> Mesh:
    """A roof in waves, whose crests shade the troughs behind them."""
    u, v = np.linspace(0, 4 * np.pi, nx + 1), np.linspace(0, 3, ny + 1)
    first = np.stack([u, 0 * u, 1.2 * np.sin(u)], axis=1)
    return shapes.translation_surface(first, np.stack([0.3 * v, 2 * v, -0.1 * v**2], axis=1))


@pytest.mark.parametrize("lower", [-0.1, 0.0, 0.1])
def test_shadows_of_opaque_panels_are_those_of_rays(lower: float) -> None:
    mesh = waves(12, 2)
    fins = Fins(approximate_pair(mesh).tilted([0.1, -0.1, 0.2]), lower, 0.3)
    suns = Suns([[-1, 0.2, 0.5], [1, -0.3, 0.7]])
    shading = cast_shadows(fins, suns, opaque=True)
    panels = mesh.vertices[mesh.combinatorics.corners.reshape(-1, 4)]
    shaded = shaded_shares(mesh, panels, suns.directions, 500)
    both = shaded_shares(mesh, np.concatenate([panels, fins.quads]), suns.directions, 500)
    for areas, rays in ((shading.panel_shadows, shaded), (shading.shadow_areas, both - shaded)):
        assert np.nanmax(np.abs(areas / shading.panel_areas - rays)) < 0.01
        by_rays = np.nansum(rays * shading.panel_areas, axis=1)
        assert areas.sum() == pytest.approx(by_rays.sum(), rel=1e-2)  # 24 panels, each to .01 of its area
    assert shading.panel_shadows.sum() > 0.1 * (shading.facing * shading.panel_areas).sum()


@given(st.integers(0, 2**32 - 1))
def test_covered_areas_are_those_of_shapely(seed: int) -> None:
    # whole coordinates: many edges agree, in part or wholly, and many corners lie on edges
    rng = np.random.default_rng(seed)
    size = int(rng.integers(3, 12))
    covers = np.array([[box_or_triangle(rng, size) for _ in range(rng.integers(1, 8))] for _ in range(3)], dtype=object)
    flat = np.array([cover for own in covers for cover in own], dtype=np.float64)
    covered = np.repeat(np.arange(3), [len(own) for own in covers])
    polygons = np.array([[[0, 0], [size, 0], [size, size], [size / 2, 1], [0, size]]] * 3, dtype=np.float64)
    order = rng.permutation(len(flat))
    turn = rotation(seed % 1000)[:2, :2]  # any affine map
    found = covered_areas(polygons @ turn, flat[order] @ turn, covered[order]) / abs(np.linalg.det(turn))
    united = [shapely.union_all(shapely.polygons(flat[covered == k])) for k in range(3)]
    expected = shapely.area(shapely.intersection(united, shapely.polygons(polygons)))
    assert found == pytest.approx(expected, abs=1e-9)


def box_or_triangle(rng: np.random.Generator, size: int) -> FloatArray:
    """(4, 2) with whole coordinates; a triangle has a corner twice."""
    x, y = rng.integers(-1, size, 2)
    w, h = rng.integers(1, size, 2)
    corners = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]], dtype=np.float64)
    if rng.integers(2):
        corners[3] = corners[2]
    return corners[::-1] if rng.integers(2) else corners


def test_whole_steps_of_many_suns_are_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh, suns = vault(), some_suns(7)
    fins = Fins(approximate_pair(mesh), 0, 0.4)
    together = cast_shadows(fins, suns).shadow_areas
    monkeypatch.setattr("geometry.shading.panel_shadows.MAX_PANELS_AND_FINS", 1)
    monkeypatch.setattr("geometry.shading.covered_areas.MAX_EDGE_PAIRS", 1)
    assert cast_shadows(fins, suns).shadow_areas == pytest.approx(together, abs=1e-12)
    assert [cast_shadows(fins, Suns([d])).shadow_areas.sum() for d in suns.directions] == pytest.approx(
        together.sum(axis=1)
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_rigid_motions_of_everything_change_nothing(seed: int) -> None:
    mesh, suns, turn = vault(), some_suns(5), rotation(seed).T
    fins = Fins(approximate_pair(mesh).tilted([0.2, 0.1, -0.3]), 0.0, 0.4)
    moved = Fins(
        Pair(
            mesh.with_vertices(mesh.vertices @ turn + [100, -300, 20]),
            mesh.with_vertices(fins.pair.gauss_image.vertices @ turn),
        ),
        0.0,
        0.4,
    )
    turned = Suns(suns.directions @ turn, suns.weights, np.array([0, 0, 1]) @ turn)
    one, other = cast_shadows(fins, suns), cast_shadows(moved, turned)
    assert other.shadow_areas == pytest.approx(one.shadow_areas, abs=1e-9)
    larger = cast_shadows(Fins(Pair(mesh * 50, fins.pair.gauss_image), 0.0, 20.0), suns)
    assert larger.shares == pytest.approx(one.shares, abs=1e-9, nan_ok=True)


# --- most shade


def test_no_translation_of_a_grid_gives_more_shade(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("geometry.shading.translations.SAMPLED_PANELS", 1)  # that one says little of all
    mesh = vault(4, 3)
    fins, suns = Fins(approximate_pair(mesh), 0.05, 0.35), some_suns(3)
    found = most_shade(fins, suns)
    places = np.linspace(-0.99, 0.99, 7)
    grid = np.stack(np.meshgrid(places, places, places), axis=3).reshape(-1, 3)
    length = np.linalg.norm(grid, axis=1)
    grid = np.concatenate([grid[length <= 0.99], 0.99 * grid[length > 0] / length[length > 0, None]])
    shares = [cast_shadows(moved, suns).share for x in grid if (moved := risen(fins, x))]
    assert len(shares) > 200
    assert found.after.share > max(shares) - 1e-4
    steps = 0.005 * np.random.default_rng(1).normal(size=(40, 3))
    near = [x * min(1, 0.99 / np.linalg.norm(x)) for x in found.shift + steps]
    assert found.after.share > max(cast_shadows(fins.tilted(x), suns).share for x in near) - 1e-4
    assert found.after.share > found.before.share + 0.1
    assert np.linalg.norm(found.shift) <= 0.99
    assert found.after.fins.pair.gauss_image.vertices == pytest.approx(fins.pair.gauss_image.vertices + found.shift)
    assert found.after.share == pytest.approx(cast_shadows(fins.tilted(found.shift), suns).share)


def risen(fins: Fins, x: FloatArray) -> Fins | None:
    normals = fins.mesh.face_normals[fins.mesh.combinatorics.corner_face]
    return fins.tilted(x) if (fins.rises + normals @ x).min() > 0 else None


def test_where_all_is_in_the_shade_the_shortest_translation_is_taken() -> None:
    square, sun = shapes.grid(1, 1), Suns([[1, 0, 1]])
    # the shadow is .8 (1 + z - x) long: 1 from z - x = 1/4 on
    found = most_shade(upright(square, 0, 0.8), sun)
    assert found.after.share == pytest.approx(1, abs=1e-3)
    assert found.shift == pytest.approx([-1 / 8, 0, 1 / 8], abs=4e-3)
    assert (most_shade(upright(square, 0, 1.2), sun).shift == 0).all()


def test_fins_stay_above_all_panels() -> None:
    base = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    steep = Mesh.from_faces([*base, [0, 0, 3]], [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    fins = Fins(Pair(steep, steep.with_vertices(steep.vertices * 0.1 + [0, 0, 0.3])), 0, 0.3)
    found = most_shade(fins, Suns([[0.1, 0.05, 1]]))  # with |x| <= .99 alone fins would lie down for the high sun
    assert 0 < found.after.fins.rises.min() < 0.02
    assert found.after.share > found.before.share


# --- suns


def test_sun_positions_are_those_of_their_paper() -> None:
    pytest.importorskip("sunposition")
    time = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
    place = np.radians(39.742476), np.radians(-105.1786)
    suns = suns_at(*place, [time, time.astimezone(UTC)], weights=[1, 2])
    # [Reda2004, A.5]: height 39.872046 without the air, azimuth 194.340241, seen from 1830 m
    height, azimuth = np.radians(39.872046), np.radians(194.340241)
    expected = [np.cos(height) * np.sin(azimuth), np.cos(height) * np.cos(azimuth), np.sin(height)]
    assert suns.directions == pytest.approx(np.array([expected, expected]), abs=5e-6)
    assert suns.weights.tolist() == [1, 2]
    lifted = suns_at(*place, [time], refraction=True)
    assert np.arcsin(lifted.directions[0, 2]) - height == pytest.approx(np.radians(0.02), abs=1e-4)
    turned = suns_at(*place, [time], north=[1, 0, 0])
    assert turned.directions[0] == pytest.approx([expected[1], -expected[0], expected[2]], abs=5e-6)


def test_without_the_package_for_suns_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sunposition", None)
    with pytest.raises(GeometryError, match=r"pip install 'fabkit\[sun\]'"):
        suns_at(0.8, 0.3, [datetime(2026, 6, 21, 12, tzinfo=UTC)])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((48.2, 16.4, [datetime(2026, 6, 21, 12, tzinfo=UTC)]), r"latitude is 48\.2.*radians"),
        ((0.8, -3.2, [datetime(2026, 6, 21, 12, tzinfo=UTC)]), r"longitude is -3\.2.*radians"),
        ((0.8, 0.3, [datetime(2026, 6, 21, 12)]), "time 0, 2026-06-21T12:00:00, has no time zone"),
        ((0.8, 0.3, []), "no times"),
        ((0.8, 0.3, [datetime(2026, 6, 21, h, tzinfo=UTC) for h in (12, 0)]), r"sun 1 is 19\.\d degrees below"),
    ],
)
def test_places_and_times_that_cannot_be(arguments: tuple[float, float, list[datetime]], said: str) -> None:
    pytest.importorskip("sunposition")
    with pytest.raises(GeometryError, match=said):
        suns_at(*arguments)


def test_north_must_be_level() -> None:
    pytest.importorskip("sunposition")
    with pytest.raises(GeometryError, match=r"north is 84\.28\d* degrees off the vertical"):
        suns_at(0.8, 0.3, [datetime(2026, 6, 21, 12, tzinfo=UTC)], north=[0, 1, 0.1])


@pytest.mark.parametrize(
    ("directions", "weights", "said"),
    [
        ([[0, 0, 1], [1, 0, -1], [0, 1, 0]], 1.0, r"sun 1 is 45\.0 degrees below the horizon.*1 more"),
        ([[0, 0, 1], [0, 0, 0]], 1.0, "direction of sun 1 is .* not zero"),
        ([[0, 0, np.nan]], 1.0, "direction of sun 0 is .* finite"),
        ([0, 0, 1], 1.0, r"shape \(3,\)"),
        (np.zeros((0, 3)), 1.0, "at least 1"),
        ([[0, 0, 1]], [1, 2], r"1 suns need as many weights.*\(2,\)"),
        ([[0, 0, 1], [1, 0, 1]], [1, 0], "sun 1 has the weight 0"),
        ([[0, 0, 1]], [np.inf], "sun 0 has the weight inf"),
    ],
)
def test_suns_that_cannot_be(directions: object, weights: object, said: str) -> None:
    with pytest.raises(GeometryError, match=said):
        Suns(directions, weights)


# --- what is refused


@pytest.mark.parametrize(("lower", "upper"), [(0.3, 0.3), (0.4, 0.3), (-0.3, 0.0), (0.0, np.nan), (-np.inf, 1.0)])
def test_distances_that_cast_no_shadow(lower: float, upper: float) -> None:
    with pytest.raises(GeometryError, match=f"from distance {lower:g} to {upper:g} cast no shadow"):
        upright(shapes.grid(1, 1), lower, upper)


@pytest.mark.parametrize("bound", [1.0, 0.0, -0.5, np.nan])
def test_a_bound_that_lets_fins_fall_over(bound: float) -> None:
    with pytest.raises(GeometryError, match="above 0 and below 1"):
        most_shade(upright(shapes.grid(1, 1), 0, 0.3), Suns([[1, 0, 1]]), bound=bound)


def test_no_sun_above_any_panel() -> None:
    fins = upright(shapes.grid(1, 1), 0, 0.3)
    below = Suns([[1, 0, -1], [0, 1, -1]], up=[0, 0, -1])
    for ask in (cast_shadows, most_shade):
        with pytest.raises(GeometryError, match=r"no panel faces any of the 2 suns: .* -7\.1e-01"):
            ask(fins, below)


def test_meshes_without_possible_fins() -> None:
    grid, dome = shapes.grid(2, 1), shapes.dome(8, 2)
    with pytest.raises(MeshError, match=r"at vertex \d+ the Gauss image rises -1\.00e\+00 above the plane of face 0"):
        upright(grid.reversed(), 0, 0.3)
    with pytest.raises(MeshError, match=r"rises -3.*translated less"):
        Fins(Pair(dome, dome), 0, 0.1).tilted([0, 0, -1.5])
    bent = grid.with_vertices(grid.vertices + 0.01 * np.eye(6, 3)[:, [1, 2, 0]])
    with pytest.raises(MeshError, match="face 0 is off its plane"):
        Fins(Pair(bent, bent * 0.3 + upright(grid, 0, 1).pair.gauss_image), 0, 0.1)
    inside_out = dome.with_vertices(-dome.vertices).reversed()
    with pytest.raises(MeshError, match=r"crosses itself: at distance 1\.2 its edge is -0\.2 .* within 1 of 0"):
        Fins(Pair(dome.reversed(), inside_out.with_vertices(-dome.vertices)), 0, 1.2)
