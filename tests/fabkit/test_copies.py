"""A mesh is its shape: not where it stands, how it is turned, in which unit and in which order it is written."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fabkit import Built
from geometry.mesh import Mesh, shapes
from tests.fabkit.assemblies import by_name
from tests.fabkit.copies import assert_same, copy_of, made_of

SEEDS = st.integers(0, 2**32 - 1)
MAP_COORDINATES = 5e6
few = settings(max_examples=5)  # a build each


@dataclass(frozen=True)
class Made:
    """A mesh, and what is built of it; folder: for its copies."""

    name: str
    folder: Path

    @property
    def mesh(self) -> Mesh:
        return mesh(self.name)

    @cached_property
    def built(self) -> Built:
        return made_of(self.mesh, self.folder)

    def check(self, seed: int, **how: Any) -> None:
        copy = copy_of(self.mesh, seed, **how)
        assert_same(self.built, made_of(copy.mesh, self.folder), copy)


@cache
def mesh(name: str) -> Mesh:
    """A dome with many equal parts, one with none, and a flat plate."""
    if name == "flat":
        return shapes.grid(5, 4)
    dome = shapes.dome(10, 3)
    noise = np.random.default_rng(7).uniform(-0.01, 0.01, dome.vertices.shape)
    made = dome if name == "dome" else dome.with_vertices(dome.vertices + noise)
    return made * (1 / made.mean_edge_length)


@pytest.fixture(scope="module", params=["dome", "rough dome"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Made:
    return Made(request.param, tmp_path_factory.mktemp("copies"))


@few
@given(SEEDS, st.sampled_from([10.0, 1e3, MAP_COORDINATES]))
def test_moved(made: Made, seed: int, reach: float) -> None:
    made.check(seed, reach=reach)


@few
@given(SEEDS)
def test_turned(made: Made, seed: int) -> None:
    made.check(seed, turned=True)


@few
@given(SEEDS)
def test_scaled(made: Made, seed: int) -> None:
    made.check(seed, scaled=True)


@few
@given(SEEDS)
def test_renumbered(made: Made, seed: int) -> None:
    made.check(seed, renumbered=True)


@few
@given(SEEDS)
def test_all_at_once(made: Made, seed: int) -> None:
    made.check(seed, reach=MAP_COORDINATES, turned=True, renumbered=True)


@few
@example(4)
@given(SEEDS)
def test_a_straight_rim_is_straight_on_a_map_too(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    """A gap of half a turn between two beams, up to rounding: the block gets no corner in it."""
    flat = Made("flat", tmp_path_factory.mktemp("flat"))
    flat.check(seed, reach=MAP_COORDINATES, turned=True, renumbered=True)


def test_marks_are_those_of_the_origin(made: Made) -> None:
    """What map coordinates round away does not tell equal parts apart, and that is said."""
    after = made_of(copy_of(made.mesh, 1, reach=MAP_COORDINATES).mesh, made.folder)
    counts = [
        [len({part.mark for part in group}) for group in by_name(built.assembly).values()]
        for built in (made.built, after)
    ]
    assert counts[0] == counts[1]
    assert made.built.summary.equal_within_mm == 1e-7
    # doubles up to 2^23 m are 2^-30 m apart, and 4 times that is allowed
    assert 0 < after.summary.equal_within_mm <= 4 * 2.0**-30 * after.summary.scale_mm
