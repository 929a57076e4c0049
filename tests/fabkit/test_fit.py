"""How ends of beams sit on node blocks: single bars on single blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fabkit.checking import fit
from fabkit.checking.fit import end_fits
from fabkit.kinds import BEAM, NODE
from fabkit.parts import Frame, Parts, Solid, prism_topology, prism_vertices
from geometry.arrays import FloatArray
from tests.fabkit.assemblies import altered
from tests.fabkit.dome import CENTRE, dome


def end_fit(x: list[float], y: list[float], block: FloatArray, *, along: float = 1.0) -> tuple[float, float]:
    """Gap and overhang of end A of a square bar in the world's x-direction on a block of height 100 about z = 0."""
    whole = dome()
    corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    turn = np.diag([along, along, 1.0])
    bar = Solid(prism_vertices(corners, -20.0, 20.0) @ turn, prism_topology(4))
    beam = altered(whole["beams"][4], solid=bar, placement=Frame(np.zeros(3), turn), nodes=(CENTRE, 999))
    prism = Solid(prism_vertices(block, -50.0, 50.0), prism_topology(len(block)))
    node = replace(whole["nodes"][CENTRE], solid=prism, placement=Frame.world())
    found = end_fits(Parts.of(BEAM, [beam]), Parts.of(NODE, [node]))
    assert (found.beams.tolist(), found.ends.tolist(), found.nodes.tolist()) == ([0], [0], [0])
    return float(found.plane_gap_mm[0]), float(found.overhang_mm[0])


SQUARE = np.array([[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]])


def test_seat_on_a_square_block() -> None:
    assert end_fit([50.0, 300.0], [-20.0, 20.0], SQUARE) == pytest.approx((0.0, -30.0))
    assert end_fit([50.5, 300.0], [-20.0, 20.0], SQUARE) == pytest.approx((0.5, -30.0))
    assert end_fit([49.5, 300.0], [-20.0, 20.0], SQUARE) == pytest.approx((0.5, -30.0))
    assert end_fit([50.0, 300.0], [12.0, 52.0], SQUARE) == pytest.approx((0.0, 2.0))


def test_facet_must_look_towards_the_end() -> None:
    """The bar lies in the block and its end A in the plane of a facet that looks the same way."""
    assert end_fit([-200.0, 50.0], [-20.0, 20.0], SQUARE, along=-1.0)[0] == pytest.approx(100.0)


def test_of_two_facets_in_one_plane_the_one_under_the_end_counts() -> None:
    fork = np.array([[-50, -50], [50, -50], [50, -10], [0, -10], [0, 10], [50, 10], [50, 50], [-50, 50.0]])
    assert end_fit([50.0, 300.0], [20.0, 40.0], fork) == pytest.approx((0.0, -10.0))
    assert end_fit([50.0, 300.0], [-40.0, -20.0], fork) == pytest.approx((0.0, -10.0))
    assert end_fit([50.0, 300.0], [-20.0, 20.0], fork) == pytest.approx((0.0, 30.0))


def test_ends_are_compared_a_few_at_a_time_with_the_same_result(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = dome()
    at_once = end_fits(whole["beams"], whole["nodes"])
    monkeypatch.setattr(fit, "MAX_FIT_VALUES_IN_MEMORY", 1)
    few = end_fits(whole["beams"], whole["nodes"])
    assert np.array_equal(few.plane_gap_mm, at_once.plane_gap_mm)
    assert np.array_equal(few.overhang_mm, at_once.overhang_mm)
