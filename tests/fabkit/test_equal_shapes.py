"""Equal shapes are found as if all pairs were looked at, without looking at all pairs."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit.detailing.assembling import detail
from fabkit.parts import Assembly
from fabkit.production.marks.equal_shapes import TurnedShapes, equal_shapes, may_have_equals
from fabkit.production.marks.sharing import share_equal_parts, turned_parts, turned_shapes, turns_of
from fabkit.rules import DetailingRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import Pair
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh import Mesh, shapes
from tests.fabkit.assemblies import by_name, with_parts
from tests.fabkit.plates import plates

WITHIN = 1.0


def by_all_pairs(given: FloatArray, within: float) -> tuple[IntArray, IntArray]:
    """For shapes (P, T, D), one after the other: those in no group that are near to the first one of these, in the
    turn in which they are nearest."""
    first, turns = np.arange(len(given)), np.zeros(len(given), dtype=np.int64)
    left = first.copy()
    while len(left):
        off = np.abs(given[left] - given[left[0], 0]).max(axis=-1)
        off[0] = np.where(np.arange(given.shape[1]) == 0, 0.0, np.inf)
        near = off.min(axis=1) <= within
        first[left[near]] = left[0]
        turns[left[near]] = (off <= off.min(axis=1, keepdims=True) + 0.01 * within).argmax(axis=1)[near]
        left = left[~near]
    return first, turns


def of_array(given: FloatArray) -> TurnedShapes:
    """given (P, T, C, d)."""
    return TurnedShapes(
        len(given), given.shape[1], given.shape[2], lambda parts, turns, corners: given[parts, turns][:, corners]
    )


@given(
    st.integers(1, 40), st.integers(1, 4), st.integers(1, 20), st.integers(0, 2**32 - 1), st.sampled_from([0, 1, 2, 6])
)
def test_shapes_are_equal_as_if_all_pairs_were_compared(
    n: int, n_turns: int, n_corners: int, seed: int, spread: int
) -> None:
    """Coordinates in steps of two fifths of the tolerance: two steps are near, three are not, none is on the edge; so
    there are long chains, with spread 0 all are equal, with a large one none."""
    rng = np.random.default_rng(seed)
    steps = rng.integers(0, spread + 1, (n, n_turns, 1, 2)) * (1 + 3 * (rng.random((n, 1, 1, 1)) < 0.3))
    bumps = (rng.random((n, n_turns, n_corners, 2)) < 0.05) * rng.integers(0, 3, (n, 1, 1, 1))
    given = 0.4 * WITHIN * (steps + bumps)
    first, turns, _ = equal_shapes(of_array(given), WITHIN)
    expected_first, expected_turns = by_all_pairs(given.reshape(n, n_turns, -1), WITHIN)
    assert first.tolist() == expected_first.tolist()
    if n_corners <= 8:  # of more, the turns are equally good in a few of them
        assert turns.tolist() == expected_turns.tolist()
    off = np.abs(given[np.arange(n), turns] - given[first, 0]).max(axis=(1, 2))
    assert (off[first != np.arange(n)] <= WITHIN).all()


@given(st.integers(2, 60), st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_shapes_that_differ_in_one_coordinate_form_a_chain(n: int, step: int, seed: int) -> None:
    """In any order; steps in hundredths and half a hundredth of the tolerance, so that none is on the edge."""
    order = np.random.default_rng(seed).permutation(n)
    given = np.zeros((n, 1, 3, 3))
    given[:, 0, 1, 0] = (step + 0.5) / 100 * order * WITHIN + order * 1e-6
    first, _, _ = equal_shapes(of_array(given), WITHIN)
    assert first.tolist() == by_all_pairs(given.reshape(n, 1, -1), WITHIN)[0].tolist()


@given(st.integers(1, 12), st.integers(3, 12), st.integers(0, 2**32 - 1), st.sampled_from([1e-7, 1e-3, 1.0]))
def test_a_solid_is_in_company_of_every_other_that_may_be_its_equal(n: int, k: int, seed: int, within: float) -> None:
    rng = np.random.default_rng(seed)
    ones = rng.uniform(-1e3, 1e3, (n, k, 3))
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    noise = rng.uniform(-within, within, (n, k, 3))
    others = rng.permutation(ones + noise, axis=1) @ axes + rng.uniform(-1e5, 1e5, 3)
    assert may_have_equals(
        np.concatenate([ones, others]), within + 1e-9
    ).all()  # 1e-9 mm: a move by 100 m rounds coordinates
    assert not may_have_equals(ones, 1e-9).any() or n == 1


def bent(n: int, seed: int) -> Assembly:
    """Parts of a structure over n x n faces, few of them equal; some nodes at the edge are less than half around."""
    rng = np.random.default_rng(seed)
    u, v = (1.5e3 * np.cumsum(rng.uniform(0.9, 1.1, n + 1)) for _ in range(2))
    first = np.stack([u, 0 * u, -(u**2) / 2e4], axis=1)
    mesh = shapes.translation_surface(first, np.stack([0 * v, v, -(v**2) / 3e4], axis=1))
    return detail(SupportStructure(approximate_pair(mesh), 120.0), DetailingRules(), name="bent").assembly


@pytest.mark.parametrize("group", ["beams", "nodes", "panels"])
def test_corners_are_turned_as_their_parts_are(group: str) -> None:
    """What is compared of a turned part stands, placed as the part then is, where its corners stood."""
    parts = bent(3, 1)[group]
    ring = getattr(parts.details, parts.kind.symmetry.ring_fields[0])
    sizes = np.array([len(ring[k]) for k in range(len(parts))])
    counts = np.stack([sizes, parts.solids.vertices.sizes], axis=1)
    for size, n_corners in np.unique(counts, axis=0).tolist():
        alike = parts.take((counts == [size, n_corners]).all(axis=1))
        corners = alike.solids.by_topology(alike.shape)[0].vertices
        turns = turns_of(alike, corners)
        found, rows = turned_shapes(turns, corners), np.arange(len(alike))
        assert (found.n_shapes, found.n_turns, found.n_corners) == (len(alike), size, n_corners)
        for k in range(size):
            turn = np.full(len(alike), k)
            seen = found.at(rows, turn, np.arange(n_corners))
            after = turned_parts(alike, turn, turns.starts[rows, turn], turns.along[rows, turn])
            stands = after.origins[:, None] + seen @ after.axes
            stood = alike.origins[:, None] + corners @ alike.axes
            apart = np.linalg.norm(stood[:, :, None] - stands[:, None], axis=3)
            # 1e-9: rounding of coordinates of a few metres in millimetres
            assert max(apart.min(axis=1).max(), apart.min(axis=2).max()) < 1e-9
            before, now = (getattr(each.details, parts.kind.symmetry.ring_fields[0])[0] for each in (alike, after))
            assert np.array_equal(np.roll(before, -k), now)


@given(st.integers(3, 7), st.integers(1, 12), st.integers(0, 2**32 - 1), st.floats(0, 0.9))
def test_regular_panels_with_any_edge_in_front_share_a_mark(n_corners: int, n: int, seed: int, noise: float) -> None:
    """All turns are equally good but for noise, which must not part what is equal."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(n_corners) / n_corners
    regular = 500 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    # noise of each corner turns the frame by less than it on an edge as long as the radius, so moves others by 4 of it
    within = 1e-3
    outlines = [np.roll(regular, k, axis=0) + noise * within / 12 * rng.uniform(-1, 1, regular.shape) for k in range(n)]
    assembly = with_parts(bent(2, 0), panels=plates(outlines))
    shared = share_equal_parts(assembly, within_mm=within)
    assert {panel.mark for panel in shared["panels"]} == {"P001"}
    for before, after in zip(assembly["panels"], shared["panels"], strict=True):
        stands = after.placement.to_world(after.solid.vertices)
        stood = before.placement.to_world(before.solid.vertices)
        apart = np.linalg.norm(stood[:, None] - stands, axis=2).min(axis=1)
        assert apart.max() <= within * 3**0.5


