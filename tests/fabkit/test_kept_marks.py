"""Which pieces keep their marks when a design changes a little, and which cannot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.parts import Assembly, Parts
from fabkit.production.marks import KeptMarks, mark_points, share_equal_parts
from tests.fabkit.plates import plates

SQUARE = np.array([[0.0, 0.0], [900.0, 0.0], [880.0, 700.0], [10.0, 690.0]])


def panes(longer: list[float], order: list[int] | None = None) -> Parts[Any]:
    """Plates, longer than a square by these mm, two metres apart; in another order on mesh elements that follow it."""
    made = plates([SQUARE + np.outer([0.0, 0.0, each, 0.0], [1.0, 0.0]) for each in longer])
    made = replace(made, origins=np.outer(np.arange(len(longer)), [0.0, 2000.0, 0.0]))
    return made if order is None else replace(made.take(np.array(order)), elements=np.arange(len(order)))


def shared_panes(parts: Parts[Any], kept: KeptMarks | None = None) -> Parts[Any]:
    known = None if kept is None else {"panels": kept}
    return share_equal_parts(Assembly("plates", (parts,)), within_mm=0.5, kept=known)["panels"]


def test_a_piece_that_crosses_the_tolerance_by_little_keeps_its_mark() -> None:
    """The second plate is all but 0.5 mm longer than the first, then a little more; a third one has always been."""
    first = shared_panes(panes([0.0, 0.499, 0.51]))
    assert first.marks == ["P001", "P001", "P002"]
    kept = mark_points(first)
    assert shared_panes(panes([0.0, 0.503, 0.51]), kept).marks == ["P001", "P001", "P002"]
    assert shared_panes(panes([0.0, 0.503, 0.51]), KeptMarks(kept.points)).marks == ["P001", "P002", "P002"]
    assert shared_panes(panes([0.0, 0.99, 0.51]), kept).marks == ["P001", "P001", "P002"]  # it changes by 0.491
    assert shared_panes(panes([0.0, 1.003, 0.51]), kept).marks == ["P001", "P002", "P002"]  # by more than the tolerance
    not_off_before, more_than_twice_apart = [0.503, 0.499, 0.51], [-0.45, 0.6, 0.51]
    assert shared_panes(panes(not_off_before), kept).marks == ["P002", "P001", "P002"]
    assert shared_panes(panes(more_than_twice_apart), kept).marks == ["P001", "P002", "P002"]


@settings(max_examples=30)
@given(
    st.lists(st.tuples(st.integers(0, 60), st.integers(-60, 60)), min_size=1, max_size=9),
    st.integers(0, 2**32 - 1),
)
def test_what_changes_by_less_than_the_tolerance_keeps_its_mark(pairs: list[tuple[int, int]], seed: int) -> None:
    """Lengths in steps of a 31st of a millimetre, so that none is on an edge of the tolerance of 0.5 mm; all pieces are
    renumbered; and once more, where nothing has changed. A second time is as the first."""
    rng, step, within = np.random.default_rng(seed), 1 / 31, 0.5
    before, change = (step * np.array(pairs, dtype=float)).T
    first = shared_panes(panes(before.tolist()))
    order = rng.permutation(len(pairs))
    second = shared_panes(panes((before + change).tolist(), order.tolist()), mark_points(first))
    marks = dict(zip(order.tolist(), second.marks, strict=True))
    after = before + change
    of_mark = {mark: [after[k] for k in marks if marks[k] == mark] for mark in marks.values()}
    assert all(max(lengths) - min(lengths) <= 2 * within for lengths in of_mark.values())
    assert second.hidden_mm.max() <= 2 * within
    for k, old in enumerate(first.marks):
        stay = [after[j] for j in range(len(pairs)) if first.marks[j] == old]
        if abs(change[k]) <= within and max(abs(after[k] - each) for each in stay) <= within:
            assert marks[k] == old
    assert shared_panes(panes(before.tolist(), order.tolist()), mark_points(first)).marks == [
        first.marks[k] for k in order.tolist()
    ]
    again = shared_panes(panes(after.tolist()), mark_points(second))
    assert again.marks == [marks[k] for k in range(len(pairs))]
