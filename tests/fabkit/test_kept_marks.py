"""Which pieces keep their marks when a design changes a little, and which cannot."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit import Built, Project, build, design
from fabkit.formats.finished import check_folder
from fabkit.parts import Assembly, Parts
from fabkit.production.marks import EQUAL_WITHIN_MM, KeptMarks, mark_points, share_equal_parts
from geometry.arrays import FloatArray
from geometry.mesh import Mesh, shapes
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


REGULAR = shapes.dome(8, 3)
PLAIN: dict[str, Any] = {"mean_edge_mm": 1500, "connection": {"kind": "contact"}, "nesting": {"mode": "off"}}
STILL_MM = 0.1
"""Corners of a part that move by no more change its own coordinates by less than 0.5 mm: they are up to 2 m from the
corner and edge of a metre or so from which these are measured."""


@cache
def dome(noise: float) -> Built:
    moves = np.random.default_rng(1).uniform(-noise, noise, REGULAR.vertices.shape)
    return design(Project(mesh=REGULAR.with_vertices(REGULAR.vertices + moves), **PLAIN))


def placed(parts: Parts[Any]) -> list[FloatArray]:
    return [parts.origins[k] + parts.solids[int(parts.shape[k])].vertices @ parts.axes[k] for k in range(len(parts))]


@pytest.mark.parametrize(("noise", "move_mm"), [(0.0, 0.2), (0.0, 5.0), (0.002, 0.2), (0.002, 5.0)])
def test_after_a_small_move_parts_that_stay_keep_their_marks_and_all_stand_in_their_places(
    noise: float, move_mm: float
) -> None:
    """Two vertices are moved: of a regular dome, which then has no exact offset any more, so that many shapes are alike
    and all change; or of an irregular one, most of which stays. Judged from corners in the world alone."""
    rng = np.random.default_rng(5)
    first = dome(noise)
    vertices = first.structure.mesh.vertices.copy()
    vertices[rng.choice(len(vertices), 2, replace=False)] += rng.uniform(-move_mm, move_mm, (2, 3))
    second = design(Project(**{**PLAIN, "mesh": REGULAR.with_vertices(vertices), "mean_edge_mm": None, "unit": "mm"}))
    kept = {parts.kind.group: mark_points(parts) for parts in first.assembly.groups}
    shared, origin = share_equal_parts(second.nominal, kept=kept), second.nominal.origin_mm
    n_still = 0
    for old, new, made in zip(first.nominal.groups, second.nominal.groups, shared.groups, strict=True):
        assert made.hidden_mm[:, 0].max() <= 2 * EQUAL_WITHIN_MM
        marks = first.assembly[old.kind.group].marks
        for k, (before, planned, points) in enumerate(zip(placed(old), placed(new), placed(made), strict=True)):
            apart = np.linalg.norm(planned[:, None] - points, axis=2)
            assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) <= 3**0.5 * made.hidden_mm[k, 0] + 1e-6
            moves = np.linalg.norm(before[:, None] - origin - planned, axis=2).min(axis=1)
            is_still = old.kind.directions is None and moves.max() <= STILL_MM
            n_still += is_still
            assert made.marks[k] == marks[k] or not is_still
    assert n_still or not noise


@pytest.mark.parametrize("step", [0.1, 0.4])
def test_a_mark_that_is_kept_from_build_to_build_does_not_drift(tmp_path: Path, step: float) -> None:
    """The left side of a flat grid moves by 0.1 or 0.4 mm with each revision: all marks stay while none is farther than
    twice the tolerance from the shape under which it was first given, which the last folder still has."""
    first: dict[tuple[str, str], FloatArray] = {}
    known: set[str] = set()
    mesh, folder = shapes.grid(3, 2), None
    for revision in range(8):
        vertices = mesh.vertices * 1.2
        vertices[vertices[:, 0] == vertices[:, 0].min(), 0] -= step * 1e-3 * revision
        folder, before = tmp_path / str(revision), folder
        keep = {"keep": before} if before else {}
        tables = {"unit": "m", "out": folder, "documents": ["tables", "parts"], "marks": keep}
        build(Project(mesh=Mesh(vertices, mesh.combinatorics), **tables))
        assert check_folder(folder) == ()
        rows = [row.split(",") for row in (folder / "mark_points.csv").read_text().replace('"', "").splitlines()[1:]]
        found: dict[tuple[str, str], list[list[float]]] = defaultdict(list)
        for row in rows:
            found[row[1], row[-4]].append([float(cell) for cell in row[-3:]])
        for (mark, what), points in found.items():
            if what == "corner":
                assert np.abs(np.array(points) - first.setdefault((mark, what), np.array(points))).max() <= 1.0 + 1e-6
            if what == "first corner":
                assert np.abs(np.array(points) - first[mark, "corner"]).max() <= 1e-6
        marks = {row.split(",")[1] for row in (folder / "pieces.csv").read_text().splitlines()[1:]}
        known = known or marks
        assert (marks == known) == (step * revision <= 1.0)  # no more than twice the tolerance from the first shape
