"""Distances of bores against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.checking.bore_distances import edge_ratios, pitch_ratios, walls
from fabkit.parts import Measures, bore_vertices, prism_topology, prism_vertices

SAMPLED_MM = 0.6
"""Largest distance of a point of a bore from the sampled ones below: half the steps along and around it."""


def block(bores: list[tuple[np.ndarray, np.ndarray, float]]) -> Measures:
    """A large block with these blind bores; where they begin does not matter."""
    box = prism_vertices(np.array([[-500.0, -500], [500, -500], [500, 500], [-500, 500]]), -500.0, 500.0)
    own = [bore_vertices(first, second, radius, np.array([0.3, 0.5, 0.7])) for first, second, radius in bores]
    return Measures(prism_topology(4).bored([(2, None)] * len(bores)), np.concatenate([box, *own])[None])


def points(first: np.ndarray, second: np.ndarray, radius: float) -> np.ndarray:
    axis = (second - first) / np.linalg.norm(second - first)
    aside = np.linalg.svd(axis[None])[2][1:]
    turns = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    circle = radius * (np.cos(turns)[:, None] * aside[0] + np.sin(turns)[:, None] * aside[1])
    discs = np.concatenate([share * circle for share in (0.0, 0.5, 1.0)])
    along = np.linspace(0, 1, 60)[:, None, None] * (second - first)
    return (first + along + discs).reshape(-1, 3)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.6, np.pi), st.floats(20, 60), st.floats(-50, 50), st.floats(4, 12), st.floats(4, 12))
def test_walls_are_never_thought_thicker_than_they_are(
    angle: float, distance: float, level: float, radius: float, other: float
) -> None:
    bores = []
    for turn, z, r in ((0.0, 0.0, radius), (angle, level, other)):
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        bores.append(((distance + 40) * out + [0, 0, z], distance * out + [0, 0, z], r))
    found = walls(block(bores)).item()
    sampled = np.linalg.norm(points(*bores[0])[::7, None] - points(*bores[1])[None, ::7], axis=2).min()
    assert found <= sampled + 1e-9
    if level == 0 and sampled > 1:
        assert found >= sampled - 6 * SAMPLED_MM


def test_walls_of_bores_at_one_level_are_exact() -> None:
    for angle in (0.7, 1.5, 2.5, np.pi):
        ends = [np.array([np.cos(a), np.sin(a), 0.0]) for a in (0.0, angle)]
        bores = [(100 * out, 50 * out, 10.0) for out in ends]
        exact = 2 * (50 * np.sin(angle / 2) - 10 * np.cos(angle / 2))
        assert walls(block(bores)).item() == pytest.approx(exact, abs=1e-9)


def test_walls_of_parallel_bores() -> None:
    x = np.array([40.0, 0, 0])
    apart = np.array([0.0, 18, 24])
    assert walls(block([(0 * x, x, 10.0), (apart, apart + x, 5.0)])).item() == pytest.approx(15.0)


def test_edges_and_pitches_of_a_plate() -> None:
    plate = prism_vertices(np.array([[0.0, 0], [60, 0], [60, 120], [0, 120]]), 0.0, 15.0)
    z = np.array([0.0, 0, 15])
    holes = [np.array([30.0, 60, 0]), np.array([30.0, 15, 0])]
    own = [bore_vertices(at, at + z, r, np.array([1.0, 0, 0])) for at, r in zip(holes, (11.0, 5.0), strict=True)]
    measures = Measures(prism_topology(4).bored([(0, 1)] * 2), np.concatenate([plate, *own])[None])
    assert edge_ratios(measures).item() == pytest.approx(min(30 / 22, 15 / 10))
    assert pitch_ratios(measures).item() == pytest.approx(45 / 16)
