"""Edges of oblique ends of round bars as they lie on their cylinders, evaluated from the text of the file alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from fabkit.parts import Solid, round_vertices, shaft_topology
from geometry.arrays import FloatArray
from tests.fabkit.part21 import StepText, coordinates, written
from tests.fabkit.round_solids import SOLIDS
from tests.fabkit.solids import frame, node

slopes = st.floats(-1.5, 1.5)


@settings(max_examples=25, deadline=None)
@given(slopes, slopes, st.floats(5.0, 300.0), st.integers(0, 999))
def test_they_are_the_ellipses(first: float, second: float, radius: float, seed: int) -> None:
    """At each of their parameters, to a third of the distance within which points are one to readers."""
    planes = (np.array([x, 0.0, slope]) for x, slope in ((0.0, first), (2000.0, second)))
    radii = radius, 0.8 * radius
    file = written(node("N1", Solid(round_vertices(radii, *planes), shaft_topology(hollow=True)), frame(seed)))
    edges = [file[each.values[3]] for each in file.all("EDGE_CURVE") if file[each.values[3]].kind == "SURFACE_CURVE"]
    assert (
        len(edges) == len(file.all("ELLIPSE")) == sum(abs(slope * r) > 1e-7 for slope in (first, second) for r in radii)
    )
    turns = np.linspace(0, 2 * np.pi, 500)
    for edge in edges:
        _, ellipse, (p_curve,), _ = edge.values
        assert np.abs(on_ellipse(file, ellipse, turns) - on_cylinder(file, p_curve, turns)).max() < 3e-8


def on_ellipse(file: StepText, number: int, turns: FloatArray) -> FloatArray:
    _, place, first, second = file[number].values
    origin, x, y, _ = axes(file, place)
    return np.asarray(origin + first * np.cos(turns)[:, None] * x + second * np.sin(turns)[:, None] * y)


def on_cylinder(file: StepText, number: int, turns: FloatArray) -> FloatArray:
    _, surface, representation = file[number].values
    _, degree, poles, *_, counts, knots, _ = file[file[representation].values[1][0]].values
    points = np.array([coordinates(file, pole) for pole in poles])
    angle, height = BSpline(np.repeat(knots, counts), points, degree)(turns).T[..., None]
    _, place, radius = file[surface].values
    origin, x, y, z = axes(file, place)
    return np.asarray(origin + radius * (np.cos(angle) * x + np.sin(angle) * y) + height * z)


def axes(file: StepText, place: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    origin, z, x = (coordinates(file, each) for each in file[place].values[1:])
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return origin, x, np.cross(z, x), z


@pytest.mark.parametrize("name", ["tube", "block", "plate with bores", "tee"])
def test_square_ends_need_none(name: str) -> None:
    assert not written(node("N1", SOLIDS[name])).all("PCURVE")
