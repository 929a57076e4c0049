"""Steps of laying quads: seamless maps, integers, exact extraction."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.layout.cells import cells_between_isolines
from geometry.layout.exact_maps import CELL_SIZE, ExactMap, cross
from geometry.layout.integer_lattices import integer_kernel, nearest_integers
from geometry.layout.quarter_turns import quarter_turned
from geometry.layout.seams import SeamlessMaps, seamless_maps
from geometry.layout.windings import wrongly_wound
from geometry.networks.combed_fields import CombedField, comb
from geometry.networks.conjugate_networks import conjugate_network
from geometry.networks.cross_fields import cross_field
from geometry.networks.tangent_frames import TangentFrames
from geometry.surface import Surface
from tests.geometry.design_surfaces import ball, chart, cylinder, disc, monkey_saddle, torus

seeds = st.integers(0, 2**32 - 1)

SURFACES = {
    "ellipsoid": lambda: ball(2, (3.0, 2.0, 1.2)),
    "torus": lambda: torus(24, 12),
    "monkey saddle": lambda: monkey_saddle(16),
    "ring": lambda: cylinder(2 * np.pi, rings="u", n=16, m=6),
    "disc": lambda: disc(6, lambda x, y: 0.3 * x**2 + 0.1 * y**2),
}


def combed(surface: Surface) -> tuple[TangentFrames, CombedField]:
    frames = TangentFrames(surface.triangulated)
    none = np.zeros(frames.combinatorics.n_edges, dtype=bool)
    return frames, conjugate_network(frames, None, none)[1]


@pytest.mark.parametrize("name", SURFACES)
def test_indices_sum_to_the_euler_characteristic(name: str) -> None:
    frames, field = combed(SURFACES[name]())
    c = frames.combinatorics
    if not c.is_boundary_vertex.any():
        assert field.indices.sum() == 4 * c.euler_characteristic
    assert field.is_cut.any() == (name != "disc")


@given(seeds)
@settings(max_examples=20)
def test_any_field_has_indices_that_sum_up(seed: int) -> None:
    frames = TangentFrames(ball(1, (3.0, 2.0, 1.2)).mesh)
    rng = np.random.default_rng(seed)
    crosses = np.exp(2j * np.pi * rng.uniform(size=frames.n_triangles))
    field = comb(frames, cross_field(frames, crosses, rng.uniform(0, 30, frames.n_triangles)))
    assert field.indices.sum() == 8
    assert_seamless(frames, field, seamless_maps(frames.combinatorics, field), rng)


@pytest.mark.parametrize("name", SURFACES)
def test_jumps_are_the_same_integers_along_edges(name: str) -> None:
    frames, field = combed(SURFACES[name]())
    assert_seamless(frames, field, seamless_maps(frames.combinatorics, field), np.random.default_rng(1))


def assert_seamless(frames: TangentFrames, field: CombedField, maps: SeamlessMaps, rng: np.random.Generator) -> None:
    """For random reals, in whole numbers of 2^-20, and random integers."""
    c = frames.combinatorics
    x, t = rng.normal(size=maps.reals.shape[1]), rng.integers(-9, 10, maps.integers.shape[1])
    exact = ExactMap.of(c, maps, field.turns, x, t)
    at = exact.values.reshape(-1, 2)
    inner = np.flatnonzero(c.twin >= 0)
    for end, other in ((inner, c.next_corner[c.twin[inner]]), (c.next_corner[inner], c.twin[inner])):
        jumps = at[other] - quarter_turned(at[end], exact.turns[inner])
        assert np.array_equal(jumps, exact.shifts[inner] * CELL_SIZE)
        assert not jumps[~field.is_cut[c.corner_edge[inner]]].any()
    assert not (at[field.indices[c.corners] != 0] % CELL_SIZE).any()
    assert (at[field.indices[c.corners] == 0] % 2 == 1).all()  # on no line


def test_maps_reach_all_that_are_seamless() -> None:
    """Numbers of free integers: two a singular point but the first, two a hole, four a handle; less two if closed."""
    for name, others in (("ellipsoid", -2), ("torus", 4), ("monkey saddle", 0), ("ring", 2), ("disc", 0)):
        frames, field = combed(SURFACES[name]())
        singular = max(np.count_nonzero(field.indices) - 1, 0)
        assert seamless_maps(frames.combinatorics, field).integers.shape[1] == 2 * singular + others, name


@given(seeds)
def test_the_kernel_has_all_integer_solutions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    equations = rng.integers(-3, 4, (rng.integers(0, 4), 5))
    basis = integer_kernel(equations)
    assert not (equations @ basis).any()
    assert basis.shape[1] == 5 - (np.linalg.matrix_rank(equations) if len(equations) else 0)
    for solution in product(range(-2, 3), repeat=5):
        if not (equations @ solution).any() and basis.shape[1]:
            t = np.linalg.lstsq(basis.astype(float), np.array(solution, dtype=float), rcond=None)[0]
            assert np.array_equal(basis @ np.rint(t).astype(int), solution)
            break


@given(seeds)
def test_nearest_integers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = 0.2 * rng.normal(size=(3, 3)) + np.eye(3)
    gram, wanted = root.T @ root, rng.uniform(-2, 2, 3)

    def energy(t: FloatArray) -> float:
        return float((t - wanted) @ gram @ (t - wanted))

    no_differences, no_gaps = np.zeros((0, 2, 3), dtype=np.int64), np.zeros((0, 3), dtype=np.int64)
    found = nearest_integers(gram, wanted, no_differences, no_gaps, no_gaps[:, 0])
    best = min((energy(np.array(t)) for t in product(range(-5, 6), repeat=3)), default=0.0)
    assert energy(found) <= 1.5 * best + 1e-9
    assert all(energy(found) <= energy(found + sign * step) + 1e-9 for step in np.eye(3) for sign in (1, -1))
    apart = np.stack([np.eye(3, dtype=np.int64)[:2]])
    assert nearest_integers(np.eye(3), np.array([0.1, -0.2, 0.4]), apart, no_gaps, no_gaps[:, 0])[:2].any()
    gaps, least = rng.permuted(np.array([[1, -1, 0], [0, 1, 1]]), axis=1), np.array([1, 3])
    assert (gaps @ nearest_integers(gram, wanted, no_differences, gaps, least) >= least).all()


def test_fans_that_surround_a_vertex_by_a_wrong_angle_are_found() -> None:
    """The map z -> z^k turns k times around 0; about a vertex of index 1, three quarters are right."""
    mesh = disc(3, lambda x, y: 0 * x).mesh
    c, at_centre = mesh.combinatorics, (mesh.combinatorics.corners == 0).reshape(-1, 3).any(axis=1)
    corners = (mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1])[c.corners.reshape(-1, 3)]
    indices = np.zeros(c.n_vertices, dtype=np.int64)

    def found(power: float, index: int) -> list[bool]:
        indices[0] = index
        turned = np.abs(corners) ** power * np.exp(1j * power * np.unwrap(np.angle(corners), axis=1))
        return wrongly_wound(c, np.stack([turned.real, turned.imag], axis=2), indices).tolist()

    assert not any(found(1, 0))
    assert not any(found(0.75, 1))
    assert found(2, 0) == at_centre.tolist()
    assert found(1, 1) == at_centre.tolist()


@given(seeds)
@settings(max_examples=25)
def test_cells_divide_the_surface_whatever_the_lines(seed: int) -> None:
    """Linear maps of a square, some with lines close to vertices and edges: areas in (u, v) add up."""
    rng = np.random.default_rng(seed)
    surface = chart(4, 4, lambda u, v: (u, v, 0 * u))
    frames, field = combed(surface)
    maps = seamless_maps(frames.combinatorics, field)
    linear = rng.integers(-6, 7, (2, 2)) / rng.integers(1, 3) if seed % 2 else rng.normal(scale=3, size=(2, 2))
    if np.linalg.det(linear) < 0:
        linear = linear[::-1]
    if np.linalg.det(linear) < 1e-3:
        return
    shift = rng.integers(0, 2, 2) / 2
    values = surface.mesh.vertices[:, :2] @ linear.T + shift
    odd = 2 * np.floor(values * CELL_SIZE / 2).astype(np.int64) + 1
    exact = ExactMap(frames.combinatorics, odd[frames.triangles], 0 * frames.triangles.ravel())
    cells = cells_between_isolines(exact)
    at = (exact.values[cells.triangles] * cells.weights[:, :, None]).sum(axis=1) / CELL_SIZE
    corners = np.split(at[cells.corners], cells.starts[1:-1])
    areas = np.array([0.5 * cross(ring, np.roll(ring, -1, axis=0)).sum() for ring in corners])
    assert maps.integers.shape[1] == 0
    assert areas.min() > -1e-6
    assert areas.max() < 1 + 1e-5
    assert abs(areas.sum() - np.linalg.det(linear)) < 1e-4


def test_a_triangle_with_too_many_lines_is_refused() -> None:
    frames, field = combed(chart(4, 4, lambda u, v: (u, v, 0 * u)))
    maps = seamless_maps(frames.combinatorics, field)
    x = np.repeat(1e4 * frames.mesh.vertices[:, :2], 1, axis=0).ravel()
    with pytest.raises(GeometryError, match="is crossed by 2500 lines, allowed 512"):
        ExactMap.of(frames.combinatorics, maps, field.turns, x, np.zeros(0, dtype=np.int64))
