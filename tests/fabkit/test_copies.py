"""A mesh is its shape: not where it stands, how it is turned, in which unit and in which order it is written."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit import Built
from geometry.mesh import Mesh, shapes
from tests.fabkit.copies import assert_same, copy_of, made_of

SEEDS = st.integers(0, 2**32 - 1)
MAP_COORDINATES = 5e6


@cache
def mesh(name: str) -> Mesh:
    """A dome with many equal parts, and one with none."""
    dome = shapes.dome(10, 3)
    noise = np.random.default_rng(7).uniform(-0.01, 0.01, dome.vertices.shape)
    made = dome if name == "dome" else dome.with_vertices(dome.vertices + noise)
    return made * (1 / made.mean_edge_length)


@pytest.fixture(scope="module", params=["dome", "rough dome"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Mesh, Built, Path]:
    folder = tmp_path_factory.mktemp("copies")
    return mesh(request.param), made_of(mesh(request.param), folder), folder


@settings(max_examples=4)
@given(SEEDS, st.sampled_from([10.0, 1e3, MAP_COORDINATES]))
def test_moved(made: tuple[Mesh, Built, Path], seed: int, reach: float) -> None:
    given_mesh, before, folder = made
    copy = copy_of(given_mesh, seed, reach=reach)
    assert_same(before, made_of(copy.mesh, folder), copy)


@settings(max_examples=4)
@given(SEEDS)
def test_turned(made: tuple[Mesh, Built, Path], seed: int) -> None:
    given_mesh, before, folder = made
    copy = copy_of(given_mesh, seed, turned=True)
    assert_same(before, made_of(copy.mesh, folder), copy)


@settings(max_examples=4)
@given(SEEDS)
def test_scaled(made: tuple[Mesh, Built, Path], seed: int) -> None:
    given_mesh, before, folder = made
    copy = copy_of(given_mesh, seed, scaled=True)
    assert_same(before, made_of(copy.mesh, folder), copy)


@settings(max_examples=4)
@given(SEEDS)
def test_renumbered(made: tuple[Mesh, Built, Path], seed: int) -> None:
    given_mesh, before, folder = made
    copy = copy_of(given_mesh, seed, renumbered=True)
    assert_same(before, made_of(copy.mesh, folder), copy)


@settings(max_examples=4)
@given(SEEDS)
def test_all_at_once(made: tuple[Mesh, Built, Path], seed: int) -> None:
    given_mesh, before, folder = made
    copy = copy_of(given_mesh, seed, reach=MAP_COORDINATES, turned=True, renumbered=True)
    assert_same(before, made_of(copy.mesh, folder), copy)


def test_marks_are_those_of_the_origin(made: tuple[Mesh, Built, Path]) -> None:
    """What map coordinates round away does not tell equal parts apart, and that is said."""
    given_mesh, before, folder = made
    after = made_of(copy_of(given_mesh, 1, reach=MAP_COORDINATES).mesh, folder)
    counts = [[len({part.mark for part in group}) for group in b.assembly.groups().values()] for b in (before, after)]
    assert counts[0] == counts[1]
    assert before.summary.equal_within_mm == 1e-7
    # doubles up to 2^23 m are 2^-30 m apart, and 4 times that is allowed
    assert 0 < after.summary.equal_within_mm <= 4 * 2.0**-30 * after.summary.scale_mm
