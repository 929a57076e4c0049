"""Setbacks against distances that shapely measures between strips in the plane, and against the table of the trade."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.checking.placed_parts import violations
from fabkit.detailing.assembling import detail
from fabkit.detailing.ends import beam_ends
from fabkit.errors import DetailingError
from fabkit.fitness import FitnessRules
from fabkit.fitness.parts import slots, uncovered
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, NodeRules
from tests.fabkit.test_detail import SIDE, fan, flat_grid

WELDED = DetailingRules(beams=BeamRules(width_mm=60), connection=ConnectionRules(kind="welded"))


def strip(angle_deg: float, width: float, setback: float) -> shapely.Polygon:
    """A beam seen along the node axis."""
    turn = np.radians(angle_deg)
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)]) * width / 2
    near, far = along * setback, along * 1000
    return shapely.Polygon([near - across, far - across, far + across, near + across])


def welded(**connection: float) -> DetailingRules:
    rules = ConnectionRules(kind="welded", **connection)
    return DetailingRules(beams=BeamRules(width_mm=60), connection=rules, nodes=NodeRules(setbacks="least"))


@settings(max_examples=60)
@given(angle=st.floats(31, 89), slot=st.floats(1, 60), ledge=st.floats(0, 40))
def test_slots_and_ledges_are_what_the_rules_ask_and_not_more(angle: float, slot: float, ledge: float) -> None:
    structure = fan(angle)
    rules = welded(slot_mm=slot, ledge_mm=ledge, longest_setback_mm=1e4)
    ends = beam_ends(structure, structure.mesh.combinatorics.edges.max(axis=1) < 3, rules)  # of the triangle
    near = np.flatnonzero(ends.vertex == 0)
    near = near[np.isfinite(ends.setback[near])]
    r = float(ends.setback[near[0]])
    assert r == pytest.approx(float(ends.setback[near[1]]))
    slot_found = strip(0, 60, r).distance(strip(angle, 60, r))
    own = r * np.tan(np.radians(angle / 2)) - 30  # from the beam to where the planes of the two facets meet
    assert slot_found >= slot - 1e-6
    assert own >= ledge - 1e-6
    assert r >= 30
    assert min(slot_found - slot, own - ledge, r - 30) < 1e-6


@pytest.mark.parametrize(("theta", "expected"), [(30, 160), (45, 105), (60, 77), (90, 48), (120, 32)])
def test_setbacks_of_a_welded_hollow_section_60_mm_wide(theta: float, expected: float) -> None:
    structure = fan(theta)
    rules = welded(longest_setback_mm=1e4)
    ends = beam_ends(structure, structure.mesh.combinatorics.edges.max(axis=1) < 3, rules)
    assert np.nanmax(ends.setback[ends.vertex == 0]) == pytest.approx(expected, abs=0.5)


def test_beams_in_line_keep_half_their_width() -> None:
    """The nodes of the rim of a grid have two beams in line and one across."""
    ends = beam_ends(flat_grid(), np.ones(17, dtype=bool), WELDED)
    assert np.nanmin(ends.setback) >= 30.0


@pytest.mark.parametrize(
    ("angle", "sentence"),
    [
        (
            32,
            r"edge 0 cannot be welded at vertex 0: it is 32.0 degrees from the beam on edge 2 about the node axis",
        ),
        (
            32,
            r"would be 150.0 mm from the axis, where at most 120.0 mm are possible \(\[connection\] "
            r"longest_setback_mm = 120, or 35% of the edge\)",
        ),
        (29, r"29.0 degrees from .* at least 30 degrees are needed; it could be in contact with its block"),
        (0.5, r"at least 30 degrees are needed; no other connection would work"),
    ],
)
def test_narrow_angles_are_refused_with_what_would_work(angle: float, sentence: str) -> None:
    with pytest.raises(DetailingError, match=sentence):
        detail(fan(angle), welded(longest_setback_mm=120.0), name="fan")


def test_what_cannot_be_welded_is_left_out_if_allowed() -> None:
    made = detail(fan(29), WELDED, name="fan", skip_unbuildable=True).assembly
    assert {left.element for left in made.left_out if left.kind == "beam"} == {0, 2}
    assert not violations(made)


def test_a_welded_grid_fits_with_its_ledges() -> None:
    made = detail(flat_grid(), WELDED, name="grid").assembly
    assert not violations(made)
    r = (25 + 60 * np.cos(np.pi / 4)) / (2 * np.sin(np.pi / 4))
    assert made["beams"].details.long_point_mm == pytest.approx(np.full(17, SIDE - 2 * r))
    inner = made["nodes"][int(np.flatnonzero(made["nodes"].details.beams.sizes == 4)[0])]
    corners = inner.solid.vertices[:, :2]
    flat = [np.sort(corners[np.isclose(corners[:, k], s * r), 1 - k]) for k in (0, 1) for s in (-1, 1)]
    for facet in flat:  # 60 of the beam and a ledge of 8 on either side
        assert facet[[0, -1]] == pytest.approx([-38, 38])


def test_a_gap_at_the_ends_shortens_beams_and_fits() -> None:
    with_gap = detail(flat_grid(), welded(gap_mm=2.0), name="grid").assembly
    without = detail(flat_grid(), welded(), name="grid").assembly
    shorter = without["beams"].details.long_point_mm - with_gap["beams"].details.long_point_mm
    assert shorter == pytest.approx(np.full(17, 4.0))
    assert not violations(with_gap)


def test_narrow_welds_and_uncovered_ends_are_told() -> None:
    nodes = detail(fan(50), WELDED, name="fan").assembly["nodes"]
    found = slots(nodes, FitnessRules())
    assert found is not None
    sharpest = np.degrees(
        np.arctan2(1 - np.sin(np.radians(50)), 1 - np.cos(np.radians(50)))
    )  # of the quad, at vertex 4
    assert (round(found.value, 6), found.elements[0]) == (round(float(sharpest), 6), 4)
    assert "less than 60 degrees apart, the smallest angle is 33.2 degrees" in found.sentence
    assert slots(nodes, FitnessRules(slots_noted_deg=33)) is None
    assert uncovered(nodes, FitnessRules()) is None
    shares = nodes.details.uncovered_percent
    bare = replace(nodes, details=replace(nodes.details, uncovered_percent=shares.with_values(shares.values + 21.0)))
    told = uncovered(bare, FitnessRules())
    assert told is not None
    assert told.sentence.startswith(f"{len(nodes)} of {len(nodes)} node blocks are trimmed so low that 10 % or more")
