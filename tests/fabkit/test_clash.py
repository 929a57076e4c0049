"""Which parts share volume: exact gaps and penetrations, other judges, prisms that are not convex."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import fabkit.checking.separation as separation
from fabkit.checking.clash import clashes
from fabkit.errors import DetailingError
from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import (
    Assembly,
    Finish,
    Frame,
    Material,
    Part,
    Solid,
    Topology,
    prism_topology,
    prism_vertices,
)
from geometry.arrays import FloatArray
from tests.fabkit.assemblies import assembled

GLASS = Material("glass", 2500.0)
EXACT_MM = 1e-9
"""Parts of 100 mm within 1000 mm of the origin: a double has 1e-13 mm left, and a few thousand operations."""
L_SHAPE = np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 40.0], [40.0, 40.0], [40.0, 100.0], [0.0, 100.0]])

seeds = st.integers(0, 2**32 - 1)
each_seed = settings(max_examples=40, deadline=None)


def assembly(solids: Sequence[Solid], placement: Frame | None = None) -> Assembly:
    panels = tuple(
        Part(
            kind=PANEL,
            mark=f"P{k}",
            solid=solid,
            placement=placement or Frame.world(),
            material=GLASS,
            element=k,
            details=PanelDetails(
                layer=0,
                pane=0,
                finish=Finish(),
                thickness_mm=0.0,
                underside_mm=0.0,
                area_mm2=0.0,
                edge_lengths_mm=(),
                corner_angles_deg=(),
                dihedrals_deg=(),
                least_seats_mm=(),
                largest_seats_mm=(),
                steps_mm=(),
                beams=(),
                neighbours=(),
            ),
        )
        for k, solid in enumerate(solids)
    )
    return assembled("solids", (), (), panels)


def found(*solids: Solid, placement: Frame | None = None) -> dict[tuple[int, int], float]:
    return {(a.element, b.element): depth for a, b, depth in clashes(assembly(solids, placement))}


def prism(outline: FloatArray, bottom: float, top: float) -> Solid:
    return Solid(prism_vertices(np.asarray(outline, dtype=float), bottom, top), prism_topology(len(outline)))


def box(lower: Sequence[float], upper: Sequence[float]) -> Solid:
    (x, y, z), (X, Y, Z) = lower, upper
    return prism(np.array([[x, y], [X, y], [X, Y], [x, Y]]), z, Z)


def moved(solid: Solid, shift: FloatArray, turn: Rotation | None = None) -> Solid:
    turn = turn or Rotation.identity()
    return Solid(solid.vertices @ turn.as_matrix().T + shift, solid.topology)


def random_prism(rng: np.random.Generator) -> Solid:
    """Convex, 20 to 200 mm in size, in any position; contains the circle of radius 10 about its axis."""
    n = int(rng.integers(3, 9))
    angles = 2 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
    radii = rng.uniform(40, 100)
    points = radii * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return prism(points[ConvexHull(points).vertices], -rng.uniform(10, 100), 0.0)


def random_motion(rng: np.random.Generator) -> Frame:
    return Frame(rng.uniform(-1000, 1000, 3), Rotation.random(rng=rng).as_matrix())


def margin(first: Solid, second: Solid) -> float:
    """Radius of the largest ball in both of two convex solids; negative where they are apart."""
    normals, levels = [], []
    for solid in (first, second):
        t = solid.topology
        anchors = solid.vertices[t.corners[t.loop_starts[t.face_starts[:-1]]]]
        facing = solid.normals
        normals.append(facing)
        levels.append(np.einsum("fk,fk->f", facing, anchors))
    A = np.concatenate(normals)
    answer = linprog(
        [0, 0, 0, -1], np.column_stack([A, np.ones(len(A))]), np.concatenate(levels), bounds=[(None, None)] * 4
    )
    assert answer.status == 0
    return float(answer.x[3])


@each_seed
@given(seeds, st.floats(1e-9, 100.0))
def test_gap_along_any_direction(seed: int, gap: float) -> None:
    rng = np.random.default_rng(seed)
    first, second = random_prism(rng), random_prism(rng)
    second = moved(second, np.zeros(3), Rotation.random(rng=rng))
    n = Rotation.random(rng=rng).as_matrix()[0]
    shift = ((first.vertices @ n).max() - (second.vertices @ n).min() + gap) * n
    assert found(first, moved(second, shift), placement=random_motion(rng)) == {}


@each_seed
@given(seeds, st.floats(1e-5, 5.0), st.booleans())
def test_depth_of_a_prism_sunk_into_a_face(seed: int, depth: float, swapped: bool) -> None:
    rng = np.random.default_rng(seed)
    first, second = random_prism(rng), random_prism(rng)
    sunk = Solid(second.vertices * [1, -1, -1], second.topology)  # upside down: its flat face looks down
    angle, side = rng.uniform(0, 2 * np.pi), rng.uniform(-2, 2, 2)
    sunk = moved(sunk, np.array([*side, -depth]), Rotation.from_rotvec([0, 0, angle]))
    pair = (sunk, first) if swapped else (first, sunk)
    # circles of radius 20 and more lie within 3 mm of each other: no shorter way out than 5 mm but back up
    assert found(*pair, placement=random_motion(rng)) == {(0, 1): pytest.approx(depth, abs=EXACT_MM)}


@each_seed
@given(seeds, st.floats(-200, 200), st.floats(-200, 200), st.floats(-100, 100))
def test_agrees_with_linear_programming_and_does_not_depend_on_place(seed: int, x: float, y: float, z: float) -> None:
    rng = np.random.default_rng(seed)
    first, second = random_prism(rng), random_prism(rng)
    second = moved(second, np.array([x, y, z]), Rotation.random(rng=rng))
    inner = margin(first, second)
    assume(abs(inner) > 1e-5)  # linprog itself is good to 1e-7
    depths = found(first, second)
    assert bool(depths) == (inner > 0)
    assert depths.get((0, 1), np.inf) >= inner  # a ball in both must be left by its diameter, at least its radius
    again = found(first, second, placement=random_motion(rng))
    assert again == {pair: pytest.approx(depth, abs=EXACT_MM) for pair, depth in depths.items()}


@each_seed
@given(seeds, st.sampled_from([0, 1, 2]), st.sampled_from([-1.0, 1.0]))
def test_boxes_that_touch(seed: int, axis: int, sign: float) -> None:
    rng = np.random.default_rng(seed)
    size = rng.uniform(10, 2000, 3)
    first = box(-size / 2, size / 2)
    step = sign * size[axis] * np.eye(3)[axis]
    frame = random_motion(rng)
    assert found(first, moved(first, step), placement=frame) == {}
    tiny = found(first, moved(first, step * (1 - 1e-3 / size[axis])), placement=frame)
    assert tiny == {(0, 1): pytest.approx(1e-3, abs=EXACT_MM)}


def test_boxes_that_share_an_edge_or_a_corner() -> None:
    first = box([0, 0, 0], [10, 10, 10])
    for step in ([10, 10, 0], [10, 0, -10], [10, 10, 10]):
        assert found(first, moved(first, np.array(step))) == {}


def test_contained_and_equal() -> None:
    outer = box([0, 0, 0], [100, 100, 100])
    assert found(outer, box([30, 30, 20], [40, 40, 30])) == {(0, 1): pytest.approx(30.0)}
    assert found(outer, outer) == {(0, 1): pytest.approx(100.0)}


@pytest.mark.parametrize("gap", [1e-3, 1.0, -1e-3, -1.0])
def test_only_the_product_of_two_edges_separates(gap: float) -> None:
    bar = box([-100, -10, -10], [100, 10, 10])
    below = moved(bar, np.zeros(3), Rotation.from_euler("x", 45, degrees=True))
    above = moved(bar, np.zeros(3), Rotation.from_euler("xz", [45, 70], degrees=True))
    above = moved(above, np.array([0, 0, 2 * np.sqrt(200) + gap]))
    assert found(below, above) == ({} if gap > 0 else {(0, 1): pytest.approx(-gap, abs=EXACT_MM)})


@settings(max_examples=5, deadline=None)
@given(seeds)
def test_every_pair_of_many_boxes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lower = rng.uniform(0, 1000, (300, 3)) * rng.permutation([0.1, 1.0, 1.0])
    upper = lower + rng.uniform(20, 150, (300, 3))
    i, j = np.triu_indices(300, 1)
    depth = np.minimum(upper[i] - lower[j], upper[j] - lower[i]).min(axis=1)
    deep = depth > 1e-6
    assert deep.sum() > 100
    expected = {(a, b): d for a, b, d in zip(i[deep].tolist(), j[deep].tolist(), depth[deep].tolist(), strict=True)}
    got = found(*(box(a, b) for a, b in zip(lower, upper, strict=True)))
    assert list(got) == sorted(expected)
    assert got == pytest.approx(expected, abs=EXACT_MM)


def test_pieces_are_compared_a_few_at_a_time_with_the_same_result(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    solids = [moved(random_prism(rng), rng.uniform(-150, 150, 3), Rotation.random(rng=rng)) for _ in range(40)]
    at_once = found(*solids)
    assert len(at_once) > 100
    monkeypatch.setattr(separation, "MAX_PROJECTIONS_IN_MEMORY", 500)
    assert found(*solids) == at_once


@pytest.mark.parametrize("placement", [None, random_motion(np.random.default_rng(1))])
def test_notch_of_an_l_shape(placement: Frame | None) -> None:
    shape = prism(L_SHAPE, 0.0, 50.0)
    assert found(shape, box([50, 50, 10], [90, 90, 40]), placement=placement) == {}
    assert found(shape, box([40, 40, 0], [100, 100, 50]), placement=placement) == {}
    pushed = found(shape, box([39, 50, 10], [90, 90, 40]), placement=placement)
    assert pushed == {(0, 1): pytest.approx(1.0, abs=EXACT_MM)}


@each_seed
@given(seeds, st.floats(-40, 140), st.floats(-40, 140), st.floats(-30, 80))
def test_l_shape_agrees_with_linear_programming(seed: int, x: float, y: float, z: float) -> None:
    rng = np.random.default_rng(seed)
    size = rng.uniform(5, 40, 3)
    other = moved(box(-size / 2, size / 2), np.array([x, y, z]), Rotation.random(rng=rng))
    halves = (box([0, 0, 0], [100, 40, 50]), box([0, 0, 0], [40, 100, 50]))
    inner = max(margin(half, other) for half in halves)
    assume(abs(inner) > 1e-5)  # linprog itself is good to 1e-7
    roll = int(rng.integers(6))
    assert bool(found(prism(np.roll(L_SHAPE, roll, axis=0), 0.0, 50.0), other)) == (inner > 0)


def test_stars_side_by_side() -> None:
    """A point of each reaches into a notch of the other, as far as it can."""
    angles = np.pi / 4 * np.arange(8)
    radii = np.where(np.arange(8) % 2, 20.0, 60.0)
    star = prism(radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1), 0.0, 10.0)
    step = star.vertices[0] - star.vertices[3]  # a notch of the second star onto a tip of the first
    assert found(star, moved(star, step)) == {}
    assert list(found(star, moved(star, step * (1 - 1e-3)))) == [(0, 1)]


def test_depth_is_that_of_the_deepest_piece() -> None:
    teeth = [[0, 0], [80, 0], [80, 96], [60, 96], [60, 10], [20, 10], [20, 100], [0, 100]]
    above = box([-50, 95, -50], [150, 300, 150])
    assert found(prism(np.array(teeth), 0.0, 50.0), above) == {(0, 1): pytest.approx(5.0, abs=EXACT_MM)}


@pytest.mark.parametrize("side", range(6))
def test_what_is_parallel_in_one_solid_slants_in_another(side: int) -> None:
    """Both have the same topology; a corner of the regular one points at a side of the other, which alone separates."""
    angles = np.pi / 3 * np.arange(6)
    regular = 10 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    angles += np.array([0.0, 0.2, -0.1, 0.25, 0.05, -0.2])
    slanted = 100 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    middle = (slanted[side] + slanted[(side + 1) % 6]) / 2
    n = middle / np.linalg.norm(middle)
    beside = prism(regular + middle - n * (regular @ n).min(), 0.0, 50.0)
    assert found(prism(slanted, 0.0, 50.0), beside) == {}
    sunk = moved(beside, np.array([*(-1e-3 * n), 0.0]))
    assert found(prism(slanted, 0.0, 50.0), sunk) == {(0, 1): pytest.approx(1e-3, abs=EXACT_MM)}


def test_pairs_come_in_the_order_of_the_parts() -> None:
    triangle = prism(np.array([[0, 0], [10, 0], [0, 10]]), 0.0, 10.0)
    assert list(found(triangle, box([0, 0, 0], [10, 10, 10]), triangle)) == [(0, 1), (0, 2), (1, 2)]


def test_oblique_prism_is_split_too() -> None:
    upright = prism(L_SHAPE, 0.0, 50.0)
    lean = upright.vertices @ np.array([[1, 0, 0], [0, 1, 0], [0.5, 0.2, 1]])
    oblique = Solid(lean, upright.topology)
    assert found(oblique, box([95, 60, 20], [110, 90, 30])) == {}
    assert list(found(oblique, box([20, 60, 20], [30, 90, 30]))) == [(0, 1)]


def test_what_cannot_be_split_is_refused() -> None:
    upright = prism(L_SHAPE, 0.0, 50.0)
    tapered = upright.vertices * np.where(upright.vertices[:, 2:] > 0, [0.9, 0.9, 1.0], 1.0)
    for solid in (
        Solid(tapered, upright.topology),
        prism(np.array([[0, 0], [30, 0], [5, 20], [30, 30]]), 0, 10),
        box_with_hole(),
    ):
        with pytest.raises(DetailingError, match=r"panel P1 \(face 1, counted from 0\) is neither convex nor a prism"):
            clashes(assembly([box([0, 0, 0], [1, 1, 1]), solid]))


def box_with_hole() -> Solid:
    """Its vertices come in an order in which it would pass for a prism over one polygon."""
    outline = [[0, 0], [30, 0], [30, 30], [0, 30], [10, 20], [20, 20], [20, 10], [10, 10]]
    vertices = prism(np.array(outline), 0, 10).vertices
    rings = [pairwise([0, 1, 2, 3, 0]), pairwise([4, 5, 6, 7, 4])]
    sides = [[a, b, b + 8, a + 8] for ring in rings for a, b in ring]
    loops = [[3, 2, 1, 0], [7, 6, 5, 4], [8, 9, 10, 11], [12, 13, 14, 15], *sides]
    starts = 4 * np.arange(len(loops) + 1)
    return Solid(vertices, Topology(16, np.concatenate(loops), starts, np.array([0, 2, *range(4, 13)])))


def test_nothing_clashes_with_nothing() -> None:
    assert clashes(assembly([])) == []
    assert found(box([0, 0, 0], [1, 1, 1])) == {}


def test_allowed_depth_is_an_argument() -> None:
    both = assembly([box([0, 0, 0], [10, 10, 10]), box([9, 0, 0], [20, 10, 10])])
    assert len(clashes(both, depth_mm=0.5)) == 1
    assert clashes(both, depth_mm=1.5) == []


def test_solids_are_where_their_placements_put_them() -> None:
    solid = box([0, 0, 0], [10, 10, 10])
    centre = Frame(solid.centroid, Rotation.from_euler("x", 90, degrees=True).as_matrix())
    assert found(solid, solid, placement=centre) == {(0, 1): pytest.approx(10.0)}