def test_two_large_round_panels_with_a_notch_are_equal_in_the_one_right_turn() -> None:
    """Of all its turns a round plate fits nearly all of its outline in each; a table of all turns would take 5 GB."""
    n = 10_000
    angles = 2 * np.pi * np.arange(n) / n
    outline = 1e5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    outline[123] *= 0.9999
    pair = plates([np.roll(outline, -4017, axis=0), np.roll(outline, -100, axis=0)])
    tracemalloc.start()
    corners = pair.solids.by_topology(pair.shape)[0].vertices
    found = equal_shapes(turned_shapes(turns_of(pair, corners), corners), 1e-5)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found[0].tolist() == [0, 0]
    assert peak < 100e6  # bytes; some twenty numbers a corner and turn, and what is held at a time


def test_marks_of_equal_squares_take_memory_in_proportion() -> None:
    """40 x 40 squares: 6561 parts, of which as many pairs are equal as there are interior ones squared."""
    mesh: Mesh = shapes.grid(40, 40) * 1000.0
    flat = SupportStructure(Pair(mesh, mesh.with_vertices(np.tile([0.0, 0.0, 1.0], (mesh.n_vertices, 1)))), 120.0)
    own = detail(flat, DetailingRules(), name="flat").assembly
    tracemalloc.start()
    shared = share_equal_parts(own)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    marks = {name: len({part.mark for part in group}) for name, group in by_name(shared).items()}
    assert marks == {"beams": 1, "nodes": 3, "panels": 1}
    # some 1.2 kB a part: its new record, its corners in all turns; pairs of equal parts would be over 1 GB
    assert peak < 6561 * 3e3
